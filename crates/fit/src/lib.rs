//! What fits of all kinds share: damped least squares by Gauss, Newton, Levenberg and Marquardt, medians, quantiles, and weights that forget gross errors ([`robust`]).
//!
//! [`least_squares`] iterates; a [`Problem`] says what is fitted. It computes the sum of squares, makes normal equations and
//! solves them, so that matrices of fixed size, sparse ones and those reduced by a Schur complement are all the same here. How
//! steps are held back ([`Damping`]), when they end, and how they ended ([`Outcome`], [`End`]) are values.
//!
//! No number is known here: neither units nor sizes of problems.

mod damping;
mod histogram;
mod iterate;
mod median;
mod problem;
mod quantile;
pub mod robust;

pub use damping::{Damping, Held, Rule};
pub use histogram::Histogram;
pub use iterate::{Limits, least_squares};
pub use median::median;
pub use problem::{End, Made, Outcome, Problem, Step};
pub use quantile::quantile;
