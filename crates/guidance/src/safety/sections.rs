//! The nearest voxel of each section of a tube.
//!
//! Distances are compared as *keys*: the square of a distance above zero, and a signed distance not above zero as it is. They are in the
//! same order, and a key costs no root.

use super::block::Block;
use super::placed::{About, Placed};
use super::search::Found;
use super::structures::{Ball, Structures};

/// A voxel, or a ball's centre, beside a tube.
#[derive(Clone, Copy)]
struct Place {
    depth: f64,
    /// How far outside the tube's side; less than zero within it.
    beside: f64,
    /// The signed distance from the whole tube.
    signed: f64,
}

impl Place {
    fn of(tube: &Placed, about: About) -> Self {
        Self {
            depth: about[2],
            beside: tube.beside(about),
            signed: tube.signed(about),
        }
    }
}

/// What a tube has between two depths, mm.
#[derive(Clone, Copy)]
pub(super) struct Slab {
    pub(super) from: f64,
    pub(super) to: f64,
}

impl Slab {
    /// The square of the distance, 0 within.
    #[inline]
    fn square(&self, place: &Place) -> f64 {
        let beside = place.beside.max(0.0);
        let beyond = (self.from - place.depth).max(place.depth - self.to).max(0.0);
        beside * beside + beyond * beyond
    }

    #[inline]
    fn key(&self, place: &Place) -> f64 {
        let square = self.square(place);
        if square > 0.0 { square } else { place.signed.min(0.0) }
    }
}

fn key_of(mm: f64) -> f64 {
    if mm > 0.0 { mm * mm } else { mm }
}

fn mm_of(key: f64) -> f64 {
    if key > 0.0 { key.sqrt() } else { key }
}

/// A block not too far from the tube.
struct Near<'a> {
    middle: Place,
    radius: f64,
    label: i16,
    block: &'a Block,
    /// The voxels that may be nearest, once somebody has asked for them.
    voxels: Vec<(u16, Place)>,
}

impl Near<'_> {
    /// Whether its ball may hold a key below `limit`, which is that of `limit_mm`.
    fn may_hold(&self, slab: &Slab, limit_mm: f64) -> bool {
        let square = slab.square(&self.middle);
        if square > self.radius * self.radius {
            let most = limit_mm.max(0.0) + self.radius;
            return square < most * most;
        }
        // A ball that reaches into the section holds distances from the tube, which are no greater than those from the section.
        self.middle.signed - self.radius < limit_mm
    }

    /// The voxel of least key, where that is below `limit`.
    fn nearest(&mut self, tube: &Placed, reach: f64, slab: &Slab, limit: f64) -> Option<(f64, u16, f64)> {
        if self.voxels.is_empty() {
            // A section is no nearer than the tube: what is beyond the reach of the tube is beyond that of each section.
            let is_beyond = self.middle.signed - self.radius > reach;
            let bits = if is_beyond {
                &self.block.boundary
            } else {
                &self.block.all
            };
            let voxels = &mut self.voxels;
            tube.each(self.block, bits, |bit, about| {
                voxels.push((bit as u16, Place::of(tube, about)))
            });
        }
        let (mut best, mut found) = (limit, None);
        for (bit, place) in &self.voxels {
            let key = slab.key(place);
            if key < best {
                best = key;
                found = Some((key, *bit, place.depth));
            }
        }
        found
    }
}

/// The blocks near a tube by their depth.
pub(super) struct Sections<'a> {
    tube: &'a Placed,
    reach: f64,
    limit_mm: f64,
    near: Vec<Near<'a>>,
    /// The largest radius of their balls.
    widest: f64,
}

impl<'a> Sections<'a> {
    /// For voxels nearer than `limit_mm`.
    pub(super) fn new(structures: &'a Structures, tube: &'a Placed, limit_mm: f64) -> Self {
        let look = |ball: &Ball| {
            let middle = Place::of(tube, tube.about(ball.centre.map(f64::from)));
            let radius = f64::from(ball.radius_mm);
            (middle.signed - radius < limit_mm).then_some((middle, radius))
        };
        let mut near = Vec::new();
        for structure in &structures.list {
            let groups = structure.groups.iter().filter(|group| look(&group.ball).is_some());
            for k in groups.flat_map(|group| group.blocks.clone()) {
                near.extend(look(&structure.balls[k]).map(|(middle, radius)| Near {
                    middle,
                    radius,
                    label: structure.label(),
                    block: &structure.blocks[k],
                    voxels: Vec::new(),
                }));
            }
        }
        near.sort_unstable_by(|a, b| a.middle.depth.total_cmp(&b.middle.depth));
        let widest = near.iter().map(|near| near.radius).fold(0.0, f64::max);
        let reach = structures.lattice.reach_mm;
        Self {
            tube,
            reach,
            limit_mm,
            near,
            widest,
        }
    }

    /// The nearest voxel of a section and its label, where it is nearer than the limit. `seed` is that of a section beside it.
    pub(super) fn nearest(&mut self, slab: &Slab, seed: Option<(i16, Found)>) -> Option<(i16, Found)> {
        let mut best = seed.map(|(label, found)| {
            let place = Place::of(self.tube, self.tube.about(found.voxel.map(f64::from)));
            let signed_mm = mm_of(slab.key(&place));
            (label, Found { signed_mm, ..found })
        });
        best = best.filter(|(_, found)| found.signed_mm < self.limit_mm);
        let middle = (slab.from + slab.to) / 2.0;
        let mut after = self.near.partition_point(|near| near.middle.depth < middle);
        let mut before = after;
        loop {
            let so_far = best.map_or(self.limit_mm, |(_, found)| found.signed_mm);
            // Away from the middle of the section on both sides, the nearer one first.
            let right = self.near.get(after).map_or(f64::INFINITY, |n| n.middle.depth - middle);
            let left = before
                .checked_sub(1)
                .map_or(f64::INFINITY, |k| middle - self.near[k].middle.depth);
            let gap = right.min(left) - (slab.to - middle) - self.widest;
            if right.min(left) == f64::INFINITY || gap >= so_far.max(0.0) {
                return best;
            }
            let k = if right <= left {
                after += 1;
                after - 1
            } else {
                before -= 1;
                before
            };
            let near = &mut self.near[k];
            if !near.may_hold(slab, so_far) {
                continue;
            }
            if let Some((key, bit, depth_mm)) = near.nearest(self.tube, self.reach, slab, key_of(so_far)) {
                let (signed_mm, voxel) = (mm_of(key), near.block.voxel(usize::from(bit)));
                let found = Found {
                    signed_mm,
                    depth_mm,
                    voxel,
                };
                best = Some((near.label, found));
            }
        }
    }
}
