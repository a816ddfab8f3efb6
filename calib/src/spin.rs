//! Spin calibration: the axis of a shaft in its marker, from poses of the marker while the instrument is spun about the
//! shaft, in a divot, in a bearing or between two fingers.
//!
//! Where the shaft keeps its direction, `R_i u = v` for the axis `u` in the marker and `v` in the tracker. Isotropic noise
//! of the rotations makes the likelihood `exp(-sum abs(R_i u - v)^2 / (2 sr^2))`, so that `v^T mean(R) u` is to be
//! largest: `u` and `v` are the first singular vectors of the mean matrix, `u` the least eigenvector of `mean((R - Rm)^T
//! (R - Rm))`. Noise shortens the mean matrix and does not turn it: there is no bias. With `rho` the resultant length of
//! the spin angles the covariance of `u` is `sr^2 / (N (1 - rho^2)) (I - u u^T)`.
//!
//! Where the axis keeps its place too, each pose puts a point `p` of it, taken across `u` from the marker's origin, at
//! the same place across `v`: a pivot in the plane, `z_i p + t_i = c` in complex numbers, `z_i` of norm 1.
//!
//! Poses at which the shaft slipped out of its bearing are forgotten by weights, first by the direction of the axis, then
//! of the others by its place; below eight poses all count.

mod error;
mod fit;
mod robust;
mod tool;

use geometry::{Direction, Frame, Point, Rigid, Vector};
use nalgebra::{Matrix3, Vector3};

use crate::coverage::Coverage;

use fit::{Directions, Places, completed, matrix, openness, turned};
use robust::settle;

pub use error::Refused;
pub use tool::{Tool, marker_from_tool};

/// The fewest poses.
const MIN_POSES: usize = 3;
/// The least share of the spread of an even turn.
const EVEN_SPREAD_SHARE: f64 = 0.9;
/// The least cosine between axis and hint: 85 degrees.
const LEAST_COSINE: f64 = 0.087_155_742_747_658_17;

/// What a calibration may be told.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// The least range of the turn, degrees.
    pub range_deg: f64,
    /// The largest root mean square angle of the axis to its mean direction in the tracker, degrees.
    pub wobble_deg: f64,
    /// Whether poses at which the shaft slipped are left out; else all count.
    pub robust: bool,
}

impl Default for Limits {
    /// 30 and 2 degrees, slipped poses left out.
    fn default() -> Self {
        Self {
            range_deg: 30.0,
            wobble_deg: 2.0,
            robust: true,
        }
    }
}

/// The axis with all that is known of its error. Lists have one entry per pose.
#[derive(Debug, Clone)]
pub struct Spin<To: Frame, From: Frame> {
    /// The axis in the marker, pointing along the hint.
    pub axis: Direction<From>,
    /// The mean direction of the axis in the tracker.
    pub axis_in_to: Direction<To>,
    /// The point of the axis nearest to the marker's origin, mm; of meaning where the axis kept its place.
    pub point: Point<From>,
    /// Angle of each pose's axis to the mean direction, rad.
    pub wobble_rad: Vec<f64>,
    /// Root mean square of these over the inliers, rad: divides by their number.
    pub wobble_rms_rad: f64,
    /// The weight in the axis' direction, 0 to 1: 0 for a pose at which the shaft slipped.
    pub weights: Vec<f64>,
    /// Poses of weight above zero.
    pub inliers: usize,
    /// The weight in the axis' place: 0 for a pose that slipped aside, and where `weights` is.
    pub place_weights: Vec<f64>,
    /// Poses whose place counts.
    pub place_inliers: usize,
    /// Distance across the axis of each pose's point from its mean place, mm.
    pub residuals_mm: Vec<f64>,
    /// Root mean square of these over the poses whose place counts, mm.
    pub rms_mm: f64,
    /// The range of the turn of the inliers, rad: a full turn less the widest gap.
    pub range_rad: f64,
    /// Covariance of the axis as a direction in the marker, rad^2; its null vector is the axis.
    pub axis_covariance: Matrix3<f64>,
    /// Covariance of the point in the marker, mm^2: across the axis by the residuals, along it by the axis' tilt.
    pub point_covariance: Matrix3<f64>,
    /// `1 / sqrt(1 - rho^2)`: error of the axis per error of the mean direction.
    pub condition: f64,
    /// The turns of the inliers about their mean.
    pub coverage: Coverage<From>,
}

impl<To: Frame, From: Frame> Spin<To, From> {
    /// Root mean square error of the axis by its covariance, rad.
    pub fn axis_error_rms_rad(&self) -> f64 {
        self.axis_covariance.trace().max(0.0).sqrt()
    }
}

/// Calibrates the axis from poses `to_from_from` of the marker `From` in the tracker `To`; of its two directions the one
/// along `hint` is taken, for instance from the marker to the tip.
///
/// # Errors
/// [`Refused`].
pub fn calibrate<To: Frame, From: Frame>(
    poses: &[Rigid<To, From>],
    hint: Direction<From>,
    limits: Limits,
) -> Result<Spin<To, From>, Refused> {
    let needed = MIN_POSES;
    let too_few = || Refused::TooFew {
        found: poses.len(),
        needed,
    };
    if poses.len() < MIN_POSES {
        return Err(too_few());
    }
    // Far below where squares overflow: what is beyond is no pose of anything.
    let bad = |p: &Rigid<To, From>| !p.translation_mm().iter().all(|x| x.abs() < 1e100);
    if let Some(pose) = poses.iter().position(bad) {
        let found = poses[pose].translation_mm();
        return Err(Refused::NotFinite { pose, found });
    }
    let axes = Axes::of(poses, hint, limits.robust)?;
    let kept = || poses.iter().zip(&axes.weights).filter(|(_, w)| **w > 0.0);
    let coverage = Coverage::of(kept().map(|(p, _)| p.rotation())).ok_or_else(too_few)?;
    // Only poses that count say how far it was turned: one that slipped would widen the range.
    let turns: Vec<Complex> = axes.inside().map(|(i, _)| axes.turns[i]).collect();
    let range_rad = range(&turns);
    axes.check(range_rad, &coverage, limits)?;
    axes.result(poses, range_rad, coverage, limits.robust)
}

type Complex = nalgebra::Complex<f64>;

/// The axis in both frames, and each pose as a turn about it.
struct Axes {
    u: Vector3<f64>,
    v: Vector3<f64>,
    /// Right-handed with `u`, and with `v`.
    across: [[Vector3<f64>; 2]; 2],
    turns: Vec<Complex>,
    wobble: Vec<f64>,
    weights: Vec<f64>,
    /// Of a component of the direction, rad^2, for the inliers with weight 1.
    variance: f64,
    /// Of the angle between `u` and the hint, of either sign.
    cosine: f64,
}

impl Axes {
    fn of<To: Frame, From: Frame>(
        poses: &[Rigid<To, From>],
        hint: Direction<From>,
        robust: bool,
    ) -> Result<Self, Refused> {
        let directions = Directions(poses.iter().map(matrix).collect());
        let settled = settle(&directions, robust)?;
        let (u, v) = settled.found;
        let cosine = u.dot(&Vector3::from(hint.components()));
        // The fit knows a line, not its direction: the hint says which way the axis points.
        let (u, v) = (u * cosine.signum(), v * cosine.signum());
        let across = [completed(&u), completed(&v)];
        let wobble = |r: &Matrix3<f64>| {
            let w = r * u;
            // Not the arc cosine, which has half the digits at angles near zero.
            w.cross(&v).norm().atan2(w.dot(&v))
        };
        Ok(Self {
            u,
            v,
            turns: directions.0.iter().map(|r| turned(r, &across)).collect(),
            wobble: directions.0.iter().map(wobble).collect(),
            across,
            weights: settled.weights,
            variance: settled.variance,
            cosine: cosine.abs(),
        })
    }

    /// The poses of weight above zero.
    fn inside(&self) -> impl Iterator<Item = (usize, f64)> + Clone {
        let weights = self.weights.iter().copied().enumerate();
        weights.filter(|(_, w)| *w > 0.0)
    }

    /// Refuses a motion that does not determine the axis.
    fn check<From: Frame>(&self, range_rad: f64, coverage: &Coverage<From>, limits: Limits) -> Result<(), Refused> {
        if limits.range_deg.is_nan() || range_rad.to_degrees() < limits.range_deg {
            return Err(Refused::SmallRange {
                axis: coverage.principal[0].axis.into(),
                found_deg: range_rad.to_degrees(),
                needed_deg: limits.range_deg,
            });
        }
        self.check_spread(range_rad, limits)?;
        let found_deg = self.wobble_rms().to_degrees();
        // A limit that is not a number lets nothing pass.
        if limits.wobble_deg.is_nan() || found_deg > limits.wobble_deg {
            let most_deg = limits.wobble_deg;
            return Err(Refused::Wobble { found_deg, most_deg });
        }
        if self.cosine < LEAST_COSINE {
            return Err(Refused::NoSign {
                axis: self.u.into(),
                angle_deg: self.cosine.acos().to_degrees(),
            });
        }
        Ok(())
    }

    /// Refuses a range that a few poses make: an even turn by `a` has `1 - rho^2 = 1 - (sin(a / 2) / (a / 2))^2`.
    fn check_spread(&self, range_rad: f64, limits: Limits) -> Result<(), Refused> {
        let open = openness(self.inside().map(|(i, _)| self.turns[i]));
        // At 0 the quotient would be 0 / 0; beyond a full turn an even turn is no more open.
        let half = limits.range_deg.to_radians().clamp(1e-3, std::f64::consts::TAU) / 2.0;
        if open >= EVEN_SPREAD_SHARE * (1.0 - (half.sin() / half).powi(2)) {
            return Ok(());
        }
        Err(Refused::Uneven {
            range_deg: range_rad.to_degrees(),
            // To the second order, below which it is where it is too small.
            even_deg: (12.0 * open).sqrt().to_degrees(),
            needed_deg: limits.range_deg,
        })
    }

    fn wobble_rms(&self) -> f64 {
        let squares: Vec<f64> = self.inside().map(|(i, _)| self.wobble[i].powi(2)).collect();
        (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
    }

    fn result<To: Frame, From: Frame>(
        self,
        poses: &[Rigid<To, From>],
        range_rad: f64,
        coverage: Coverage<From>,
        robust: bool,
    ) -> Result<Spin<To, From>, Refused> {
        let places = Places::of(&self, poses);
        let settled = settle(&places, robust)?;
        let (place, centre) = settled.found;
        let every = self.turns.iter().zip(poses);
        let residuals_mm = every.map(|(z, p)| (z * place + self.place_of(p) - centre).norm());
        let residuals_mm: Vec<f64> = residuals_mm.collect();
        let mut place_weights = vec![0.0; poses.len()];
        self.inside()
            .zip(&settled.weights)
            .for_each(|((i, _), w)| place_weights[i] = *w);
        let counted = || residuals_mm.iter().zip(&place_weights).filter(|(_, w)| **w > 0.0);
        let place_inliers = counted().count();
        let squares = counted().map(|(r, _)| r * r).sum::<f64>();
        let (inliers, open) = (
            self.inside().count(),
            openness(self.inside().map(|(i, _)| self.turns[i])),
        );
        let [[a, b], _] = &self.across;
        // `across` spans the plane through the marker's origin, so that this is the axis' nearest point to it.
        let point = a * place.re + b * place.im;
        let flat = Matrix3::identity() - self.u * self.u.transpose();
        // The directions are z_i u = v in the plane across: u has the variance of a slope in regression, variance / (N
        // (1 - rho^2)).
        let tilt = self.variance / (inliers as f64 * open);
        // A tilt of the axis carries its nearest point along it.
        let along = self.u * self.u.transpose() * (tilt * place.norm_sqr());
        let kept = (0..poses.len()).filter(|i| place_weights[*i] > 0.0);
        let spread = place_inliers as f64 * openness(kept.map(|i| self.turns[i]));
        let direction = |v: &Vector3<f64>| (v.x, v.y, v.z);
        let ((ux, uy, uz), (vx, vy, vz)) = (direction(&self.u), direction(&self.v));
        Ok(Spin {
            axis: Vector::new(ux, uy, uz).direction().ok_or(Refused::NoFrame)?,
            axis_in_to: Vector::new(vx, vy, vz).direction().ok_or(Refused::NoFrame)?,
            point: Point::new(point.x, point.y, point.z),
            wobble_rms_rad: self.wobble_rms(),
            wobble_rad: self.wobble,
            inliers,
            weights: self.weights,
            place_weights,
            place_inliers,
            rms_mm: (squares / place_inliers as f64).sqrt(),
            residuals_mm,
            range_rad,
            axis_covariance: flat * tilt,
            point_covariance: flat * (settled.variance / spread) + along,
            condition: 1.0 / open.sqrt(),
            coverage,
        })
    }

    /// The marker's origin across the axis.
    fn place_of<To, From>(&self, pose: &Rigid<To, From>) -> Complex {
        let [_, [c, d]] = &self.across;
        let t = Vector3::from(pose.translation_mm());
        Complex::new(t.dot(c), t.dot(d))
    }
}

/// The range of angles on the circle: a full turn less the widest gap.
fn range(turns: &[Complex]) -> f64 {
    let mut angles: Vec<f64> = turns.iter().map(|z| z.im.atan2(z.re)).collect();
    angles.sort_by(f64::total_cmp);
    let around = angles.first().zip(angles.last());
    // The gap over the end of the list, where angles go round from pi to -pi.
    let around = around.map_or(0.0, |(first, last)| first + std::f64::consts::TAU - last);
    let gaps = angles.windows(2).map(|w| w[1] - w[0]);
    std::f64::consts::TAU - gaps.fold(around, f64::max)
}
