//! Which back end draws: as the scene asks, as the machine allows, and as long as the card lives.
//!
//! The CPU is always made ready beside a card, so that an image that the card fails at is still drawn, by the CPU and in
//! the same call. A card that failed once is not asked again.

use bus::scene::{BackEnd, Render, Sampling};
use bus::volume::VolumeView;
use geometry::SlicePlane;

use super::gpu::{Accepted, Timings};
use super::{Cpu, Gpu, Resampler, ResliceError};

/// The back end of a scene, with the CPU behind it.
#[derive(Debug)]
pub struct Chosen {
    cpu: Cpu,
    gpu: Option<Gpu>,
    name: String,
    /// A card drew once and failed.
    lost: bool,
}

impl Chosen {
    /// The back end that `render` asks for.
    ///
    /// [`BackEnd::Gpu`] without a card is said on stderr; [`BackEnd::Cpu`] does not even look for one.
    pub fn new(render: Render) -> Self {
        match render.back_end {
            BackEnd::Cpu => Self::of(Cpu::default(), None),
            BackEnd::Auto => Self::open(Accepted::Hardware, render),
            BackEnd::Gpu => {
                let chosen = Self::open(Accepted::Any, render);
                if chosen.gpu.is_none() {
                    warn(&chosen.name);
                }
                chosen
            }
        }
    }

    pub(super) fn open(accepted: Accepted, render: Render) -> Self {
        let opened = Gpu::open(accepted, render.gpu_weights);
        let why = opened.as_ref().err().cloned();
        let mut chosen = Self::of(Cpu::default(), opened.ok());
        if let Some(why) = why {
            chosen.name = format!("{} ({why})", chosen.cpu.name());
        }
        chosen
    }

    fn of(cpu: Cpu, gpu: Option<Gpu>) -> Self {
        let name = gpu.as_ref().map_or(cpu.name(), Gpu::name).to_owned();
        Self {
            cpu,
            gpu,
            name,
            lost: false,
        }
    }

    /// The name, with the memory taken on the card: what a process says of itself.
    pub fn note(&self) -> String {
        match self.gpu_bytes() {
            Some(bytes) => format!("{}, {} MiB", self.name, bytes.div_ceil(1 << 20)),
            None => self.name.clone(),
        }
    }

    /// Bytes taken on the card; `None` where the CPU draws.
    pub fn gpu_bytes(&self) -> Option<u64> {
        self.gpu.as_ref().map(Gpu::bytes)
    }

    /// How long the card's parts of the work took; `None` where the CPU draws.
    pub fn gpu_timings(&self) -> Option<Timings> {
        self.gpu.as_ref().map(Gpu::timings)
    }

    /// The card, to be taken away in a test.
    #[cfg(test)]
    pub(super) fn gpu(&self) -> Option<&Gpu> {
        self.gpu.as_ref()
    }

    /// From now on the CPU draws.
    fn fall_back(&mut self, how: &str, why: &str) {
        self.name = format!("{} (GPU {how}: {why})", self.cpu.name());
        warn(&self.name);
        self.lost = true;
        if let Some(gpu) = self.gpu.take() {
            gpu.close();
        }
    }
}

fn warn(name: &str) {
    bus::say!("slice-view-proc: warning: the CPU draws: {name}");
}

impl Resampler for Chosen {
    fn name(&self) -> &str {
        &self.name
    }

    fn caution(&self) -> &'static str {
        if self.lost { "GPU LOST, CPU DRAWS" } else { "" }
    }

    fn error_bound_hu(&self, sampling: &Sampling, max_abs_hu: f64) -> f64 {
        match &self.gpu {
            Some(gpu) => gpu.error_bound_hu(sampling, max_abs_hu),
            None => self.cpu.error_bound_hu(sampling, max_abs_hu),
        }
    }

    fn prepare(
        &mut self,
        volume: &VolumeView<'_>,
        samplings: &[Sampling],
        alive: &mut dyn FnMut(),
    ) -> Result<(), ResliceError> {
        self.cpu.prepare(volume, samplings, alive)?;
        match self.gpu.as_mut().map(|gpu| gpu.prepare(volume, samplings, alive)) {
            Some(Err(ResliceError::Gpu(why))) => {
                self.fall_back("unusable", &why);
                Ok(())
            }
            Some(other) => other,
            None => Ok(()),
        }
    }

    fn reslice(
        &mut self,
        volume: &VolumeView<'_>,
        plane: &SlicePlane,
        sampling: &Sampling,
        hu: &mut [f32],
    ) -> Result<(), ResliceError> {
        match self.gpu.as_mut().map(|gpu| gpu.reslice(volume, plane, sampling, hu)) {
            Some(Err(ResliceError::Gpu(why))) => self.fall_back("lost", &why),
            Some(other) => return other,
            None => {}
        }
        self.cpu.reslice(volume, plane, sampling, hu)
    }
}
