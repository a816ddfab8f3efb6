//! Going over an image: rows, the points of large pixels, the layers of slabs.
//!
//! Thin images of single points are drawn in tiles, whose neighbourhood in the volume fits the nearest cache in every
//! direction of the plane (see `tiles`). Pixels of several points are drawn row by row through sums in f64.

use std::ops::Range;

use bus::volume::VolumeView;
use geometry::SlicePlane;
use scene::{Sampling, SlabMode};

use super::super::Samples;
use super::aligned::{Axes, Lines, Separable};
use super::kernel::Kernel;
use super::kernels::Draw;
use super::patch::Patches;
use super::region::Region;
use super::tiles::{Copies, Tiles};
use super::vector::Vector;
use super::walk::{LANES, Walk, lanes};

/// Buffers of one row, taken once.
#[derive(Debug, Clone, Default)]
pub(super) struct Fold {
    points: Vec<f32>,
    area: Vec<(f64, f64)>,
    pixels: Vec<(f64, f64)>,
    lines: Lines,
    copies: Copies,
    walks: Vec<(Walk, Range<usize>)>,
}

/// An image being drawn.
pub(super) struct Image<'a> {
    samples: Samples,
    lanes: Option<[[i32; LANES]; 3]>,
    dims: [u32; 3],
    width: usize,
    mode: SlabMode,
    padding: f32,
    fold: &'a mut Fold,
    hu: &'a mut [f32],
}

impl Draw for Image<'_> {
    fn draw<const N: usize>(&mut self, kernel: &impl Separable<N>) {
        let [kx, ky] = self.samples.fold.map(|k| k as usize);
        let points = [self.width * kx, self.hu.len() / self.width * ky];
        match Axes::of(&self.samples, points) {
            Some(axes) => Vector::with(kernel.vector(), || self.draw_aligned(kernel, axes)),
            None if self.samples.are_pixels() => self.draw_points(kernel),
            None => {
                let (dims, padding) = (self.dims, self.padding);
                self.draw_sums(|walk, _, line| {
                    let blocks = whole_blocks(kernel, walk, dims);
                    segment(kernel, walk, &blocks, 0..line.len(), line, padding);
                });
            }
        }
    }
}

impl<'a> Image<'a> {
    pub(super) fn new(
        volume: &VolumeView<'_>,
        plane: &SlicePlane,
        sampling: &Sampling,
        fold: &'a mut Fold,
        hu: &'a mut [f32],
    ) -> Self {
        let samples = Samples::new(volume, plane, sampling);
        Self {
            lanes: lanes(samples.right),
            samples,
            dims: volume.grid.dims(),
            width: plane.size()[0] as usize,
            mode: sampling.slab.map_or(SlabMode::Mean, |slab| slab.mode),
            padding: f32::from(volume.padding_hu),
            fold,
            hu,
        }
    }

    /// A plane along the volume's axes.
    #[inline(always)]
    fn draw_aligned<const N: usize>(&mut self, kernel: &impl Separable<N>, axes: Axes) {
        let mut lines = std::mem::take(&mut self.fold.lines);
        lines.restart(self.samples.depths);
        if self.samples.are_pixels() {
            for y in 0..self.hu.len() / self.width {
                let walk = self.walk(y, 0, self.width);
                let line = &mut self.hu[y * self.width..][..self.width];
                line[..walk.inside.start].fill(self.padding);
                line[walk.inside.end..].fill(self.padding);
                lines.draw(kernel, axes, &walk, 0, line);
            }
        } else {
            self.draw_sums(|walk, d, line| lines.draw(kernel, axes, walk, d, line));
        }
        self.fold.lines = lines;
    }

    fn walk(&self, y: usize, d: u32, width: usize) -> Walk {
        Walk::new(&self.samples, self.lanes, [y as f64, f64::from(d)], width, self.dims)
    }

    /// Single points, tile by tile. While one tile is drawn, the memory of the next is asked for.
    fn draw_points(&mut self, kernel: &impl Kernel) {
        let tiles = Tiles::of(&self.samples, kernel.reach(), [self.width, self.hu.len() / self.width]);
        let region = |i: usize| {
            let tile = (i < tiles.count()).then(|| tiles.tile(i))?;
            Region::new(&self.samples, &tile, tiles.reach()?, self.dims)
        };
        let mut copies = std::mem::take(&mut self.fold.copies);
        let mut walks = std::mem::take(&mut self.fold.walks);
        copies.plan(kernel, region(0));
        for i in 0..tiles.count() {
            let tile = tiles.tile(i);
            // Tiles side by side have the same rows, whose walks are made once.
            if tile.columns.start == 0 {
                walks.clear();
                walks.extend(tile.rows.clone().map(|y| self.row(kernel, y)));
            }
            // The plan is used up before the next tile's takes its place.
            copies.take(kernel);
            copies.plan(kernel, region(i + 1));
            for (n, (y, (walk, blocks))) in tile.rows.clone().zip(&walks).enumerate() {
                copies.fetch(kernel, n, tile.rows.len());
                let line = &mut self.hu[y * self.width..][tile.columns.clone()];
                match copies.held() {
                    Some(patches) => copied(kernel, patches, walk, tile.columns.clone(), line, self.padding),
                    None => segment(kernel, walk, blocks, tile.columns.clone(), line, self.padding),
                }
            }
        }
        self.fold.copies = copies;
        self.fold.walks = walks;
    }

    /// A row of points, and which of its blocks can be done as a whole.
    fn row(&self, kernel: &impl Kernel, y: usize) -> (Walk, Range<usize>) {
        let walk = self.walk(y, 0, self.width);
        let blocks = whole_blocks(kernel, &walk, self.dims);
        (walk, blocks)
    }

    /// Pixels of several points; `draw` draws the inside of a row of points of a layer.
    #[inline(always)]
    fn draw_sums(&mut self, mut draw: impl FnMut(&Walk, u32, &mut [f32])) {
        let [kx, ky] = self.samples.fold.map(|k| k as usize);
        let width = self.width * kx;
        // Taken out while it is used, as the drawing borrows the rest.
        let mut fold = std::mem::take(self.fold);
        fold.points.resize(width, 0.0);
        for row in 0..self.hu.len() / self.width {
            fold.pixels.clear();
            fold.pixels.resize(self.width, (0.0, 0.0));
            for d in 0..self.samples.depths {
                fold.area.clear();
                fold.area.resize(self.width, (0.0, 0.0));
                for j in 0..ky {
                    let walk = self.walk(row * ky + j, d, width);
                    draw(&walk, d, &mut fold.points);
                    // Points outside the volume do not count, so that the border keeps its grey.
                    for x in walk.inside.clone() {
                        let (sum, count) = &mut fold.area[x / kx];
                        // In f64, so that the mean of many points adds no error to theirs.
                        *sum += f64::from(fold.points[x]);
                        *count += 1.0;
                    }
                }
                add_layer(self.mode, &fold.area, &mut fold.pixels);
            }
            for ((sum, count), hu) in fold.pixels.iter().zip(&mut self.hu[row * self.width..]) {
                *hu = if *count > 0.0 {
                    (sum / count) as f32
                } else {
                    self.padding
                };
            }
        }
        *self.fold = fold;
    }
}

/// The means of one layer become part of the pixels; a pixel is its first number over its second.
fn add_layer(mode: SlabMode, area: &[(f64, f64)], pixels: &mut [(f64, f64)]) {
    for ((sum, count), pixel) in area.iter().zip(pixels) {
        if *count == 0.0 {
            continue;
        }
        let mean = sum / count;
        *pixel = match mode {
            SlabMode::Mean => (pixel.0 + mean, pixel.1 + 1.0),
            // The first layer inside: a maximum with the zero that pixels begin with would hide air, which is below 0
            // HU.
            _ if pixel.1 == 0.0 => (mean, 1.0),
            SlabMode::Maximum => (pixel.0.max(mean), 1.0),
            SlabMode::Minimum => (pixel.0.min(mean), 1.0),
        };
    }
}

/// The blocks that the kernel can do as a whole.
fn whole_blocks(kernel: &impl Kernel, walk: &Walk, dims: [u32; 3]) -> Range<usize> {
    let (Some(reach), Some(_)) = (kernel.whole_blocks(), &walk.lanes) else {
        return 0..0;
    };
    let interior = walk.interior(dims, reach);
    // Blocks that lie in the interior whole.
    interior.start.div_ceil(LANES)..interior.end / LANES
}

/// Draws `columns` of a row into `line` from a copy of what they need.
fn copied(kernel: &impl Kernel, patches: &Patches, walk: &Walk, columns: Range<usize>, line: &mut [f32], padding: f32) {
    let clip = |c: usize| c.clamp(columns.start, columns.end);
    let inside = clip(walk.inside.start)..clip(walk.inside.end);
    let at = |c: usize| c - columns.start;
    line[..at(inside.start)].fill(padding);
    line[at(inside.end)..].fill(padding);
    kernel.copied(
        patches,
        walk,
        inside.clone(),
        &mut line[at(inside.start)..at(inside.end)],
    );
}

/// Draws `columns` of a row into `line`. Tiles begin at whole blocks.
fn segment(
    kernel: &impl Kernel,
    walk: &Walk,
    blocks: &Range<usize>,
    columns: Range<usize>,
    line: &mut [f32],
    padding: f32,
) {
    let clip = |c: usize| c.clamp(columns.start, columns.end);
    let inside = clip(walk.inside.start)..clip(walk.inside.end);
    let whole = clip(blocks.start * LANES)..clip(blocks.end * LANES);
    let whole = match whole.is_empty() {
        true => inside.end..inside.end,
        // A tile's end within a block leaves the rest of it to the points.
        false => whole.start..whole.start + (whole.end - whole.start) / LANES * LANES,
    };
    let at = |c: usize| c - columns.start;
    line[..at(inside.start)].fill(padding);
    kernel.points(
        walk,
        inside.start..whole.start,
        &mut line[at(inside.start)..at(whole.start)],
    );
    if !whole.is_empty() {
        kernel.blocks(walk, whole.start / LANES, &mut line[at(whole.start)..at(whole.end)]);
    }
    kernel.points(walk, whole.end..inside.end, &mut line[at(whole.end)..at(inside.end)]);
    line[at(inside.end)..].fill(padding);
}
