//! Control: the search for a local minimum of the energy (II 3.4). Knows vectors and sparse matrices only.

mod evaluation;
mod factors;
mod line_search;
mod newton;
mod potential;
mod report;
mod rounding;
mod settings;

pub use newton::Newton;
pub use potential::Potential;
pub use report::{Failed, Minimum, Stability};
pub use settings::Settings;
