//! The parts of a base that are touched.

use std::fmt;

/// What a touch lies on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Feature {
    /// The plate's upper face.
    Plane,
    /// A groove, 0 to 2.
    Groove(usize),
}

impl Feature {
    /// The plane, then the grooves.
    pub const ALL: [Self; 4] = [Self::Plane, Self::Groove(0), Self::Groove(1), Self::Groove(2)];

    /// The place in [`Feature::ALL`].
    pub(super) const fn index(self) -> usize {
        match self {
            Self::Plane => 0,
            Self::Groove(k) => k + 1,
        }
    }

    /// The fewest touches that make the feature a plane or a line.
    pub(super) const fn needed(self) -> usize {
        match self {
            Self::Plane => 3,
            Self::Groove(_) => 2,
        }
    }
}

impl fmt::Display for Feature {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Plane => write!(f, "plane"),
            Self::Groove(k) => write!(f, "groove {k}"),
        }
    }
}

/// A feature off which its touches lie as a whole.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OneSide {
    /// Which.
    pub feature: Feature,
    /// Its touches that were kept.
    pub touches: usize,
    /// How far their mean lies off it, mm.
    pub off_mm: f64,
}
