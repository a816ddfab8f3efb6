//! The sight: one target seen along the tool's axis, as one looks through a telescopic sight.
//!
//! # Definitions
//!
//! All in `Ct`, mm. With the tip `p` and the unit axis `a` (the direction in which the tool advances), the target's centre `c` of
//! radius `R`, and the sight's unit vectors `r` (right) and `u` (up), which are perpendicular to `a` and to each other:
//!
//! ```text
//! depth  = a . (c - p)                positive before the target, zero beside its centre, negative past it       (1)
//! to go  = depth - stop               the tip is to stand `stop` mm before the centre, stop >= 0                 (2)
//! miss   = (r . (c - p), u . (c - p)) the target on the sight, whose middle is the axis                          (3)
//! c      = p + a depth + r miss_0 + u miss_1                                                                     (4)
//! aim    = p + a stop                 the point that is to reach the target; abs(aim - c) = hypot(miss, to go)   (5)
//! ```
//!
//! The sight shares its right and its down with the perpendicular image: what lies to the right on one lies to the right on the
//! other. Looking along the tool, `right x down` is the axis; axes that would show the patient mirrored are refused.
//!
//! # Predicted error
//!
//! The pose's covariance is that of a small motion (w, v) after it (`geometry::uncertain`). It moves the tool past the target by
//! `v + w x c`, whose 3 x 3 covariance, in (r, u, a), gives the ellipse in the sight's plane at the target's depth, the error along
//! the axis, and the ball about the target. First order leaves out at most `abs(w)^2 abs(c) / 2`, as that motion turns about the
//! origin of `Ct`; [`Predicted::remainder_mm`] bounds it. What the covariance does not hold is not predicted: a bent tool, an organ
//! that has moved, a target marked at a wrong place.
//!
//! # Verdict
//!
//! See [`Verdict`]. ON TARGET says: by the covariance, the aim (5) lies in the target's ball in at least 94.9 of 100 cases.

mod axes;
mod input;
mod phase;
mod predicted;
mod refusal;
mod verdict;

pub use axes::SightAxes;
pub use input::{Aim, Covariance, MAX_MM, Pose, Thresholds, ToolShape};
pub use phase::Phase;
pub use predicted::{Ellipse, Predicted, Unknown};
pub use refusal::{Input, NoSight, Refused};
pub use verdict::{Shape, Verdict};

use geometry::{Ct, Direction, Point};

/// The planned line, from the entry to the target's centre, as the tool stands to it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Line {
    /// The angle between the tool's axis and the line from entry to target, rad, 0 to pi; 0 where both point alike.
    pub angle_rad: f64,
    /// The entry on the sight, (right, up), mm: as [`Sight::miss_mm`] of the target.
    pub entry_mm: [f64; 2],
    /// How far the entry lies before the tip along the axis, mm; negative once the tip is past it.
    pub entry_depth_mm: f64,
    /// The distance of the tip from the planned way, mm: from the entry before it, from the line beyond it.
    pub off_line_mm: f64,
}

/// What is shown of one pose. Equations of [the module](self).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sight {
    /// The tip `p`.
    pub tip: Point<Ct>,
    /// The axis `a`, along which the tool advances.
    pub axis: Direction<Ct>,
    /// The sight's right `r`: unit, perpendicular to the axis.
    pub right: Direction<Ct>,
    /// The sight's up `u`: unit, perpendicular to the axis and to right.
    pub up: Direction<Ct>,
    /// From the tip to the target's centre along the axis (1), mm: positive before the target, negative past it.
    pub depth_mm: f64,
    /// How far the tool is to advance (2), mm; negative where it is to be withdrawn.
    pub to_go_mm: f64,
    /// The target's centre on the sight (3), (right, up), mm: steer towards it.
    pub miss_mm: [f64; 2],
    /// Its distance from the axis, mm.
    pub miss_length_mm: f64,
    /// The planned line; `None` without an entry.
    pub line: Option<Line>,
    /// The predicted error at the target, or why it is not known.
    pub predicted: Result<Predicted, Unknown>,
    /// What is to be done next.
    pub phase: Phase,
    /// What may be said.
    pub verdict: Verdict,
}

/// The sight of a pose.
///
/// `axes` are the perpendicular image's right and down. Each length is at most [`MAX_MM`]. Error of each length: 16 eps times the
/// largest coordinate; of the angle: 4 eps, and 2 eps times the largest coordinate over the line's length.
///
/// # Errors
/// [`NoSight::Lost`] with the pose's own reason; [`NoSight::Refused`] where an input is not a number, out of its domain, or
/// contradicts another. A covariance that is none is no error: the sight then says so in [`Sight::predicted`].
pub fn sight<R>(
    pose: Pose<R>,
    tool: &ToolShape,
    aim: &Aim,
    axes: &SightAxes,
    thresholds: &Thresholds,
) -> Result<Sight, NoSight<R>> {
    let (ct_from_tool, covariance) = match pose {
        Pose::Valid {
            ct_from_tool,
            covariance,
        } => (ct_from_tool, covariance),
        Pose::Lost(reason) => return Err(NoSight::Lost(reason)),
    };
    input::check(&ct_from_tool, tool, aim, thresholds)?;
    let tip = ct_from_tool * tool.tip_in_tool;
    let axis = ct_from_tool * tool.axis_in_tool;
    let [right, up] = axes.about(axis)?;
    let on_sight = |p: Point<Ct>| [right, up, axis].map(|d| (p - tip).dot(d.vector()));

    let [miss_right, miss_up, depth_mm] = on_sight(aim.target);
    let (miss_length_mm, to_go_mm) = (miss_right.hypot(miss_up), depth_mm - aim.stop_mm);
    let line = aim.entry.map(|entry| {
        let way = phase::Way::new(entry, aim.target)?;
        let [x, y, entry_depth_mm] = on_sight(entry);
        Ok(Line {
            angle_rad: way.angle(axis),
            entry_mm: [x, y],
            entry_depth_mm,
            off_line_mm: way.distance(tip),
        })
    });
    let line = line.transpose().map_err(NoSight::Refused)?;
    let predicted = predicted::at(aim.target, [right, up, axis], ct_from_tool, covariance);
    Ok(Sight {
        tip,
        axis,
        right,
        up,
        depth_mm,
        to_go_mm,
        miss_mm: [miss_right, miss_up],
        miss_length_mm,
        line,
        predicted,
        phase: match line {
            Some(line) => phase::planned(line.off_line_mm, line.angle_rad, thresholds),
            None => phase::free(miss_length_mm, depth_mm, aim.radius_mm, thresholds),
        },
        verdict: verdict::of([miss_right, miss_up], to_go_mm, aim.radius_mm, predicted.as_ref().ok()),
    })
}
