//! Tables that cannot be, cells without extent, and states without energy.

use super::*;

fn point(nodes: usize) -> Point {
    Point {
        weight: 1.0,
        at: Vector3::new(1.0, 2.0, 3.0),
        slopes: vec![Vector3::new(0.1, 0.2, 0.3); nodes],
    }
}

fn refused(nodes: usize, points: &[Point]) -> BadTable {
    Table::new(nodes, points, Dilatation::Linear).unwrap_err()
}

#[test]
fn bad_tables_are_refused_by_name() {
    assert!(matches!(refused(0, &[point(0)]), BadTable::Size { nodes: 0, .. }));
    assert!(matches!(refused(8, &[]), BadTable::Size { points: 0, .. }));
    let most = Table::MOST_NODES;
    assert!(matches!(refused(most + 1, &[point(most + 1)]), BadTable::Size { .. }));
    assert!(Table::new(most, &[point(most)], Dilatation::Linear).is_ok());
    let found = refused(8, &[point(8), point(7)]);
    assert_eq!(
        found,
        BadTable::Slopes {
            point: 1,
            found: 7,
            nodes: 8
        }
    );
    for weight in [0.0, -1.0, f64::INFINITY, f64::NAN] {
        let bad = Point { weight, ..point(4) };
        assert!(matches!(
            refused(4, &[point(4), bad]),
            BadTable::Weight { point: 1, .. }
        ));
    }
    let mut bad = point(4);
    bad.at.y = f64::NAN;
    assert_eq!(refused(4, &[bad]), BadTable::NotFinite { point: 0 });
    let mut bad = point(4);
    bad.slopes[3].z = f64::INFINITY;
    assert_eq!(refused(4, &[bad]), BadTable::NotFinite { point: 0 });
    for size in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let found = Table::cube(Order::Linear, size, Dilatation::Plain);
        assert!(matches!(found, Err(BadTable::Edge { .. })));
    }
    let large = Point {
        weight: 1e308,
        ..point(4)
    };
    let found = refused(4, &[large.clone(), large]);
    assert!(matches!(found, BadTable::Volume { found } if found.is_infinite()));
    // Its volume is no number.
    assert!(Table::cube(Order::Linear, 1e200, Dilatation::Plain).is_err());
    assert!(Table::cube(Order::Linear, 1e-200, Dilatation::Plain).is_err());
}

#[test]
fn cells_without_extent_are_projected_on_what_they_have() {
    let cell = scattered(20, 12, Dilatation::Linear);
    let material = materials()[2];
    let u = noisy(&cell, 0.05, 4);
    let slopes = |p: usize| {
        cell.table
            .slopes_at(p)
            .iter()
            .map(|q| Vector3::from(*q))
            .collect::<Vec<_>>()
    };
    let on = |at: Vector3<f64>, p: usize| Point {
        weight: 0.5,
        at,
        slopes: slopes(p),
    };
    let x = Vector3::new(0.3, -0.4, 2.0);
    for (points, modes) in [
        ((0..12).map(|p| on(x, p)).collect::<Vec<_>>(), 1),
        ((0..12).map(|p| on(x * p as f64, p)).collect(), 2),
        (
            (0..12)
                .map(|p| on(x * p as f64 + Vector3::x() * (p * p) as f64, p))
                .collect(),
            3,
        ),
        (vec![on(x, 0)], 1),
    ] {
        let table = Table::new(20, &points, Dilatation::Linear).unwrap();
        assert_eq!(table.mode_count, modes);
        assert!(table.energy(&material, &u).unwrap() > 0.0);
        // One point is projected on itself.
        if points.len() == 1 {
            let plain = Table::new(20, &points, Dilatation::Plain).unwrap();
            let (a, b) = (table.energy(&material, &u), plain.energy(&material, &u));
            assert!((a.unwrap() / b.unwrap() - 1.0).abs() < 1e-14);
        }
    }
}

#[test]
fn states_without_energy_have_none() {
    for material in materials() {
        for cell in DILATATIONS.into_iter().flat_map(cells) {
            let turned_over = displaced(&cell, |x| x * -2.5);
            let mut not_a_number = vec![0.0; turned_over.len()];
            not_a_number[4] = f64::NAN;
            let table = &cell.table;
            assert!(table.least_determinant(&turned_over) < 0.0);
            for (u, none) in [(&turned_over, material.forbids_inversion()), (&not_a_number, true)] {
                let mut forces = vec![0.0; u.len()];
                assert_eq!(table.energy(&material, u).is_none(), none, "{material:?}");
                assert_eq!(
                    table.gradient(&material, u, &mut forces).is_none(),
                    none,
                    "{material:?}"
                );
                let found = table.stiffness(&material, u, false, &mut Vec::new());
                assert_eq!(found.is_none(), none, "{material:?}");
                let stressed = material.law == Law::Linear && !none;
                assert_eq!(table.state(&material, u, 0).is_some(), stressed, "{material:?}");
            }
            assert!(table.least_determinant(&not_a_number).is_nan());
        }
    }
}
