//! Four cells of one [`Table`] at once, neo-Hookean: energy, forces and stiffness in lanes of four numbers.
//!
//! Each lane does what one cell alone would do, in the same order, and no product is fused with a sum. So the bits of a
//! cell depend neither on whether AVX2 is there nor on the three cells beside it: [`Lanes::gradient_of_one`] and the like,
//! for cells whose table no other has, give them too. From one machine to another they may differ where `J` is off 1 by more
//! than 0.1: the logarithm there is the C library's. They differ from those of [`Table::gradient`] and [`Table::stiffness`]
//! by rounding.
//!
//! The stiffness is not contracted from a tangent of 9 x 9: with `a_n = (cof F) Q_n` and the pressure `p`,
//! `K_(ni)(mk) = w (mu Q_n . Q_m d_ik + (mu - p) / J^2 a_nk a_mi)`, and what the pressures couple. That follows from
//! `F (Q_n x Q_m) = (a_n x a_m) / J`; the first term is the same for all cells of the table.

#[cfg(target_arch = "x86_64")]
mod avx2;
mod forces;
mod four;
mod lane;
mod other;
mod points;
mod single;
mod stiffness;

#[cfg(test)]
mod tests;

use lane::Lane;

use super::element::Table;
use super::law::Material;
use crate::law::Law;

/// How many cells are done at once.
pub const CELLS: usize = 4;

/// Memory for four cells and for one, kept from call to call.
#[derive(Debug, Clone, Default)]
pub struct Lanes {
    #[cfg(target_arch = "x86_64")]
    wide: Option<Wide>,
    four: four::Work<[f64; CELLS]>,
    single: single::Work<[f64; CELLS]>,
    other: other::Work,
}

/// The same for AVX2.
#[cfg(target_arch = "x86_64")]
#[derive(Debug, Clone)]
struct Wide {
    proof: avx2::Vector,
    four: four::Work<avx2::Wide>,
    single: single::Work<avx2::Wide>,
}

impl Lanes {
    /// With AVX2 where this processor has it.
    pub fn new() -> Self {
        Self {
            #[cfg(target_arch = "x86_64")]
            wide: avx2::Vector::detect().map(|proof| Wide {
                proof,
                four: four::Work::new(proof),
                single: single::Work::default(),
            }),
            ..Self::default()
        }
    }

    /// Without AVX2: the same bits, slower.
    pub fn portable() -> Self {
        Self::default()
    }

    /// Whether AVX2 is used.
    pub fn is_wide(&self) -> bool {
        #[cfg(target_arch = "x86_64")]
        return self.wide.is_some();
        #[cfg(not(target_arch = "x86_64"))]
        return false;
    }

    /// Whether a material is done in lanes from end to end: neo-Hookean, without fibres. Of others, energies and forces are
    /// [`Table`]'s, cell by cell, and lanes contract the tangents to the stiffness.
    pub fn knows(material: &Material) -> bool {
        material.law == Law::NeoHookean && material.fibre.is_none()
    }

    /// The elastic energies of four cells of these displacements ([`Table`]'s `u`). `None` for a cell where the law has none.
    pub fn energy(&mut self, table: &Table, material: &Material, u: [&[f64]; CELLS]) -> [Option<f64>; CELLS] {
        if !Self::knows(material) {
            return other::energy(table, material, u);
        }
        #[cfg(target_arch = "x86_64")]
        if let Some(Wide { proof, four, .. }) = &mut self.wide {
            return proof.run(
                #[inline(always)]
                || forces::energy(*proof, four, table, material, &u),
            );
        }
        forces::energy((), &mut self.four, table, material, &u)
    }

    /// The same, and their derivatives added to `forces`, of cells with an energy.
    pub fn gradient(
        &mut self,
        table: &Table,
        material: &Material,
        u: [&[f64]; CELLS],
        forces: [&mut [f64]; CELLS],
    ) -> [Option<f64>; CELLS] {
        if !Self::knows(material) {
            return other::gradient(table, material, u, forces);
        }
        #[cfg(target_arch = "x86_64")]
        if let Some(Wide { proof, four, .. }) = &mut self.wide {
            return proof.run(
                #[inline(always)]
                || forces::gradient(*proof, four, table, material, &u, forces),
            );
        }
        forces::gradient((), &mut self.four, table, material, &u, forces)
    }

    /// The second derivatives, packed as by [`Table::stiffness`]; convex ones are made cell by cell, from
    /// tangents. False for a cell where
    /// the law has no energy: its numbers are not to be used.
    pub fn stiffness(
        &mut self,
        table: &Table,
        material: &Material,
        u: [&[f64]; CELLS],
        convex: bool,
        packed: &mut [Vec<f64>; CELLS],
    ) -> [bool; CELLS] {
        if convex || !Self::knows(material) {
            // Tangents come from the law cell by cell: only their contraction is done in lanes.
            let mut regular = [false; CELLS];
            for ((regular, u), packed) in regular.iter_mut().zip(u).zip(packed) {
                *regular = self.stiffness_of_one(table, material, u, convex, packed);
            }
            return regular;
        }
        #[cfg(target_arch = "x86_64")]
        if let Some(Wide { proof, four, .. }) = &mut self.wide {
            return proof.run(
                #[inline(always)]
                || stiffness::stiffness(*proof, four, table, material, &u, packed),
            );
        }
        stiffness::stiffness((), &mut self.four, table, material, &u, packed)
    }

    /// [`Self::energy`] of one cell alone.
    pub fn energy_of_one(&mut self, table: &Table, material: &Material, u: &[f64]) -> Option<f64> {
        if !Self::knows(material) {
            return table.energy(material, u);
        }
        #[cfg(target_arch = "x86_64")]
        if let Some(Wide { proof, single, .. }) = &mut self.wide {
            return proof.run(
                #[inline(always)]
                || single::energy(*proof, single, table, material, u),
            );
        }
        single::energy((), &mut self.single, table, material, u)
    }

    /// [`Self::gradient`] of one cell alone.
    pub fn gradient_of_one(
        &mut self,
        table: &Table,
        material: &Material,
        u: &[f64],
        forces: &mut [f64],
    ) -> Option<f64> {
        if !Self::knows(material) {
            return other::gradient_of_one(table, material, u, forces);
        }
        #[cfg(target_arch = "x86_64")]
        if let Some(Wide { proof, single, .. }) = &mut self.wide {
            return proof.run(
                #[inline(always)]
                || single::gradient(*proof, single, table, material, u, forces),
            );
        }
        single::gradient((), &mut self.single, table, material, u, forces)
    }

    /// [`Self::stiffness`] of one cell alone.
    pub fn stiffness_of_one(
        &mut self,
        table: &Table,
        material: &Material,
        u: &[f64],
        convex: bool,
        packed: &mut Vec<f64>,
    ) -> bool {
        if convex || !Self::knows(material) {
            return self.general(table, material, u, convex, packed);
        }
        #[cfg(target_arch = "x86_64")]
        if let Some(Wide { proof, single, .. }) = &mut self.wide {
            return proof.run(
                #[inline(always)]
                || single::stiffness(*proof, single, table, material, u, packed),
            );
        }
        single::stiffness((), &mut self.single, table, material, u, packed)
    }

    /// [`Self::stiffness_of_one`] of any law.
    fn general(&mut self, table: &Table, material: &Material, u: &[f64], convex: bool, packed: &mut Vec<f64>) -> bool {
        let other = &mut self.other;
        #[cfg(target_arch = "x86_64")]
        if let Some(Wide { proof, single, .. }) = &mut self.wide {
            return proof.run(
                #[inline(always)]
                || other::stiffness(*proof, (other, single), table, material, u, convex, packed),
            );
        }
        other::stiffness((), (other, &mut self.single), table, material, u, convex, packed)
    }
}
