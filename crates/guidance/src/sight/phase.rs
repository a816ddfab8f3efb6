//! What is to be done next: a function of the pose alone, without memory.

use geometry::{Ct, Direction, Point};

use super::input::Thresholds;
use super::refusal::Refused;

/// What is to be done next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Phase {
    /// Bring the tip to the entry: it is further than `corridor_mm` from the planned way.
    FindEntry,
    /// Turn the axis: the angle to the planned line is above `align_rad`.
    Align,
    /// Advance, or withdraw, by what is to go.
    Advance,
}

impl Phase {
    /// As a person reads it.
    pub const fn word(self) -> &'static str {
        match self {
            Self::FindEntry => "FIND THE ENTRY",
            Self::Align => "ALIGN",
            Self::Advance => "ADVANCE",
        }
    }
}

/// The shortest line, mm: at coordinates of [`super::MAX_MM`] its direction is then good to 2e-7 rad.
const SHORTEST_MM: f64 = 1e-3;

/// The planned way: from the entry along the line to the target, and on.
#[derive(Debug, Clone, Copy)]
pub(super) struct Way {
    entry: Point<Ct>,
    along: Direction<Ct>,
}

impl Way {
    pub(super) fn new(entry: Point<Ct>, target: Point<Ct>) -> Result<Self, Refused> {
        let line = target - entry;
        let too_short = Refused::EntryIsTarget {
            distance_mm: line.norm(),
            least_mm: SHORTEST_MM,
        };
        match line.direction() {
            Some(along) if line.norm() >= SHORTEST_MM => Ok(Self { entry, along }),
            _ => Err(too_short),
        }
    }

    /// Between `axis` and the line, rad, 0 to pi: by the arc tangent, as an arc cosine knows no angle below 1e-8.
    pub(super) fn angle(&self, axis: Direction<Ct>) -> f64 {
        axis.cross(self.along).norm().atan2(axis.dot(self.along))
    }

    /// Of `p` from the half-line that begins at the entry, mm.
    pub(super) fn distance(&self, p: Point<Ct>) -> f64 {
        let from_entry = p - self.entry;
        if from_entry.dot(self.along.vector()) < 0.0 {
            return from_entry.norm();
        }
        from_entry.cross(self.along.vector()).norm()
    }
}

/// With an entry: the tip's distance from the way, mm, and the axis's angle to the line, rad.
pub(super) fn planned(off_line_mm: f64, angle_rad: f64, thresholds: &Thresholds) -> Phase {
    if off_line_mm > thresholds.corridor_mm {
        Phase::FindEntry
    } else if angle_rad > thresholds.align_rad {
        Phase::Align
    } else {
        Phase::Advance
    }
}

/// Without an entry: the line is that from the tip to the target. Inside the target it has no meaning any more.
pub(super) fn free(miss_mm: f64, depth_mm: f64, radius_mm: f64, thresholds: &Thresholds) -> Phase {
    let is_inside = miss_mm.hypot(depth_mm) <= radius_mm;
    if is_inside || miss_mm.atan2(depth_mm) <= thresholds.align_rad {
        Phase::Advance
    } else {
        Phase::Align
    }
}
