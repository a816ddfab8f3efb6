//! A half space under small loads: a block whose far faces are held where the closed form of the half space has them.

use nalgebra::Vector3;
use simulation::law::Law;
use simulation::space::cells::{Mesh, Settings};
use simulation::space::law::Material;
use simulation::space::solid::Deformable;
use simulation::space::system::System;

use crate::common::{balance, displacement, everywhere, hold};

/// A quarter of the block `|x|, |y|, z < reach`, its surface at `z = 0` and z downwards: cubes of `side` as far as `fine`, twice
/// as large as far as twice that, four times from there on.
pub(crate) fn block(reach: f64, side: f64, fine: f64) -> Mesh {
    let settings = Settings {
        levels: 2,
        ..Settings::of_side(4.0 * side)
    };
    let corners = [Vector3::zeros(), Vector3::repeat(reach)];
    // The lowest corner is the nearest one. Downwards two thirds as far.
    let refine = |low: &Vector3<f64>, high: &Vector3<f64>| {
        let far = low.component_mul(&Vector3::new(1.0, 1.0, 1.5)).max();
        far < fine * 0.5 * (high.x - low.x) / side - 1e-9
    };
    Mesh::new(&everywhere(reach), corners, &settings, &refine).unwrap()
}

/// The solid of such a block of Young's modulus 1 under small strains, and its state of rest with planes of symmetry held.
pub(crate) fn solid(mesh: &Mesh, nu: f64) -> (System, Vec<f64>) {
    let material = Material::new(Law::Linear, 1.0, nu).unwrap();
    let mut system = System::new();
    system.add(Deformable::new(mesh.clone(), material, Vector3::zeros()).unwrap());
    for axis in 0..2 {
        for node in mesh.nodes_where(|x| x[axis] < 1e-9) {
            system.fixed[3 * node + axis] = true;
        }
    }
    let a = system.initial();
    (system, a)
}

/// Holds the far faces where a displacement field has them.
pub(crate) fn hold_far(
    system: &mut System,
    a: &mut [f64],
    mesh: &Mesh,
    reach: f64,
    field: impl Fn(&Vector3<f64>) -> Vector3<f64>,
) {
    for node in mesh.nodes_where(|x| x.max() > reach - 1e-9) {
        let to = field(&mesh.nodes[node]);
        (0..3).for_each(|k| hold(system, a, 3 * node + k, to[k]));
    }
}

/// Displacement at `x` by a unit force along z at the depth `c` below the origin of a half space of Young's modulus 1
/// (Mindlin 1936; `c = 0`: Boussinesq).
pub(crate) fn mindlin(nu: f64, c: f64, x: &Vector3<f64>) -> Vector3<f64> {
    let square = x.x * x.x + x.y * x.y;
    let (near, far) = (x.z - c, x.z + c);
    let [r1, r2] = [near, far].map(|z| (square + z * z).sqrt());
    let k = 3.0 - 4.0 * nu;
    let twice = 6.0 * c * x.z * far / r2.powi(5);
    let along = k / r1
        + (8.0 * (1.0 - nu).powi(2) - k) / r2
        + near * near / r1.powi(3)
        + (k * far * far - 2.0 * c * x.z) / r2.powi(3)
        + twice * far;
    let across =
        near / r1.powi(3) + k * near / r2.powi(3) - 4.0 * (1.0 - nu) * (1.0 - 2.0 * nu) / (r2 * (r2 + far)) + twice;
    // 16 pi G (1 - nu), G = 1 / (2 (1 + nu)).
    let scale = (1.0 + nu) / (8.0 * std::f64::consts::PI * (1.0 - nu));
    Vector3::new(x.x * across, x.y * across, along) * scale
}

/// Points and weights of Gauss's rule of five points on `[-1, 1]`.
const GAUSS: [(f64, f64); 5] = [
    (-0.906_179_845_938_664, 0.236_926_885_056_189_1),
    (-0.538_469_310_105_683_1, 0.478_628_670_499_366_5),
    (0.0, 0.568_888_888_888_888_9),
    (0.538_469_310_105_683_1, 0.478_628_670_499_366_5),
    (0.906_179_845_938_664, 0.236_926_885_056_189_1),
];

/// The same of a unit force spread evenly over a square of half side `s` at the depth `c`, and over depths from `c - t` to
/// `c + t`. From `2 s` on the rule's error is below 1e-6.
fn spread(nu: f64, [c, t]: [f64; 2], s: f64, x: &Vector3<f64>) -> Vector3<f64> {
    let mut sum = Vector3::zeros();
    for (px, wx) in GAUSS {
        for (py, wy) in GAUSS {
            for (pz, wz) in GAUSS {
                sum += mindlin(nu, c + t * pz, &(x - Vector3::new(s * px, s * py, 0.0))) * (wx * wy * wz / 8.0);
            }
        }
    }
    sum
}

const REACH: f64 = 40.0;
/// Half the side of what is loaded.
const HALF: f64 = 5.0;
const PLACES: [[f64; 3]; 6] = [
    [0.0, 0.0, 20.0],
    [15.0, 0.0, 0.0],
    [12.0, 12.0, 0.0],
    [10.0, 10.0, 10.0],
    [25.0, 10.0, 5.0],
    [0.0, 20.0, 25.0],
];

/// The largest error at the places by the largest displacement there, and the unknowns. A unit force lies on a square of
/// the surface, or in a cube about the depth `c`.
fn loaded(side: f64, nu: f64, c: f64) -> (f64, usize) {
    let mesh = block(REACH, side, 15.0);
    let (mut system, mut a) = solid(&mesh, nu);
    let thick = if c > 0.0 { HALF } else { 0.0 };
    let field = |x: &Vector3<f64>| spread(nu, [c, thick], HALF, x);
    hold_far(&mut system, &mut a, &mesh, REACH, field);
    let near = |x: &Vector3<f64>| x.x < HALF && x.y < HALF && (x.z - c).abs() <= thick;
    let area = (2.0 * HALF).powi(2);
    let load: Vec<(usize, f64)> = if c > 0.0 {
        let density = Vector3::z() / (2.0 * HALF * area);
        let each = mesh.spread(|x| if near(x) { density } else { Vector3::zeros() });
        each.into_iter().enumerate().collect()
    } else {
        let material = Material::new(Law::Linear, 1.0, nu).unwrap();
        let solid = Deformable::new(mesh.clone(), material, Vector3::zeros()).unwrap();
        solid.traction(|x, normal| {
            if near(x) && normal.z < -0.5 {
                Vector3::z() / area
            } else {
                Vector3::zeros()
            }
        })
    };
    system.load(0, &load);
    balance(&system, &mut a, 1e-10).unwrap();
    let exact = PLACES.map(|x| field(&Vector3::from(x)));
    let off = PLACES.iter().zip(&exact);
    let off = off.map(|(x, u)| (displacement(&mesh, &a, &Vector3::from(*x)) - u).norm());
    let most = exact.iter().map(|u| u.norm()).fold(0.0, f64::max);
    (off.fold(0.0, f64::max) / most, a.len())
}

#[test]
fn a_small_load_on_and_in_a_half_space() {
    for (nu, c) in [(0.3, 0.0), (0.4999, 0.0), (0.3, HALF), (0.4999, HALF)] {
        let each = [5.0, 2.5].map(|side| loaded(side, nu, c));
        println!(
            "nu {nu}, depth {c}: {:.3} % of {} unknowns, {:.3} % of {}",
            100.0 * each[0].0,
            each[0].1,
            100.0 * each[1].0,
            each[1].1
        );
        // Places within two of the largest cubes, of 10, from the load. Of order 3, one less is left to the load's edge.
        assert!(each[1].0 < 0.02 && each[0].0 > 4.0 * each[1].0, "{each:?}");
    }
}
