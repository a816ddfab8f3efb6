//! The tree of dark regions of a plane: every region below a level hangs under the one that swallows it.

use crate::image::Plane;

/// Grey levels that a plane is rounded to.
const LEVELS: usize = 1024;

/// A tree over pixels; a node is a pixel that stands for its region.
#[derive(Debug)]
pub(crate) struct Tree {
    /// Pixels from the darkest.
    pub(crate) order: Vec<u32>,
    /// The node that a pixel or node hangs under.
    pub(crate) parent: Vec<u32>,
    /// Level of each pixel.
    pub(crate) level: Vec<u16>,
    /// Grey of a level's step.
    pub(crate) step: f64,
}

impl Tree {
    /// Of dark regions, of bright ones where `bright`; pixels are joined through their sides.
    pub(crate) fn new(plane: &Plane, bright: bool) -> Self {
        let bounds = plane
            .samples
            .iter()
            .fold([f32::MAX, f32::MIN], |[low, high], v| [low.min(*v), high.max(*v)]);
        let step = (f64::from(bounds[1] - bounds[0]) / (LEVELS - 1) as f64).max(1e-6);
        let scale = (1.0 / step) as f32;
        let place = |v: &f32| {
            let level = if bright { bounds[1] - v } else { v - bounds[0] };
            ((level * scale) as usize).min(LEVELS - 1) as u16
        };
        let level: Vec<u16> = plane.samples.iter().map(place).collect();
        let order = sorted(&level);
        let parent = joined(&order, &level, plane.width);
        Self {
            order,
            parent,
            level,
            step,
        }
    }

    /// Whether a pixel stands for a region.
    pub(crate) fn is_node(&self, p: usize) -> bool {
        let parent = self.parent[p] as usize;
        parent == p || self.level[parent] != self.level[p]
    }
}

/// Pixels by level, by counting.
fn sorted(level: &[u16]) -> Vec<u32> {
    let mut starts = vec![0_u32; LEVELS + 1];
    level.iter().for_each(|l| starts[usize::from(*l) + 1] += 1);
    (0..LEVELS).for_each(|k| starts[k + 1] += starts[k]);
    let mut order = vec![0; level.len()];
    for (p, l) in level.iter().enumerate() {
        let slot = &mut starts[usize::from(*l)];
        order[*slot as usize] = p as u32;
        *slot += 1;
    }
    order
}

fn root_of(roots: &mut [u32], p: u32) -> u32 {
    let mut r = p;
    while roots[r as usize] != r {
        let up = roots[roots[r as usize] as usize];
        roots[r as usize] = up;
        r = up;
    }
    r
}

/// Union by level (Berger 2007): the pixel that comes later swallows its neighbours' regions.
fn joined(order: &[u32], level: &[u16], width: usize) -> Vec<u32> {
    let n = level.len();
    let mut parent = vec![u32::MAX; n];
    let mut roots = vec![u32::MAX; n];
    for p in order.iter().copied() {
        let i = p as usize;
        (parent[i], roots[i]) = (p, p);
        let x = i % width;
        let sides = [
            (x > 0).then(|| i - 1),
            (x + 1 < width).then_some(i + 1),
            i.checked_sub(width),
            Some(i + width).filter(|j| *j < n),
        ];
        for j in sides.into_iter().flatten() {
            if parent[j] == u32::MAX {
                continue;
            }
            let root = root_of(&mut roots, j as u32);
            if root != p {
                (roots[root as usize], parent[root as usize]) = (p, p);
            }
        }
    }
    for p in order.iter().rev().copied() {
        let up = parent[p as usize] as usize;
        let above = parent[up];
        if level[above as usize] == level[up] {
            parent[p as usize] = above;
        }
    }
    parent
}
