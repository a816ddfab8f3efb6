//! Which way is right and up on the sight.

use geometry::{Ct, Direction};

use super::refusal::{Input, Refused};

/// The right and the down of the image perpendicular to the tool, in `Ct`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SightAxes {
    /// The direction of growing columns.
    pub right: Direction<Ct>,
    /// The direction of growing rows.
    pub down: Direction<Ct>,
}

/// The largest cosine between two of right, down and axis: an image of another pose, or of a plane that is not perpendicular to the
/// axis, is further off; rounding of axes that went through files is not.
const SKEWED: f64 = 1e-6;

impl SightAxes {
    /// Right and up about `axis`, perpendicular to rounding: right is kept but for its part along the axis.
    pub(super) fn about(&self, axis: Direction<Ct>) -> Result<[Direction<Ct>; 2], Refused> {
        let cosines = [self.right.dot(self.down), self.right.dot(axis), self.down.dot(axis)].map(f64::abs);
        if let Some(found) = cosines.into_iter().find(|c| !c.is_finite()) {
            let what = Input::SightAxes;
            return Err(Refused::NotFinite { what, found });
        }
        let cosine = cosines.into_iter().fold(0.0, f64::max);
        let skewed = Refused::Skewed { cosine };
        if cosine > SKEWED {
            return Err(skewed);
        }
        if self.right.cross(self.down).dot(axis.vector()) <= 0.0 {
            return Err(Refused::Mirrored);
        }
        let across = self.right.vector() + axis * -self.right.dot(axis);
        let right = across.direction().ok_or(skewed)?;
        let up = right.cross(axis).direction().ok_or(skewed)?;
        Ok([right, up])
    }
}
