//! What may be said of a sight.

use super::predicted::Predicted;

/// What may be said. The first that holds, in this order: error unknown, on target, past target, on course, within error, steer.
///
/// With the miss m, what is to go g, the target's radius R, and of the predicted error the ball B, the ellipse's longer half-axis E
/// and the remainder r:
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Verdict {
    /// `hypot(m, g) + B + r <= R`: the point that is to reach the target lies in it, together with its predicted error. So also
    /// `m + E + r <= R` and `abs(g) <= R`.
    OnTarget,
    /// `m + E + r <= R`, `g >= 0`: the axis goes through the target, together with its predicted error; the depth is not reached,
    /// or is not known well enough to say so.
    OnCourse,
    /// The target's centre lies in the 95 % ellipse about the axis, but the error may be larger than the target: whether it is
    /// aimed at cannot be told, and steering by the sight improves nothing.
    WithinError,
    /// The axis passes beside the target: steer towards it.
    Steer,
    /// `g < -R`, or on course with `g < 0`: the target lies behind the point that was to reach it.
    PastTarget,
    /// The predicted error is not known: nothing may be claimed.
    ErrorUnknown,
}

/// What is drawn beside a verdict's word, each of another outline: colour is never the only difference.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Shape {
    /// A filled disc.
    Disc,
    /// A ring.
    Ring,
    /// A ring of dashes.
    DashedRing,
    /// An arrow towards the target on the sight.
    Arrow,
    /// A bar across the sight.
    Bar,
    /// A question mark.
    QuestionMark,
}

impl Verdict {
    /// Every verdict.
    pub const ALL: [Self; 6] = [
        Self::OnTarget,
        Self::OnCourse,
        Self::WithinError,
        Self::Steer,
        Self::PastTarget,
        Self::ErrorUnknown,
    ];

    /// As a person reads it.
    pub const fn word(self) -> &'static str {
        match self {
            Self::OnTarget => "ON TARGET",
            Self::OnCourse => "ON COURSE",
            Self::WithinError => "WITHIN ERROR",
            Self::Steer => "STEER",
            Self::PastTarget => "PAST TARGET",
            Self::ErrorUnknown => "ERROR UNKNOWN",
        }
    }

    /// What is drawn beside it.
    pub const fn shape(self) -> Shape {
        match self {
            Self::OnTarget => Shape::Disc,
            Self::OnCourse => Shape::Ring,
            Self::WithinError => Shape::DashedRing,
            Self::Steer => Shape::Arrow,
            Self::PastTarget => Shape::Bar,
            Self::ErrorUnknown => Shape::QuestionMark,
        }
    }
}

/// The verdict of a miss (right, up), of what is to go and of a radius, all mm and finite. `None`: the error is not known.
pub(super) fn of(miss_mm: [f64; 2], to_go_mm: f64, radius_mm: f64, predicted: Option<&Predicted>) -> Verdict {
    let Some(predicted) = predicted else {
        return Verdict::ErrorUnknown;
    };
    let miss = miss_mm[0].hypot(miss_mm[1]);
    // Written so that a number that is none claims nothing.
    let fits = |off_mm: f64, error_mm: f64| off_mm + error_mm + predicted.remainder_mm <= radius_mm;
    let is_on_course = fits(miss, predicted.ellipse.half_axes_mm[0]);
    if fits(miss.hypot(to_go_mm), predicted.ball_95_mm) {
        Verdict::OnTarget
    } else if to_go_mm < -radius_mm || (is_on_course && to_go_mm < 0.0) {
        Verdict::PastTarget
    } else if is_on_course {
        Verdict::OnCourse
    } else if predicted.ellipse.contains(miss_mm) {
        Verdict::WithinError
    } else {
        Verdict::Steer
    }
}
