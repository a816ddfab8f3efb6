//! The back end on a graphics card, by wgpu: Vulkan, Metal or OpenGL, without a window.
//!
//! The volume lies in a three-dimensional texture of the card ([`texture`]). For each image the CPU decides in f64 which
//! points of each row are inside and where the first of them lies ([`rows`]); from there the card steps in 64-bit integers
//! (`shaders/common.wgsl`), so that a place is off by 2^-25 of a voxel, at the end of a row as at its beginning. f32 alone
//! would cost 0.1 HU at the edge of a bone.
//!
//! [`GpuWeights::Exact`] interpolates in the program, with the weights and in the precision of [`Cpu`].
//! [`GpuWeights::Sampler`] leaves linear interpolation to the texture sampler, whose weights have 8 bits.

mod device;
mod frame;
mod program;
mod rows;
mod texture;

use bus::clock::monotonic_ns;
use bus::scene::{Filter, GpuWeights, Sampling};
use bus::volume::VolumeView;
use geometry::SlicePlane;

use super::{Cpu, Resampler, ResliceError};
pub(super) use device::Accepted;
use device::{Card, guarded};
use frame::{Frame, Tools};
use program::{Program, Way};
use rows::Rows;
use texture::{Contents, Uploaded};

/// How long the parts of the work took: the upload in [`Resampler::prepare`], the rest in the last image.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Timings {
    /// Volume and programs onto the card.
    pub upload_ns: i64,
    /// The inside part of each row, on the CPU.
    pub plan_ns: i64,
    /// From handing the work over until the results can be read.
    pub run_ns: i64,
    /// Copying them out.
    pub read_ns: i64,
}

/// The back end on a graphics card.
#[derive(Debug)]
pub struct Gpu {
    card: Card,
    name: String,
    sampler: bool,
    prepared: Option<Prepared>,
    frame: Frame,
    timings: Timings,
}

/// What was made ready for one volume.
#[derive(Debug)]
struct Prepared {
    /// Where its voxels were read from, which tells it from another volume.
    voxels: (usize, usize),
    dims: [u32; 3],
    textures: Vec<Uploaded>,
    programs: Vec<Program>,
}

impl Gpu {
    /// Opens the best card among those accepted; in words why there is none.
    pub(super) fn open(accepted: Accepted, weights: GpuWeights) -> Result<Self, String> {
        let mut words = String::new();
        let opened = guarded(|| Ok(Card::open(accepted).map_err(|why| words = why).ok()));
        let card = opened.map_err(|error| error.to_string())?.ok_or(words)?;
        let sampler = weights == GpuWeights::Sampler && card.samples_16_bit;
        let kind = match (weights, sampler) {
            (GpuWeights::Exact, _) => "exact weights",
            (GpuWeights::Sampler, true) => "sampler weights",
            (GpuWeights::Sampler, false) => "exact weights (no 16-bit sampler)",
        };
        Ok(Self {
            name: format!("gpu {kind}: {}", card.name()),
            card,
            sampler,
            prepared: None,
            frame: Frame::default(),
            timings: Timings::default(),
        })
    }

    /// Bytes taken on the card: textures and buffers.
    pub fn bytes(&self) -> u64 {
        let textures = self
            .prepared
            .iter()
            .flat_map(|p| p.textures.iter().map(|t| t.contents.bytes(p.dims)));
        textures.sum::<u64>() + self.frame.bytes()
    }

    /// How long the parts of the work took.
    pub fn timings(&self) -> Timings {
        self.timings
    }

    /// Gives everything back, also on a card that is in a bad state.
    pub(super) fn close(self) {
        // Whatever goes wrong here, there is nothing left to be done with it.
        let _ = guarded(|| {
            drop(self);
            Ok(())
        });
    }

    /// Takes the card away, as a driver may at any time.
    #[cfg(test)]
    pub(super) fn lose(&self) {
        self.card.device.destroy();
    }

    fn way(&self, filter: Filter) -> Way {
        match filter {
            Filter::Linear if self.sampler => Way::Sampler,
            _ => Way::Exact(filter),
        }
    }

    fn upload(&self, volume: &VolumeView<'_>, ways: &[Way], alive: &mut dyn FnMut()) -> Result<Prepared, ResliceError> {
        let mut prepared = Prepared {
            voxels: identity(volume),
            dims: volume.grid.dims(),
            textures: Vec::new(),
            programs: Vec::new(),
        };
        for contents in [Contents::Voxels, Contents::Fractions, Contents::Coefficients] {
            if ways.iter().any(|way| way.contents() == contents) {
                prepared
                    .textures
                    .push(Uploaded::new(&self.card, volume, contents, alive)?);
            }
        }
        for &way in ways {
            if !prepared.programs.iter().any(|p| p.way == way) {
                prepared.programs.push(Program::new(&self.card, way)?);
                alive();
            }
        }
        Ok(prepared)
    }
}

/// Where the voxels of a volume are read from.
fn identity(volume: &VolumeView<'_>) -> (usize, usize) {
    (volume.voxels.as_ptr() as usize, volume.voxels.len())
}

impl Prepared {
    fn tools<'a>(&'a self, card: &'a Card, way: Way) -> Option<Tools<'a>> {
        Some(Tools {
            card,
            program: self.programs.iter().find(|p| p.way == way)?,
            volume: self.textures.iter().find(|t| t.contents == way.contents())?,
        })
    }
}

impl Resampler for Gpu {
    fn name(&self) -> &str {
        &self.name
    }

    fn error_bound_hu(&self, sampling: &Sampling, max_abs_hu: f64) -> f64 {
        let way = self.way(sampling.filter);
        // Places and weights are those of the CPU's back end, or better. Means, of a layer and of layers, are added up
        // in units, of which they are off by half each time, and divided: 12 roundings in all.
        let rounding = f64::from(f32::EPSILON) / 2.0 * way.gain() * max_abs_hu;
        let means = 1.0 / f64::from(way.unit()) + 12.0 * rounding;
        let exact = Cpu::default().error_bound_hu(sampling, max_abs_hu) + means;
        if way != Way::Sampler {
            return exact;
        }
        // A weight of 8 bits is off by half of 1/256, and comes from an f32 coordinate with four roundings. Values
        // differ by twice the largest from voxel to voxel. The sampler's own sums are good to one step of its 16 bits,
        // and -32768 is no fraction of 32767.
        let longest = self
            .prepared
            .as_ref()
            .map_or(2048, |p| p.dims.into_iter().max().unwrap_or(1));
        let weight = 1.0 / 512.0 + f64::from(longest) / f64::from(1 << 22);
        exact + 3.0 * weight * 2.0 * max_abs_hu + 1.0 + f64::from(u8::from(max_abs_hu > 32_767.0))
    }

    fn prepare(
        &mut self,
        volume: &VolumeView<'_>,
        samplings: &[Sampling],
        alive: &mut dyn FnMut(),
    ) -> Result<(), ResliceError> {
        let began = monotonic_ns();
        // What the card held before makes room first.
        self.prepared = None;
        self.frame.unbind();
        let ways: Vec<Way> = samplings.iter().map(|s| self.way(s.filter)).collect();
        self.prepared = Some(guarded(|| self.upload(volume, &ways, alive))?);
        self.timings.upload_ns = monotonic_ns() - began;
        Ok(())
    }

    fn reslice(
        &mut self,
        volume: &VolumeView<'_>,
        plane: &SlicePlane,
        sampling: &Sampling,
        hu: &mut [f32],
    ) -> Result<(), ResliceError> {
        let way = self.way(sampling.filter);
        let prepared = self.prepared.as_ref().filter(|p| p.voxels == identity(volume));
        let tools = prepared.and_then(|p| p.tools(&self.card, way));
        let tools = tools.ok_or(ResliceError::NotPrepared(sampling.filter))?;
        let rows = Rows::new(volume, plane, sampling);
        let (frame, mut timings) = (
            &mut self.frame,
            Timings {
                upload_ns: self.timings.upload_ns,
                ..Timings::default()
            },
        );
        let image = [i32::from(volume.padding_hu), plane.size()[0] as i32];
        guarded(|| frame.draw(tools, &rows, image, hu, &mut timings))?;
        self.timings = timings;
        Ok(())
    }
}

#[cfg(test)]
mod tests;
