//! Elements: patch test, rigid motions, derivatives, mapped and refused meshes.

use nalgebra::{DMatrix, DVector, Matrix2, Vector2};
use simulation::law::{Law, Material};
use simulation::q9::{Mesh, Refused, blob, grid, rectangle, ring};
use simulation::solid::{Deformable, Global, Rigid, Solid};
use simulation::sparse::Triplets;

/// 3 x 3 elements with curved, distorted sides.
fn distorted() -> Mesh {
    grid([3, 3], false, |s, t| {
        let wave = (7.0 * s + 3.0 * t).sin() * 0.04 + (5.0 * t - 2.0 * s).cos() * 0.03;
        Vector2::new(s + wave * t, t - wave * s)
    })
    .expect("a mesh")
}

fn solid(mesh: Mesh, law: Law, poisson: f64) -> Deformable {
    let material = Material::new(law, 1.0, poisson).expect("a material");
    Deformable::new(mesh, material, Vector2::zeros()).expect("a solid")
}

const LAWS: [Law; 3] = [Law::StVenantKirchhoff, Law::NeoHookean, Law::StableNeoHookean];

#[test]
fn a_uniform_gradient_leaves_inner_nodes_without_force() {
    let g = Matrix2::new(0.2, -0.1, 0.3, 0.1);
    for (law, mixed) in LAWS.into_iter().flat_map(|law| [(law, false), (law, true)]) {
        let mesh = if mixed { distorted().mixed() } else { distorted() };
        let area = mesh.area();
        let a: Vec<f64> = mesh.nodes.iter().flat_map(|p| [(g * p).x, (g * p).y]).collect();
        let solid = solid(mesh, law, 0.3);
        let mut forces = vec![0.0; a.len()];
        let energy = solid.gradient(&a, &mut forces).expect("an energy");
        let boundary = &solid.boundary().nodes;
        let inner = (0..a.len() / 2).filter(|n| !boundary.contains(n));
        let worst = inner
            .map(|n| forces[2 * n].abs().max(forces[2 * n + 1].abs()))
            .fold(0.0, f64::max);
        assert!(worst < 1e-14, "{law:?} {mixed} {worst:e}");
        let exact = area * solid.material().density(&g).expect("a density");
        // The curved map's area is a polynomial that the rule integrates exactly; the mixed form adds solves of 3 x 3.
        assert!((energy / exact - 1.0).abs() < 1e-13, "{law:?} {mixed} {energy} {exact}");
        assert!((solid.energy(&a).expect("an energy") - energy).abs() < 1e-15);
    }
}

#[test]
fn rigid_motions_cost_nothing() {
    for (law, mixed) in LAWS.into_iter().flat_map(|law| [(law, false), (law, true)]) {
        let mesh = if mixed { distorted().mixed() } else { distorted() };
        let nodes = mesh.nodes.clone();
        let solid = solid(mesh, law, 0.3);
        let mut a = solid.initial();
        solid.rotate(&mut a, 2.5, Vector2::new(0.3, -0.2));
        solid.translate(&mut a, Vector2::new(0.7, 1.1));
        let mut forces = vec![0.0; a.len()];
        let energy = solid.gradient(&a, &mut forces).expect("an energy");
        assert!(energy.abs() < 1e-28, "{law:?} {mixed} {energy:e}");
        assert!(forces.iter().all(|f| f.abs() < 1e-14), "{law:?} {mixed}");
        let mut sink = Triplets::new(a.len());
        solid.hessian(&a, false, &mut sink, 0).expect("second derivatives");
        let turn: Vec<f64> = (0..nodes.len())
            .flat_map(|n| {
                let p = solid.point(&a, n);
                [-p.y, p.x]
            })
            .collect();
        let along: Vec<f64> = (0..a.len()).map(|i| f64::from(i as u32 % 2)).collect();
        for mode in [turn, along] {
            let worst = sink.product(&mode).iter().fold(0.0_f64, |m, v| m.max(v.abs()));
            assert!(worst < 3e-14, "{law:?} {mixed} {worst:e}");
        }
    }
}

#[test]
fn a_free_element_has_three_modes_without_energy() {
    let mesh = rectangle(Vector2::zeros(), Vector2::new(1.0, 1.0), [1, 1]).expect("a mesh");
    let solid = solid(mesh, Law::Linear, 0.3);
    let dense = dense(&solid, &solid.initial(), false);
    let eigen = dense.symmetric_eigenvalues();
    assert_eq!(eigen.iter().filter(|v| v.abs() < 1e-13).count(), 3, "{eigen}");
    // Values of an independent code.
    assert!(eigen.iter().filter(|v| v.abs() >= 1e-13).all(|v| *v > 0.1), "{eigen}");
}

fn dense(solid: &dyn Solid, a: &[f64], convex: bool) -> DMatrix<f64> {
    let mut sink = Triplets::new(a.len());
    solid.hessian(a, convex, &mut sink, 0).expect("second derivatives");
    let column = |k: usize| {
        let mut unit = vec![0.0; a.len()];
        unit[k] = 1.0;
        DVector::from_vec(sink.product(&unit))
    };
    DMatrix::from_columns(&(0..a.len()).map(column).collect::<Vec<_>>())
}

fn solids() -> Vec<Box<dyn Solid>> {
    let weight = Vector2::new(0.1, -0.3);
    let material = |law| Material::new(law, 2.0, 0.3).expect("a material");
    let small = || blob(Vector2::new(0.3, 0.2), [0.7, 0.5], 0.4, [2, 1]).expect("a mesh");
    let mut all: Vec<Box<dyn Solid>> = Vec::new();
    for law in LAWS {
        all.push(Box::new(
            Deformable::new(small(), material(law), weight).expect("a solid"),
        ));
        all.push(Box::new(
            Deformable::new(small().mixed(), material(law), weight).expect("a solid"),
        ));
        let block = [Vector2::new(-1.0, -1.0), Vector2::new(1.5, 1.2)];
        all.push(Box::new(
            Global::new(small(), material(law), weight, block).expect("a solid"),
        ));
    }
    let corners = [(0.0, 0.0), (2.0, 0.1), (2.3, 1.0), (0.4, 1.4)].map(|(x, y)| Vector2::new(x, y));
    all.push(Box::new(Rigid::new(&corners, weight).expect("a polygon")));
    all
}

#[test]
fn every_solid_has_the_derivatives_of_its_energy() {
    let h = 1e-6;
    for solid in solids() {
        let mut a = solid.initial();
        solid.rotate(&mut a, 0.3, Vector2::new(1.0, 0.0));
        a.iter_mut()
            .enumerate()
            .for_each(|(k, a)| *a += 0.03 * (k as f64 * 1.7).sin());
        let at = |k: usize, by: f64| {
            let mut b = a.clone();
            b[k] += by;
            let mut gradient = vec![0.0; b.len()];
            let energy = solid.gradient(&b, &mut gradient).expect("an energy");
            assert!((energy - solid.energy(&b).expect("an energy")).abs() < 1e-14);
            (energy, DVector::from_vec(gradient))
        };
        let (gradient, hessian) = (at(0, 0.0).1, dense(solid.as_ref(), &a, false));
        for k in 0..a.len() {
            let (plus, minus) = (at(k, h), at(k, -h));
            // h^2 times third derivatives below 1e3, and eps / h.
            assert!(((plus.0 - minus.0) / (2.0 * h) - gradient[k]).abs() < 1e-8, "{solid:?}");
            assert!(
                ((plus.1 - minus.1) / (2.0 * h) - hessian.column(k)).amax() < 1e-7,
                "{solid:?}"
            );
        }
        let convex = dense(solid.as_ref(), &a, true).symmetric_eigenvalues();
        assert!(convex.min() > -1e-12, "{convex}");
    }
}

#[test]
fn the_boundary_moves_as_its_rows_say() {
    let h = 1e-6;
    for solid in solids() {
        let mut a = solid.initial();
        solid.rotate(&mut a, -0.8, Vector2::new(1.0, 0.0));
        for &node in solid.boundary().nodes.iter().take(4) {
            let mut rows = vec![Vector2::zeros(); a.len()];
            solid.rows(&a, node, &mut |p, by| rows[p] += by);
            let mut bend = Triplets::new(a.len());
            let force = Vector2::new(0.3, -0.7);
            solid.bend(&a, node, force, &mut bend, 0);
            for k in 0..a.len() {
                let at = |by: f64| {
                    let mut b = a.clone();
                    b[k] += by;
                    let mut rows = vec![Vector2::zeros(); b.len()];
                    solid.rows(&b, node, &mut |p, by| rows[p] += by);
                    let pull: Vec<f64> = rows.iter().map(|r| r.dot(&force)).collect();
                    (solid.point(&b, node), DVector::from_vec(pull))
                };
                let (plus, minus) = (at(h), at(-h));
                assert!(((plus.0 - minus.0) / (2.0 * h) - rows[k]).amax() < 1e-9);
                let mut unit = vec![0.0; a.len()];
                unit[k] = 1.0;
                let column = DVector::from_vec(bend.product(&unit));
                assert!(((plus.1 - minus.1) / (2.0 * h) - column).amax() < 1e-9);
            }
        }
    }
}

#[test]
fn areas_and_orientation_of_generated_meshes() {
    let pi = std::f64::consts::PI;
    // Quadratic sides miss the circle by the fourth power of the element: 3e-5 of the area with 20 elements.
    let ring = ring(Vector2::new(1.0, 2.0), [0.7, 1.0], [20, 2]).expect("a ring");
    assert!((ring.area() / (pi * 0.51) - 1.0).abs() < 1e-4, "{}", ring.area());
    let sign = |mesh: &Mesh| -> f64 {
        let arcs = mesh.boundary.iter();
        arcs.map(|a| {
            let (p, q) = (mesh.nodes[a[0]], mesh.nodes[a[2]]);
            0.5 * (p.x * q.y - p.y * q.x)
        })
        .sum()
    };
    assert!(sign(&ring) > 1.4 && ring.boundary.len() == 40);
    let blob = blob(Vector2::zeros(), [0.7, 0.6], 0.3, [4, 4]).expect("a blob");
    assert!(sign(&blob) > 1.0 && blob.boundary.len() == 16);
}

/// What spoils nodes and elements.
type Change = dyn Fn(&mut Vec<Vector2<f64>>, &mut Vec<[usize; 9]>);

#[test]
fn bad_meshes_are_refused_by_name() {
    let good = rectangle(Vector2::zeros(), Vector2::new(1.0, 1.0), [2, 1]).expect("a mesh");
    let elements: Vec<[usize; 9]> = good.elements.iter().map(|e| e.nodes).collect();
    let with = |change: &Change| {
        let (mut nodes, mut ids) = (good.nodes.clone(), elements.clone());
        change(&mut nodes, &mut ids);
        Mesh::new(nodes, &ids).expect_err("refused")
    };
    assert_eq!(with(&|_, ids| ids.clear()), Refused::Empty);
    assert!(matches!(
        with(&|n, _| n[3].x = f64::NAN),
        Refused::NotFinite { node: 3, .. }
    ));
    assert_eq!(
        with(&|_, ids| ids[1][4] = 99),
        Refused::MissingNode {
            element: 1,
            node: 99,
            nodes: 15
        }
    );
    assert!(matches!(
        with(&|_, ids| ids[0][4] = ids[0][0]),
        Refused::RepeatedNode { element: 0, .. }
    ));
    assert_eq!(with(&|n, _| n.push(Vector2::zeros())), Refused::UnusedNode { node: 15 });
    assert!(matches!(
        with(&|n, _| n.iter_mut().for_each(|p| p.x = -p.x)),
        Refused::Clockwise { element: 0, .. }
    ));
    assert!(matches!(
        with(&|_, ids| ids[1] = ids[0]),
        Refused::UnusedNode { .. } | Refused::Side { .. }
    ));
}

/// At the quarter point the map is singular in the corner; beyond it folds. Inside it is good.
#[test]
fn a_middle_node_at_the_quarter_point_is_refused() {
    let with = |x: f64| {
        let mut nodes: Vec<Vector2<f64>> = (0..9)
            .map(|k| Vector2::new(f64::from(k % 3), f64::from(k / 3)) * 0.5)
            .collect();
        nodes[1].x = x;
        Mesh::new(nodes, &[std::array::from_fn(|n| n)])
    };
    assert!(with(0.26).is_ok());
    for x in [0.25, 0.24, 0.0] {
        let refused = with(x).expect_err("refused");
        assert!(
            matches!(refused, Refused::Folded { element: 0, .. } | Refused::Clockwise { .. }),
            "{x}: {refused}"
        );
    }
}
