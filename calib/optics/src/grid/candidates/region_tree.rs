//! The tree of dark regions of a plane: every region below a level hangs under the one that swallows it.
//!
//! The plane is flooded from its darkest places as by water (Nister and Stewenius 2008): pixels are met region by region,
//! so that time is linear in them and memory is touched where it was touched last.

use crate::image::Plane;

/// Grey levels that a plane is rounded to.
const GREY_LEVELS: usize = 1024;
/// Regions of fewer pixels are not kept.
pub(crate) const MIN_AREA: f64 = 5.0;
/// 2^23, from where on numbers are whole.
const WHOLE_FROM: f32 = 8_388_608.0;
const NO_REGION: u32 = u32::MAX;
/// In place of a pixel's level: it is on the shore or belongs to a region.
const SEEN_LEVEL: u16 = u16::MAX;

/// A region: everything below its level that hangs together through the sides of pixels.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Node {
    /// The region that swallows it; itself for the whole plane.
    pub(crate) parent: u32,
    pub(crate) level: u16,
    /// Its darkest pixel's level.
    pub(crate) darkest: u16,
    /// Area, sums of x and y, and of their products; beyond the area that was asked for no sums but the area.
    pub(crate) sums: [f64; 6],
}

/// The regions of a plane, each behind those that it swallows.
#[derive(Debug)]
pub(crate) struct Tree {
    pub(crate) nodes: Vec<Node>,
    /// Grey of a level's step.
    pub(crate) step: f64,
}

impl Tree {
    /// Of dark regions, of bright ones where `bright`, by levels of `finest` grey at least; sums of those of an area of up to
    /// `greatest`.
    pub(crate) fn new(plane: &Plane, bright: bool, finest: f64, greatest: f64) -> Self {
        let bounds = bounds(&plane.samples);
        // A plane of one grey has no range: any step above 0 will do.
        let step = (f64::from(bounds[1] - bounds[0]) / (GREY_LEVELS - 1) as f64)
            .max(finest)
            .max(1e-6);
        let scale = (1.0 / step) as f32;
        // Below 2^23 the sum has the number, rounded, in its lowest bits, and a half less cuts off: as a conversion it
        // would go one by one.
        let place = |v: &f32| {
            let level = if bright { bounds[1] - v } else { v - bounds[0] };
            (((level * scale - 0.5).max(0.0) + WHOLE_FROM).to_bits() as u16).min(GREY_LEVELS as u16 - 1)
        };
        let levels: Vec<u16> = plane.samples.iter().map(place).collect();
        let nodes = Flood::new(&levels, plane.width, greatest).run();
        Self { nodes, step }
    }
}

/// The least and the greatest, in eight lanes.
fn bounds(samples: &[f32]) -> [f32; 2] {
    let (mut low, mut high) = ([f32::MAX; 8], [f32::MIN; 8]);
    for part in samples.chunks(8) {
        for (k, v) in part.iter().enumerate() {
            // A plain comparison, which `f32::min` is not (it must look for NaN), becomes one vector instruction.
            low[k] = if *v < low[k] { *v } else { low[k] };
            high[k] = if *v > high[k] { *v } else { high[k] };
        }
    }
    [
        low.into_iter().fold(f32::MAX, f32::min),
        high.into_iter().fold(f32::MIN, f32::max),
    ]
}

/// A region while it grows: a node without a parent, and the nodes that it has swallowed and that wait for theirs.
#[derive(Debug, Clone, Copy)]
struct Growing {
    level: u16,
    darkest: u16,
    sums: [f64; 6],
    /// The first and the last of a list of nodes.
    held: [u32; 2],
}

impl Growing {
    fn new(level: u16) -> Self {
        Self {
            level,
            darkest: level,
            sums: [0.0; 6],
            held: [NO_REGION; 2],
        }
    }
}

/// Pixels that were seen from a region but do not belong to one yet, lists by level.
struct Shore {
    first: Vec<u32>,
    /// The pixel behind each in its list.
    next: Vec<u32>,
    /// A bit for each level whose list is not empty.
    full: [u64; GREY_LEVELS / 64],
}

impl Shore {
    #[inline]
    fn push(&mut self, pixel: u32, level: u16) {
        let l = usize::from(level);
        self.next[pixel as usize] = self.first[l];
        self.first[l] = pixel;
        self.full[l / 64] |= 1 << (l % 64);
    }

    /// The darkest, and its level; none is below `level`.
    #[inline]
    fn pop(&mut self, level: u16) -> Option<(u32, u16)> {
        let first = usize::from(level) / 64;
        // The water never falls below `level` here: lower words are empty.
        let word = first + self.full.get(first..)?.iter().position(|w| *w != 0)?;
        let l = word * 64 + self.full[word].trailing_zeros() as usize;
        let pixel = self.first[l];
        self.first[l] = self.next[pixel as usize];
        if self.first[l] == NO_REGION {
            self.full[word] &= !(1 << (l % 64));
        }
        Some((pixel, l as u16))
    }
}

/// The plane with a rim of one pixel about it, which counts as seen: no pixel needs to ask where the plane ends.
struct Flood {
    /// Levels of pixels not seen yet.
    levels: Vec<u16>,
    /// Of the plane with its rim; whole pixels of the image have 32 bits.
    width: u32,
    /// 2^64 over the width, rounded up: below 2^32 pixels the upper half of the product with it is the exact quotient.
    inverse: u64,
    shore: Shore,
    /// Regions around each other, the darkest last, and the one within them all that grows.
    stack: Vec<Growing>,
    top: Growing,
    /// Larger regions are but counted.
    greatest: f64,
    nodes: Vec<Node>,
    /// The node behind each in the list that waits for its parent.
    next: Vec<u32>,
}

impl Flood {
    fn new(levels: &[u16], width: usize, greatest: f64) -> Self {
        let wide = width + 2;
        let rows = levels.chunks_exact(width.max(1));
        let size = wide * (rows.len() + 2);
        // A rim of pixels that are seen already: the flood needs no test for the border of the image.
        let mut rimmed = vec![SEEN_LEVEL; size];
        for (y, row) in rows.enumerate() {
            let from = (y + 1) * wide + 1;
            rimmed[from..from + width].copy_from_slice(row);
        }
        let shore = Shore {
            first: vec![NO_REGION; GREY_LEVELS],
            next: vec![NO_REGION; size],
            full: [0; GREY_LEVELS / 64],
        };
        Self {
            levels: rimmed,
            width: wide as u32,
            inverse: u64::MAX / wide as u64 + 1,
            shore,
            stack: Vec::new(),
            top: Growing::new(0),
            greatest,
            nodes: Vec::new(),
            next: Vec::new(),
        }
    }

    fn run(mut self) -> Vec<Node> {
        let corner = self.width as usize + 1;
        let Some(mut level) = self.levels.get(corner).copied().filter(|l| *l != SEEN_LEVEL) else {
            return self.nodes;
        };
        let mut pixel = corner;
        self.levels[corner] = SEEN_LEVEL;
        self.top = Growing::new(level);
        loop {
            // Down to where nothing around is darker.
            while let Some((darker, below)) = self.darker(pixel, level) {
                self.shore.push(pixel as u32, level);
                self.stack.push(std::mem::replace(&mut self.top, Growing::new(below)));
                (pixel, level) = (darker, below);
            }
            self.take(pixel);
            let Some((next, above)) = self.shore.pop(level) else {
                break;
            };
            if above > level {
                self.rise(above);
            }
            (pixel, level) = (next as usize, above);
        }
        self.rise(u16::MAX);
        // The whole plane hangs under itself.
        if let Some(root) = self.nodes.len().checked_sub(1) {
            self.nodes[root].parent = root as u32;
        }
        self.nodes
    }

    /// Puts the neighbours not seen yet on the shore, up to one that is darker than `level`.
    #[inline]
    fn darker(&mut self, pixel: usize, level: u16) -> Option<(usize, u16)> {
        let wide = self.width as usize;
        for side in [pixel - 1, pixel + 1, pixel - wide, pixel + wide] {
            let other = self.levels[side];
            if other == SEEN_LEVEL {
                continue;
            }
            self.levels[side] = SEEN_LEVEL;
            if other < level {
                return Some((side, other));
            }
            self.shore.push(side as u32, other);
        }
        None
    }

    /// Gives a pixel to the region that grows.
    #[inline]
    fn take(&mut self, pixel: usize) {
        let sums = &mut self.top.sums;
        sums[0] += 1.0;
        // No candidate is so large: its centroid and shape are never asked for.
        if sums[0] > self.greatest {
            return;
        }
        let row = ((pixel as u128 * u128::from(self.inverse)) >> 64) as u32;
        let (x, y) = (
            f64::from((pixel as u32 - row * self.width) as i32 - 1),
            f64::from(row as i32 - 1),
        );
        let part = [x, y, x * x, x * y, y * y];
        sums[1..].iter_mut().zip(part).for_each(|(to, v)| *to += v);
    }

    /// The water rises to a level: regions below it are done, and those that meet become one.
    fn rise(&mut self, level: u16) {
        while self.top.level < level {
            let mut done = self.top;
            self.done(&mut done);
            match self.stack.last().copied() {
                Some(under) if under.level <= level => {
                    self.stack.pop();
                    self.top = under;
                    let sums = self.top.sums.iter_mut().zip(done.sums);
                    sums.for_each(|(to, v)| *to += v);
                    self.top.darkest = under.darkest.min(done.darkest);
                    self.top.held = joined(&mut self.next, under.held, done.held);
                }
                _ => {
                    // What is under it lies higher than the water: the same region goes on, at the new level.
                    done.level = level;
                    self.top = done;
                }
            }
        }
    }

    /// Makes a region a node, and the parent of what it holds.
    fn done(&mut self, region: &mut Growing) {
        // It holds no nodes either, as they would be smaller still.
        if region.sums[0] < MIN_AREA {
            return;
        }
        let node = self.nodes.len() as u32;
        let mut held = region.held[0];
        while held != NO_REGION {
            self.nodes[held as usize].parent = node;
            held = self.next[held as usize];
        }
        self.nodes.push(Node {
            parent: node,
            level: region.level,
            darkest: region.darkest,
            sums: region.sums,
        });
        self.next.push(NO_REGION);
        region.held = [node; 2];
    }
}

/// Two lists of nodes as one.
fn joined(next: &mut [u32], a: [u32; 2], b: [u32; 2]) -> [u32; 2] {
    if a[0] == NO_REGION {
        return b;
    }
    if b[0] == NO_REGION {
        return a;
    }
    next[a[1] as usize] = b[0];
    [a[0], b[1]]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Area and level of the region of a pixel at every level, by flooding from it anew.
    fn area(levels: &[u16], width: usize, from: usize, level: u16) -> usize {
        let (mut seen, mut open) = (vec![false; levels.len()], vec![from]);
        seen[from] = true;
        let mut count = 0;
        while let Some(p) = open.pop() {
            count += 1;
            let x = p % width;
            let sides = [
                (x > 0).then(|| p - 1),
                (x + 1 < width).then_some(p + 1),
                p.checked_sub(width),
                Some(p + width).filter(|j| *j < levels.len()),
            ];
            for q in sides.into_iter().flatten() {
                if !seen[q] && levels[q] <= level {
                    seen[q] = true;
                    open.push(q);
                }
            }
        }
        count
    }

    #[test]
    fn regions_are_those_that_flooding_from_each_pixel_finds() {
        let (width, height) = (23, 17);
        let mut state = 12345_u32;
        let mut random = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 20) as u16 % 40
        };
        let levels: Vec<u16> = (0..width * height).map(|_| random()).collect();
        let nodes = Flood::new(&levels, width, f64::MAX).run();
        // Every node is a region by its area, and every region of a pixel at its own level is a node.
        let mut found: Vec<(u16, usize)> = nodes.iter().map(|n| (n.level, n.sums[0] as usize)).collect();
        let mut known: Vec<(u16, usize, usize)> = Vec::new();
        for p in 0..levels.len() {
            let count = area(&levels, width, p, levels[p]);
            // The region's first pixel of that level stands for it.
            let same = (0..p).any(|q| levels[q] == levels[p] && area_holds(&levels, width, p, q));
            if count as f64 >= MIN_AREA && !same {
                known.push((levels[p], count, p));
            }
        }
        let mut known: Vec<(u16, usize)> = known.into_iter().map(|(l, c, _)| (l, c)).collect();
        found.sort_unstable();
        known.sort_unstable();
        assert_eq!(found, known);
        let root = nodes.last().unwrap();
        assert_eq!(root.sums[0] as usize, levels.len());
        for (i, node) in nodes.iter().enumerate() {
            let parent = &nodes[node.parent as usize];
            assert!(node.parent as usize > i || node.parent as usize == nodes.len() - 1);
            assert!(parent.level > node.level || node.parent as usize == i, "{i}");
            assert!(parent.sums[0] > node.sums[0] || node.parent as usize == i, "{i}");
        }
    }

    /// Whether a pixel lies in the region of another at that one's level.
    fn area_holds(levels: &[u16], width: usize, from: usize, other: usize) -> bool {
        let level = levels[from];
        let without = area(levels, width, from, level);
        let mut cut = levels.to_vec();
        cut[other] = u16::MAX;
        area(&cut, width, from, level) != without
    }

    #[test]
    fn a_plane_of_one_level_is_one_region() {
        let nodes = Flood::new(&[7; 12], 4, 12.0).run();
        assert_eq!((nodes.len(), nodes[0].sums[0], nodes[0].parent), (1, 12.0, 0));
        assert!(Flood::new(&[7; 4], 2, 4.0).run().is_empty());
        assert!(Flood::new(&[], 1, 1.0).run().is_empty());
    }
}
