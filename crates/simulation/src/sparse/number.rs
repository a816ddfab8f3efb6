//! The numbers that an elimination computes with.

use std::fmt::Debug;
use std::iter::Sum;
use std::ops::{AddAssign, Div, DivAssign, Mul, Sub, SubAssign};

use nalgebra::{DMatrixView, DMatrixViewMut, Dyn};

/// A matrix column by column, its columns so many numbers apart.
type View<'a, T> = DMatrixView<'a, T, Dyn, Dyn>;
type ViewMut<'a, T> = DMatrixViewMut<'a, T, Dyn, Dyn>;

/// Double or single precision.
pub(super) trait Number:
    Copy
    + Default
    + Debug
    + PartialEq
    + Send
    + Sync
    + AddAssign
    + SubAssign
    + DivAssign
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Sum
    + 'static
{
    /// A pivot below this part of the diagonal entry that it comes from counts as zero: what is left is rounding.
    const ZERO_PIVOT: f64;

    fn rounded(value: f64) -> Self;
    fn value(self) -> f64;
    /// `c -= a b`, by the library's product, which uses the widest registers that the processor has.
    fn subtract_product(c: ViewMut<'_, Self>, a: &View<'_, Self>, b: &View<'_, Self>);
}

impl Number for f64 {
    // Some 45 times 2^-52: what cancellation of a diagonal entry may leave.
    const ZERO_PIVOT: f64 = 1e-14;

    #[inline]
    fn rounded(value: f64) -> Self {
        value
    }

    #[inline]
    fn value(self) -> f64 {
        self
    }

    fn subtract_product(mut c: ViewMut<'_, Self>, a: &View<'_, Self>, b: &View<'_, Self>) {
        c.gemm(-1.0, a, b, 1.0);
    }
}

impl Number for f32 {
    // As many roundings: 45 times 2^-23.
    const ZERO_PIVOT: f64 = 5e-6;

    #[inline]
    fn rounded(value: f64) -> Self {
        value as f32
    }

    #[inline]
    fn value(self) -> f64 {
        f64::from(self)
    }

    fn subtract_product(mut c: ViewMut<'_, Self>, a: &View<'_, Self>, b: &View<'_, Self>) {
        c.gemm(-1.0, a, b, 1.0);
    }
}
