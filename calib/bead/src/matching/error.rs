//! Why touched points were not matched.

use std::fmt;

use super::Errors;
use calib::registration;

/// Which bead each touched point is in one solution. Indices count from 0.
#[derive(Debug, Clone, PartialEq)]
pub struct Pairing {
    /// (touched point, bead).
    pub pairs: Vec<(usize, usize)>,
    /// Root mean square residual, mm.
    pub fre_rms_mm: f64,
}

impl fmt::Display for Pairing {
    /// Counts from 1, as people do.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let words: Vec<String> = self.pairs.iter().map(|(t, b)| format!("{}-{}", t + 1, b + 1)).collect();
        write!(f, "{} (FRE {:.3} mm)", words.join(" "), self.fre_rms_mm)
    }
}

/// Why touched points were not matched to beads. Indices count from 0 in fields and from 1 in texts.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Refused {
    /// The deviations are not usable.
    #[error("the deviations {} mm of a bead and {} mm of a touched point must be finite, at least 0, and not both 0", .0.bead_mm, .0.touch_mm)]
    Errors(Errors),
    /// Errors of other than all touches are stated.
    #[error("{found} stated errors for {touches} touched points")]
    StatedCount {
        /// Errors.
        found: usize,
        /// Touched points.
        touches: usize,
    },
    /// What a touch states of its error is no covariance.
    #[error("touched point {}: its covariance is none, or less than the part of it that all touches share", .touch + 1)]
    Stated {
        /// Which.
        touch: usize,
    },
    /// Fewer than three.
    #[error("{found} {what}; at least 3 are needed")]
    TooFew {
        /// Beads or touched points.
        what: &'static str,
        /// How many.
        found: usize,
    },
    /// More than the search takes.
    #[error("{found} {what}; at most {most} are taken: leave out what cannot be meant")]
    TooMany {
        /// Beads or touched points.
        what: &'static str,
        /// How many.
        found: usize,
        /// The bound.
        most: usize,
    },
    /// A coordinate is NaN or infinite.
    #[error("{what} {}: {found:?} holds a number that is not finite", .index + 1)]
    NotFinite {
        /// Bead or touched point.
        what: &'static str,
        /// Which.
        index: usize,
        /// Its coordinates.
        found: [f64; 3],
    },
    /// Two touched points are so near that they may be one.
    #[error(
        "touched points {} and {} are {distance_mm:.3} mm apart, and two beads must be {least_mm:.3} mm apart to be told \
         from one: leave one out, or put in their mean",
        .first + 1, .second + 1
    )]
    TouchedTwice {
        /// The earlier one.
        first: usize,
        /// The later one.
        second: usize,
        /// Their distance, mm.
        distance_mm: f64,
        /// The least that is accepted, mm.
        least_mm: f64,
    },
    /// No three touched points agree with three beads.
    #[error(
        "no 3 of the {touched} touched points agree with 3 of the {beads} beads: their distances differ by more than \
         {distance_mm:.3} mm. Check that these are this patient's beads, and the pointer's calibration"
    )]
    NoMatch {
        /// Beads.
        beads: usize,
        /// Touched points.
        touched: usize,
        /// The greatest difference of distances accepted, mm.
        distance_mm: f64,
    },
    /// Two pairings fit equally well and place the patient differently.
    #[error(
        "the pairing is ambiguous (touched point-bead): {first} and {second} both fit, and place the points up to \
         {apart_mm:.1} mm apart. Touch more beads, or beads in a less regular layout"
    )]
    Ambiguous {
        /// The one of the least residuals.
        first: Pairing,
        /// The other.
        second: Pairing,
        /// Greatest distance between the two places of a touched point, mm.
        apart_mm: f64,
    },
    /// Too many touched points lie on no bead.
    #[error(
        "only {} of the {touched} touched points lie on beads (touched point-bead: {best}), and at most {allowed} may lie on none: these may be \
         another person's beads, a side exchanged or the pointer's calibration wrong. Touch beads only, and leave out points that were none",
        .best.pairs.len()
    )]
    FewOnBeads {
        /// The pairing of the most.
        best: Pairing,
        /// Touched points.
        touched: usize,
        /// How many may lie on no bead.
        allowed: usize,
    },
    /// A touch on no bead is plainly of one, and farther from it than the errors told.
    #[error(
        "touched point {} lies {distance_mm:.2} mm from bead {}, which no other touch is of: more than the errors told, and less than the \
         {limit_mm:.2} mm from which on it is taken for a touch of something else. Touch it again; or the hand errs by more than told, or what that \
         bead is fixed to has moved",
        .touch + 1, .bead + 1
    )]
    NearBead {
        /// The touch.
        touch: usize,
        /// The bead.
        bead: usize,
        /// How far they are apart in the registration, mm.
        distance_mm: f64,
        /// From where on a touch is of no bead, mm.
        limit_mm: f64,
    },
    /// Anybody's touches would match as well.
    #[error(
        "{} touched points match (touched point-bead: {best}), and of touches of another person {by_chance:.2} such pairings with {beads} beads \
         are to be expected, at most 0.001 are allowed: touch more beads, or leave out false ones",
        .best.pairs.len()
    )]
    ByChance {
        /// The pairing.
        best: Pairing,
        /// Beads.
        beads: usize,
        /// Pairings that are to be expected.
        by_chance: f64,
    },
    /// The matched points lie so nearly on a line that noise alone turns the patient about it.
    #[error(
        "the {points} matched points lie on a line to {width_mm:.3} mm (root mean square), and at least {needed_mm:.3} mm \
         are needed to fix the turn about it: touch a bead off the line"
    )]
    Collinear {
        /// Matched points.
        points: usize,
        /// Root mean square distance from the best line, mm.
        width_mm: f64,
        /// The least accepted, mm.
        needed_mm: f64,
    },
    /// The search was given up.
    #[error(
        "the search for the pairing did not end within {steps} steps: give smaller errors if they are, or leave out false \
         beads"
    )]
    SearchTooLong {
        /// The steps made.
        steps: usize,
    },
    /// The registration of the pairs failed.
    #[error(transparent)]
    Registration(#[from] registration::Refused),
}
