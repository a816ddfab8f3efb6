//! A target to be reached: drawn from a seed.

use std::f64::consts::{PI, TAU};

use chance::{Chance, mix};
use geometry::{Ct, Direction, Point, Vector};
use guidance::sight::Aim;

use crate::tube::{Posture, Way};

/// Which ways are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Approach {
    /// Within 6 degrees of an axial plane, up to 30 degrees from straight backwards: as ways are planned that are to be
    /// followed on slices.
    InPlane,
    /// Up to 30 degrees from straight backwards in any direction.
    Oblique,
}

/// One task.
#[derive(Debug, Clone, PartialEq)]
pub struct Task {
    /// The seed of all that is drawn in it.
    pub seed: u64,
    /// The planned line, and the tube.
    pub way: Way,
    /// What is aimed at.
    pub aim: Aim,
    /// How the tube stands at the beginning.
    pub start: Posture,
}

/// From the entry to the target, mm.
const TARGET_DEPTH_MM: f64 = 90.0;
/// Radius of the target, mm.
const RADIUS_MM: f64 = 2.5;
/// The tube, from its tip to the hand, mm: the demonstration's.
const LENGTH_MM: f64 = 180.0;
/// How deep the tube is at the beginning, mm.
const START_DEPTH_MM: f64 = 10.0;
/// How far it points beside the target at the beginning, at least and at most, rad: 4 to 8 degrees.
const START_TILT_RAD: [f64; 2] = [4.0 * PI / 180.0, 8.0 * PI / 180.0];
/// Targets lie about the CT's origin within this along each axis, mm.
const ABOUT_MM: f64 = 50.0;

impl Task {
    /// The task of this number in a study. The same for the same seed, always.
    pub fn draw(seed: u64, number: u64, approach: Approach) -> Self {
        let seed = mix(seed ^ mix(number));
        let chance = Chance::new(seed, 0);
        let evenly = |draw: u64, low: f64, high: f64| low + (high - low) * chance.uniform(draw);
        let [x, y, z] = [0, 1, 2].map(|k| evenly(k, -ABOUT_MM, ABOUT_MM));
        let target = Point::new(x, y, z);
        let line = match approach {
            Approach::InPlane => {
                let (sin, cos) = evenly(3, -PI / 6.0, PI / 6.0).sin_cos();
                let (up, flat) = evenly(4, -PI / 30.0, PI / 30.0).sin_cos();
                Vector::new(flat * sin, flat * cos, up)
            }
            Approach::Oblique => {
                let ((sin, cos), (up, right)) = (evenly(3, 0.0, PI / 6.0).sin_cos(), evenly(4, 0.0, TAU).sin_cos());
                Vector::new(sin * right, cos, sin * up)
            }
        };
        let tilt = evenly(5, START_TILT_RAD[0], START_TILT_RAD[1]).tan();
        let (sin, cos) = evenly(6, 0.0, TAU).sin_cos();
        let entry = target + line * -TARGET_DEPTH_MM;
        Self {
            seed,
            way: way(entry, target, evenly(7, 0.0, TAU)),
            aim: Aim {
                target,
                radius_mm: RADIUS_MM,
                entry: None,
                stop_mm: 0.0,
            },
            start: Posture {
                tilt: [tilt * cos, tilt * sin],
                depth_mm: START_DEPTH_MM,
            },
        }
    }
}

/// The way; entry and target are 90 mm apart, so there is always one.
fn way(entry: Point<Ct>, target: Point<Ct>, roll: f64) -> Way {
    let straight = || Way::new(target + Direction::Y * -TARGET_DEPTH_MM, target, LENGTH_MM, roll);
    Way::new(entry, target, LENGTH_MM, roll)
        .or_else(straight)
        .unwrap_or_else(|| unreachable!("a line of 90 mm"))
}
