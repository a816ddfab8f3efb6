//! A plate that is not flat: its height over the plane of the grid, the same in every view.
//!
//! With `(u, w)` the place from the middle of all discs in units of half the grid's longer side
//!
//! ```text
//! z = b1 u^2 + b2 u w + b3 w^2, mm                                                                              (9)
//! ```
//!
//! A plane is no part of it, as the pose has one. Sheet that was rolled, pressed or is held at its ends bends so; anything
//! finer takes more views than hold a camera.

use nalgebra::{Matrix3, Vector2};

use super::view::View;

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
    middle: Vector2<f64>,
    half: f64,
}

impl Ruler {
    /// Of views that were checked: finite places, not all of them the same.
    pub(super) fn of(views: &[View]) -> Self {
        let places = || views.iter().flat_map(|v| &v.sightings).map(|s| s.at_mm);
        let least = places().reduce(|a, b| a.inf(&b)).unwrap_or_default();
        let most = places().reduce(|a, b| a.sup(&b)).unwrap_or_default();
        Self {
            middle: (least + most) / 2.0,
            half: ((most - least).max() / 2.0).max(f64::MIN_POSITIVE),
        }
    }

    /// `u^2`, `u w`, `w^2` of a place.
    pub(super) fn bow(&self, at_mm: Vector2<f64>) -> [f64; Bend::NUMBERS] {
        let p = (at_mm - self.middle) / self.half;
        [p.x * p.x, p.x * p.y, p.y * p.y]
    }
}

/// How far the grid's plate is from flat.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plate {
    ruler: Ruler,
    bend: Bend,
    /// Covariance of the numbers of (9), square millimetres.
    pub covariance: Matrix3<f64>,
}

impl Plate {
    pub(super) fn new(views: &[View], bend: Bend, covariance: Matrix3<f64>) -> Self {
        Self {
            ruler: Ruler::of(views),
            bend,
            covariance,
        }
    }

    /// The numbers of (9): of u^2, u w and w^2, mm.
    pub fn numbers_mm(&self) -> [f64; 3] {
        self.bend.0
    }

    /// The origin of (9), on the grid, mm, and its unit, half the longer side, mm.
    pub fn ruler_mm(&self) -> (Vector2<f64>, f64) {
        (self.ruler.middle, self.ruler.half)
    }

    /// The height over the grid's plane at a place of the grid, mm, along the grid's third axis.
    pub fn height_mm(&self, at_mm: Vector2<f64>) -> f64 {
        self.bend.height(&self.ruler.bow(at_mm))
    }
}
