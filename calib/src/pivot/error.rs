//! Why poses have no pivot.

use crate::coverage::Named;

/// Why a pivot calibration was refused. Indices count from 0, angles are half openings as in
/// [`Coverage`](crate::coverage::Coverage).
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Refused {
    /// Too few poses.
    #[error("{found} poses; at least {needed} are needed: two leave the tip free along the one axis that joins them")]
    TooFew {
        /// How many came.
        found: usize,
        /// The least number.
        needed: usize,
    },
    /// A translation is NaN or infinite.
    #[error("pose {pose}: the translation {found:?} mm holds a number that is not finite")]
    NotFinite {
        /// The first such pose.
        pose: usize,
        /// The translation found, mm.
        found: [f64; 3],
    },
    /// The noise is no noise.
    #[error(
        "the noise of a pose, {sigma_mm} mm and {sigma_rad} rad, must be finite, the first above 0 and the second at least 0"
    )]
    BadNoise {
        /// Of the translation, mm.
        sigma_mm: f64,
        /// Of the rotation, rad.
        sigma_rad: f64,
    },
    /// The covariance of a pose cannot weigh it.
    #[error(
        "pose {pose}: its covariance leaves the marker's place without noise in some direction, so that it cannot be weighed"
    )]
    BadCovariance {
        /// The first such pose.
        pose: usize,
    },
    /// The marker was moved without being turned.
    #[error(
        "the poses hold no rotation (principal angles {:.2}, {:.2} and {:.2} degrees): keep the tip in place and turn \
         the instrument about it", angles_deg[0], angles_deg[1], angles_deg[2]
    )]
    NoRotation {
        /// Principal angles, degrees.
        angles_deg: [f64; 3],
    },
    /// The marker was turned about one axis only.
    #[error(
        "the poses turn about one axis only, {}, by {:.1} degrees, and by {:.2} about any other: the tip is \
         undetermined along it; rotate about another axis, such as {}",
        axis, angles_deg[0], angles_deg[1], missing
    )]
    OneAxis {
        /// The one axis, along which the tip is not known.
        axis: Named,
        /// The next principal axis.
        missing: Named,
        /// Principal angles, degrees.
        angles_deg: [f64; 3],
    },
    /// The cone is too narrow.
    #[error(
        "the poses fill a cone of {:.2} degrees only, at least {least_deg} are needed: rotate more about {}",
        angles_deg[1], missing
    )]
    NarrowCone {
        /// The axis about which least was done that counts.
        missing: Named,
        /// Principal angles, degrees.
        angles_deg: [f64; 3],
        /// The least half opening, degrees.
        least_deg: f64,
    },
    /// The cone is hardly more than the noise of the rotations.
    #[error(
        "the poses fill a cone of {:.2} degrees, of which noise of the rotations of {noise_deg:.2} degrees may be the most: at least \
         {least_deg:.1} are needed with so much noise; rotate more about {}",
        angles_deg[1], missing
    )]
    Noise {
        /// The axis about which least was done that counts.
        missing: Named,
        /// Principal angles, degrees.
        angles_deg: [f64; 3],
        /// The noise of the rotations that the residuals show, a standard deviation about each axis, degrees.
        noise_deg: f64,
        /// The least half opening, degrees.
        least_deg: f64,
    },
    /// Too few of the poses agree.
    #[error("{found} of {poses} poses agree on a pivot; {needed} are needed: the tip did not stay in place")]
    NoConsensus {
        /// Poses of weight above zero.
        found: usize,
        /// All poses.
        poses: usize,
        /// The least number.
        needed: usize,
    },
    /// The matrix of a method is singular though the motion is not.
    #[error("the equations of the {method} method are singular on these poses: turn further, and about more axes")]
    MethodFails {
        /// Its name.
        method: &'static str,
    },
    /// An iteration did not settle.
    #[error("no convergence after {steps} steps (last step {last_mm:e} mm)")]
    NoConvergence {
        /// The steps made.
        steps: usize,
        /// Length of the last step, mm.
        last_mm: f64,
    },
}
