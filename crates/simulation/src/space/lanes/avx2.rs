//! Four lanes in a register of AVX2. The only file of this crate with unsafe code.
//!
//! Each operation is that of the portable lanes; nothing reads or writes memory by address.
#![allow(
    unsafe_code,
    reason = "vector instructions that not every processor has; a proof of AVX2 is asked for where a number is made"
)]

use std::arch::x86_64::{
    __m256d, _mm256_add_pd, _mm256_div_pd, _mm256_mul_pd, _mm256_set1_pd, _mm256_setr_pd, _mm256_sub_pd,
};

use super::points::Work;
use super::{CELLS, Lane, Material, Table, forces, stiffness};

/// Proof that this processor has AVX2.
#[derive(Debug, Clone, Copy)]
pub(super) struct Vector(());

/// Four numbers. Made with a [`Vector`], or from others: where there is one, there is AVX2.
#[derive(Debug, Clone, Copy)]
pub(super) struct Wide(__m256d);

impl Vector {
    pub(super) fn detect() -> Option<Self> {
        std::arch::is_x86_feature_detected!("avx2").then_some(Self(()))
    }

    pub(super) fn energy(
        self,
        work: &mut Option<Work<Wide>>,
        table: &Table,
        material: &Material,
        u: [&[f64]; CELLS],
    ) -> [Option<f64>; CELLS] {
        let work = work.get_or_insert_with(|| Work::new(self));
        // SAFETY: the proof says that this processor has AVX2.
        unsafe { energy(self, work, table, material, &u) }
    }

    pub(super) fn gradient(
        self,
        work: &mut Option<Work<Wide>>,
        table: &Table,
        material: &Material,
        u: [&[f64]; CELLS],
        forces: [&mut [f64]; CELLS],
    ) -> [Option<f64>; CELLS] {
        let work = work.get_or_insert_with(|| Work::new(self));
        // SAFETY: the proof says that this processor has AVX2.
        unsafe { gradient(self, work, table, material, &u, forces) }
    }

    pub(super) fn stiffness(
        self,
        work: &mut Option<Work<Wide>>,
        table: &Table,
        material: &Material,
        u: [&[f64]; CELLS],
        packed: &mut [Vec<f64>; CELLS],
    ) -> [bool; CELLS] {
        let work = work.get_or_insert_with(|| Work::new(self));
        // SAFETY: the proof says that this processor has AVX2.
        unsafe { stiffness_of(self, work, table, material, &u, packed) }
    }
}

#[target_feature(enable = "avx2")]
fn energy(
    proof: Vector,
    work: &mut Work<Wide>,
    table: &Table,
    material: &Material,
    u: &[&[f64]; CELLS],
) -> [Option<f64>; CELLS] {
    forces::energy(proof, work, table, material, u)
}

#[target_feature(enable = "avx2")]
fn gradient(
    proof: Vector,
    work: &mut Work<Wide>,
    table: &Table,
    material: &Material,
    u: &[&[f64]; CELLS],
    forces: [&mut [f64]; CELLS],
) -> [Option<f64>; CELLS] {
    forces::gradient(proof, work, table, material, u, forces)
}

#[target_feature(enable = "avx2")]
fn stiffness_of(
    proof: Vector,
    work: &mut Work<Wide>,
    table: &Table,
    material: &Material,
    u: &[&[f64]; CELLS],
    packed: &mut [Vec<f64>; CELLS],
) -> [bool; CELLS] {
    stiffness::stiffness(proof, work, table, material, u, packed)
}

impl Lane for Wide {
    type Proof = Vector;
    const COUNT: usize = CELLS;

    #[inline(always)]
    fn splat(_: Vector, value: f64) -> Self {
        // SAFETY: the proof says that this processor has AVX2.
        Self(unsafe { _mm256_set1_pd(value) })
    }
    #[inline(always)]
    fn of(_: Vector, [a, b, c, d]: [f64; CELLS]) -> Self {
        // SAFETY: the proof says that this processor has AVX2.
        Self(unsafe { _mm256_setr_pd(a, b, c, d) })
    }
    #[inline(always)]
    fn lanes(self) -> [f64; CELLS] {
        // SAFETY: both are 32 bytes of four numbers, and every pattern of bits is a number.
        unsafe { std::mem::transmute::<__m256d, [f64; CELLS]>(self.0) }
    }
    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        // SAFETY: a `Wide` was made with a proof that this processor has AVX2.
        Self(unsafe { _mm256_add_pd(self.0, other.0) })
    }
    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        // SAFETY: a `Wide` was made with a proof that this processor has AVX2.
        Self(unsafe { _mm256_sub_pd(self.0, other.0) })
    }
    #[inline(always)]
    fn times(self, other: Self) -> Self {
        // SAFETY: a `Wide` was made with a proof that this processor has AVX2.
        Self(unsafe { _mm256_mul_pd(self.0, other.0) })
    }
    #[inline(always)]
    fn over(self, other: Self) -> Self {
        // SAFETY: a `Wide` was made with a proof that this processor has AVX2.
        Self(unsafe { _mm256_div_pd(self.0, other.0) })
    }
}
