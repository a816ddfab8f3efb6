//! Control: the search for a local minimum of the energy (II 3.4). Knows vectors and sparse matrices only.

mod newton;
mod potential;
mod report;
mod rounding;
mod search;

pub use newton::{Newton, Settings};
pub use potential::Potential;
pub use report::{Failed, Minimum, Stability};
