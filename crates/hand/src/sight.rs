//! The sight as a person reads it: the numbers of `guidance::sight`, as coarse as their drawing.

use geometry::{Ct, Direction, Point, Rigid, Tool};
use guidance::sight::{NoSight, Pose, Sight, SightAxes, Thresholds, ToolShape, Verdict, sight};

use crate::dial::Dial;
use crate::reader::{Reader, Reading, Shown, upright_axes};

/// Where phases of the sight end: the window's numbers. The operator does not read phases.
const THRESHOLDS: Thresholds = Thresholds {
    corridor_mm: 10.0,
    align_rad: 0.087,
};

/// Reads the sight.
#[derive(Debug, Clone, Copy)]
pub struct SightReader {
    dial: Dial,
}

impl SightReader {
    /// Of a sight that is drawn so.
    pub const fn new(dial: Dial) -> Self {
        Self { dial }
    }
}

/// The sight on what is shown, exact.
///
/// # Errors
/// [`NoSight`], as of `guidance::sight::sight`.
pub(crate) fn exact(shown: &Shown) -> Result<Sight, NoSight<std::convert::Infallible>> {
    let tool = ToolShape {
        tip_in_tool: Point::new(0.0, 0.0, 0.0),
        axis_in_tool: Direction::Z,
    };
    let [right, up] = upright_axes(shown.pose * Direction::<Tool>::Z);
    let pose = Pose::Valid {
        ct_from_tool: shown.pose,
        covariance: shown.covariance,
    };
    let axes = SightAxes { right, down: -up };
    sight(pose, &tool, &shown.aim, &axes, &THRESHOLDS)
}

impl Reader for SightReader {
    fn pictures(&self, _: &Shown) -> Vec<usize> {
        vec![0]
    }

    fn axes(&self, _: usize, pose: Rigid<Ct, Tool>) -> [Direction<Ct>; 2] {
        upright_axes(pose * Direction::<Tool>::Z)
    }

    fn read(&mut self, _: usize, shown: &Shown) -> Option<Reading> {
        let sight = exact(shown).ok()?;
        Some(Reading {
            target_mm: self.dial.rounded(sight.miss_mm),
            // The sight looks along the tube.
            axis: [0.0; 2],
            to_go_mm: Some(self.dial.rounded_to_go(sight.to_go_mm)),
            room_mm: shown.aim.radius_mm,
            is_inside: sight.verdict == Verdict::OnTarget,
        })
    }

    /// The target is always on the sight.
    fn unseen_mm(&self, _: &Shown) -> f64 {
        0.0
    }
}
