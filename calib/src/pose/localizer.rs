//! The noise of a localizer at a place.

use geometry::{Point, Tracker};
use nalgebra::{Matrix3, Vector3};

/// How a localizer errs: normal noise, with one deviation across the line of sight and another along it, both of which
/// grow with the distance; and the rounding of what it tells, which does not.
///
/// At `d` mm from `eye`: `sigma = sigma(at_mm) (d / at_mm)^growth`; cameras that triangulate have growth 1 across and
/// up to 2 along.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Localizer {
    /// Where it looks from.
    pub eye: Point<Tracker>,
    /// Standard deviation along each of the two directions across the line of sight, mm.
    pub across_mm: f64,
    /// Along the line of sight, mm.
    pub depth_mm: f64,
    /// The distance for which these hold, mm.
    pub at_mm: f64,
    /// How the deviation across grows with the distance.
    pub growth_across: f64,
    /// How the one along grows.
    pub growth_depth: f64,
    /// Coordinates are rounded to multiples of this, mm; 0: they are not. A step q deviates by q / sqrt(12), alike in every
    /// direction and at every distance, and as if drawn anew for each emitter and frame: for a marker at rest whose noise is far
    /// below a step the errors of following frames are the same, and their mean is no better than one of them.
    pub step_mm: f64,
}

/// The largest step, mm: no emitter is told from its neighbours with coarser ones.
const MOST_STEP_MM: f64 = 100.0;

/// Why numbers are not a localizer's.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum LocalizerError {
    /// A number is not finite, or not above zero where it must be.
    #[error("localizer: {what} is {found}, a finite number {allowed} is needed")]
    Number {
        /// Which.
        what: &'static str,
        /// The number found.
        found: f64,
        /// What is allowed.
        allowed: &'static str,
    },
}

impl Localizer {
    /// The same noise in every direction and at every distance.
    pub fn isotropic(sigma_mm: f64) -> Self {
        Self {
            eye: Point::new(0.0, 0.0, 0.0),
            across_mm: sigma_mm,
            depth_mm: sigma_mm,
            at_mm: 1000.0,
            growth_across: 0.0,
            growth_depth: 0.0,
            step_mm: 0.0,
        }
    }

    /// These numbers, if they are usable.
    ///
    /// # Errors
    /// [`LocalizerError::Number`].
    pub fn checked(self) -> Result<Self, LocalizerError> {
        let above = [
            ("across_mm", self.across_mm),
            ("depth_mm", self.depth_mm),
            ("at_mm", self.at_mm),
        ];
        let number = |what, found, allowed| Err(LocalizerError::Number { what, found, allowed });
        for (what, found) in above {
            if !(found.is_finite() && found > 0.0) {
                return number(what, found, "above zero");
            }
        }
        if let Some(found) = self.eye.mm().into_iter().find(|x| !x.is_finite()) {
            return number("eye", found, "a finite place");
        }
        // A NaN is in no range.
        if !(0.0..=MOST_STEP_MM).contains(&self.step_mm) {
            return number("step_mm", self.step_mm, "from 0 to 100");
        }
        for (what, found) in [
            ("growth_across", self.growth_across),
            ("growth_depth", self.growth_depth),
        ] {
            if !(0.0..=4.0).contains(&found) {
                return number(what, found, "from 0 to 4");
            }
        }
        Ok(self)
    }

    /// Standard deviations of the noise at `p`, without the rounding: across the line of sight and along it, mm.
    pub fn deviations_mm(&self, p: Point<Tracker>) -> [f64; 2] {
        let share = self.eye.distance(p) / self.at_mm;
        // The noise of cameras that triangulate grows with powers 1 and 2; a general power costs more than these.
        let grown = |growth: f64| match growth {
            0.0 => 1.0,
            1.0 => share,
            2.0 => share * share,
            _ => share.powf(growth),
        };
        [
            self.across_mm * grown(self.growth_across),
            self.depth_mm * grown(self.growth_depth),
        ]
    }

    /// Covariance of a point seen at `p`, mm^2: `(a^2 + q^2 / 12) I + (d^2 - a^2) u u^T` with the line of sight `u` and the step q.
    pub fn covariance_mm2(&self, p: Point<Tracker>) -> Matrix3<f64> {
        let [across, depth] = self.deviations_mm(p).map(|s| s * s);
        let way = Vector3::from(p.mm()) - Vector3::from(self.eye.mm());
        let even = Matrix3::identity() * (across + self.step_mm * self.step_mm / 12.0);
        // At the eye itself there is no line of sight.
        match way.try_normalize(0.0) {
            Some(u) if across != depth => even + u * u.transpose() * (depth - across),
            _ => even,
        }
    }
}
