//! A pair of points.

use crate::input_files::points_text::StatedError;

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
    /// What a touch states of the error of `from`, where the file has it.
    pub(crate) error: Option<StatedError>,
}
