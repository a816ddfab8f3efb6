//! Other laws than the neo-Hookean: energies and forces by the table, stiffness from the table's tangents.

use super::{CELLS, Lane, Material, Table, single};
use crate::space::law::Tangent;

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
    // The table adds forces before it has seen all points, so that the energy is asked for first.
    table.energy(material, u)?;
    table.gradient(material, u, forces)
}

/// What the stiffness of other laws, or one made convex, needs beside [`single::Work`].
#[derive(Debug, Clone, Default)]
pub(super) struct Work {
    tangents: Vec<Tangent>,
    changes: Vec<f64>,
}

/// The packed stiffness from tangents of 9 x 9. False where the law has no energy.
#[inline(always)]
pub(super) fn stiffness<W: Lane>(
    proof: W::Proof,
    (work, single): (&mut Work, &mut single::Work<W>),
    table: &Table,
    material: &Material,
    u: &[f64],
    convex: bool,
    packed: &mut Vec<f64>,
) -> bool {
    work.tangents.clear();
    // Zeros each time, as the table adds to what it is given.
    work.changes.clear();
    work.changes.resize(3 * table.nodes() * table.mode_count, 0.0);
    let (tangents, changes) = (&mut work.tangents, &mut work.changes);
    let found = table.tangents(material, u, convex, changes, |_, tangent| tangents.push(*tangent));
    if found.is_none() {
        return false;
    }
    let couples = (material.lame.lambda / table.volume(), work.changes.as_slice());
    single::contract(proof, single, table, &work.tangents, couples, packed);
    true
}
