//! Bodies of closed form, as triangles, for tests.

use std::f64::consts::{PI, TAU};

pub(crate) type Triangles = (Vec<[f64; 3]>, Vec<[u32; 3]>);

/// A grid of `rows` times `columns` corners as triangles; columns go round where `is_round`.
fn quads(rows: u32, columns: u32, is_round: bool) -> Vec<[u32; 3]> {
    let mut triangles = Vec::new();
    for i in 0..rows - 1 {
        for j in 0..if is_round { columns } else { columns - 1 } {
            let k = (j + 1) % columns;
            let (a, b, c, d) = (
                i * columns + j,
                i * columns + k,
                (i + 1) * columns + k,
                (i + 1) * columns + j,
            );
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    triangles
}

/// A ball about the origin; `n` rings.
pub(crate) fn ball(radius: f64, n: u32) -> Triangles {
    let mut corners = Vec::new();
    for i in 0..=n {
        for j in 0..2 * n {
            let (s, f) = (PI * f64::from(i) / f64::from(n), TAU * f64::from(j) / f64::from(2 * n));
            let s = if i == 0 || i == n {
                (0.0, if i == 0 { 1.0 } else { -1.0 })
            } else {
                s.sin_cos()
            };
            corners.push([radius * s.0 * f.cos(), radius * s.0 * f.sin(), radius * s.1]);
        }
    }
    let turned = quads(n + 1, 2 * n, true).into_iter().map(|[a, b, c]| [a, c, b]);
    (corners, turned.collect())
}

/// A box about the origin of these half sides; `n` squares along each side.
pub(crate) fn cuboid(half: [f64; 3], n: u32) -> Triangles {
    let (mut corners, mut triangles) = (Vec::new(), Vec::new());
    for axis in 0..3 {
        for side in [-1.0, 1.0] {
            let first = corners.len() as u32;
            for i in 0..=n {
                for j in 0..=n {
                    let mut p = [0.0; 3];
                    p[axis] = side * half[axis];
                    p[(axis + 1) % 3] = (2.0 * f64::from(i) / f64::from(n) - 1.0) * half[(axis + 1) % 3];
                    p[(axis + 2) % 3] = (2.0 * f64::from(j) / f64::from(n) - 1.0) * half[(axis + 2) % 3];
                    corners.push(p);
                }
            }
            let order = |[a, b, c]: [u32; 3]| if side < 0.0 { [a, b, c] } else { [a, c, b] };
            triangles.extend(
                quads(n + 1, n + 1, false)
                    .into_iter()
                    .map(|t| order(t.map(|c| c + first))),
            );
        }
    }
    (corners, triangles)
}

/// The shell of a cylinder along z, open at both ends.
pub(crate) fn tube(radius: f64, half_length: f64, n: u32) -> Triangles {
    let mut corners = Vec::new();
    for i in 0..=n {
        for j in 0..n {
            let f = TAU * f64::from(j) / f64::from(n);
            let z = half_length * (2.0 * f64::from(i) / f64::from(n) - 1.0);
            corners.push([radius * f.cos(), radius * f.sin(), z]);
        }
    }
    (corners, quads(n + 1, n, true))
}

/// A square in the plane z = 0 whose normal is +z.
pub(crate) fn plane(half: f64, n: u32) -> Triangles {
    let step = |i: u32| (2.0 * f64::from(i) / f64::from(n) - 1.0) * half;
    let corners = (0..=n).flat_map(|i| (0..=n).map(move |j| [step(j), step(i), 0.0]));
    (corners.collect(), quads(n + 1, n + 1, false))
}
