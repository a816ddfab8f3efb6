//! Uniform gradients, rigid motions and sizes.

use super::*;

#[test]
fn uniform_gradients_have_the_energy_and_forces_of_the_law() {
    let g = Matrix3::new(0.1, 0.2, -0.05, -0.15, 0.07, 0.1, 0.05, -0.1, -0.2);
    let way = Matrix3::new(0.3, -0.1, 0.2, 0.5, 0.1, 0.6, -0.2, 0.4, 0.2);
    for material in materials() {
        let (density, stress) = material.stress(&g).unwrap();
        for cell in DILATATIONS.into_iter().flat_map(cells) {
            let u = displaced(&cell, |x| g * x + Vector3::new(3.0, -2.0, 1.0));
            let volume = cell.table.volume();
            let scale = volume * material.lame.confined();
            let (energy, forces) = forces(&cell.table, &material, &u);
            assert!((energy - volume * density).abs() < 1e-13 * scale);
            assert!((cell.table.energy(&material, &u).unwrap() - energy).abs() < 1e-13 * scale);
            // The work along a linear displacement is that of the stress.
            let along = displaced(&cell, |x| way * x);
            let work = forces.dot(&DVector::from_vec(along));
            let stress = Matrix3::from_column_slice(stress.as_slice());
            assert!((work - volume * stress.dot(&way)).abs() < 1e-12 * scale, "{material:?}");
            let least = cell.table.least_determinant(&u);
            assert!((least - (Matrix3::identity() + g).determinant()).abs() < 1e-13);
            let state = cell.table.state(&material, &u, 0).unwrap();
            assert!((state.gradient - g).amax() < 1e-13 && (state.density - density).abs() < 1e-13);
            let f = Matrix3::identity() + g;
            let cauchy = match material.law {
                Law::Linear => stress,
                _ => stress * f.transpose() / f.determinant(),
            };
            assert!((state.cauchy - cauchy).amax() < 1e-12, "{material:?}");
        }
    }
}

/// Eight cubes about one node, or 27-node cubes about 27 inner nodes: no force is left on what lies inside.
#[test]
fn patches_of_cubes_bear_uniform_stress() {
    let g = Matrix3::new(0.1, 0.2, -0.05, -0.15, 0.07, 0.1, 0.05, -0.1, -0.2);
    for (order, dilatation) in ORDERS.into_iter().flat_map(|o| DILATATIONS.map(|d| (o, d))) {
        let cell = cube(order, 0.7, dilatation);
        let n = if order == Order::Linear { 2 } else { 3 };
        let side = 2 * n - 1;
        for material in materials() {
            let mut total = vec![Vector3::zeros(); side * side * side];
            for corner in 0..8 {
                let [i, j, k] = [corner % 2, corner / 2 % 2, corner / 4];
                let shift = Vector3::new(i as f64, j as f64, k as f64) * 0.7;
                let u = displaced(&cell, |x| g * (x + shift));
                let (_, forces) = forces(&cell.table, &material, &u);
                for node in 0..cell.table.nodes() {
                    let [x, y, z] = [node % n, node / n % n, node / (n * n)];
                    let [x, y, z] = [x + i * (n - 1), y + j * (n - 1), z + k * (n - 1)];
                    total[x + side * (y + side * z)] += forces.fixed_rows::<3>(3 * node);
                }
            }
            let inside = |k: usize| {
                [k % side, k / side % side, k / side / side]
                    .iter()
                    .all(|c| *c > 0 && *c < side - 1)
            };
            let outer: f64 = total.iter().map(|f| f.amax()).fold(0.0, f64::max);
            for (k, force) in total.iter().enumerate().filter(|(k, _)| inside(*k)) {
                assert!(force.amax() < 1e-13 * outer.max(1.0), "{material:?} {k} {force}");
            }
            assert!(outer > 1e-2);
        }
    }
}

#[test]
fn rigid_motions_cost_nothing() {
    let turn = Rotation3::from_euler_angles(0.7, -1.1, 2.3).into_inner() - Matrix3::identity();
    let spin = Matrix3::new(0.0, 0.3, -0.2, -0.3, 0.0, 0.5, 0.2, -0.5, 0.0);
    for material in materials() {
        // The linear law knows small rotations alone.
        let motion = if material.law == Law::Linear { spin } else { turn };
        for cell in DILATATIONS.into_iter().flat_map(cells) {
            let u = displaced(&cell, |x| motion * x + Vector3::new(5.0, -3.0, 2.0));
            let (energy, forces) = forces(&cell.table, &material, &u);
            let stiffness = stiffness(&cell.table, &material, &u, false);
            // Displacements of 6 are rounded to eps times that.
            let scale = 6.0 * stiffness.amax();
            assert!(forces.amax() < 1e-13 * scale, "{material:?} {}", forces.amax() / scale);
            // Rounding of G alone: the terms of a density are of size 1 at a half turn.
            assert!(energy.abs() < 1e-15 * scale, "{material:?} {}", energy / scale);
            // And no stiffness along what moves on.
            let rotated = displaced(&cell, |x| spin * (x + motion * x));
            let shifted = displaced(&cell, |_| Vector3::new(1.0, -2.0, 0.5));
            for way in [shifted, rotated] {
                if material.law == Law::Linear && way[0] != 1.0 {
                    continue;
                }
                let resisted = &stiffness * DVector::from_vec(way);
                assert!(
                    resisted.amax() < 1e-13 * scale,
                    "{material:?} {}",
                    resisted.amax() / scale
                );
            }
        }
    }
}

#[test]
fn sizes_scale_to_the_last_bit() {
    for (order, dilatation) in ORDERS.into_iter().flat_map(|o| DILATATIONS.map(|d| (o, d))) {
        let unit = cube(order, 1.0, dilatation);
        let u = noisy(&unit, 0.05, 3);
        for material in materials() {
            let (energy, at) = forces(&unit.table, &material, &u);
            let matrix = stiffness(&unit.table, &material, &u, false);
            // 1e-6 to 1e6.
            for exponent in [-20, -7, -1, 1, 5, 20] {
                let size = 2.0_f64.powi(exponent);
                let other = cube(order, size, dilatation);
                let v: Vec<f64> = u.iter().map(|x| x * size).collect();
                let (found, scaled) = forces(&other.table, &material, &v);
                assert_eq!(found, energy * size * size * size);
                assert_eq!(scaled, &at * (size * size));
                assert_eq!(stiffness(&other.table, &material, &v, false), &matrix * size);
            }
        }
    }
}

#[test]
fn densities_sum_to_the_energy() {
    for material in materials() {
        for cell in DILATATIONS.into_iter().flat_map(cells) {
            let u = noisy(&cell, 0.05, 9);
            let energy = cell.table.energy(&material, &u).unwrap();
            let points = 0..cell.table.points();
            let sum: f64 = points
                .map(|p| cell.table.weights[p] * cell.table.state(&material, &u, p).unwrap().density)
                .sum();
            assert!((sum / energy - 1.0).abs() < 1e-12, "{sum} {energy}");
            assert!(cell.table.state(&material, &u, cell.table.points()).is_none());
        }
    }
}

#[test]
fn principal_stresses_of_a_state() {
    let cell = cube(Order::Linear, 1.0, Dilatation::Plain);
    let material = Material::new(Law::Linear, 1.0, 0.25).unwrap();
    let g = Matrix3::from_diagonal(&Vector3::new(1e-3, 3e-3, -1e-3));
    let state = cell.table.state(&material, &displaced(&cell, |x| g * x), 3).unwrap();
    let (lambda, mu) = (material.lame.lambda, material.lame.mu);
    let expected = Vector3::new(3e-3, 1e-3, -1e-3).map(|e| 2.0 * mu * e + lambda * 3e-3);
    assert!((state.principal() - expected).amax() < 1e-17);
    // Half the squares of the differences 2e-3, 2e-3 and 4e-3 of strains.
    assert!((state.von_mises() - 2.0 * mu * 12e-6_f64.sqrt()).abs() < 1e-17);
}
