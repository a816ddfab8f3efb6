//! The back end on a graphics card, by wgpu over Vulkan, without a window.
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

use std::time::Duration;

use bus::clock::monotonic_ns;
use bus::message::{Marks, VolumeHash};
use bus::volume::{Layout, OwnedVolume, VolumeView, Voxels};
use geometry::{Affine, Direction, Point, SlicePlane, VolumeGrid};
use scene::{Filter, GpuWeights, Sampling};

use super::spline::{self, Spline};
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
    programs: Vec<Program>,
    prepared: Option<Prepared>,
    frame: Frame,
    timings: Timings,
}

/// What was made ready of one volume.
#[derive(Debug)]
struct Prepared {
    /// Where its voxels were read from, which tells it from another volume.
    voxels: (usize, usize),
    dims: [u32; 3],
    textures: Vec<Uploaded>,
    /// Pieces that are on the card, of all textures one after the other.
    done: u32,
    /// The largest magnitude among the voxels read so far, HU.
    largest_hu: u16,
}

impl Gpu {
    /// Opens the best card, which may be a program on the CPU, with nobody watching it; in words why there is none.
    ///
    /// # Errors
    /// What the drivers say.
    pub fn of_any_kind(weights: GpuWeights) -> Result<Self, String> {
        Self::open(Accepted::Any, weights)
    }

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
            programs: Vec::new(),
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

    /// Compiles the programs for these ways of sampling that it has not compiled yet.
    ///
    /// # Errors
    /// [`ResliceError::Gpu`].
    pub(super) fn compile(&mut self, samplings: &[Sampling]) -> Result<(), ResliceError> {
        for sampling in samplings {
            let way = self.way(sampling.filter);
            if !self.programs.iter().any(|program| program.way == way) {
                self.programs.push(guarded(|| Program::new(&self.card, way))?);
            }
        }
        Ok(())
    }

    /// Draws a few pixels of a tiny volume in each of these ways: some drivers compile at the first run, which takes long. From then on
    /// the card is given little time for anything.
    ///
    /// # Errors
    /// [`ResliceError`].
    pub(super) fn rehearse(&mut self, samplings: &[Sampling]) -> Result<(), ResliceError> {
        let tiny = tiny_volume().ok_or_else(|| ResliceError::Gpu("no volume to rehearse with".to_owned()))?;
        let middle = tiny.grid.ct_from_voxel() * Point::new(1.5, 1.5, 1.5);
        let plane = SlicePlane::centred(middle, [Direction::X, Direction::Y], 0.5, [8, 8]);
        let plane = plane.map_err(|error| ResliceError::Gpu(error.to_string()))?;
        self.prepare(&tiny.view(), samplings, &mut || {})?;
        for sampling in samplings {
            self.reslice(&tiny.view(), &plane, sampling, &mut [0.0; 64])?;
        }
        self.card.hurry();
        Ok(())
    }

    /// Whether it is no program on the CPU.
    pub(super) fn is_hardware(&self) -> bool {
        self.card.is_hardware()
    }

    /// Makes room for `volume`; [`Gpu::upload`] brings it there.
    ///
    /// # Errors
    /// [`ResliceError::Gpu`] where the card is too small.
    pub(super) fn begin(&mut self, volume: &VolumeView<'_>, samplings: &[Sampling]) -> Result<(), ResliceError> {
        // What the card held before makes room first.
        self.prepared = None;
        self.frame.unbind();
        self.timings.upload_ns = 0;
        let dims = volume.grid.dims();
        let ways: Vec<Way> = samplings.iter().map(|s| self.way(s.filter)).collect();
        let mut textures = Vec::new();
        for contents in [Contents::Voxels, Contents::Fractions, Contents::Coefficients] {
            if ways.iter().any(|way| way.contents() == contents) {
                textures.push(guarded(|| Uploaded::empty(&self.card, dims, contents))?);
            }
        }
        self.prepared = Some(Prepared {
            voxels: identity(volume),
            dims,
            textures,
            done: 0,
            largest_hu: 0,
        });
        Ok(())
    }

    /// Brings one more piece of the volume, or of its `spline`, onto the card: some milliseconds of work. Returns whether it was
    /// the last one.
    ///
    /// # Errors
    /// [`ResliceError::Gpu`], [`ResliceError::NotPrepared`] without the coefficients that it needs.
    pub(super) fn upload(
        &mut self,
        volume: &VolumeView<'_>,
        spline: Option<&Spline<f32>>,
    ) -> Result<bool, ResliceError> {
        let began = monotonic_ns();
        let (card, prepared) = (&self.card, self.prepared.as_mut());
        // Another volume may have been loaded while the last one was still on its way to the card.
        let Some(prepared) = prepared.filter(|p| p.voxels == identity(volume)) else {
            return Err(ResliceError::NotPrepared(Filter::Linear));
        };
        let pieces = Uploaded::pieces(prepared.dims);
        let (texture, piece) = (prepared.done / pieces, prepared.done % pieces);
        if let Some(uploaded) = prepared.textures.get(texture as usize) {
            guarded(|| match (uploaded.contents, spline) {
                (Contents::Voxels | Contents::Fractions, _) => uploaded.fill(card, volume.layout, volume.voxels, piece),
                (Contents::Coefficients, Some(spline)) => {
                    uploaded.fill(card, &spline.layout, &spline.coefficients, piece)
                }
                (Contents::Coefficients, None) => Err(ResliceError::NotPrepared(Filter::BSpline)),
            })?;
            prepared.done += 1;
        }
        // The largest value bounds the error of f32 sums: found on the way, as every voxel is read once anyway.
        if texture == 0 {
            // Parts of memory, not of slices: together they are all voxels in any layout.
            let part = volume.voxels.len().div_ceil(pieces as usize);
            let voxels = volume
                .voxels
                .chunks(part.max(1))
                .nth(piece as usize)
                .unwrap_or_default();
            let largest = voxels.iter().map(|hu| hu.unsigned_abs()).max().unwrap_or(0);
            prepared.largest_hu = prepared.largest_hu.max(largest);
        }
        self.timings.upload_ns += monotonic_ns() - began;
        Ok(prepared.is_whole())
    }

    /// The largest magnitude among the voxels on the card, HU.
    pub(super) fn largest_hu(&self) -> f64 {
        self.prepared.as_ref().map_or(0.0, |p| f64::from(p.largest_hu))
    }

    /// Samples `plane` as [`Resampler::reslice`] does, but gives the card up where it takes longer than `patience`.
    ///
    /// # Errors
    /// [`ResliceError`].
    pub(super) fn reslice_within(
        &mut self,
        volume: &VolumeView<'_>,
        plane: &SlicePlane,
        sampling: &Sampling,
        hu: &mut [f32],
        patience: Duration,
    ) -> Result<(), ResliceError> {
        let missing = || ResliceError::NotPrepared(sampling.filter);
        let way = self.way(sampling.filter);
        let prepared = self
            .prepared
            .as_ref()
            .filter(|p| p.voxels == identity(volume) && p.is_whole());
        let textures = prepared.map(|p| &p.textures).ok_or_else(missing)?;
        let tools = Tools {
            card: &self.card,
            program: self.programs.iter().find(|p| p.way == way).ok_or_else(missing)?,
            volume: textures
                .iter()
                .find(|t| t.contents == way.contents())
                .ok_or_else(missing)?,
            patience,
        };
        let rows = Rows::new(volume, plane, sampling);
        // The upload's time belongs to the volume, not to this image.
        let mut timings = Timings {
            upload_ns: self.timings.upload_ns,
            ..Timings::default()
        };
        let image = [i32::from(volume.padding_hu), plane.size()[0] as i32];
        let frame = &mut self.frame;
        guarded(|| frame.draw(tools, &rows, image, hu, &mut timings))?;
        self.timings = timings;
        Ok(())
    }

    /// Puts zeros where the volume was, as a card with bad memory may.
    #[cfg(test)]
    pub(super) fn spoil(&self) {
        for texture in self.prepared.iter().flat_map(|p| &p.textures) {
            texture.spoil(&self.card);
        }
    }
}

/// 4 x 4 x 4 voxels of 1 mm.
fn tiny_volume() -> Option<OwnedVolume> {
    let affine = Affine::from_rows([[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]);
    let layout = Layout::new([4; 3], [4; 3]).ok()?;
    Some(OwnedVolume {
        grid: VolumeGrid::checked([4; 3], affine).ok()?,
        voxels: Voxels::zeroed(layout.stored() as usize),
        layout,
        padding_hu: 0,
        hash: VolumeHash::default(),
        marks: Marks::NONE,
    })
}

/// Where the voxels of a volume are read from.
fn identity(volume: &VolumeView<'_>) -> (usize, usize) {
    (volume.voxels.as_ptr() as usize, volume.voxels.len())
}

impl Prepared {
    fn is_whole(&self) -> bool {
        self.done >= Uploaded::pieces(self.dims) * self.textures.len() as u32
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
        // A weight of 8 bits is off by up to 1/256, as a card may cut it off instead of rounding it (an H100's are off by 0.58 of that in
        // the oblique planes of `figures`), and comes from an f32 coordinate with four roundings. Values
        // differ by twice the largest from voxel to voxel. The sampler's own sums are good to one step of its 16 bits,
        // and -32768 is no fraction of 32767.
        let longest = self
            .prepared
            .as_ref()
            .map_or(2048, |p| p.dims.into_iter().max().unwrap_or(1));
        let weight = 1.0 / 256.0 + f64::from(longest) / f64::from(1 << 22);
        exact + 3.0 * weight * 2.0 * max_abs_hu + 1.0 + f64::from(u8::from(max_abs_hu > 32_767.0))
    }

    fn prepare(
        &mut self,
        volume: &VolumeView<'_>,
        samplings: &[Sampling],
        alive: &mut dyn FnMut(),
    ) -> Result<(), ResliceError> {
        self.compile(samplings)?;
        let spline = samplings.iter().any(|s| s.filter == Filter::BSpline).then(|| {
            spline::check_memory::<f32>(volume)?;
            Ok(Spline::new(volume, alive))
        });
        let spline = spline.transpose()?;
        self.begin(volume, samplings)?;
        while !self.upload(volume, spline.as_ref())? {
            alive();
        }
        Ok(())
    }

    fn reslice(
        &mut self,
        volume: &VolumeView<'_>,
        plane: &SlicePlane,
        sampling: &Sampling,
        hu: &mut [f32],
    ) -> Result<(), ResliceError> {
        let patience = self.card.patience();
        self.reslice_within(volume, plane, sampling, hu, patience)
    }
}

#[cfg(test)]
mod tests;
