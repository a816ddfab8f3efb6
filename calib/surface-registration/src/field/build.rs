//! The field's nodes.

use nalgebra::Vector3;

use super::rows::{Lattice, Rows};
use super::{Field, FieldError, MOST_NODES, Rough, Spacing};
use crate::tree::{Normals, Tree, Triangle};

/// Nodes within so many spacings of a triangle get their exact distance.
const EXACT: f64 = 1.5;

/// What is known of a node on the way.
#[derive(Clone, Copy)]
struct Near {
    /// The nearest place of the surface so far, from the lattice's origin.
    foot: [f32; 3],
    /// Square of its distance.
    distance2: f32,
    /// Whether it is on an open border.
    is_open: bool,
}

const UNKNOWN: Near = Near {
    foot: [0.0; 3],
    distance2: f32::INFINITY,
    is_open: false,
};

impl Near {
    /// Takes what another node found, where it is nearer to this one, at (x, y, z).
    #[inline]
    fn offer(&mut self, from: &Self, x: f32, y: f32, z: f32) {
        let off = [x - from.foot[0], y - from.foot[1], z - from.foot[2]];
        let distance2 = off[0] * off[0] + off[1] * off[1] + off[2] * off[2];
        if distance2 < self.distance2 && from.distance2 < f32::INFINITY {
            *self = Self { distance2, ..*from };
        }
    }
}

/// The nodes while they are made.
struct Nodes {
    origin: Vector3<f64>,
    spacing: f64,
    size: [usize; 3],
    near: Vec<Near>,
}

pub(super) fn build(
    tree: &Tree,
    caps: &[[Vector3<f64>; 3]],
    is_sheet: bool,
    spacing: Spacing,
) -> Result<Field, FieldError> {
    check(&spacing)?;
    let h = spacing.spacing_mm;
    let [least, most] = tree.bounds();
    // Off the round numbers at which corners of label maps lie, so that hardly a row meets an edge. Two more cells, so that no node that
    // is near lies on the border.
    let origin = least - Vector3::repeat(spacing.margin_mm) - Vector3::new(2.381_966, 2.732_051, 2.236_068) * h;
    let size = [0, 1, 2].map(|k| ((most[k] + spacing.margin_mm - origin[k]) / h).ceil() as usize + 3);
    let total = size
        .iter()
        .try_fold(1_usize, |all, n| all.checked_mul(*n))
        .unwrap_or(usize::MAX);
    if total > MOST_NODES {
        return Err(FieldError::TooFine { nodes: total });
    }
    let mut nodes = Nodes {
        origin,
        spacing: h,
        size,
        near: vec![UNKNOWN; total],
    };
    for (triangle, normals) in tree.faces() {
        nodes.take(triangle, normals);
    }
    nodes.spread();
    let solid = tree.triangles().map(|t| [t.a, t.b, t.c]).chain(caps.iter().copied());
    let lattice = Lattice {
        origin,
        spacing: h,
        rows: [size[1], size[2]],
    };
    let values = if is_sheet {
        nodes.by_side(tree)
    } else {
        nodes.by_winding(&Rows::new(solid, lattice))
    };
    let open: Vec<bool> = nodes.near.iter().map(|near| near.is_open).collect();
    // Of a closed surface no look need ask.
    let open = if open.contains(&true) { open } else { Vec::new() };
    Ok(Field {
        spacing,
        origin,
        nodes: size,
        rough: Rough::new(h, size, &values, &open),
        values,
        open,
    })
}

fn check(spacing: &Spacing) -> Result<(), FieldError> {
    let ranges = [
        ("the field's spacing", spacing.spacing_mm, 0.1..=20.0, "0.1 to 20 mm"),
        ("the field's margin", spacing.margin_mm, 0.0..=1000.0, "0 to 1000 mm"),
    ];
    for (what, found, range, allowed) in ranges {
        // A NaN is in no range.
        if !range.contains(&found) {
            return Err(FieldError::Spacing { what, found, allowed });
        }
    }
    Ok(())
}

impl Nodes {
    fn place(&self, i: usize, j: usize, k: usize) -> usize {
        (k * self.size[1] + j) * self.size[0] + i
    }

    /// The exact distances of the nodes around a triangle.
    fn take(&mut self, t: &Triangle, normals: &Normals) {
        let (h, reach) = (self.spacing, EXACT * self.spacing);
        let least = t.a.inf(&t.b).inf(&t.c) - self.origin;
        let most = t.a.sup(&t.b).sup(&t.c) - self.origin;
        let first = [0, 1, 2].map(|k| ((least[k] - reach) / h).ceil().max(0.0) as usize);
        let last = [0, 1, 2].map(|k| (((most[k] + reach) / h).floor() as usize).min(self.size[k] - 1));
        for k in first[2]..=last[2] {
            for j in first[1]..=last[1] {
                for i in first[0]..=last[0] {
                    let at = Vector3::new(i as f64, j as f64, k as f64) * h;
                    let foot = t.near(&(at + self.origin));
                    let place = self.place(i, j, k);
                    let near = &mut self.near[place];
                    if (foot.distance2 as f32) < near.distance2 {
                        let from = foot.place - self.origin;
                        *near = Near {
                            foot: [from.x as f32, from.y as f32, from.z as f32],
                            distance2: foot.distance2 as f32,
                            is_open: normals.is_open(&foot),
                        };
                    }
                }
            }
        }
    }

    /// Takes the nearest places of neighbours on, to and fro along each axis (Danielsson 1980).
    fn spread(&mut self) {
        let [_, ny, nz] = self.size;
        let rows = ny as isize;
        for k in (0..nz).chain((0..nz).rev()) {
            // Up through all layers, then down: each layer takes from the one before, and then from row to row, there and back.
            for j in 0..ny {
                self.take_row(j, k, -rows);
                self.take_row(j, k, rows);
            }
            for j in 0..ny {
                self.take_row(j, k, -1);
                self.along_row(j, k);
            }
            for j in (0..ny).rev() {
                self.take_row(j, k, 1);
                self.along_row(j, k);
            }
        }
    }

    /// Offers each node of a row what the node at the same place of the row `by` rows on has.
    fn take_row(&mut self, j: usize, k: usize, by: isize) {
        let row = k * self.size[1] + j;
        let other = row as isize + by;
        // A row of the same layer, or the same row of another layer.
        let is_there = if by.unsigned_abs() == self.size[1] {
            (0..(self.size[1] * self.size[2]) as isize).contains(&other)
        } else {
            (0..self.size[1] as isize).contains(&(j as isize + by))
        };
        if !is_there {
            return;
        }
        let n = self.size[0];
        let (own, from) = (row * n, other as usize * n);
        let (h, y, z) = self.sides(j, k);
        let (low, high) = self.near.split_at_mut(own.max(from));
        let (to, from) = if own > from {
            (&mut high[..n], &low[from..from + n])
        } else {
            (&mut low[own..own + n], &high[..n])
        };
        for (i, (to, from)) in to.iter_mut().zip(from).enumerate() {
            to.offer(from, i as f32 * h, y, z);
        }
    }

    /// Offers each node of a row what its neighbours in it have, there and back.
    fn along_row(&mut self, j: usize, k: usize) {
        let n = self.size[0];
        let first = (k * self.size[1] + j) * n;
        let (h, y, z) = self.sides(j, k);
        let row = &mut self.near[first..first + n];
        for i in 1..n {
            let from = row[i - 1];
            row[i].offer(&from, i as f32 * h, y, z);
        }
        for i in (0..n - 1).rev() {
            let from = row[i + 1];
            row[i].offer(&from, i as f32 * h, y, z);
        }
    }

    fn sides(&self, j: usize, k: usize) -> (f32, f32, f32) {
        let h = self.spacing as f32;
        (h, j as f32 * h, k as f32 * h)
    }

    /// Signed by how often the surface winds about each node.
    fn by_winding(&self, rows: &Rows) -> Vec<f32> {
        let mut values = Vec::with_capacity(self.near.len());
        for k in 0..self.size[2] {
            for j in 0..self.size[1] {
                let mut crossings = rows.along(j, k);
                for i in 0..self.size[0] {
                    let d = self.near[values.len()].distance2.sqrt();
                    let winds = crossings.winding(self.origin.x + self.spacing * i as f64);
                    values.push(if winds > 0 { -d } else { d });
                }
            }
        }
        values
    }

    /// Signed by the side of the nearest place: of a sheet, which encloses nothing.
    fn by_side(&self, tree: &Tree) -> Vec<f32> {
        let mut values = Vec::with_capacity(self.near.len());
        for k in 0..self.size[2] {
            for j in 0..self.size[1] {
                for i in 0..self.size[0] {
                    let near = &self.near[values.len()];
                    let foot = Vector3::from(near.foot.map(f64::from)) + self.origin;
                    let p = self.origin + Vector3::new(i as f64, j as f64, k as f64) * self.spacing;
                    // The place that was found is near the surface to rounding, and the triangle there has the normal.
                    let normal = tree.foot(&foot, 1.0, None).map_or(Vector3::zeros(), |foot| foot.normal);
                    let d = near.distance2.sqrt();
                    values.push(if (p - foot).dot(&normal) < 0.0 { -d } else { d });
                }
            }
        }
        values
    }
}
