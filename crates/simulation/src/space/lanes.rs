//! Four cells of one [`Table`] at once, neo-Hookean: energy, forces and stiffness in lanes of four numbers.
//!
//! Each lane does what one cell alone would do, in the same order, and no product is fused with a sum. So the bits of a
//! cell depend neither on the processor (AVX2 or not) nor on the three cells beside it: [`Lanes::one`] gives them too. They
//! differ from those of [`Table::gradient`] and [`Table::stiffness`] by rounding.
//!
//! The stiffness is not contracted from a tangent of 9 x 9: with `a_n = (cof F) Q_n` and the pressure `p`,
//! `K_(ni)(mk) = w (mu Q_n . Q_m d_ik + (mu - p) / J^2 a_nk a_mi)`, and what the pressures couple. That follows from
//! `F (Q_n x Q_m) = (a_n x a_m) / J`; the first term is the same for all cells of the table.

#[cfg(target_arch = "x86_64")]
mod avx2;
mod forces;
mod lane;
mod points;
mod stiffness;

#[cfg(test)]
mod tests;

use lane::Lane;
use points::Work;

use super::element::Table;
use super::law::Material;
use crate::law::Law;

/// How many cells are done at once.
pub const CELLS: usize = 4;

/// Memory for four cells, kept from call to call.
#[derive(Debug, Clone, Default)]
pub struct Lanes {
    #[cfg(target_arch = "x86_64")]
    vector: Option<avx2::Vector>,
    #[cfg(target_arch = "x86_64")]
    wide: Option<Work<avx2::Wide>>,
    portable: Work<[f64; CELLS]>,
    single: Work<f64>,
}

impl Lanes {
    /// With AVX2 where this processor has it.
    pub fn new() -> Self {
        Self {
            #[cfg(target_arch = "x86_64")]
            vector: avx2::Vector::detect(),
            ..Self::portable()
        }
    }

    /// Without AVX2: the same bits, slower.
    pub fn portable() -> Self {
        Self::default()
    }

    /// Whether AVX2 is used.
    pub fn is_wide(&self) -> bool {
        #[cfg(target_arch = "x86_64")]
        return self.vector.is_some();
        #[cfg(not(target_arch = "x86_64"))]
        return false;
    }

    /// Whether a material is done in lanes: neo-Hookean, without fibres. Others are to be given to [`Table`].
    pub fn knows(material: &Material) -> bool {
        material.law == Law::NeoHookean && material.fibre.is_none()
    }

    /// The elastic energies of four cells of these displacements ([`Table`]'s `u`). `None` for a cell where the law has none.
    /// The material is taken as neo-Hookean.
    pub fn energy(&mut self, table: &Table, material: &Material, u: [&[f64]; CELLS]) -> [Option<f64>; CELLS] {
        #[cfg(target_arch = "x86_64")]
        if let Some(vector) = self.vector {
            return vector.energy(&mut self.wide, table, material, u);
        }
        forces::energy((), &mut self.portable, table, material, &u)
    }

    /// The same, and their derivatives added to `forces`, of cells with an energy.
    pub fn gradient(
        &mut self,
        table: &Table,
        material: &Material,
        u: [&[f64]; CELLS],
        forces: [&mut [f64]; CELLS],
    ) -> [Option<f64>; CELLS] {
        #[cfg(target_arch = "x86_64")]
        if let Some(vector) = self.vector {
            return vector.gradient(&mut self.wide, table, material, u, forces);
        }
        forces::gradient((), &mut self.portable, table, material, &u, forces)
    }

    /// The second derivatives, packed as by [`Table::stiffness`], not made convex. False for a cell where the law has no
    /// energy: its numbers are not to be used.
    pub fn stiffness(
        &mut self,
        table: &Table,
        material: &Material,
        u: [&[f64]; CELLS],
        packed: &mut [Vec<f64>; CELLS],
    ) -> [bool; CELLS] {
        #[cfg(target_arch = "x86_64")]
        if let Some(vector) = self.vector {
            return vector.stiffness(&mut self.wide, table, material, u, packed);
        }
        stiffness::stiffness((), &mut self.portable, table, material, &u, packed)
    }

    /// One cell alone, to the bits that it has among four.
    pub fn one<'a>(&'a mut self, table: &'a Table, material: &'a Material, u: &'a [f64]) -> One<'a> {
        One {
            work: &mut self.single,
            table,
            material,
            u,
        }
    }
}

/// One cell alone.
#[derive(Debug)]
pub struct One<'a> {
    work: &'a mut Work<f64>,
    table: &'a Table,
    material: &'a Material,
    u: &'a [f64],
}

impl One<'_> {
    /// Its elastic energy. `None` where the law has none.
    pub fn energy(&mut self) -> Option<f64> {
        let [energy, ..] = forces::energy((), self.work, self.table, self.material, &[self.u]);
        energy
    }

    /// The same, and its derivatives added to `forces`.
    pub fn gradient(&mut self, forces: &mut [f64]) -> Option<f64> {
        let [energy, ..] = forces::gradient((), self.work, self.table, self.material, &[self.u], [forces]);
        energy
    }

    /// The second derivative, packed as by [`Table::stiffness`]; false where the law has no energy.
    pub fn stiffness(&mut self, packed: &mut Vec<f64>) -> bool {
        let packed = std::slice::from_mut(packed);
        let [regular, ..] = stiffness::stiffness((), self.work, self.table, self.material, &[self.u], packed);
        regular
    }
}
