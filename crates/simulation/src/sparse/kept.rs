//! A factor's entries in one piece.

/// The columns of all fronts, and the pivots.
#[derive(Debug, Clone, Default)]
pub(super) struct Kept<T> {
    pub(super) entries: Vec<T>,
    /// Where each front begins, and the last one ends.
    pub(super) starts: Vec<usize>,
    /// Without a pivot that was found last: 0.
    pub(super) pivots: Vec<f64>,
}
