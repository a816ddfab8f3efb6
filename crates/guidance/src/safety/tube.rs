//! The tube: a solid cylinder with flat ends.

use geometry::{Ct, Direction, Point};

use super::refusal::{Input, TubeError};

/// No length, radius or distance may be beyond this, mm: ten metres.
pub const MAX_LENGTH_MM: f64 = 1e4;
/// No coordinate may be beyond this, mm: a kilometre.
pub const MAX_COORDINATE_MM: f64 = 1e6;
/// The shortest tube, mm: at the largest coordinates its axis is then good to 2e-7 rad.
pub const MIN_LENGTH_MM: f64 = 1e-3;

/// A tube pushed in a straight line, as the solid that it sweeps: all points within `radius` of the axis whose depth is 0 to `length`.
///
/// Depths are counted along the axis from the entry, mm, positive towards the tip.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tube {
    entry: Point<Ct>,
    tip: Point<Ct>,
    radius_mm: f64,
    axis: Direction<Ct>,
    length_mm: f64,
}

impl Tube {
    /// The tube from `entry` to `tip`, mm, whose outer radius is `radius_mm`.
    ///
    /// # Errors
    /// Each variant of [`TubeError`]: coordinates are within [`MAX_COORDINATE_MM`], the radius is above zero and at most
    /// [`MAX_LENGTH_MM`], the length [`MIN_LENGTH_MM`] to [`MAX_LENGTH_MM`].
    pub fn new(entry: Point<Ct>, tip: Point<Ct>, radius_mm: f64) -> Result<Self, TubeError> {
        for (what, place) in [(Input::Entry, entry), (Input::Tip, tip)] {
            for x in place.mm() {
                within(what, x, [-MAX_COORDINATE_MM, MAX_COORDINATE_MM])?;
            }
        }
        if radius_mm == 0.0 {
            let (what, found, allowed) = (Input::Radius, radius_mm, [0.0, MAX_LENGTH_MM]);
            return Err(TubeError::OutOfRange { what, found, allowed });
        }
        within(Input::Radius, radius_mm, [0.0, MAX_LENGTH_MM])?;
        let length_mm = tip.distance(entry);
        let no_axis = TubeError::EntryIsTip {
            distance_mm: length_mm,
            least_mm: MIN_LENGTH_MM,
        };
        if length_mm < MIN_LENGTH_MM {
            return Err(no_axis);
        }
        within(Input::Length, length_mm, [MIN_LENGTH_MM, MAX_LENGTH_MM])?;
        Ok(Self {
            entry,
            tip,
            radius_mm,
            axis: (tip - entry).direction().ok_or(no_axis)?,
            length_mm,
        })
    }

    /// The part between two depths, mm, 0 to the length: for what lies within a map's field where the rest does not.
    ///
    /// # Errors
    /// [`TubeError::OutOfRange`] and [`TubeError::NotFinite`] of a depth, [`TubeError::EntryIsTip`] of a part without length.
    pub fn part(&self, from_mm: f64, to_mm: f64) -> Result<Self, TubeError> {
        within(Input::Part, from_mm, [0.0, self.length_mm])?;
        within(Input::Part, to_mm, [from_mm, self.length_mm])?;
        Self::new(self.at(from_mm), self.at(to_mm), self.radius_mm)
    }

    /// Where the axis begins.
    pub fn entry(&self) -> Point<Ct> {
        self.entry
    }

    /// Where it ends.
    pub fn tip(&self) -> Point<Ct> {
        self.tip
    }

    /// The outer radius, mm.
    pub fn radius_mm(&self) -> f64 {
        self.radius_mm
    }

    /// From entry to tip, mm.
    pub fn length_mm(&self) -> f64 {
        self.length_mm
    }

    /// The direction from entry to tip.
    pub fn axis(&self) -> Direction<Ct> {
        self.axis
    }

    /// The point of the axis at a depth, mm.
    pub fn at(&self, depth_mm: f64) -> Point<Ct> {
        self.entry + self.axis * depth_mm
    }
}

/// A number within both ends of its domain.
pub(super) fn within(what: Input, found: f64, allowed: [f64; 2]) -> Result<(), TubeError> {
    if !found.is_finite() {
        return Err(TubeError::NotFinite { what, found });
    }
    if (allowed[0]..=allowed[1]).contains(&found) {
        return Ok(());
    }
    Err(TubeError::OutOfRange { what, found, allowed })
}
