//! Candidates of a grid: regions that hardly grow while the level rises, and that are ellipses.

use nalgebra::{Matrix2, Vector2};

use super::tree::Tree;
use crate::image::Plane;

/// The most candidates, the most salient first: what follows takes time in their square.
pub(crate) const MAX_BLOBS: usize = 1200;
/// Fewer pixels have no shape.
const MIN_AREA: f64 = 5.0;
/// The most that a region may grow, beside its own area.
const MAX_GROWTH: f64 = 0.75;
/// Area beside that of the ellipse of the same moments: 1 for an ellipse, 0.955 for a square.
const MIN_FILL: f64 = 0.8;
/// Regions that hold each other and differ by less in area are one candidate.
const SAME: f64 = 4.0;

/// A region that may be a disc.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Blob {
    /// Centroid, pixels.
    pub(crate) at: Vector2<f64>,
    /// Four times its second moment: the shape of the ellipse.
    pub(crate) shape: Matrix2<f64>,
    /// Pixels.
    pub(crate) area: f64,
    /// How far below what swallows it its darkest pixel is, steps of a sample.
    pub(crate) depth: f64,
}

/// Area, sums of x and y, and of their products; the darkest level.
#[derive(Debug, Clone, Copy, Default)]
struct Moments {
    sums: [f64; 6],
    darkest: u16,
}

/// The candidates of a plane whose noise has the deviation `noise`.
pub(crate) fn blobs(plane: &Plane, noise: f64, bright: bool) -> Vec<Blob> {
    let tree = Tree::new(plane, bright);
    let moments = gathered(&tree, plane.width);
    // What noise alone does to a level does not count as growth, nor what rounding does.
    let delta = ((4.0 * noise / tree.step).ceil() as u16)
        .max((2.0 / tree.step).ceil() as u16)
        .max(4);
    let greatest = (plane.samples.len() as f64 / 40.0).max(MIN_AREA);
    let mut stable: Vec<(f64, u32)> = Vec::new();
    for p in 0..tree.parent.len() {
        let area = moments[p].sums[0];
        if tree.is_node(p) && (MIN_AREA..=greatest).contains(&area) && fill(&moments[p]) > MIN_FILL {
            let growth = growth(&tree, &moments, p, delta);
            if growth < MAX_GROWTH {
                stable.push((growth, p as u32));
            }
        }
    }
    stable.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut found: Vec<Blob> = distinct(&tree, &moments, &stable);
    found.sort_by(|a, b| (b.depth * b.area.sqrt()).total_cmp(&(a.depth * a.area.sqrt())));
    found.truncate(MAX_BLOBS);
    found
}

fn gathered(tree: &Tree, width: usize) -> Vec<Moments> {
    let mut moments: Vec<Moments> = (0..tree.parent.len())
        .map(|p| {
            let (x, y) = ((p % width) as f64, (p / width) as f64);
            let sums = [1.0, x, y, x * x, x * y, y * y];
            Moments {
                sums,
                darkest: tree.level[p],
            }
        })
        .collect();
    for p in &tree.order {
        let (p, up) = (*p as usize, tree.parent[*p as usize] as usize);
        if p != up {
            let part = moments[p];
            let whole = &mut moments[up];
            (0..6).for_each(|k| whole.sums[k] += part.sums[k]);
            whole.darkest = whole.darkest.min(part.darkest);
        }
    }
    moments
}

fn ellipse(moments: &Moments) -> (Vector2<f64>, Matrix2<f64>) {
    let [n, x, y, xx, xy, yy] = moments.sums;
    let (x, y) = (x / n, y / n);
    // A pixel is a square: its own second moment is 1/12.
    let (a, b, c) = (xx / n - x * x + 1.0 / 12.0, xy / n - x * y, yy / n - y * y + 1.0 / 12.0);
    (Vector2::new(x, y), Matrix2::new(a, b, b, c) * 4.0)
}

fn fill(moments: &Moments) -> f64 {
    let (_, shape) = ellipse(moments);
    moments.sums[0] / (std::f64::consts::PI * shape.determinant().max(1e-12).sqrt())
}

/// How much the region gains when the level rises by `delta`, beside its area.
fn growth(tree: &Tree, moments: &[Moments], p: usize, delta: u16) -> f64 {
    let (limit, area) = (tree.level[p].saturating_add(delta), moments[p].sums[0]);
    let mut q = p;
    loop {
        let up = tree.parent[q] as usize;
        if up == q || tree.level[up] > limit {
            return moments[q].sums[0] / area - 1.0;
        }
        q = up;
    }
}

/// Of regions that hold each other the most stable.
fn distinct(tree: &Tree, moments: &[Moments], stable: &[(f64, u32)]) -> Vec<Blob> {
    let mut taken = vec![false; tree.parent.len()];
    let mut holds = vec![false; tree.parent.len()];
    let mut found = Vec::new();
    for (_, p) in stable {
        let p = *p as usize;
        let area = moments[p].sums[0];
        if holds[p] || within_taken(tree, moments, p, &taken) {
            continue;
        }
        taken[p] = true;
        let mut q = p;
        loop {
            let up = tree.parent[q] as usize;
            if up == q || moments[up].sums[0] > SAME * area {
                break;
            }
            holds[up] = true;
            q = up;
        }
        let top = tree.parent[q] as usize;
        let rise = f64::from(tree.level[top].saturating_sub(moments[p].darkest));
        let (at, shape) = ellipse(&moments[p]);
        found.push(Blob {
            at,
            shape,
            area,
            depth: rise * tree.step,
        });
    }
    found
}

fn within_taken(tree: &Tree, moments: &[Moments], p: usize, taken: &[bool]) -> bool {
    let most = SAME * moments[p].sums[0];
    let mut q = p;
    loop {
        if taken[q] {
            return true;
        }
        let up = tree.parent[q] as usize;
        if up == q || moments[up].sums[0] > most {
            return false;
        }
        q = up;
    }
}
