//! What is seen of a body, what is asked of its pose, and what comes of it.

use geometry::{Frame, Point, Tracker, Uncertain};

/// Most emitters of one body.
pub const MAX_EMITTERS: usize = 32;

/// One emitter as seen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sighting {
    /// Which of the body's emitters, from 0.
    pub emitter: usize,
    /// Where the localizer saw it.
    pub place: Point<Tracker>,
}

/// When a pose is not given.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gates {
    /// Fewest emitters that a pose may rest on; 3 are needed, 4 check each other.
    pub min_emitters: usize,
    /// Largest root mean square residual of the emitters kept, mm.
    pub max_fre_mm: f64,
    /// An emitter whose residual is this many of its own deviations off is left out, the worst first.
    pub outlier_sigmas: f64,
    /// Largest predicted error at the tip, 95 %, mm: refuses emitters too close together for a tip so far away.
    pub max_tip_mm: f64,
}

impl Default for Gates {
    fn default() -> Self {
        Self {
            min_emitters: 4,
            max_fre_mm: 1.0,
            outlier_sigmas: 5.0,
            max_tip_mm: 5.0,
        }
    }
}

/// Where the body is.
#[derive(Debug, Clone, Copy)]
pub struct Pose<F: Frame> {
    /// `tracker_from_body`, with the covariance that follows from the emitters' noise and calibration.
    pub transform: Uncertain<Tracker, F>,
    /// Root mean square residual of the emitters used, mm: divides by their number.
    pub fre_rms_mm: f64,
    /// Emitters used.
    pub used: usize,
    /// Emitters seen and left out, because they disagree with all others.
    pub outliers: usize,
    /// Sum of the squared residuals in units of their deviations; about 3 `used` - 6 where the noise is as stated.
    pub chi_squared: f64,
    /// Predicted error at the tip, 95 %, mm, from the emitters alone.
    pub tip_95_mm: f64,
}

/// Why there is no pose.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum Lost {
    /// The localizer sees none of the body.
    #[error("no emitter is seen")]
    NotSeen,
    /// Too few emitters.
    #[error("{seen} emitters are seen, {needed} are needed")]
    TooFew {
        /// How many of them.
        seen: usize,
        /// How many are needed.
        needed: usize,
    },
    /// The emitters do not fit the body: bent, mislabelled, mirrored, or seen wrong.
    #[error(
        "the emitters do not fit the body: residual {fre_rms_mm:.2} mm (rms), emitter {worst} {worst_mm:.2} mm; {allowed_mm} mm are allowed"
    )]
    Residual {
        /// Root mean square, mm.
        fre_rms_mm: f64,
        /// The emitter of largest residual.
        worst: usize,
        /// Its residual, mm.
        worst_mm: f64,
        /// The gate.
        allowed_mm: f64,
    },
    /// The emitters seen lie so that the pose does not follow, or the tip is thrown too far.
    #[error(
        "the emitters seen do not hold the tip: predicted error {tip_95_mm:.2} mm (95 %), {allowed_mm} mm are allowed"
    )]
    Geometry {
        /// Predicted error at the tip, mm; infinite where no pose follows at all.
        tip_95_mm: f64,
        /// The gate.
        allowed_mm: f64,
    },
    /// A number that is not finite, or an emitter that the body does not have.
    #[error("sighting {index} is not one: emitter {emitter} at {place:?}")]
    Malformed {
        /// Which sighting.
        index: usize,
        /// Its emitter.
        emitter: usize,
        /// Its place.
        place: [f64; 3],
    },
}
