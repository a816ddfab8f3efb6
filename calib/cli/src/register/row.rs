//! A pair of points.

/// A pair as it was read.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Row {
    /// Lines of the `to` and of the `from` point, counted from 1; the same in one file.
    pub(crate) lines: [usize; 2],
    /// mm.
    pub(crate) to: [f64; 3],
    /// mm.
    pub(crate) from: [f64; 3],
    /// 1 where the file has none.
    pub(crate) weight: f64,
    /// Empty where the file has none.
    pub(crate) label: String,
}
