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

use super::{CELLS, Lane};

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

    /// Runs `work` compiled for AVX2.
    #[inline(always)]
    pub(super) fn run<R>(self, work: impl FnOnce() -> R) -> R {
        // SAFETY: the proof says that this processor has AVX2.
        unsafe { run(work) }
    }
}

/// Compiles what it is given for AVX2.
#[target_feature(enable = "avx2")]
fn run<R>(work: impl FnOnce() -> R) -> R {
    work()
}

impl Lane for Wide {
    type Proof = Vector;

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
