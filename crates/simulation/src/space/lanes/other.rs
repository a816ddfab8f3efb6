//! What is not done in lanes: cell by cell, by the table.

use super::{CELLS, Material, Table};

pub(super) fn energy(table: &Table, material: &Material, u: [&[f64]; CELLS]) -> [Option<f64>; CELLS] {
    u.map(|u| table.energy(material, u))
}

pub(super) fn gradient(
    table: &Table,
    material: &Material,
    u: [&[f64]; CELLS],
    forces: [&mut [f64]; CELLS],
) -> [Option<f64>; CELLS] {
    let mut energies = [None; CELLS];
    for ((energy, u), forces) in energies.iter_mut().zip(u).zip(forces) {
        *energy = gradient_of_one(table, material, u, forces);
    }
    energies
}

/// Forces are added to where there is an energy only, as in lanes.
pub(super) fn gradient_of_one(table: &Table, material: &Material, u: &[f64], forces: &mut [f64]) -> Option<f64> {
    table.energy(material, u)?;
    table.gradient(material, u, forces)
}

pub(super) fn stiffness(
    table: &Table,
    material: &Material,
    u: [&[f64]; CELLS],
    convex: bool,
    packed: &mut [Vec<f64>; CELLS],
) -> [bool; CELLS] {
    let mut regular = [false; CELLS];
    for ((regular, u), packed) in regular.iter_mut().zip(u).zip(packed) {
        *regular = table.stiffness(material, u, convex, packed).is_some();
    }
    regular
}
