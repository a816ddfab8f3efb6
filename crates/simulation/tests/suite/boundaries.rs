//! Cursors, polygons, blocks, overlaps.

use nalgebra::Vector2;
use simulation::constraint::overlapping;
use simulation::law::{Law, Material};
use simulation::q9::{blob, rectangle, ring};
use simulation::solid::{BadPolygon, Cursor, Deformable, Global, Rigid, Solid};
use simulation::system::System;

fn curved() -> Deformable {
    let mesh = blob(Vector2::new(0.3, 0.2), [0.7, 0.5], 0.4, [2, 2]).expect("a mesh");
    let material = Material::new(Law::NeoHookean, 1.0, 0.3).expect("a material");
    Deformable::new(mesh, material, Vector2::zeros()).expect("a solid")
}

/// A deformed state.
fn bent(solid: &dyn Solid) -> Vec<f64> {
    let mut a = solid.initial();
    a.iter_mut()
        .enumerate()
        .for_each(|(k, a)| *a += 0.02 * (1.3 * k as f64).sin());
    a
}

#[test]
fn a_cursor_knows_its_derivatives_by_arc_length() {
    let solid = curved();
    let a = bent(&solid);
    let h = 1e-4;
    for (arc, u) in [(0, 0.1), (3, -0.6), (5, 0.7)] {
        let cursor = Cursor { arc, u };
        let at = |by: f64| cursor.moved(&solid, by).local(&solid, &a);
        let (plus, minus, here) = (at(h), at(-h), at(0.0));
        // h^2 / 6 times third derivatives below 10, and eps / h^2 for the second.
        assert!(((plus.position - minus.position) / (2.0 * h) - here.tangent).amax() < 1e-6);
        let second = (plus.position - here.position * 2.0 + minus.position) / (h * h);
        assert!((second - here.second).amax() < 1e-5, "{second} {}", here.second);
        assert!((here.normal().dot(&here.tangent)).abs() < 1e-15);
    }
}

#[test]
fn a_cursors_rows_are_the_derivatives_of_its_point_and_tangent() {
    let solid = curved();
    let a = bent(&solid);
    let cursor = Cursor { arc: 2, u: 0.4 };
    let h = 1e-6;
    let mut rows = vec![[Vector2::zeros(); 2]; a.len()];
    cursor.rows(&solid, &a, &mut |p, by, slope| {
        rows[p][0] += by;
        rows[p][1] += slope;
    });
    for (k, row) in rows.iter().enumerate() {
        let at = |by: f64| {
            let mut b = a.clone();
            b[k] += by;
            cursor.local(&solid, &b)
        };
        let (plus, minus) = (at(h), at(-h));
        assert!(((plus.position - minus.position) / (2.0 * h) - row[0]).amax() < 1e-9);
        assert!(((plus.tangent - minus.tangent) / (2.0 * h) - row[1]).amax() < 1e-8);
    }
}

#[test]
fn a_cursor_goes_round_and_comes_back() {
    // Once round the outer contour of a ring, whose length the arcs approximate.
    let mesh = ring(Vector2::zeros(), [0.7, 1.0], [16, 1]).expect("a ring");
    let material = Material::new(Law::NeoHookean, 1.0, 0.3).expect("a material");
    let solid = Deformable::new(mesh, material, Vector2::zeros()).expect("a solid");
    let a = solid.initial();
    let outer = |arc: &usize| Cursor { arc: *arc, u: 0.0 }.local(&solid, &a).position.norm() > 0.9;
    let arc = (0..32).find(outer).expect("an outer arc");
    let start = Cursor { arc, u: 0.3 };
    let begin = start.local(&solid, &a);
    let length = std::f64::consts::TAU;
    // Each of 16 arcs misses the circle's length by about its angle to the fourth / 5000: 1e-4 in all.
    let end = start.moved(&solid, length).local(&solid, &a);
    assert!((end.position - begin.position).norm() < 1e-3);
    let back = start.moved(&solid, 2.345).moved(&solid, -2.345);
    assert!(back.arc == start.arc && (back.u - start.u).abs() < 1e-10, "{back:?}");
    // The solid lies on the left: normals point out, and a turn to the left is a centre inside.
    assert!(begin.normal().dot(&begin.position) > 0.99 && begin.second.dot(&begin.position) < -0.9);
}

#[test]
fn polygons_know_their_moments_and_refuse_what_is_none() {
    let square = [(1.0, 1.0), (3.0, 1.0), (3.0, 2.0), (1.0, 2.0)].map(|(x, y)| Vector2::new(x, y));
    let solid = Rigid::new(&square, Vector2::new(0.0, -3.0)).expect("a polygon");
    assert!((solid.centre() - Vector2::new(2.0, 1.5)).amax() < 1e-15);
    let mut weight = [0.0; 3];
    solid.weight(&mut weight);
    assert_eq!(weight, [0.0, -6.0, 0.0]);
    let mut a = solid.initial();
    solid.rotate(&mut a, 0.7, Vector2::new(1.0, 1.0));
    // The corner that it turned about stays.
    assert!((solid.point(&a, 0) - square[0]).amax() < 1e-15 && (solid.angle(&a) - 0.7).abs() < 1e-15);
    let with = |points: &[(f64, f64)]| {
        let points: Vec<Vector2<f64>> = points.iter().map(|(x, y)| Vector2::new(*x, *y)).collect();
        Rigid::new(&points, Vector2::zeros()).expect_err("refused")
    };
    assert_eq!(with(&[(0.0, 0.0), (1.0, 0.0)]), BadPolygon::TooFew { found: 2 });
    assert!(matches!(
        with(&[(0.0, 0.0), (f64::NAN, 0.0), (0.0, 1.0)]),
        BadPolygon::NotFinite { vertex: 1, .. }
    ));
    assert_eq!(
        with(&[(0.0, 0.0), (1.0, 0.0), (1.0, 0.0), (0.0, 1.0)]),
        BadPolygon::Repeated { vertex: 1, next: 2 }
    );
    let bow = with(&[(0.0, 0.0), (1.0, 1.0), (1.0, 0.0), (0.0, 1.0)]);
    assert_eq!(bow, BadPolygon::Crossing { first: 0, second: 2 });
    assert!(matches!(with(&[(0.0, 0.0), (0.0, 1.0), (1.0, 0.0)]), BadPolygon::Clockwise { area } if area == -0.5));
    assert!(matches!(
        with(&[(0.0, 0.0), (1.0, 0.0), (2.0, 0.0)]),
        BadPolygon::Clockwise { .. }
    ));
}

/// A deformation that the block can describe costs what it costs the mesh.
#[test]
fn a_block_deforms_its_solid_as_a_mesh_of_the_same_displacements() {
    let mesh = || blob(Vector2::new(0.3, 0.2), [0.7, 0.5], 0.4, [3, 3]).expect("a mesh");
    let material = Material::new(Law::NeoHookean, 1.0, 0.3).expect("a material");
    let weight = Vector2::new(0.1, -0.2);
    let fine = Deformable::new(mesh(), material, weight).expect("a solid");
    let block = [Vector2::new(-0.6, -0.6), Vector2::new(1.2, 1.0)];
    let coarse = Global::new(mesh(), material, weight, block).expect("a solid");
    assert_eq!(coarse.parameters(), 18);
    // Affine: both represent it exactly.
    let by = |p: Vector2<f64>| Vector2::new(0.1 * p.x - 0.05 * p.y + 0.2, 0.07 * p.x + 0.12 * p.y);
    let a: Vec<f64> = fine.mesh().nodes.iter().flat_map(|p| [by(*p).x, by(*p).y]).collect();
    let mut b = Vec::new();
    for n in 0..9 {
        let (s, t) = (f64::from(n % 3) * 0.5, f64::from(n / 3) * 0.5);
        let at = Vector2::new(-0.6 + 1.8 * s, -0.6 + 1.6 * t);
        b.extend([by(at).x, by(at).y]);
    }
    let (x, y) = (
        fine.energy(&a).expect("an energy"),
        coarse.energy(&b).expect("an energy"),
    );
    assert!((x - y).abs() < 1e-14, "{x} {y}");
    for &node in &fine.boundary().nodes {
        assert!((fine.point(&a, node) - coarse.point(&b, node)).amax() < 1e-14);
    }
    let small = [Vector2::new(-0.1, -0.6), Vector2::new(1.2, 1.0)];
    let refused = Global::new(mesh(), material, weight, small).expect_err("refused");
    assert!(refused.to_string().contains("outside the block"), "{refused}");
}

#[test]
fn overlaps_are_found_by_name() {
    let mut system = System::new();
    for x in [0.0, 1.5, 1.9] {
        let mesh = rectangle(Vector2::new(x, 0.0), Vector2::new(1.0, 1.0), [2, 2]).expect("a mesh");
        let material = Material::new(Law::NeoHookean, 1.0, 0.3).expect("a material");
        system.add(Deformable::new(mesh, material, Vector2::zeros()).expect("a solid"));
    }
    let found = overlapping(&system.bodies, &system.initial());
    assert!(
        !found.is_empty()
            && found
                .iter()
                .all(|o| o.first.min(o.second) == 1 && o.first.max(o.second) == 2),
        "{found:?}"
    );
    assert!(found[0].to_string().contains("solids 1 and 2 overlap"));
}
