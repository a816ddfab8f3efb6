//! Numbers that are added and multiplied lane by lane.

use std::ops::{Add, Div, Mul, Sub};

use super::CELLS;

/// Four numbers: one of each of four cells or points, or the three of a vector and one that does not count.
pub(super) trait Lane: Copy + std::fmt::Debug {
    /// What it takes to make one.
    type Proof: Copy;

    /// The same number for all.
    fn splat(proof: Self::Proof, value: f64) -> Self;
    /// These numbers.
    fn of(proof: Self::Proof, lanes: [f64; CELLS]) -> Self;
    /// Its numbers.
    fn lanes(self) -> [f64; CELLS];
    fn plus(self, other: Self) -> Self;
    fn minus(self, other: Self) -> Self;
    fn times(self, other: Self) -> Self;
    fn over(self, other: Self) -> Self;
}

#[inline(always)]
fn each(a: [f64; CELLS], b: [f64; CELLS], of: impl Fn(f64, f64) -> f64) -> [f64; CELLS] {
    [of(a[0], b[0]), of(a[1], b[1]), of(a[2], b[2]), of(a[3], b[3])]
}

impl Lane for [f64; CELLS] {
    type Proof = ();

    #[inline(always)]
    fn splat((): (), value: f64) -> Self {
        [value; CELLS]
    }
    #[inline(always)]
    fn of((): (), lanes: [f64; CELLS]) -> Self {
        lanes
    }
    #[inline(always)]
    fn lanes(self) -> [f64; CELLS] {
        self
    }
    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        each(self, other, Add::add)
    }
    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        each(self, other, Sub::sub)
    }
    #[inline(always)]
    fn times(self, other: Self) -> Self {
        each(self, other, Mul::mul)
    }
    #[inline(always)]
    fn over(self, other: Self) -> Self {
        each(self, other, Div::div)
    }
}
