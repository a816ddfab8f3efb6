//! The scripted gesture: insert along a line towards the target, rest, sweep about the entry, withdraw, and again.

use std::f64::consts::TAU;

use geometry::rotation::Rotation;
use geometry::{Ct, Direction, Point, Rigid, Tool, Vector, VolumeGrid};
use scene::{Approach, Target};

/// The tip starts this far in front of the skin.
const START_OUTSIDE_MM: f64 = 40.0;
/// Without a given entry: from the patient's left and back, as in a lomboscopy.
const FROM_LEFT_AND_BACK: [f64; 3] = [0.8, 0.6, 0.0];
/// Without a given entry: this part of the way from the target to the volume's border, which is near the skin.
const TO_SKIN: f64 = 0.75;

/// A gesture in the patient.
#[derive(Debug, Clone)]
pub struct Gesture {
    entry: Point<Ct>,
    stop: Point<Ct>,
    along: Direction<Ct>,
    approach: Approach,
}

/// Why a gesture cannot be played.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum GestureError {
    /// The tip would have nowhere to go.
    #[error(
        "the approach: from the entry to the target are {distance_mm:.1} mm; it must be more than \
         stop_short_mm ({stop_short_mm} mm)"
    )]
    TooShort {
        /// From entry to target.
        distance_mm: f64,
        /// From the scene.
        stop_short_mm: f64,
    },
}

/// What the approach aims at: the named target, else the first, else `None`.
pub(crate) fn aim<'a>(approach: &Approach, targets: &'a [Target]) -> Option<&'a Target> {
    match &approach.target {
        Some(name) => targets.iter().find(|t| t.name == *name),
        None => targets.first(),
    }
}

impl Gesture {
    /// The gesture towards `target`, in a volume with this `grid` (used where the scene gives no entry).
    ///
    /// # Errors
    /// [`GestureError::TooShort`].
    pub fn new(approach: &Approach, target: Point<Ct>, grid: Option<&VolumeGrid>) -> Result<Self, GestureError> {
        let entry = approach.entry.unwrap_or_else(|| default_entry(target, grid));
        let distance_mm = entry.distance(target);
        let stop_short_mm = approach.stop_short_mm;
        let too_short = GestureError::TooShort {
            distance_mm,
            stop_short_mm,
        };
        if distance_mm <= stop_short_mm {
            return Err(too_short);
        }
        let along = (target - entry).direction().ok_or(too_short)?;
        Ok(Self {
            entry,
            stop: target - along * stop_short_mm,
            along,
            approach: approach.clone(),
        })
    }

    /// Duration of one round, s.
    pub fn round_s(&self) -> f64 {
        2.0 * self.approach.insert_s + self.approach.pause_s + self.approach.sweep_s
    }

    /// The true pose at script time `t` (s).
    pub fn ct_from_tool(&self, t: f64) -> Rigid<Ct, Tool> {
        let a = &self.approach;
        let t = t.rem_euclid(self.round_s());
        if t < a.insert_s {
            return self.inserted(t / a.insert_s);
        }
        let t = t - a.insert_s;
        if t < a.pause_s {
            return self.inserted(1.0);
        }
        let t = t - a.pause_s;
        if t < a.sweep_s {
            return self.swept(t / a.sweep_s);
        }
        self.inserted(1.0 - (t - a.sweep_s) / a.insert_s)
    }

    /// The tip at fraction `s` of the insertion; it starts and stops gently.
    fn inserted(&self, s: f64) -> Rigid<Ct, Tool> {
        let s = s * s * (3.0 - 2.0 * s);
        let start = self.entry - self.along * START_OUTSIDE_MM;
        tool_at(start.lerp(self.stop, s), self.along)
    }

    /// The tube turned about the entry: a figure of eight inside the cone, from the middle back to the middle.
    fn swept(&self, s: f64) -> Rigid<Ct, Tool> {
        let amplitude = self.approach.sweep_rad.tan();
        let (side, up) = sides(self.along);
        let tilt = side * (amplitude * (TAU * s).sin()) + up * (amplitude * 0.5 * (2.0 * TAU * s).sin());
        let along = (self.along.vector() + tilt).direction().unwrap_or(self.along);
        tool_at(self.entry + along * self.entry.distance(self.stop), along)
    }
}

/// Two directions across `along`, the second as near to the head as it can be.
fn sides(along: Direction<Ct>) -> (Direction<Ct>, Direction<Ct>) {
    let frame = frame_along(Point::new(0.0, 0.0, 0.0), along);
    (frame * Direction::<Tool>::X, frame * Direction::<Tool>::Y)
}

fn tool_at(tip: Point<Ct>, along: Direction<Ct>) -> Rigid<Ct, Tool> {
    frame_along(tip, along)
}

/// The tool frame with its tip at `tip`, its axis along `along` and its +y towards the head, or towards the front for a
/// tube along the body.
fn frame_along(tip: Point<Ct>, along: Direction<Ct>) -> Rigid<Ct, Tool> {
    let up = if along.dot(Direction::Z).abs() < 0.9 {
        Direction::Z
    } else {
        -Direction::Y
    };
    // `up` is never within 25 degrees of `along`, so the axes exist.
    Rigid::from_axes(tip, along, up)
        .unwrap_or_else(|| Rigid::from_parts(Rotation::IDENTITY, tip - Point::new(0.0, 0.0, 0.0)))
}

/// A point near the skin, from the patient's left and back.
fn default_entry(target: Point<Ct>, grid: Option<&VolumeGrid>) -> Point<Ct> {
    let [x, y, z] = FROM_LEFT_AND_BACK;
    let outwards = Vector::<Ct>::new(x, y, z);
    let Some(grid) = grid else {
        return target + outwards * 120.0;
    };
    let (low, high) = grid.bounds();
    let (p, low, high) = (target.mm(), low.mm(), high.mm());
    let to_border = (0..3)
        .filter(|&a| outwards.mm()[a] != 0.0)
        .map(|a| ((high[a] - p[a]) / outwards.mm()[a]).max((low[a] - p[a]) / outwards.mm()[a]))
        .fold(f64::INFINITY, f64::min);
    target + outwards * (to_border.max(0.0) * TO_SKIN)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gesture() -> Gesture {
        let approach = Approach {
            target: None,
            entry: Some(Point::new(100.0, 60.0, 0.0)),
            stop_short_mm: 5.0,
            insert_s: 4.0,
            pause_s: 2.0,
            sweep_s: 4.0,
            sweep_rad: 0.1,
        };
        Gesture::new(&approach, Point::new(10.0, -10.0, 20.0), None).unwrap()
    }

    fn tip(t: f64) -> Point<Ct> {
        gesture().ct_from_tool(t) * Point::<Tool>::new(0.0, 0.0, 0.0)
    }

    #[test]
    fn stops_short_of_the_target_and_points_at_it() {
        let target = Point::new(10.0, -10.0, 20.0);
        assert!((tip(5.0).distance(target) - 5.0).abs() < 1e-9);
        let axis = gesture().ct_from_tool(5.0) * Direction::<Tool>::Z;
        assert!(axis.dot((target - tip(5.0)).direction().unwrap()) > 1.0 - 1e-12);
    }

    #[test]
    fn never_jumps() {
        // The fastest part is the insertion: 1.5 times its mean speed.
        let (g, step) = (gesture(), 1.0 / 500.0);
        let length = tip(0.0).distance(tip(4.0));
        let fastest = 1.6 * length / 4.0 * step;
        let n = (2.0 * g.round_s() / step) as u32;
        for i in 0..n {
            let t = f64::from(i) * step;
            assert!(tip(t).distance(tip(t + step)) < fastest, "at {t}");
        }
    }

    #[test]
    fn the_sweep_turns_about_the_entry() {
        let entry = Point::<Ct>::new(100.0, 60.0, 0.0);
        let depth = tip(5.0).distance(entry);
        for t in [6.5, 7.7, 9.9] {
            let axis = gesture().ct_from_tool(t) * Direction::<Tool>::Z;
            assert!((tip(t) - axis * depth).distance(entry) < 1e-9);
        }
    }

    #[test]
    fn an_approach_without_way_is_refused() {
        let mut approach = gesture().approach;
        approach.stop_short_mm = 500.0;
        let error = Gesture::new(&approach, Point::new(0.0, 0.0, 0.0), None).unwrap_err();
        assert!(
            error.to_string().contains("more than stop_short_mm (500 mm)"),
            "{error}"
        );
        approach.entry = Some(Point::new(0.0, 0.0, 0.0));
        approach.stop_short_mm = 0.0;
        assert!(Gesture::new(&approach, Point::new(0.0, 0.0, 0.0), None).is_err());
    }
}
