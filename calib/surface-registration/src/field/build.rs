//! The field's nodes.

use nalgebra::Vector3;

use super::rows::{Lattice, Rows};
use super::{BRICK, BRICK_NODES, Field, FieldError, MOST_NODES, NO_BRICK, Spacing};
use crate::tree::Tree;

/// What a node's value comes from.
struct Source<'a> {
    tree: &'a Tree,
    /// Of a sheet, which encloses nothing, there are none: the nearest triangle says on which side a node is.
    rows: Option<Rows>,
    origin: Vector3<f64>,
    spacing: f64,
}

/// Nodes along a line, each with a bound from the one before.
#[derive(Clone, Copy)]
struct Near {
    place: Vector3<f64>,
    distance: f64,
    triangle: u32,
}

impl Source<'_> {
    /// The value at the fine node (i, j, k).
    fn value(&self, [i, j, k]: [usize; 3], near: &mut Option<Near>) -> f32 {
        let p = self.origin + Vector3::new(i as f64, j as f64, k as f64) * self.spacing;
        // Nothing is further away than it was from the node before, and the step here: a bound that spares most of the tree.
        let within = near.map_or(f64::INFINITY, |n| (n.distance + (p - n.place).norm()) * (1.0 + 1e-9) + 1e-9);
        let Some(foot) = self.tree.foot(&p, within, near.map(|n| n.triangle)) else {
            return f32::MAX;
        };
        let (signed, _) = foot.signed(&p);
        *near = Some(Near {
            place: p,
            distance: signed.abs(),
            triangle: foot.triangle,
        });
        let is_inside = self.rows.as_ref().map_or(signed < 0.0, |rows| rows.winding(j, k, p.x) > 0);
        (if is_inside { -signed.abs() } else { signed.abs() }) as f32
    }
}

pub(super) fn build(
    tree: &Tree,
    caps: &[[Vector3<f64>; 3]],
    is_sheet: bool,
    spacing: Spacing,
) -> Result<Field, FieldError> {
    check(&spacing)?;
    let h = spacing.fine_mm;
    let [least, most] = tree.bounds();
    // Off the round numbers at which corners of label maps lie, so that hardly a row meets an edge.
    let shift = Vector3::new(0.381_966, 0.732_051, 0.236_068) * h;
    let origin = least - Vector3::repeat(spacing.margin_mm) - shift;
    let cells = [0, 1, 2].map(|k| {
        let length = most[k] + spacing.margin_mm - origin[k];
        (length / (h * BRICK as f64)).ceil() as usize * BRICK
    });
    let nodes = cells.map(|n| n / spacing.coarse + 1);
    let total = nodes.iter().try_fold(1_usize, |all, n| all.checked_mul(*n));
    let total = total.unwrap_or(usize::MAX);
    if total > MOST_NODES {
        return Err(FieldError::TooFine { nodes: total });
    }
    let solid = || tree.triangles().map(|t| [t.a, t.b, t.c]).chain(caps.iter().copied());
    let lattice = Lattice {
        origin,
        spacing: h,
        rows: [cells[1] + 1, cells[2] + 1],
    };
    let source = Source {
        tree,
        rows: (!is_sheet).then(|| Rows::new(solid(), lattice)),
        origin,
        spacing: h,
    };
    let coarse = coarse(&source, nodes, &spacing);
    let (table, brick_places) = table(tree, origin, cells, &spacing);
    let count = brick_places.len() * BRICK_NODES.pow(3);
    if count > MOST_NODES {
        return Err(FieldError::TooFine { nodes: count });
    }
    Ok(Field {
        spacing,
        origin,
        cells,
        nodes,
        coarse,
        table,
        bricks: bricks(&source, &brick_places, spacing.threads),
    })
}

fn check(spacing: &Spacing) -> Result<(), FieldError> {
    let refused = |what, found, allowed| Err(FieldError::Spacing { what, found, allowed });
    let is_in = |x: f64, least: f64, most: f64| x >= least && x <= most;
    if !is_in(spacing.fine_mm, 0.05, 20.0) {
        return refused("spacing of the field, mm", spacing.fine_mm, "0.05 to 20");
    }
    if ![1, 2, 4, 8].contains(&spacing.coarse) {
        return refused("ratio of the spacings", spacing.coarse as f64, "1, 2, 4 or 8");
    }
    if !is_in(spacing.band_mm, 0.0, 1000.0) {
        return refused("fine band, mm", spacing.band_mm, "0 to 1000");
    }
    if !is_in(spacing.margin_mm, 0.0, 1000.0) {
        return refused("margin, mm", spacing.margin_mm, "0 to 1000");
    }
    if !(1..=256).contains(&spacing.threads) {
        return refused("threads", spacing.threads as f64, "1 to 256");
    }
    Ok(())
}

fn coarse(source: &Source<'_>, nodes: [usize; 3], spacing: &Spacing) -> Vec<f32> {
    let layer = nodes[0] * nodes[1];
    let mut values = vec![0.0; layer * nodes[2]];
    let mut layers: Vec<(usize, &mut [f32])> = values.chunks_mut(layer).enumerate().collect();
    in_threads(&mut layers, spacing.threads, |(k, layer)| {
        // From nothing in each layer: values are the same however layers are shared out.
        let mut near = None;
        // To and fro, so that each node is beside the one before.
        for j in 0..nodes[1] {
            for step in 0..nodes[0] {
                let i = if j % 2 == 0 { step } else { nodes[0] - 1 - step };
                let node = [i, j, *k].map(|n| n * spacing.coarse);
                layer[j * nodes[0] + i] = source.value(node, &mut near);
            }
        }
    });
    values
}

/// The number of the brick at each place, and the first fine node of each brick.
fn table(tree: &Tree, origin: Vector3<f64>, cells: [usize; 3], spacing: &Spacing) -> (Vec<u32>, Vec<[usize; 3]>) {
    let places = cells.map(|n| n / BRICK);
    let edge = spacing.fine_mm * BRICK as f64;
    // From a brick's middle its corners are the furthest.
    let within = spacing.band_mm + edge * 0.5 * 3.0_f64.sqrt();
    let mut table = Vec::with_capacity(places.iter().product());
    let mut bricks = Vec::new();
    for k in 0..places[2] {
        for j in 0..places[1] {
            for i in 0..places[0] {
                let middle = origin + Vector3::new(i as f64 + 0.5, j as f64 + 0.5, k as f64 + 0.5) * edge;
                if tree.foot(&middle, within, None).is_some() {
                    table.push(bricks.len() as u32);
                    bricks.push([i, j, k].map(|n| n * BRICK));
                } else {
                    table.push(NO_BRICK);
                }
            }
        }
    }
    (table, bricks)
}

fn bricks(source: &Source<'_>, places: &[[usize; 3]], threads: usize) -> Vec<f32> {
    const N: usize = BRICK_NODES;
    let mut values = vec![0.0; places.len() * N * N * N];
    let mut all: Vec<([usize; 3], &mut [f32])> = places.iter().copied().zip(values.chunks_mut(N * N * N)).collect();
    in_threads(&mut all, threads, |(first, brick)| {
        let mut near = None;
        for k in 0..N {
            for j in 0..N {
                for step in 0..N {
                    let i = if (j + k) % 2 == 0 { step } else { N - 1 - step };
                    let node = [first[0] + i, first[1] + j, first[2] + k];
                    brick[(k * N + j) * N + i] = source.value(node, &mut near);
                }
            }
        }
    });
    values
}

/// Does the same to each of `items`, in so many threads.
fn in_threads<T: Send>(items: &mut [T], threads: usize, work: impl Fn(&mut T) + Sync) {
    if threads < 2 || items.len() < 2 {
        return items.iter_mut().for_each(work);
    }
    // Dealt out like cards: neighbours cost alike, so that each thread has its share of the dear ones.
    let mut hands: Vec<Vec<&mut T>> = (0..threads).map(|_| Vec::new()).collect();
    for (i, item) in items.iter_mut().enumerate() {
        hands[i % threads].push(item);
    }
    std::thread::scope(|scope| {
        for hand in hands {
            scope.spawn(|| hand.into_iter().for_each(&work));
        }
    });
}
