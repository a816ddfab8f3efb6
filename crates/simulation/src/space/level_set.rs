//! The surface where a smooth field is zero, with its signed distance: bone, and the surfaces of organs.
//!
//! # Why the distance, and not the field over the length of its slope
//!
//! Both are zero on the surface, with the unit normal for a derivative there, so what contact converges to is the same. Away
//! from it the quotient is no use: a smoothed label is flat two voxels off, the quotient has no bound there, and its second
//! derivatives need the field's third, which jump for cubic splines. The distance asks the field on the surface only, where
//! it is steep; its slope is a unit vector everywhere, so no point comes nearer than by its way; and its second
//! derivatives are the surface's curvature carried along the normal, `S (1 + d S)^-1`.
//!
//! # How it is found
//!
//! Boxes that the surface may cut, by the field's own bounds, are halved until they are small; each gives a point of the
//! surface. The nearest of these is where Newton's method begins, which finds the foot of a place to rounding. Where two
//! parts of the surface are nearly as far (farther outside a hollow than it is wide) either may answer.

mod cover;
mod edges;
mod foot;
#[cfg(test)]
mod tests;

use std::sync::Arc;

use nalgebra::Vector3;

use super::cells::Curved;
use super::tree::Tree;
use super::tube::Distance;
use edges::Looked;
pub use edges::{LeftOut, Unproved};

/// Points of the surface are so far apart at most, in radii of the ball that rolls inside.
const SPACING: f64 = 0.5;

/// Why a field has no surface that contact could be with.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum NoSurface {
    /// A radius that is none.
    #[error("the radius is {found} mm; it must be finite and above 0")]
    Radius {
        /// The number found.
        found: f64,
    },
    /// The box has corners that are not finite, or no volume.
    #[error("the box from {low:?} to {high:?} mm has no volume")]
    Box {
        /// Lowest corner.
        low: [f64; 3],
        /// Highest corner.
        high: [f64; 3],
    },
    /// Too many boxes.
    #[error("the surface has more than {most} parts of {side:.3} mm in the box: take a smaller box or a larger radius")]
    TooMany {
        /// Diagonal of a part, mm.
        side: f64,
        /// The most.
        most: usize,
    },
    /// The field does not change its sign in the box.
    #[error("the field has no surface in the box")]
    Empty,
    /// Thinner, or sharper, than the ball.
    #[error(
        "at {at:?} mm a ball of radius {radius} mm does not fit behind the surface: it is thinner or sharper there"
    )]
    Thin {
        /// A point of the surface.
        at: [f64; 3],
        /// The ball's radius, mm.
        radius: f64,
    },
}

/// The surface where a field is zero, closed or not, with what is behind it where the field is negative.
#[derive(Debug, Clone)]
pub struct LevelSet {
    field: Arc<dyn Curved>,
    /// Corners of the box asked for.
    corners: [Vector3<f64>; 2],
    radius: f64,
    /// Points of the surface.
    feet: Arc<Tree>,
    /// No point of the surface is farther from all of them.
    cover: f64,
    /// Where it was looked for, and what of it is not proved; `None`: in the box, and all of it is.
    looked: Option<Arc<Looked>>,
}

impl LevelSet {
    /// The surface of a field in a box. A ball of `radius`, mm, must fit behind every point of it that is looked at
    /// (half of that apart): it says how deep a point may come and still be led out where it came in. Beyond the box the
    /// surface is known as far as it goes on smoothly.
    ///
    /// # Errors
    /// Every variant of [`NoSurface`].
    pub fn new(field: Arc<dyn Curved>, corners: [Vector3<f64>; 2], radius: f64) -> Result<Self, NoSurface> {
        if !(radius.is_finite() && radius > 0.0) {
            return Err(NoSurface::Radius { found: radius });
        }
        let [low, high] = corners;
        if !(high - low).iter().all(|x| x.is_finite() && *x > 0.0) {
            let [low, high] = corners.map(Into::into);
            return Err(NoSurface::Box { low, high });
        }
        // The feet of all places in the box that are nearer than the radius are in the grown one.
        let grown = [low.add_scalar(-radius), high.add_scalar(radius)];
        let (parts, cover) = cover::parts(field.as_ref(), grown, SPACING * radius, &|_, _| true)?;
        let set = Self {
            feet: Arc::new(Tree::new(parts.iter().map(|part| part.foot).collect())),
            cover,
            field,
            corners,
            radius,
            looked: None,
        };
        let thin = parts.iter().find(|part| !set.holds_ball(&part.foot));
        thin.map_or(Ok(set.clone()), |part| {
            let at = part.foot.into();
            Err(NoSurface::Thin { at, radius })
        })
    }

    /// The radius of the ball that fits behind the surface, mm.
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// The field.
    pub fn field(&self) -> &dyn Curved {
        self.field.as_ref()
    }

    /// Signed distance of a place from the surface, above zero outside, with two derivatives. Where the nearest point of the surface is
    /// found, exact to rounding; a place that is not finite gives NaN.
    pub fn signed_distance(&self, x: &Vector3<f64>) -> Distance {
        let (start, _) = self.feet.nearest(x);
        foot::signed_distance(self.field.as_ref(), x, &start, self.cover)
    }

    /// A lower bound of the signed distance that costs less; below all numbers where none is known.
    pub fn clearance(&self, x: &Vector3<f64>) -> f64 {
        let [low, high] = &self.corners;
        let within = (0..3).all(|k| x[k] >= low[k] && x[k] <= high[k]);
        // Nothing more than the radius is ever told.
        let clear = self.feet.apart_within(x, self.radius + self.cover) - self.cover;
        if within && clear > 0.0 && self.field.value(x) > 0.0 {
            // Beyond the grown box may be more of the surface.
            clear.min(self.radius)
        } else {
            f64::NEG_INFINITY
        }
    }

    /// Whether the ball fits behind a point of the surface.
    fn holds_ball(&self, foot: &Vector3<f64>) -> bool {
        let centre = foot - foot::unit(&self.field.slope(foot)) * self.radius;
        let (_, apart) = self.feet.nearest(&centre);
        // A ball of that very radius touches everywhere.
        apart >= self.radius * (1.0 - 1e-6) && self.field.value(&centre) < 0.0
    }
}
