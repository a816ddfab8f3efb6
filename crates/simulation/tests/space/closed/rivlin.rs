//! Large strains against closed forms: a thick ball that is inflated and a bar that is twisted (Rivlin).

use std::f64::consts::PI;

use nalgebra::{Rotation3, Vector3};
use simulation::law::Law;
use simulation::space::cells::{Mesh, Settings, Shell};
use simulation::space::law::Material;
use simulation::space::solid::Deformable;
use simulation::space::system::System;

use crate::common::{Cylinder, balance, forces, symmetric};

const RADII: [f64; 2] = [20.0, 40.0];

/// Pressure by shear modulus that inflates an incompressible neo-Hookean ball, `mu/2 (|F|^2 - 3)`, from the stretches
/// `r / R` of its inner and outer surface. From `d sigma_r / dr = 2 (sigma_t - sigma_r) / r` with
/// `sigma_t - sigma_r = mu (l^2 - l^-4)` and `dr / r = dl / (l (1 - l^3))`.
fn incompressible([inner, outer]: [f64; 2]) -> f64 {
    let term = |l: f64| 2.0 / l + 0.5 / l.powi(4);
    term(outer) - term(inner)
}

/// `r'` for a radial stress `mu (r' - 1 / r') + lambda ln(r' l^2) / r'` at a stretch `l` around.
fn radial_stretch(material: &Material, stress: f64, l: f64) -> f64 {
    let (mu, lambda) = (material.lame.mu, material.lame.lambda);
    let mut s = 1.0 / (l * l);
    for _ in 0..30 {
        let volume = lambda * (s * l * l).ln();
        let value = mu * (s - 1.0 / s) + volume / s - stress;
        s -= value / (mu * (1.0 + 1.0 / (s * s)) + (lambda - volume) / (s * s));
    }
    s
}

/// Stretch of the inner surface, and pressure on its *reference* area, of the compressible ball whose outer surface is free
/// and stretched by `outer`: Runge and Kutta's method from there inwards.
fn compressible(material: &Material, outer: f64) -> (f64, f64) {
    const STEPS: i32 = 2000;
    let (mu, lambda) = (material.lame.mu, material.lame.lambda);
    let rate = |at: f64, [r, stress]: [f64; 2]| {
        let l = r / at;
        let s = radial_stretch(material, stress, l);
        let around = mu * (l - 1.0 / l) + lambda * (s * l * l).ln() / l;
        [s, -2.0 * (stress - around) / at]
    };
    let h = (RADII[0] - RADII[1]) / f64::from(STEPS);
    let mut y = [outer * RADII[1], 0.0];
    let plus = |y: [f64; 2], k: [f64; 2], h: f64| [y[0] + h * k[0], y[1] + h * k[1]];
    for step in 0..STEPS {
        let at = RADII[1] + h * f64::from(step);
        let one = rate(at, y);
        let two = rate(at + 0.5 * h, plus(y, one, 0.5 * h));
        let three = rate(at + 0.5 * h, plus(y, two, 0.5 * h));
        let four = rate(at + h, plus(y, three, h));
        y = [0, 1].map(|k| y[k] + h / 6.0 * (one[k] + 2.0 * (two[k] + three[k]) + four[k]));
    }
    (y[0] / RADII[0], -y[1])
}

/// Stretches of the inner surface of a ball under a dead pressure on its reference area: mean, least, largest; unknowns.
/// Where all is round normals do not turn and areas grow alike: a following pressure is the dead one by the square of the
/// stretch.
fn inflated(side: f64, material: Material, pressure: f64, outer: f64) -> ([f64; 3], usize) {
    let shell = Shell {
        centre: Vector3::zeros(),
        radii: RADII,
    };
    let corners = [Vector3::zeros(), Vector3::repeat(RADII[1])];
    let mesh = Mesh::new(&shell, corners, &Settings::of_side(side), &|_, _| false).unwrap();
    let solid = Deformable::new(mesh.clone(), material, Vector3::zeros()).unwrap();
    // Not on the planes of symmetry.
    let inner = |at: &Vector3<f64>| at.norm() < 0.5 * (RADII[0] + RADII[1]) && at.min() > 1e-9;
    let pressed = solid.traction(|at, normal| {
        if inner(at) {
            -normal * pressure
        } else {
            Vector3::zeros()
        }
    });
    let mut system = System::new();
    let body = system.add(solid);
    system.load(body, &pressed);
    symmetric(&mut system, &mesh, 1e-9);
    // From the incompressible state, `r^3 - R^3` the same everywhere: from rest one step would turn cubes inside out.
    let grown = (outer.powi(3) - 1.0) * RADII[1].powi(3);
    let start = |x: &Vector3<f64>| *x * ((1.0 + grown / x.norm().max(0.5 * RADII[0]).powi(3)).cbrt() - 1.0);
    let mut a: Vec<f64> = mesh.nodes.iter().flat_map(|x| start(x).data.0[0]).collect();
    let found = balance(&system, &mut a, 1e-9).unwrap();
    assert!(found.least_determinant > 0.5, "{found:?}");
    let solid = system.bodies.solid(body);
    let (mut sum, mut area, mut ends) = (0.0, 0.0, [f64::INFINITY, 0.0_f64]);
    for (at, _, part, now) in (0..solid.points()).map(|k| {
        let (at, normal, part) = solid.reference(k);
        (at, normal, part, solid.point(&a, k))
    }) {
        if inner(&at) {
            let stretch = now.norm() / at.norm();
            (sum, area) = (sum + part * stretch, area + part);
            ends = [ends[0].min(stretch), ends[1].max(stretch)];
        }
    }
    ([sum / area, ends[0], ends[1]], a.len())
}

#[test]
fn an_inflated_ball() {
    const OUTER: f64 = 1.0905;
    for nu in [0.3, 0.49, 0.4999] {
        let material = Material::new(Law::NeoHookean, 1.0, nu).unwrap();
        let (stretch, pressure) = compressible(&material, OUTER);
        let following = pressure / stretch.powi(2) / material.lame.mu;
        let closed = following / incompressible([stretch, OUTER]) - 1.0;
        println!("nu {nu}: inner stretch {stretch:.5}; pressure by the incompressible one's {closed:+.2e}");
        // A volume changes by pressures of some shear moduli by lambda.
        assert!(closed.abs() < 2.0 * (1.0 - 2.0 * nu), "{closed}");
        let mut errors = Vec::new();
        for cubes in [4.0, 8.0] {
            let (found, unknowns) = inflated(RADII[1] / cubes, material, pressure, OUTER);
            let [mean, least, largest] = found.map(|s| s / stretch - 1.0);
            println!(
                "  {cubes} cubes a radius, {unknowns} unknowns: stretch off by {:+.4} %, points by {:+.4} to {:+.4} %",
                100.0 * mean,
                100.0 * least,
                100.0 * largest
            );
            errors.push([mean.abs(), (-least).max(largest)]);
        }
        // Asked for is 0.1 %. What a load does work on converges twice as fast as gradients: order 4, and points with 3;
        // one order less is left to cut cubes.
        assert!(errors[1][0] < 1e-4 && errors[1][1] < 1e-3, "{errors:?}");
        assert!(
            errors[0][0] > 8.0 * errors[1][0] && errors[0][1] > 4.0 * errors[1][1],
            "{errors:?}"
        );
    }
}

const RADIUS: f64 = 10.0;

/// Moment and axial force, by the closed form's, of a bar of shear modulus 1 whose end turns by `rate` a length.
///
/// Every section turns as it is, and bears `mu rate r` around and `mu rate^2 (r^2 - a^2) / 2` along and across.
fn twisted(side: f64, nu: f64, rate: f64) -> ([f64; 2], usize) {
    let (length, reach) = (RADIUS, side * (RADIUS / side).ceil());
    let corners = [Vector3::new(-reach, -reach, 0.0), Vector3::new(reach, reach, length)];
    let bar = Cylinder { radius: RADIUS };
    let mesh = Mesh::new(&bar, corners, &Settings::of_side(side), &|_, _| false).unwrap();
    let material = Material::new(Law::NeoHookean, 2.0 * (1.0 + nu), nu).unwrap();
    let mut system = System::new();
    let body = system.add(Deformable::new(mesh.clone(), material, Vector3::zeros()).unwrap());
    // The search begins where every section turns as it is; the ends stay so.
    let turned = |x: &Vector3<f64>| Rotation3::from_axis_angle(&Vector3::z_axis(), rate * x.z) * x - x;
    let mut a: Vec<f64> = mesh.nodes.iter().flat_map(|x| turned(x).data.0[0]).collect();
    for node in mesh.nodes_where(|x| x.z < 1e-9 || x.z > length - 1e-9) {
        system.fixed[3 * node..3 * node + 3].fill(true);
    }
    balance(&system, &mut a, 1e-10).unwrap();
    let forces = forces(system.bodies.solid(body), &a);
    let (mut moment, mut axial) = (0.0, 0.0);
    for node in mesh.nodes_where(|x| x.z > length - 1e-9) {
        let three = |of: &[f64]| Vector3::from_column_slice(&of[3 * node..3 * node + 3]);
        let (x, force) = (mesh.nodes[node] + three(&a), three(&forces));
        moment += x.x * force.y - x.y * force.x;
        axial += force.z;
    }
    let exact = [
        PI * rate * RADIUS.powi(4) / 2.0,
        -PI * rate.powi(2) * RADIUS.powi(4) / 4.0,
    ];
    ([moment / exact[0] - 1.0, axial / exact[1] - 1.0], a.len())
}

#[test]
fn a_twisted_bar() {
    let mut errors = Vec::new();
    for side in [5.0, 2.5] {
        // Ends that are held bar the change of volume that pressure makes: forces differ by some (1 - 2 nu) (a / side)^2.
        let (off, unknowns) = twisted(side, 0.499_999, 0.1);
        println!(
            "{} cubes a radius, {unknowns} unknowns: moment {:+.4} %, axial force {:+.4} %",
            RADIUS / side,
            100.0 * off[0],
            100.0 * off[1]
        );
        errors.push(off.map(f64::abs));
    }
    // Asked for is 0.1 %. Forces are slopes of the energy, of order 4; one order less is left to cut cubes.
    assert!(errors[1].iter().all(|e| *e < 1e-4), "{errors:?}");
    assert!((0..2).all(|k| errors[0][k] > 8.0 * errors[1][k]), "{errors:?}");
}
