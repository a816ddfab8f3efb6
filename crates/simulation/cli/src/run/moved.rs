//! How far walls and instruments went.

/// How far something went in a frame.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Moved {
    /// Its name.
    pub(crate) name: String,
    /// What was asked for, a length or the larger of a translation and an angle in radians.
    pub(crate) asked: f64,
    /// The part of it that was gone, 0 to 1.
    pub(crate) part: f64,
    /// Into how many parts contact broke it.
    pub(crate) parts: usize,
}

impl Moved {
    pub(crate) fn limited(&self) -> bool {
        self.part < 1.0
    }

    pub(crate) fn words(&self) -> String {
        format!(
            "{:?} went {:.1} % of its way in {} parts: contact stops it",
            self.name,
            100.0 * self.part,
            self.parts
        )
    }
}
