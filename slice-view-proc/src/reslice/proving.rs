//! A card before it may draw: the volume goes there piece by piece, then small images of every way of sampling in the scene are
//! compared with the CPU's, pixel by pixel, on that volume.

use bus::volume::VolumeView;
use scene::Sampling;

use super::watch::{Drawn, PROOFS, proof_plane};
use super::{Cpu, Gpu, Resampler};

/// A card on trial.
#[derive(Debug)]
pub(super) struct Proving {
    gpu: Box<Gpu>,
    samplings: Vec<Sampling>,
    is_loaded: bool,
    /// Images compared so far.
    compared: usize,
}

impl Proving {
    /// Begins with `volume`; in words why the card cannot hold it.
    pub(super) fn new(mut gpu: Box<Gpu>, volume: &VolumeView<'_>, samplings: &[Sampling]) -> Result<Self, String> {
        let begun = gpu.compile(samplings).and_then(|()| gpu.begin(volume, samplings));
        if let Err(error) = begun {
            gpu.close();
            return Err(error.to_string());
        }
        Ok(Self {
            gpu,
            samplings: samplings.to_vec(),
            is_loaded: false,
            compared: 0,
        })
    }

    /// Goes on for some milliseconds; returns whether the card has proved itself, or in words why it has not.
    pub(super) fn step(&mut self, volume: &VolumeView<'_>, cpu: &mut Cpu) -> Result<bool, String> {
        if !self.is_loaded {
            let loaded = self.gpu.upload(volume, cpu.spline());
            self.is_loaded = loaded.map_err(|error| error.to_string())?;
            return Ok(false);
        }
        let Some(sampling) = self.samplings.get(self.compared / PROOFS).copied() else {
            return Ok(true);
        };
        self.compare(volume, &sampling, cpu)?;
        self.compared += 1;
        Ok(false)
    }

    fn compare(&mut self, volume: &VolumeView<'_>, sampling: &Sampling, cpu: &mut Cpu) -> Result<(), String> {
        let Some(plane) = proof_plane(volume, self.compared % PROOFS) else {
            return Ok(());
        };
        let [width, height] = plane.size();
        // What the card leaves out stays NaN, which is near to no value of the CPU.
        let mut hu = vec![f32::NAN; (width * height) as usize];
        let drawn = self.gpu.reslice(volume, &plane, sampling, &mut hu);
        drawn.map_err(|error| error.to_string())?;
        let largest_hu = self.gpu.largest_hu();
        let drawn = Drawn {
            volume,
            plane: &plane,
            sampling,
            hu: &hu,
            bound_hu: self.gpu.error_bound_hu(sampling, largest_hu) + cpu.error_bound_hu(sampling, largest_hu),
        };
        match drawn.check_all(cpu) {
            Ok(None) => Ok(()),
            Ok(Some(deviation)) => Err(deviation.to_string()),
            Err(error) => Err(error.to_string()),
        }
    }

    #[cfg(test)]
    pub(super) fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    /// The card.
    pub(super) fn into_gpu(self) -> Box<Gpu> {
        self.gpu
    }
}
