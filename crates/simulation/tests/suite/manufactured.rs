//! A manufactured solution: errors of order 3 in the displacement and 2 in its gradient.

use nalgebra::{Matrix2, Vector2};
use serde_json::Value;
use simulation::control::{Newton, Settings};
use simulation::law::{Law, Material};
use simulation::q9::{Mesh, gradients, grid, values};
use simulation::solid::Deformable;
use simulation::system::System;

const PI: f64 = std::f64::consts::PI;

fn exact(x: Vector2<f64>) -> Vector2<f64> {
    let second = 0.03 * (0.5 * PI * x.x).cos() * (PI * x.y).sin() + 0.05 * x.x * x.x;
    Vector2::new(0.03 * (PI * x.x).sin() * (PI * x.y).cos(), second)
}

fn exact_gradient(x: Vector2<f64>) -> Matrix2<f64> {
    let (a, b) = (PI * x.x, PI * x.y);
    Matrix2::new(
        0.03 * PI * a.cos() * b.cos(),
        -0.03 * PI * a.sin() * b.sin(),
        -0.015 * PI * (0.5 * a).sin() * b.sin() + 0.1 * x.x,
        0.03 * PI * (0.5 * a).cos() * b.cos(),
    )
}

/// `-Div P`, by differences of fourth order: h^4 / 30 times fifth derivatives below 20 is 1e-12.
fn force(material: &Material, x: Vector2<f64>) -> Vector2<f64> {
    let h = 1e-3;
    let stress = |x: Vector2<f64>| material.response(&exact_gradient(x)).expect("no inversion").stress;
    let mut force = Vector2::zeros();
    for (axis, e) in [Vector2::x(), Vector2::y()].into_iter().enumerate() {
        let near = stress(x + e * h) - stress(x - e * h);
        let far = stress(x + e * (2.0 * h)) - stress(x - e * (2.0 * h));
        let slope = (near * 8.0 - far) / (12.0 * h);
        force -= Vector2::new(slope[2 * axis], slope[2 * axis + 1]);
    }
    force
}

/// Root of the integrals of the squared errors of the displacement and of its gradient, by a rule of five points.
fn errors(mesh: &Mesh, a: &[f64]) -> [f64; 2] {
    let (p, q) = (0.538_469_310_105_683_1, 0.906_179_845_938_664);
    let rule = [
        (-q, 0.236_926_885_056_189_1),
        (-p, 0.478_628_670_499_366_5),
        (0.0, 0.568_888_888_888_888_9),
    ];
    let rule: Vec<(f64, f64)> = rule.into_iter().chain([(p, rule[1].1), (q, rule[0].1)]).collect();
    let mut sums = [0.0; 2];
    for element in &mesh.elements {
        for ((u, wu), (v, wv)) in rule.iter().flat_map(|u| rule.iter().map(move |v| (*u, *v))) {
            let (weights, slopes) = (values(u, v), gradients(u, v));
            let (mut x, mut d, mut map, mut by) =
                (Vector2::zeros(), Vector2::zeros(), Matrix2::zeros(), Matrix2::zeros());
            for (k, n) in element.nodes.iter().enumerate() {
                let moved = Vector2::new(a[2 * n], a[2 * n + 1]);
                x += mesh.nodes[*n] * weights[k];
                d += moved * weights[k];
                map += mesh.nodes[*n] * slopes[k].transpose();
                by += moved * slopes[k].transpose();
            }
            let area = wu * wv * map.determinant();
            let gradient = by * map.try_inverse().expect("a good map");
            sums[0] += area * (d - exact(x)).norm_squared();
            sums[1] += area * (gradient - exact_gradient(x)).norm_squared();
        }
    }
    sums.map(f64::sqrt)
}

fn solve(mesh: Mesh, law: Law) -> [f64; 2] {
    let material = Material::new(law, 1.0, 0.3).expect("a material");
    let boundary: Vec<usize> = mesh.boundary.iter().flatten().copied().collect();
    let mut loads = Vec::new();
    for element in &mesh.elements {
        for point in &element.points {
            let x: Vector2<f64> = element
                .nodes
                .iter()
                .zip(point.values)
                .map(|(n, w)| mesh.nodes[*n] * w)
                .sum();
            let force = force(&material, x) * point.weight;
            for (n, w) in element.nodes.iter().zip(point.values) {
                loads.extend([(2 * n, force.x * w), (2 * n + 1, force.y * w)]);
            }
        }
    }
    let mut system = System::new();
    let body = system.add(Deformable::new(mesh.clone(), material, Vector2::zeros()).expect("a solid"));
    system.load(body, &loads);
    system.clamp(body, &boundary);
    let mut a: Vec<f64> = mesh.nodes.iter().flat_map(|x| [exact(*x).x, exact(*x).y]).collect();
    Newton::new(Settings::default())
        .minimise(&system, &mut a)
        .expect("a state");
    errors(&mesh, &a)
}

fn check(rows: &Value, name: &str, solve: impl Fn(usize) -> [f64; 2]) {
    let mut last: Option<[f64; 2]> = None;
    for row in rows.as_array().expect("rows").iter().skip(1).take(3) {
        let n = row["n"].as_u64().expect("a number") as usize;
        let found = solve(n);
        let expected = ["L2", "H1"].map(|key| row[key].as_f64().expect("a number"));
        for k in 0..2 {
            // The other code integrates the loads by another rule.
            assert!(
                (found[k] / expected[k] - 1.0).abs() < 0.02,
                "{name} n={n}: {found:?} {expected:?}"
            );
        }
        if let Some(coarse) = last.filter(|_| n > 8) {
            let order = [0, 1].map(|k| (coarse[k] / found[k]).log2());
            assert!(
                (order[0] - 3.0).abs() < 0.03 && (order[1] - 2.0).abs() < 0.03,
                "{name} n={n}: {order:?}"
            );
        }
        last = Some(found);
    }
}

#[test]
fn errors_fall_with_the_third_power() {
    let Some(oracle) = crate::common::oracle() else { return };
    let cases = &oracle["mms"]["cases"];
    let square = |n| grid([n, n], false, Vector2::new).expect("a mesh");
    for (key, law) in [("svk_3x3", Law::StVenantKirchhoff), ("nh_3x3", Law::NeoHookean)] {
        check(&cases[key], key, |n| solve(square(n), law));
    }
    let annulus = |n| {
        grid([n, n], false, |s, t| {
            let angle = 0.5 * PI * (1.0 - s);
            Vector2::new(angle.cos(), angle.sin()) * (0.5 + 0.5 * t)
        })
        .expect("a mesh")
    };
    let key = "svk_3x3_quarter_annulus_curved_isoparametric";
    check(&cases[key], key, |n| solve(annulus(n), Law::StVenantKirchhoff));
}
