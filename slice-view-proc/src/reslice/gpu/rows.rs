//! What the card is told of an image: for each row of points the part inside the volume, and where it begins.
//!
//! Both come from f64: the border rule is decided here, not on the card, and each row has an origin of its own.

use std::ops::Range;

use bus::volume::VolumeView;
use geometry::SlicePlane;
use scene::{Sampling, SlabMode};

use super::super::Samples;
use super::super::cpu::walk::inside;
use super::program::Way;

/// Bits of fraction of a place.
const ONE: f64 = (1_u64 << 48) as f64;
/// Marks the first run of a layer of points.
const NEW_LAYER: u32 = 1 << 31;

/// Most of anything in one piece of work.
#[derive(Debug, Clone, Copy)]
pub(super) struct Most {
    /// Pixels.
    pub(super) pixels: usize,
    /// Runs.
    pub(super) runs: usize,
    /// Points.
    pub(super) points: u64,
}

/// An image to be drawn.
#[derive(Debug)]
pub(super) struct Rows {
    samples: Samples,
    dims: [u32; 3],
    size: [usize; 2],
    mode: SlabMode,
}

/// Some of its rows of pixels, as the card reads them; buffers taken once.
#[derive(Debug, Default)]
pub(super) struct Band {
    /// For each row of pixels its first run and how many there are.
    pub(super) rows: Vec<[u32; 2]>,
    /// Place (three low words), first column, place (three high words), column behind the last.
    pub(super) runs: Vec<[u32; 8]>,
}

impl Rows {
    pub(super) fn new(volume: &VolumeView<'_>, plane: &SlicePlane, sampling: &Sampling) -> Self {
        Self {
            samples: Samples::new(volume, plane, sampling),
            dims: volume.grid.dims(),
            size: plane.size().map(|n| n as usize),
            mode: sampling.slab.map_or(SlabMode::Mean, |slab| slab.mode),
        }
    }

    /// Fills `band` with rows of pixels from `first` on, at least one; returns which.
    pub(super) fn fill(&self, first: usize, most: Most, band: &mut Band) -> Range<usize> {
        let (mut end, mut points) = (first, 0);
        band.rows.clear();
        band.runs.clear();
        while end < self.size[1] && (end - first + 1) * self.size[0] <= most.pixels.max(self.size[0]) {
            let before = band.runs.len();
            points += self.add_row(end, &mut band.runs);
            // One row is drawn however much it is: it cannot be cut.
            let too_much = band.runs.len() > most.runs || points > most.points;
            if too_much && end > first {
                band.runs.truncate(before);
                break;
            }
            band.rows.push([before as u32, (band.runs.len() - before) as u32]);
            end += 1;
        }
        first..end
    }

    /// Adds the runs of one row of pixels; returns how many points they have.
    fn add_row(&self, row: usize, runs: &mut Vec<[u32; 8]>) -> u64 {
        let [kx, ky] = self.samples.fold.map(|k| k as usize);
        let mut points = 0;
        for d in 0..self.samples.depths {
            let mut mark = NEW_LAYER;
            for y in row * ky..(row + 1) * ky {
                let (y, d) = (y as f64, f64::from(d));
                let columns = inside(&self.samples, [y, d], self.size[0] * kx, self.dims);
                if columns.is_empty() {
                    continue;
                }
                let at = self.samples.at(columns.start as f64, y, d).map(fixed);
                let [x, y, z] = at.map(|place| place as u32);
                let [above_x, above_y, above_z] = at.map(|place| (place >> 32) as u32);
                let (from, to) = (columns.start as u32 | mark, columns.end as u32);
                runs.push([x, y, z, from, above_x, above_y, above_z, to]);
                points += columns.len() as u64;
                mark = 0;
            }
        }
        points
    }

    /// The parameters of the program, in its order, for `rows` rows of pixels.
    pub(super) fn parameters(&self, rows: usize, padding: i16, way: Way) -> [u32; 20] {
        let step = self.samples.right.map(fixed);
        // 48 bits of fraction in two words: shaders have no 64-bit integers.
        let [x, y, z] = step.map(|step| step as u32);
        let [above_x, above_y, above_z] = step.map(|step| (step >> 32) as u32);
        let [nx, ny, nz] = self.dims;
        let mode = match self.mode {
            SlabMode::Mean => 0,
            SlabMode::Maximum => 1,
            SlabMode::Minimum => 2,
        };
        let numbers = [f32::from(padding), way.unit(), 1.0 / way.unit()];
        let [padding, unit, per_unit] = numbers.map(f32::to_bits);
        let (fold, width) = (self.samples.fold[0], self.size[0] as u32);
        [
            x,
            y,
            z,
            fold,
            above_x,
            above_y,
            above_z,
            width,
            nx,
            ny,
            nz,
            rows as u32,
            mode,
            padding,
            unit,
            per_unit,
            way.taps(),
            0,
            0,
            0,
        ]
    }
}

/// A place with 48 bits of fraction. Of a point inside it is exact to 2^-44; a step too long for it has no second point
/// inside.
fn fixed(index: f64) -> i64 {
    // Below 2^15 voxels, so that 48 bits of fraction fit into 63; longer ones saturate.
    (index * ONE).round() as i64
}
