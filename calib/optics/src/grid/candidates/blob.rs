//! Candidates of a grid: regions that hardly grow while the level rises, and that are ellipses.

use nalgebra::{Matrix2, Vector2};

use crate::grid::candidates::region_tree::{MIN_AREA, Node, Tree};
use crate::image::Plane;

/// The most candidates, the most salient first: what follows takes time in their square.
pub(crate) const MAX_BLOBS: usize = 1200;
/// Levels lie at least so many deviations of the noise apart: what is finer shows regions of noise.
const LEAST_LEVEL_DEVIATIONS: f64 = 0.25;
/// The most that a region may grow, beside its own area.
const MAX_GROWTH: f64 = 0.75;
/// Area beside that of the ellipse of the same moments: 1 for an ellipse, 0.955 for a square.
const MIN_FILL: f64 = 0.8;
/// Regions that hold each other and differ by less in area are one candidate.
const SAME_AREA_FACTOR: f64 = 4.0;

/// A region that may be a disc.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Blob {
    /// Centroid, pixels.
    pub(crate) at: Vector2<f64>,
    /// Four times its second moment: the shape of the ellipse.
    pub(crate) shape: Matrix2<f64>,
    /// Pixels.
    pub(crate) area: f64,
    /// How far below what swallows it its darkest pixel is, grey levels.
    pub(crate) depth: f64,
    /// Its ellipse reaches the plane's border: what lies beyond is not seen, and centroid, shape and area are not those of
    /// the disc.
    pub(crate) cut: bool,
}

/// Whether an ellipse reaches the middles of a plane's outermost pixels.
fn is_cut(at: Vector2<f64>, shape: &Matrix2<f64>, plane: &Plane) -> bool {
    let last = [plane.width, plane.height].map(|n| n as f64 - 1.0);
    (0..2).any(|k| at[k].min(last[k] - at[k]) < shape[(k, k)].sqrt())
}

/// The candidates of a plane whose noise has the deviation `noise`.
pub(crate) fn blobs(plane: &Plane, noise: f64, bright: bool) -> Vec<Blob> {
    let greatest = (plane.samples.len() as f64 / 40.0).max(MIN_AREA);
    let tree = Tree::new(
        plane,
        bright,
        LEAST_LEVEL_DEVIATIONS * noise,
        SAME_AREA_FACTOR * greatest,
    );
    // What noise alone does to a level does not count as growth, nor what rounding does.
    // Four deviations of the noise and two grey levels, and four levels where these are coarser than that.
    let delta = ((4.0 * noise / tree.step).ceil() as u16)
        .max((2.0 / tree.step).ceil() as u16)
        .max(4);
    let mut stable: Vec<(f64, u32)> = Vec::new();
    for (p, node) in tree.nodes.iter().enumerate() {
        if (MIN_AREA..=greatest).contains(&node.sums[0]) {
            let growth = growth(&tree, p, delta);
            if growth < MAX_GROWTH && fill(node) > MIN_FILL {
                stable.push((growth, p as u32));
            }
        }
    }
    stable.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut found: Vec<Blob> = distinct(&tree, &stable);
    found.iter_mut().for_each(|b| b.cut = is_cut(b.at, &b.shape, plane));
    // Contrast times the root of the area goes as the signal to noise of a region's mean.
    found.sort_by(|a, b| (b.depth * b.area.sqrt()).total_cmp(&(a.depth * a.area.sqrt())));
    found.truncate(MAX_BLOBS);
    found
}

fn ellipse(node: &Node) -> (Vector2<f64>, Matrix2<f64>) {
    let [n, x, y, xx, xy, yy] = node.sums;
    let (x, y) = (x / n, y / n);
    // A pixel is a square: its own second moment is 1/12.
    let (a, b, c) = (xx / n - x * x + 1.0 / 12.0, xy / n - x * y, yy / n - y * y + 1.0 / 12.0);
    (Vector2::new(x, y), Matrix2::new(a, b, b, c) * 4.0)
}

fn fill(node: &Node) -> f64 {
    let (_, shape) = ellipse(node);
    node.sums[0] / (std::f64::consts::PI * shape.determinant().max(1e-12).sqrt())
}

/// How much the region gains when the level rises by `delta`, beside its area; not farther than to [`MAX_GROWTH`].
fn growth(tree: &Tree, p: usize, delta: u16) -> f64 {
    let nodes = &tree.nodes;
    // The walk up ends at the greatest growth, where the region is no candidate anyway: to the root it would take long.
    let (limit, area) = (nodes[p].level.saturating_add(delta), nodes[p].sums[0]);
    let mut q = p;
    loop {
        let growth = nodes[q].sums[0] / area - 1.0;
        let up = nodes[q].parent as usize;
        if up == q || nodes[up].level > limit || growth >= MAX_GROWTH {
            return growth;
        }
        q = up;
    }
}

/// Of regions that hold each other the most stable.
fn distinct(tree: &Tree, stable: &[(f64, u32)]) -> Vec<Blob> {
    let nodes = &tree.nodes;
    let mut taken = vec![false; nodes.len()];
    let mut holds = vec![false; nodes.len()];
    let heaviest = heaviest(nodes);
    let mut found = Vec::new();
    for (_, p) in stable {
        let p = *p as usize;
        let area = nodes[p].sums[0];
        // Stable regions come first: what holds one or lies in one is the same disc at another level.
        if holds[p] || within_taken(nodes, p, &taken) {
            continue;
        }
        taken[p] = true;
        let mut q = p;
        loop {
            let up = nodes[q].parent as usize;
            if up == q || nodes[up].sums[0] > SAME_AREA_FACTOR * area {
                break;
            }
            holds[up] = true;
            q = up;
        }
        let top = &nodes[nodes[q].parent as usize];
        let rise = f64::from(top.level.saturating_sub(nodes[p].darkest));
        // At half the rise the outline is that of the disc, whatever the blur: there both sides see as much of it.
        let half = nodes[p].darkest.midpoint(top.level);
        let outline = at_level(nodes, &heaviest, p, half, q);
        let (at, shape) = ellipse(outline);
        found.push(Blob {
            at,
            shape,
            area: outline.sums[0],
            depth: rise * tree.step,
            cut: false,
        });
    }
    found
}

/// For each region the largest of those that it swallows, itself where there is none.
fn heaviest(nodes: &[Node]) -> Vec<u32> {
    let mut heaviest: Vec<u32> = (0..nodes.len() as u32).collect();
    for (p, node) in nodes.iter().enumerate() {
        let up = node.parent as usize;
        let so_far = heaviest[up] as usize;
        if up != p && (so_far == up || nodes[so_far].sums[0] < node.sums[0]) {
            heaviest[up] = p as u32;
        }
    }
    heaviest
}

/// The region about `p` at a level: half way between its darkest pixel and what swallows it is the outline, of a size that
/// does not change from disc to disc as that of the most stable level does. At most the region `last`; `p` itself where
/// the other is no ellipse.
fn at_level<'a>(nodes: &'a [Node], heaviest: &[u32], p: usize, level: u16, last: usize) -> &'a Node {
    let mut q = p;
    while q != last && nodes[nodes[q].parent as usize].level <= level {
        q = nodes[q].parent as usize;
    }
    while nodes[q].level > level && heaviest[q] as usize != q {
        q = heaviest[q] as usize;
    }
    if fill(&nodes[q]) > MIN_FILL {
        &nodes[q]
    } else {
        &nodes[p]
    }
}

fn within_taken(nodes: &[Node], p: usize, taken: &[bool]) -> bool {
    let most = SAME_AREA_FACTOR * nodes[p].sums[0];
    let mut q = p;
    loop {
        if taken[q] {
            return true;
        }
        let up = nodes[q].parent as usize;
        if up == q || nodes[up].sums[0] > most {
            return false;
        }
        q = up;
    }
}
