//! Near incompressibility: one cube bent as an incompressible block bends, in the plane of x and z.

use super::*;

/// Angle between the ends, radians; the cube's edge is 1.
const ANGLE: f64 = 0.8;

/// Rivlin's bending of an incompressible block: `X` becomes an angle, `Z` the radius `sqrt(inner^2 + 2 Z / k)`, with no
/// force along it. Gives the inner radius.
fn inner_radius() -> f64 {
    let k = ANGLE;
    // Inner times outer radius is 1 / k^2.
    (((1.0 + 1.0 / (k * k)).sqrt() - 1.0) / k).sqrt()
}

fn bent(x: &Vector3<f64>) -> Vector3<f64> {
    let (inner, angle) = (inner_radius(), ANGLE * (x.x - 0.5));
    let radius = (inner * inner + 2.0 * x.z / ANGLE).sqrt();
    Vector3::new(radius * angle.sin() + 0.5, x.y, radius * angle.cos()) - x
}

/// Its neo-Hookean energy over `mu`, by a sum over the thickness: stretches `k r` and `1 / (k r)`.
fn exact() -> f64 {
    let inner = inner_radius();
    let steps = 10_000;
    let density = |z: f64| {
        let square = ANGLE * ANGLE * (inner * inner + 2.0 * z / ANGLE);
        0.5 * (square + 1.0 / square - 2.0)
    };
    (0..steps)
        .map(|k| density((f64::from(k) + 0.5) / f64::from(steps)) / f64::from(steps))
        .sum()
}

/// The energy over `mu` where the nodes between the ends have found their places in the plane.
fn relaxed(order: Order, dilatation: Dilatation, poisson: f64) -> f64 {
    let cell = cube(order, 1.0, dilatation);
    let material = Material::new(Law::NeoHookean, 2.0 * (1.0 + poisson), poisson).unwrap();
    let mut u = displaced(&cell, bent);
    let free: Vec<usize> = (0..u.len())
        .filter(|k| cell.nodes[k / 3].x == 0.5 && k % 3 != 1)
        .collect();
    for _ in 0..if free.is_empty() { 0 } else { 30 } {
        let (energy, forces) = forces(&cell.table, &material, &u);
        let matrix = stiffness(&cell.table, &material, &u, true);
        let part = DMatrix::from_fn(free.len(), free.len(), |i, j| matrix[(free[i], free[j])]);
        let step = part
            .cholesky()
            .unwrap()
            .solve(&DVector::from_fn(free.len(), |i, _| -forces[free[i]]));
        let moved = |by: f64| {
            let mut moved = u.clone();
            free.iter().zip(step.iter()).for_each(|(k, s)| moved[*k] += by * s);
            moved
        };
        let mut by = 1.0;
        while by > 1e-9 && cell.table.energy(&material, &moved(by)).is_none_or(|e| e > energy) {
            by *= 0.5;
        }
        u = moved(by);
    }
    cell.table.energy(&material, &u).unwrap()
}

#[test]
fn the_block_keeps_its_volume() {
    let h = 1e-6;
    for x in [
        Vector3::new(0.1, 0.3, 0.2),
        Vector3::new(0.9, 0.0, 1.0),
        Vector3::new(0.5, 1.0, 0.0),
    ] {
        let columns =
            [Vector3::x(), Vector3::y(), Vector3::z()].map(|e| (bent(&(x + e * h)) - bent(&(x - e * h))) / (2.0 * h));
        let determinant = (Matrix3::identity() + Matrix3::from_columns(&columns)).determinant();
        assert!((determinant - 1.0).abs() < 1e-8, "{determinant}");
    }
}

#[test]
fn linear_dilatation_does_not_lock() {
    let exact = exact();
    for (poisson, locked) in [(0.3, 1.0), (0.49, 1.5), (0.4999, 50.0)] {
        let [plain, mixed] =
            [Dilatation::Plain, Dilatation::Linear].map(|d| relaxed(Order::Quadratic, d, poisson) / exact);
        println!("27 nodes, nu = {poisson}: plain {plain:.3}, linear dilatation {mixed:.3} of the exact energy");
        // A quadratic arc of 0.8 radians for a circle; at 0.3 the volume need not be kept, which costs less.
        assert!(poisson == 0.3 || (mixed - 1.0).abs() < 0.02, "{mixed}");
        assert!(poisson == 0.3 || plain > locked, "{plain}");
    }
}

#[test]
fn constant_dilatation_does_not_lock() {
    // The bending that 8 nodes have, u = x z along x about the centre: its energy by that without lambda.
    for (poisson, locked) in [(0.49, 10.0), (0.4999, 1000.0)] {
        let material = Material::new(Law::NeoHookean, 1.0, poisson).unwrap();
        let mu_alone = Material::new(Law::NeoHookean, 1.0 / (1.0 + poisson), 0.0).unwrap();
        let ratio = |dilatation: Dilatation| {
            let cell = cube(Order::Linear, 1.0, dilatation);
            let u = displaced(&cell, |x| Vector3::new(1e-3 * (x.x - 0.5) * (x.z - 0.5), 0.0, 0.0));
            cell.table.energy(&material, &u).unwrap() / cell.table.energy(&mu_alone, &u).unwrap()
        };
        let (plain, mean) = (ratio(Dilatation::Plain), ratio(Dilatation::Constant));
        println!("8 nodes, nu = {poisson}: plain {plain:.3}, constant dilatation {mean:.6} of the energy of shear");
        // The mean of ln J is of second order in the bending: lambda / mu times its square is next to nothing.
        assert!((mean - 1.0).abs() < 1e-3, "{mean}");
        assert!(plain > locked, "{plain}");
    }
}
