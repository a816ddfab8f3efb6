//! Generated meshes.

use nalgebra::Vector2;

use super::{Mesh, NODES, Refused};

/// The most elements of a generated mesh.
const MAX_ELEMENTS: usize = 1 << 22;

/// A mesh of `across` x `along` elements whose node at the parameters `(s, t)` in `[0, 1]^2` lies at `place(s, t)`.
///
/// Middle nodes lie where the map puts the middle parameters: on curved sides too. `periodic` joins `s = 1` to `s = 0`.
///
/// # Errors
/// [`Refused::Shape`] for a count, and what [`Mesh::new`] finds in the map.
pub fn grid(
    [across, along]: [usize; 2],
    periodic: bool,
    place: impl Fn(f64, f64) -> Vector2<f64>,
) -> Result<Mesh, Refused> {
    // With two elements round, both rows of sides would have the same two ends, which name a side.
    let least = if periodic { 3 } else { 1 };
    let allowed = "1 (3 where it closes on itself) to 4194304 elements in all";
    if across < least || along < 1 || across.saturating_mul(along) > MAX_ELEMENTS {
        let found = across as f64 * along as f64;
        return Err(Refused::Shape {
            what: "the number of elements",
            found,
            allowed,
        });
    }
    // A node of a middle or a corner for each half element; a closed mesh shares the last column with the first.
    let columns = if periodic { 2 * across } else { 2 * across + 1 };
    let id = |i: usize, j: usize| j * columns + i % columns;
    let (ds, dt) = (0.5 / across as f64, 0.5 / along as f64);
    let rows = 0..=2 * along;
    let nodes = rows.flat_map(|j| (0..columns).map(move |i| (i, j)));
    let nodes = nodes.map(|(i, j)| place(i as f64 * ds, j as f64 * dt)).collect();
    let elements: Vec<[usize; NODES]> = (0..across * along)
        .map(|e| {
            let (i, j) = (2 * (e % across), 2 * (e / across));
            std::array::from_fn(|n| id(i + n % 3, j + n / 3))
        })
        .collect();
    Mesh::new(nodes, &elements)
}

fn positive(what: &'static str, found: f64) -> Result<f64, Refused> {
    let good = found.is_finite() && found > 0.0;
    good.then_some(found).ok_or(Refused::Shape {
        what,
        found,
        allowed: "a finite number above 0",
    })
}

/// A rectangle from `corner`, of `size`.
///
/// # Errors
/// [`Refused::Shape`].
pub fn rectangle(corner: Vector2<f64>, size: Vector2<f64>, elements: [usize; 2]) -> Result<Mesh, Refused> {
    positive("the width", size.x)?;
    positive("the height", size.y)?;
    grid(elements, false, |s, t| corner + Vector2::new(s * size.x, t * size.y))
}

/// A full ring: `elements` round it and through its thickness. The first nodes lie below the centre.
///
/// # Errors
/// [`Refused::Shape`].
pub fn ring(centre: Vector2<f64>, [inner, outer]: [f64; 2], elements: [usize; 2]) -> Result<Mesh, Refused> {
    positive("the inner radius", inner)?;
    positive("the thickness", outer - inner)?;
    let turn = std::f64::consts::TAU;
    grid(elements, true, |s, t| {
        // Parameters run round and outwards, clockwise: seen from inside, outwards lies on the left.
        let angle = -turn * s - 0.25 * turn;
        let radius = inner + (outer - inner) * t;
        centre + Vector2::new(angle.cos(), angle.sin()) * radius
    })
}

/// A rounded solid: `(xi, eta)` in `[-1, 1]^2` goes to `(a xi sqrt(1 - 0.4 eta^2), b eta sqrt(1 - 0.4 xi^2))`, turned by
/// `angle` radians.
///
/// # Errors
/// [`Refused::Shape`].
pub fn blob(centre: Vector2<f64>, [a, b]: [f64; 2], angle: f64, elements: [usize; 2]) -> Result<Mesh, Refused> {
    positive("a half axis", a)?;
    positive("a half axis", b)?;
    let (sin, cos) = angle.sin_cos();
    grid(elements, false, |s, t| {
        let (xi, eta) = (2.0 * s - 1.0, 2.0 * t - 1.0);
        let x = a * xi * (1.0 - 0.4 * eta * eta).sqrt();
        let y = b * eta * (1.0 - 0.4 * xi * xi).sqrt();
        centre + Vector2::new(cos * x - sin * y, sin * x + cos * y)
    })
}
