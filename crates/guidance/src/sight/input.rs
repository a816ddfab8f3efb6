//! What a sight is made of, and which numbers are accepted.

use geometry::{Ct, Direction, Point, Rigid, Tool};

use super::refusal::{Input, Refused};

/// No length or coordinate may be beyond this, mm: a kilometre, so that no square overflows.
pub const MAX_MM: f64 = 1e6;

/// What is known of a pose's error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Covariance {
    /// Nothing.
    Missing,
    /// The upper triangle, row by row, of the 6 x 6 covariance of (rotation vector, translation) in `Ct`, rad and mm, in the
    /// convention of `geometry::uncertain`. All zero counts as missing: samples without a covariance carry zeros.
    Upper([f64; 21]),
    /// The pose is exact, as of a simulation without noise.
    Exact,
}

/// A pose with its error, or the reason why there is none.
#[derive(Debug, Clone, Copy, PartialEq)]
#[allow(
    clippy::large_enum_variant,
    reason = "it lives for one call, and a box would allocate for each pose"
)]
pub enum Pose<R> {
    /// A pose that is valid now.
    Valid {
        /// Where the tool is in the patient.
        ct_from_tool: Rigid<Ct, Tool>,
        /// How well that is known.
        covariance: Covariance,
    },
    /// No pose: lost, old, or refused.
    Lost(R),
}

/// The tool.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ToolShape {
    /// Its tip, mm.
    pub tip_in_tool: Point<Tool>,
    /// The direction in which it advances.
    pub axis_in_tool: Direction<Tool>,
}

/// What a person has chosen to aim at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Aim {
    /// The target's centre, mm.
    pub target: Point<Ct>,
    /// The target's radius, mm; above zero.
    pub radius_mm: f64,
    /// Where the tool is to enter, mm; at another place than the target.
    pub entry: Option<Point<Ct>>,
    /// How far before the target's centre the tip is to stop, mm; zero or more.
    pub stop_mm: f64,
}

/// Where one phase ends and the next begins: a person's choice. There is no hysteresis: a phase depends on the pose alone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Thresholds {
    /// How far the tip may be from the planned way, mm; above zero. Beyond: find the entry.
    pub corridor_mm: f64,
    /// How far the axis may be turned from the planned line, rad; above zero, at most half a right angle. Beyond: align.
    pub align_rad: f64,
}

/// Refuses what is not a number or beyond its domain.
pub(super) fn check(
    ct_from_tool: &Rigid<Ct, Tool>,
    tool: &ToolShape,
    aim: &Aim,
    thresholds: &Thresholds,
) -> Result<(), Refused> {
    place(Input::Pose, ct_from_tool.translation_mm())?;
    place(Input::Tip, tool.tip_in_tool.mm())?;
    place(Input::Axis, tool.axis_in_tool.components())?;
    place(Input::Target, aim.target.mm())?;
    if let Some(entry) = aim.entry {
        place(Input::Entry, entry.mm())?;
    }
    positive(Input::Radius, aim.radius_mm, MAX_MM)?;
    if aim.stop_mm != 0.0 {
        positive(Input::Stop, aim.stop_mm, MAX_MM)?;
    }
    positive(Input::Corridor, thresholds.corridor_mm, MAX_MM)?;
    positive(Input::Align, thresholds.align_rad, std::f64::consts::FRAC_PI_4)
}

/// Three numbers, each within [`MAX_MM`].
fn place(what: Input, found: [f64; 3]) -> Result<(), Refused> {
    found.into_iter().try_for_each(|x| {
        finite(what, x)?;
        if x.abs() > MAX_MM {
            return Err(Refused::OutOfRange {
                what,
                found: x,
                allowed: [-MAX_MM, MAX_MM],
            });
        }
        Ok(())
    })
}

/// A number above zero, at most `most`.
fn positive(what: Input, found: f64, most: f64) -> Result<(), Refused> {
    finite(what, found)?;
    if found > 0.0 && found <= most {
        return Ok(());
    }
    let allowed = [0.0, most];
    Err(Refused::OutOfRange { what, found, allowed })
}

fn finite(what: Input, found: f64) -> Result<(), Refused> {
    if found.is_finite() {
        return Ok(());
    }
    Err(Refused::NotFinite { what, found })
}
