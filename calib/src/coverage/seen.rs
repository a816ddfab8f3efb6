//! Where a motion has been: what a picture of it shows while it goes on.
//!
//! A motion that pivots is shown as seen along the shaft from the handle: each direction in which the handle was tilted is a sector, and
//! reaches as far as the motion covers there. With `v = n sin(theta / 2)` the turn of a pose from the mean and `s` the shaft, the tilts are
//! `t = v x s`, and a direction `d` across the shaft is reached to `4 asin(sqrt(d^T mean(t t^T) d))`.
//!
//! `mean(t t^T)` is `mean(v v^T)` on the plane across the shaft, turned by a right angle. The least eigenvalue there is at most the second of
//! the whole (Cauchy's interlacing), which the gate of a cone is on: no motion has all sectors reached and too narrow a cone.

use geometry::rotation::Rotation;
use geometry::{Direction, Frame};
use nalgebra::{Matrix2, Vector2, Vector3, Vector4};

use super::{Coverage, mean, turn};

/// Sectors of a round.
pub const SECTORS: usize = 24;
/// Rings of cells, each a quarter of what is needed wide.
pub const RINGS: usize = 5;
/// Cells of a turn about the shaft, over a whole round.
pub const TURN_CELLS: usize = 72;
/// Reaches are told so much short that no rounding on their way makes them look enough.
const SHORT: f64 = 1.0 - 1e-9;

/// A motion as it is drawn. Angles are radians.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Seen {
    /// How far the motion reaches in each direction, the least over each sector; 0 where it says nothing yet. Sector `k` is about the
    /// angle `k` of [`SECTORS`] of a round, from the right to the top.
    pub reach_rad: [f64; SECTORS],
    /// What the gate is on: of a cone its half opening, of a turn twice its root mean square.
    pub reached_rad: f64,
    /// What is needed of that.
    pub needed_rad: f64,
    /// Cells where poses were: of a cone `ring * SECTORS + sector`, of a turn about the shaft from half a round back.
    pub cells: u128,
    /// Where the handle is: to the right and to the top, or how far it is turned, and 0.
    pub now_rad: [f64; 2],
    /// Which axis of the marker points to the top, from 0.
    pub up: usize,
}

impl Seen {
    /// Whether every direction is reached.
    pub fn is_complete(&self) -> bool {
        // What is not a number is not reached.
        self.reach_rad.iter().all(|reach| *reach >= self.needed_rad)
    }

    /// The same with nothing reached: poses that no result is made of are no ground for one.
    #[must_use]
    pub const fn without_reach(mut self) -> Self {
        self.reach_rad = [0.0; SECTORS];
        self
    }

    /// A pivoting of the rotations `F` to a fixed frame, the last being the newest, with the direction from the handle to the tip.
    /// `None` without any rotation.
    pub fn cone<F: Frame>(
        rotations: impl Iterator<Item = Rotation> + Clone,
        shaft: Direction<F>,
        needed_rad: f64,
    ) -> Option<Self> {
        let coverage = Coverage::<F>::of(rotations.clone())?;
        let (view, quaternions) = (View::along(shaft), rotations.map(|r| Vector4::from(r.quaternion())));
        let mean = mean(quaternions.clone())?;
        let turns = quaternions.map(|q| (turn(&mean, &q), mean.dot(&q)));
        let count = turns.clone().count() as f64;
        // About the mean, as the gate is: a motion about a place that it never was at would look wide.
        let tilts = turns.clone().map(|(v, _)| view.flat(&v.cross(&view.shaft)));
        let spread = tilts.map(|t| t * t.transpose()).sum::<Matrix2<f64>>() / count;
        let (mut cells, mut now) = (0, Vector2::zeros());
        for (v, w) in turns {
            now = view.handle(&v, w);
            cells |= 1 << cell(now, needed_rad);
        }
        Some(Self {
            reach_rad: reaches(&spread, coverage.cone_rad()),
            reached_rad: coverage.cone_rad(),
            needed_rad,
            cells,
            now_rad: now.into(),
            up: view.up,
        })
    }

    /// A spinning about the shaft, in the same way.
    pub fn spin<F: Frame>(
        rotations: impl Iterator<Item = Rotation> + Clone,
        shaft: Direction<F>,
        needed_rad: f64,
    ) -> Option<Self> {
        let reached_rad = Coverage::<F>::of(rotations.clone())?.principal[0].angle_rad;
        let (view, quaternions) = (View::along(shaft), rotations.map(|r| Vector4::from(r.quaternion())));
        let mean = mean(quaternions.clone())?;
        let (mut cells, mut now) = (0, 0.0);
        for q in quaternions {
            // q and -q are the same turn: the one by less than a round is meant.
            let (s, c) = (turn(&mean, &q).dot(&view.shaft), mean.dot(&q));
            now = 2.0 * (s * c.signum()).atan2(c.abs());
            let round = (now / std::f64::consts::TAU + 0.5).rem_euclid(1.0);
            cells |= 1 << ((round * TURN_CELLS as f64) as usize).min(TURN_CELLS - 1);
        }
        Some(Self {
            reach_rad: [SHORT * reached_rad; SECTORS],
            reached_rad,
            needed_rad,
            cells,
            now_rad: [now, 0.0],
            up: view.up,
        })
    }
}

/// A look along the shaft from the handle, in the marker's frame.
struct View {
    shaft: Vector3<f64>,
    right: Vector3<f64>,
    top: Vector3<f64>,
    up: usize,
}

impl View {
    fn along<F: Frame>(shaft: Direction<F>) -> Self {
        let shaft = Vector3::from(shaft.components());
        // The marker's axis that lies most across the shaft: 54 degrees from it at least.
        let up = shaft.iamin();
        let across = Vector3::from_fn(|i, _| f64::from(u8::from(i == up)));
        let top = (across - shaft * shaft[up]).try_normalize(0.0).unwrap_or(across);
        Self {
            shaft,
            right: shaft.cross(&top),
            top,
            up,
        }
    }

    fn flat(&self, v: &Vector3<f64>) -> Vector2<f64> {
        Vector2::new(v.dot(&self.right), v.dot(&self.top))
    }

    /// Where the handle points from the tip after the turn with the vector `v` and the number `w`: the angle from the mean, rad, in its
    /// direction.
    fn handle(&self, v: &Vector3<f64>, w: f64) -> Vector2<f64> {
        // The turned shaft, by the quaternion's formula.
        let cross = v.cross(&self.shaft);
        let turned = self.shaft + (cross * w + v.cross(&cross)) * 2.0;
        let aside = -self.flat(&turned);
        let length = aside.norm();
        let angle = length.atan2(turned.dot(&self.shaft));
        if length > 0.0 { aside * (angle / length) } else { aside }
    }
}

/// The least reach over each sector: at one of its ends, or where the least of all is, if that lies in it.
fn reaches(spread: &Matrix2<f64>, cone_rad: f64) -> [f64; SECTORS] {
    let (half, slant) = (0.5 * (spread[(0, 0)] - spread[(1, 1)]), spread[(0, 1)]);
    let (middle, swing) = (0.5 * spread.trace(), half.hypot(slant));
    // d^T spread d = middle + swing cos(2 (phi - widest)) for the direction of angle phi.
    let widest = 0.5 * slant.atan2(half);
    let reach = |square: f64| 4.0 * square.clamp(0.0, 1.0).sqrt().asin();
    let at = |phi: f64| middle + swing * (2.0 * (phi - widest)).cos();
    let wide = std::f64::consts::TAU / SECTORS as f64;
    std::array::from_fn(|k| {
        let phi = wide * k as f64;
        let pi = std::f64::consts::PI;
        // From the sector's middle to the least, which both directions of a line have.
        let off = (widest + 0.5 * pi - phi + 0.5 * pi).rem_euclid(pi) - 0.5 * pi;
        let least = match off.abs() <= 0.5 * wide {
            // Rounding may put this above the second eigenvalue of the whole.
            true => reach(middle - swing).min(cone_rad),
            false => reach(at(phi - 0.5 * wide).min(at(phi + 0.5 * wide))),
        };
        SHORT * least
    })
}

fn cell(at: Vector2<f64>, needed_rad: f64) -> usize {
    let ring = (4.0 * at.norm() / needed_rad.max(f64::MIN_POSITIVE)) as usize;
    let round = (at.y.atan2(at.x) / std::f64::consts::TAU).rem_euclid(1.0);
    let sector = (round * SECTORS as f64).round() as usize % SECTORS;
    ring.min(RINGS - 1) * SECTORS + sector
}
