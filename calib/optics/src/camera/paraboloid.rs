//! A plate that is not flat: its height over the plane of the grid, the same in every view.
//!
//! With `(u, w)` the place from the middle of all discs in units of half the grid's longer side
//!
//! ```text
//! z = b1 u^2 + b2 u w + b3 w^2, mm                                                                              (9)
//! ```
//!
//! A plane is no part of it, as the pose has one. Sheet that was rolled, pressed or is held at its ends bends so; what is
//! finer is the field's ([`super::plate_field`]).

use nalgebra::Vector2;

use super::model::PARAMETERS;

/// The numbers that all views share: the camera's, then the plate's.
pub(super) const SHARED: usize = PARAMETERS + Bend::NUMBERS;

/// The numbers of (9), mm.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Bend(pub(super) [f64; Self::NUMBERS]);

impl Bend {
    /// How many.
    pub(super) const NUMBERS: usize = 3;

    /// The height where the powers of the place are `bow`, mm.
    pub(super) fn height(&self, bow: &[f64; Self::NUMBERS]) -> f64 {
        self.0.iter().zip(bow).map(|(b, power)| b * power).sum()
    }
}

/// What (9) measures places in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Ruler {
    /// The origin, mm.
    pub(super) middle: Vector2<f64>,
    /// The unit, mm.
    pub(super) half: f64,
}

impl Ruler {
    /// Of places that were checked: finite, not all of them the same.
    pub(super) fn of(places: impl Iterator<Item = Vector2<f64>> + Clone) -> Self {
        let least = places.clone().reduce(|a, b| a.inf(&b)).unwrap_or_default();
        let most = places.reduce(|a, b| a.sup(&b)).unwrap_or_default();
        Self {
            middle: (least + most) / 2.0,
            half: ((most - least).max() / 2.0).max(f64::MIN_POSITIVE),
        }
    }

    /// `(u, w)` of a place.
    pub(super) fn place(&self, at_mm: Vector2<f64>) -> Vector2<f64> {
        (at_mm - self.middle) / self.half
    }

    /// `u^2`, `u w`, `w^2` of a place.
    pub(super) fn bow(&self, at_mm: Vector2<f64>) -> [f64; Bend::NUMBERS] {
        let p = self.place(at_mm);
        [p.x * p.x, p.x * p.y, p.y * p.y]
    }
}
