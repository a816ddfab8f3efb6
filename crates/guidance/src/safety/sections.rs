//! The nearest voxel of each section of a tube, in two passes.
//!
//! First the blocks about the tube's solid, all of their voxels, each told to the few sections within the grid's reach of it; then, section by
//! section, the boundary voxels of the blocks beside it, where no voxel lies within.
//!
//! Distances are compared as *keys*: the square of a distance above zero, and a signed distance not above zero as it is. They are in the
//! same order, and a key costs no root.

use super::block::Block;
use super::placed::{About, Placed};
use super::search::Found;
use super::slab::{Place, Slab, key_of, mm_of};
use super::structures::{Ball, Structures};

/// A ball not too far from the tube: what is asked for each section lies close together in memory.
struct Near {
    middle: Place,
    radius: f64,
    /// Whose ball it is, in `owners`.
    owner: usize,
}

/// A block not too far from the tube.
struct Owner<'a> {
    label: i16,
    block: &'a Block,
    /// Its boundary voxels, once somebody has asked for them.
    boundary: Vec<(u16, Place)>,
}

/// The best voxel of a section so far.
#[derive(Clone, Copy)]
struct Hit {
    owner: usize,
    bit: u16,
    depth: f64,
}

/// The sections of a tube, and the blocks near it.
pub(super) struct Sections<'a> {
    tube: &'a Placed,
    reach: f64,
    slabs: Vec<Slab>,
    /// Sections in a millimetre.
    per_mm: f64,
    keys: Vec<f64>,
    hits: Vec<Option<Hit>>,
    /// By depth.
    near: Vec<Near>,
    owners: Vec<Owner<'a>>,
    /// The largest radius of the balls.
    widest: f64,
}

impl<'a> Sections<'a> {
    /// The voxels nearest to each slab and nearer than `limit_mm`. The slabs are the tube in equal parts.
    pub(super) fn new(structures: &'a Structures, tube: &'a Placed, slabs: Vec<Slab>, limit_mm: f64) -> Self {
        let (mut near, mut owners) = (Vec::new(), Vec::new());
        let look = |ball: &Ball| {
            let middle = Place::of(tube, tube.about(ball.centre.map(f64::from)));
            let radius = f64::from(ball.radius_mm);
            (middle.signed - radius < limit_mm).then_some((middle, radius))
        };
        for structure in &structures.list {
            let groups = structure.groups.iter().filter(|group| look(&group.ball).is_some());
            for k in groups.flat_map(|group| group.blocks.clone()) {
                if let Some((middle, radius)) = look(&structure.balls[k]) {
                    let owner = owners.len();
                    near.push(Near { middle, radius, owner });
                    owners.push(Owner {
                        label: structure.label(),
                        block: &structure.blocks[k],
                        boundary: Vec::new(),
                    });
                }
            }
        }
        let mut sections = Self {
            tube,
            reach: structures.lattice.reach_mm,
            per_mm: slabs.len() as f64 / slabs.last().map_or(1.0, |slab| slab.to),
            keys: vec![key_of(limit_mm); slabs.len()],
            hits: vec![None; slabs.len()],
            slabs,
            widest: near.iter().map(|near| near.radius).fold(0.0, f64::max),
            near,
            owners,
        };
        sections.near_the_solid();
        sections.beside();
        sections
    }

    /// The nearest voxel of a section and its label.
    pub(super) fn found(&self, section: usize) -> Option<(i16, Found)> {
        self.hits[section].map(|hit| {
            let owner = &self.owners[hit.owner];
            let found = Found {
                signed_mm: mm_of(self.keys[section]),
                depth_mm: hit.depth,
                voxel: owner.block.voxel(usize::from(hit.bit)),
            };
            (owner.label, found)
        })
    }

    /// The sections between two depths, with those at both ends.
    fn between(&self, from: f64, to: f64) -> std::ops::RangeInclusive<usize> {
        // Before the first section it is the first, as numbers below zero become 0.
        let at = |depth: f64| ((depth * self.per_mm) as usize).min(self.slabs.len() - 1);
        at(from)..=at(to)
    }

    /// Every voxel of the blocks within reach of the tube, to the sections within reach of it.
    fn near_the_solid(&mut self) {
        self.near
            .sort_unstable_by(|a, b| a.middle.signed.total_cmp(&b.middle.signed));
        // The deepest first: most others cannot be deeper then.
        for k in 0..self.near.len() {
            let Near { middle, radius, owner } = self.near[k];
            let least = middle.signed - radius;
            if least > self.reach {
                continue;
            }
            let around = radius + self.reach;
            let mut touched = self.between(middle.depth - around, middle.depth + around);
            if touched.any(|section| key_of(least) < self.keys[section]) {
                self.tell(owner);
            }
        }
    }

    /// Tells all voxels of a block to the sections within reach.
    fn tell(&mut self, owner: usize) {
        let (tube, block) = (self.tube, self.owners[owner].block);
        tube.each(block, &block.all, |bit, about| {
            let place = Place::of(tube, about);
            if place.signed <= self.reach {
                let hit = Hit {
                    owner,
                    bit: bit as u16,
                    depth: place.depth,
                };
                for section in self.between(place.depth - self.reach, place.depth + self.reach) {
                    self.better(section, &place, hit);
                }
            }
        });
    }

    fn better(&mut self, section: usize, place: &Place, hit: Hit) {
        let key = self.slabs[section].key(place);
        if key < self.keys[section] {
            self.keys[section] = key;
            self.hits[section] = Some(hit);
        }
    }

    /// The boundary voxels beside each section that has no voxel within.
    fn beside(&mut self) {
        self.near
            .sort_unstable_by(|a, b| a.middle.depth.total_cmp(&b.middle.depth));
        for section in 0..self.slabs.len() {
            // What was nearest to the section before is near to this one too.
            if let Some(hit) = section.checked_sub(1).and_then(|before| self.hits[before]) {
                let voxel = self.owners[hit.owner].block.voxel(usize::from(hit.bit));
                let place = Place::of(self.tube, self.tube.about(voxel.map(f64::from)));
                self.better(section, &place, hit);
            }
            // A voxel within is one of the solid, and all of those were told.
            if self.keys[section] > 0.0 {
                self.spread(section);
            }
        }
    }

    /// From the middle of a section to blocks on both sides, the nearer one first, as far as one may hold a nearer voxel.
    fn spread(&mut self, section: usize) {
        let slab = self.slabs[section];
        let middle = (slab.from + slab.to) / 2.0;
        let mut after = self.near.partition_point(|near| near.middle.depth < middle);
        let mut before = after;
        let mut so_far = mm_of(self.keys[section]);
        loop {
            let right = self.near.get(after).map_or(f64::INFINITY, |n| n.middle.depth - middle);
            let left = before
                .checked_sub(1)
                .map_or(f64::INFINITY, |k| middle - self.near[k].middle.depth);
            let gap = right.min(left) - (slab.to - middle) - self.widest;
            if right.min(left) == f64::INFINITY || gap >= so_far {
                return;
            }
            let k = if right <= left {
                after += 1;
                after - 1
            } else {
                before -= 1;
                before
            };
            let Near { middle, radius, owner } = &self.near[k];
            let most = so_far + radius;
            if slab.square(middle) < most * most {
                self.look(section, *owner);
                so_far = mm_of(self.keys[section]);
            }
        }
    }

    /// Looks at the boundary voxels of a block.
    fn look(&mut self, section: usize, k: usize) {
        let (tube, owner) = (self.tube, &mut self.owners[k]);
        if owner.boundary.is_empty() {
            let boundary = &mut owner.boundary;
            let see = |bit: usize, about: About| boundary.push((bit as u16, Place::of(tube, about)));
            tube.each(owner.block, &owner.block.boundary, see);
        }
        let (slab, mut best) = (self.slabs[section], self.keys[section]);
        for (bit, place) in &owner.boundary {
            let key = slab.key(place);
            if key < best {
                best = key;
                self.hits[section] = Some(Hit {
                    owner: k,
                    bit: *bit,
                    depth: place.depth,
                });
            }
        }
        self.keys[section] = best;
    }
}
