//! An equilibrium that was found.

use simulation::equilibrium::Equilibrium;

use crate::model::Maker;

/// An equilibrium, and what it took.
#[derive(Debug, Clone)]
pub(super) struct Found {
    pub(super) equilibrium: Equilibrium,
    pub(super) makers: Vec<Maker>,
    /// Exact contact was looked for.
    pub(super) wanted_exact: bool,
    pub(super) iterations: usize,
    pub(super) milliseconds: f64,
}
