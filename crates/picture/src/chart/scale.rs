//! How numbers become lengths.

/// The largest number that is drawn: differences of two stay finite.
const LARGEST: f64 = 1e300;

/// How numbers become lengths.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scale {
    /// Equal differences are equally far apart.
    Linear,
    /// Equal ratios are; only numbers above zero have a place.
    Log,
}

impl Scale {
    /// Whether a number has a place.
    pub(crate) fn places(self, x: f64) -> bool {
        x.abs() <= LARGEST && (self == Self::Linear || x > 0.0)
    }

    pub(crate) fn place(self, x: f64) -> f64 {
        match self {
            Self::Linear => x,
            Self::Log => x.log10(),
        }
    }
}
