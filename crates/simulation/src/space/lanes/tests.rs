//! Bits of lanes against one another, and numbers against those of the elements.

use super::*;
use crate::space::element::{Dilatation, Order, Point};

/// Deterministic numbers in (-1, 1).
fn numbers(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
    move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

fn tables() -> Vec<Table> {
    let dilatations = [Dilatation::Plain, Dilatation::Constant, Dilatation::Linear];
    let orders = [Order::Linear, Order::Quadratic];
    let cubes = orders
        .into_iter()
        .flat_map(|o| dilatations.map(|d| Table::cube(o, 1.5, d).unwrap()));
    // And cells of any number of nodes and points.
    let scattered = [(5, 6), (20, 13), (1, 1), (31, 70)].map(|(nodes, points)| scattered(nodes, points));
    cubes.chain(scattered).collect()
}

fn scattered(nodes: usize, points: usize) -> Table {
    let mut next = numbers((100 * nodes + points) as u64);
    let mut vector = || nalgebra::Vector3::new(next(), next(), next());
    let point = |k: usize| Point {
        weight: 0.1 + (k % 5) as f64,
        at: vector(),
        slopes: (0..nodes).map(|_| vector() * (3.0 / nodes as f64)).collect(),
    };
    let points: Vec<Point> = (0..points).map(point).collect();
    Table::new(nodes, &points, Dilatation::Linear).unwrap()
}

/// Four states: nearly at rest, deformed, far from 1 in volume, and one that may be turned inside out.
fn states(table: &Table, seed: u64) -> [Vec<f64>; CELLS] {
    let mut next = numbers(seed);
    let mut state = |size: f64| (0..3 * table.nodes()).map(|_| size * next()).collect::<Vec<f64>>();
    [state(1e-9), state(0.02), state(0.08), state(0.5)]
}

fn material() -> Material {
    Material::new(Law::NeoHookean, 1.7, 0.49).unwrap()
}

fn slices(u: &[Vec<f64>; CELLS]) -> [&[f64]; CELLS] {
    u.each_ref().map(Vec::as_slice)
}

fn gradient(lanes: &mut Lanes, table: &Table, u: &[Vec<f64>; CELLS]) -> ([Option<f64>; CELLS], [Vec<f64>; CELLS]) {
    let mut forces = [(); CELLS].map(|()| vec![0.0; 3 * table.nodes()]);
    let [a, b, c, d] = &mut forces;
    let energies = lanes.gradient(table, &material(), slices(u), [a, b, c, d]);
    (energies, forces)
}

fn bits(values: &[f64]) -> Vec<u64> {
    values.iter().map(|x| x.to_bits()).collect()
}

#[test]
fn all_lanes_give_the_same_bits() {
    let (mut wide, mut portable, material) = (Lanes::new(), Lanes::portable(), material());
    assert!(!portable.is_wide());
    let mut none = 0;
    for (table, seed) in tables().iter().flat_map(|t| (0..20).map(move |s| (t, s))) {
        let u = states(table, seed);
        let (energies, forces) = gradient(&mut wide, table, &u);
        assert_eq!((energies, forces.clone()), gradient(&mut portable, table, &u));
        assert_eq!(wide.energy(table, &material, slices(&u)), energies);
        assert_eq!(portable.energy(table, &material, slices(&u)), energies);
        let [mut stiff, mut other] = [(); 2].map(|()| [(); CELLS].map(|()| Vec::new()));
        let regular = wide.stiffness(table, &material, slices(&u), false, &mut stiff);
        assert_eq!(
            regular,
            portable.stiffness(table, &material, slices(&u), false, &mut other)
        );
        for (k, u) in u.iter().enumerate() {
            assert_eq!(energies[k].is_some(), regular[k]);
            none += usize::from(!regular[k]);
            for lanes in [&mut wide, &mut portable] {
                let (mut alone, mut packed) = (vec![0.0; u.len()], Vec::new());
                assert_eq!(lanes.energy_of_one(table, &material, u), energies[k]);
                assert_eq!(lanes.gradient_of_one(table, &material, u, &mut alone), energies[k]);
                assert_eq!(bits(&alone), bits(&forces[k]));
                assert_eq!(
                    lanes.stiffness_of_one(table, &material, u, false, &mut packed),
                    regular[k]
                );
                assert!(!regular[k] || bits(&stiff[k]) == bits(&packed));
            }
            if regular[k] {
                assert_eq!(bits(&stiff[k]), bits(&other[k]));
            }
        }
    }
    // Some states are turned inside out, not all of the fourth.
    assert!(none > 20 && none < 20 * tables().len() * 2, "{none}");
}

#[test]
fn numbers_are_those_of_the_elements() {
    let (mut lanes, material) = (Lanes::new(), material());
    for (table, seed) in tables().iter().flat_map(|t| (0..20).map(move |s| (t, s))) {
        let u = states(table, seed);
        let (energies, forces) = gradient(&mut lanes, table, &u);
        let mut stiff = [(); CELLS].map(|()| Vec::new());
        lanes.stiffness(table, &material, slices(&u), false, &mut stiff);
        for (k, u) in u.iter().enumerate() {
            let mut expected = vec![0.0; u.len()];
            let energy = table.gradient(&material, u, &mut expected);
            assert_eq!(energy.is_some(), energies[k].is_some());
            let (Some(energy), Some(found)) = (energy, energies[k]) else {
                continue;
            };
            let mut packed = Vec::new();
            table.stiffness(&material, u, false, &mut packed).unwrap();
            // Sums of some 100 terms that cancel, each rounded to eps of the largest: at rest of the displacement's size.
            let scale = packed.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
            let size = u.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
            assert!((found / energy - 1.0).abs() < 1e-12, "{found} {energy}");
            let off = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(off(&forces[k], &expected) < 1e-13 * scale * size);
            assert_eq!(stiff[k].len(), packed.len());
            let error = off(&stiff[k], &packed);
            assert!(error < 1e-13 * scale, "{error:e} of {scale:e}");
        }
    }
}

#[test]
fn forces_are_added_to_those_of_cells_with_an_energy() {
    let table = &tables()[2];
    let mut u = states(table, 1);
    u[3].iter_mut()
        .enumerate()
        .for_each(|(k, u)| *u = if k % 3 == 0 { f64::NAN } else { 0.0 });
    let mut lanes = Lanes::new();
    let (_, once) = gradient(&mut lanes, table, &u);
    let mut sums = [(); CELLS].map(|()| vec![1.0; 24]);
    let [a, b, c, d] = &mut sums;
    let energies = lanes.gradient(table, &material(), slices(&u), [a, b, c, d]);
    assert!(energies[3].is_none() && energies[0].is_some());
    assert_eq!(sums[3], [1.0; 24]);
    for (sum, once) in sums.iter().zip(&once).take(3) {
        assert!(sum.iter().zip(once).all(|(sum, once)| *sum == 1.0 + once));
    }
}

#[test]
fn what_lanes_know() {
    assert!(Lanes::knows(&material()));
    let fibre = crate::space::law::Fibre::new(nalgebra::Vector3::x(), 1.0, 1.0).unwrap();
    let fibred = Material {
        fibre: Some(fibre),
        ..material()
    };
    assert!(!Lanes::knows(&fibred));
    assert!(!Lanes::knows(&Material::new(Law::Linear, 1.0, 0.3).unwrap()));
}

#[test]
fn other_laws_and_convex_stiffness_are_those_of_the_table() {
    let (mut wide, mut portable) = (Lanes::new(), Lanes::portable());
    let stable = Material::new(Law::StableNeoHookean, 1.0, 0.4).unwrap();
    let svk = Material::new(Law::StVenantKirchhoff, 1.0, 0.3).unwrap();
    for (table, (convex, material)) in tables()
        .iter()
        .flat_map(|t| [(false, stable), (true, svk), (true, material())].map(move |case| (t, case)))
    {
        let u = states(table, 3);
        let empty = || [(); CELLS].map(|()| Vec::new());
        let (mut packed, mut other) = (empty(), empty());
        let regular = wide.stiffness(table, &material, slices(&u), convex, &mut packed);
        assert_eq!(
            regular,
            portable.stiffness(table, &material, slices(&u), convex, &mut other)
        );
        for (k, u) in u.iter().enumerate() {
            let (mut alone, mut expected) = (Vec::new(), Vec::new());
            assert_eq!(
                table.stiffness(&material, u, convex, &mut expected).is_some(),
                regular[k]
            );
            assert_eq!(
                wide.stiffness_of_one(table, &material, u, convex, &mut alone),
                regular[k]
            );
            if !regular[k] {
                continue;
            }
            assert_eq!(bits(&packed[k]), bits(&other[k]));
            assert_eq!(bits(&packed[k]), bits(&alone));
            let scale = expected.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
            let off = expected
                .iter()
                .zip(&alone)
                .map(|(a, b)| (a - b).abs())
                .fold(0.0, f64::max);
            assert!(off < 1e-14 * scale, "{off:e} of {scale:e}");
        }
    }
}

#[test]
fn energies_and_forces_of_other_laws_are_those_of_the_table() {
    let (mut lanes, material) = (Lanes::new(), Material::new(Law::StableNeoHookean, 1.0, 0.4).unwrap());
    for table in &tables() {
        let u = states(table, 3);
        let mut forces = [(); CELLS].map(|()| vec![0.0; 3 * table.nodes()]);
        let [a, b, c, d] = &mut forces;
        let energies = lanes.gradient(table, &material, slices(&u), [a, b, c, d]);
        let alone = lanes.energy(table, &material, slices(&u));
        for (k, u) in u.iter().enumerate() {
            let (mut own, mut other) = (vec![0.0; u.len()], vec![0.0; u.len()]);
            assert_eq!(table.gradient(&material, u, &mut own), energies[k]);
            assert_eq!(lanes.gradient_of_one(table, &material, u, &mut other), energies[k]);
            assert_eq!(table.energy(&material, u), alone[k]);
            assert_eq!(lanes.energy_of_one(table, &material, u), alone[k]);
            assert_eq!((&own, &other), (&forces[k], &forces[k]));
        }
    }
}

#[test]
fn infinite_and_huge_states_have_no_energy() {
    let mut lanes = Lanes::new();
    for table in &tables() {
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e200, -1e200] {
            let mut u = [(); CELLS].map(|()| vec![0.0; 3 * table.nodes()]);
            u[2][1] = bad;
            let (energies, forces) = gradient(&mut lanes, table, &u);
            assert_eq!(energies, [Some(0.0), Some(0.0), None, Some(0.0)]);
            assert!(forces.iter().flatten().all(|f| *f == 0.0));
            assert_eq!(lanes.energy_of_one(table, &material(), &u[2]), None);
        }
    }
}
