//! Why poses have no common axis.

use crate::coverage::Named;

/// Why a spin calibration was refused. Indices count from 0.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Refused {
    /// Too few poses.
    #[error("{found} poses; at least {needed} are needed, so that residuals say something")]
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
    /// The instrument was turned too little.
    #[error(
        "the poses turn by {found_deg:.1} degrees about {axis}, at least {needed_deg} are needed: spin the instrument \
         further about its shaft"
    )]
    SmallRange {
        /// The axis about which most was done.
        axis: Named,
        /// The range of the turn, degrees.
        found_deg: f64,
        /// The least range, degrees.
        needed_deg: f64,
    },
    /// A few poses were turned far, and nearly all of them little.
    #[error(
        "the poses turn by {range_deg:.1} degrees, but nearly all of them by much less: their spread is that of an even turn \
         of {even_deg:.1}, at least {needed_deg} are needed: spin the instrument further, all of the recording through"
    )]
    Uneven {
        /// The range of the turn, degrees.
        range_deg: f64,
        /// The even turn of the same spread, degrees.
        even_deg: f64,
        /// The least range, degrees.
        needed_deg: f64,
    },
    /// The axis did not keep its direction.
    #[error(
        "the axis wobbles by {found_deg:.2} degrees root mean square, at most {most_deg} are allowed: hold the shaft in a \
         bearing, or keep its direction while it spins"
    )]
    Wobble {
        /// Root mean square angle of the axis to its mean, degrees.
        found_deg: f64,
        /// The largest accepted, degrees.
        most_deg: f64,
    },
    /// The hint does not tell the two directions of the axis apart.
    #[error(
        "the axis {axis:?} lies at {angle_deg:.1} degrees to the direction given, too near to 90 to tell which way it \
         points: give the direction from the handle to the tip"
    )]
    NoSign {
        /// The axis found, of unknown sign.
        axis: [f64; 3],
        /// The angle to the hint, degrees.
        angle_deg: f64,
    },
    /// Too few of the poses agree.
    #[error("{found} of {poses} poses agree on an axis; {needed} are needed: the shaft did not stay in its bearing")]
    NoConsensus {
        /// Poses of weight above zero.
        found: usize,
        /// All poses.
        poses: usize,
        /// The least number.
        needed: usize,
    },
    /// The weights did not come to rest.
    #[error("the weights of the poses did not settle in {steps} steps: two axes fit about equally many poses")]
    NoConvergence {
        /// The steps made.
        steps: usize,
    },
    /// Pivot and spin leave no frame: the tip is not finite, or the axis has no direction.
    #[error("tip and axis do not make a frame")]
    NoFrame,
}
