//! Poses, tools and sights made by hand.

#![allow(dead_code, reason = "each test uses its part")]
#![allow(clippy::unwrap_used, reason = "a test stops where it cannot go on")]

use geometry::{Ct, Direction, Point, Rigid, Tool, Vector};
use guidance::sight::{Aim, Covariance, NoSight, Pose, Refused, Sight, SightAxes, Thresholds, ToolShape, sight};
use nalgebra::Matrix6;

pub(crate) const TOOL: ToolShape = ToolShape {
    tip_in_tool: Point::new(0.0, 0.0, 0.0),
    axis_in_tool: Direction::Z,
};
pub(crate) const THRESHOLDS: Thresholds = Thresholds {
    corridor_mm: 5.0,
    align_rad: 0.05,
};

pub(crate) fn pose(turn: [f64; 3], t: [f64; 3]) -> Rigid<Ct, Tool> {
    Rigid::from_rotation_vector(Vector::new(turn[0], turn[1], turn[2]), Vector::new(t[0], t[1], t[2])).unwrap()
}

pub(crate) fn aim(target: [f64; 3], radius_mm: f64) -> Aim {
    Aim {
        target: Point::new(target[0], target[1], target[2]),
        radius_mm,
        entry: None,
        stop_mm: 0.0,
    }
}

/// Right and down of an image across the tool: as of a perpendicular view whose up is the tool's own +y.
pub(crate) fn tool_axes(ct_from_tool: &Rigid<Ct, Tool>) -> SightAxes {
    SightAxes {
        right: *ct_from_tool * -Direction::<Tool>::X,
        down: *ct_from_tool * -Direction::<Tool>::Y,
    }
}

/// The upper triangle, row by row.
pub(crate) fn upper(c: &Matrix6<f64>) -> [f64; 21] {
    let entries: Vec<f64> = (0..6).flat_map(|i| (i..6).map(move |j| c[(i, j)])).collect();
    entries.try_into().unwrap()
}

/// The covariance of turns of `turn` rad and shifts of `shift` mm about the point `c`, alike in all directions.
pub(crate) fn about(c: [f64; 3], turn: f64, shift: f64) -> [f64; 21] {
    // v = v_c - w x c: a factor whose columns are such motions.
    let mut factor = Matrix6::<f64>::identity() * turn;
    for k in 0..3 {
        factor[(k + 3, k + 3)] = shift;
    }
    let [x, y, z] = c.map(|c| c * turn);
    for (i, j, value) in [(0, 1, -z), (0, 2, y), (1, 0, z), (1, 2, -x), (2, 0, -y), (2, 1, x)] {
        // Row i of c x w.
        factor[(i + 3, j)] = value;
    }
    upper(&(factor * factor.transpose()))
}

pub(crate) fn look(ct_from_tool: Rigid<Ct, Tool>, covariance: Covariance, aim: &Aim) -> Result<Sight, Refused> {
    let axes = tool_axes(&ct_from_tool);
    let pose = Pose::<()>::Valid {
        ct_from_tool,
        covariance,
    };
    sight(pose, &TOOL, aim, &axes, &THRESHOLDS).map_err(|e| match e {
        NoSight::Refused(refused) => refused,
        NoSight::Lost(()) => unreachable!(),
    })
}
