//! Candidates of a grid's discs, and who is next to whom.

pub(super) mod blob;
pub(super) mod grazing;
pub(super) mod neighbours;
pub(super) mod region_tree;
pub(super) mod smoothing_passes;
