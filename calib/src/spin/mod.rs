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

mod error;
mod tool;

use geometry::{Direction, Frame, Point, Rigid, Vector};
use nalgebra::{Matrix3, Vector3};

use crate::coverage::Coverage;
use crate::registration::jacobi::symmetric3;

pub use error::Refused;
pub use tool::{Tool, marker_from_tool};

/// The fewest poses.
const NEEDED: usize = 3;
/// The least cosine between axis and hint: 85 degrees.
const LEAST_COSINE: f64 = 0.087_155_742_747_658_17;

/// What a calibration may be told.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// The least range of the turn, degrees.
    pub range_deg: f64,
    /// The largest root mean square angle of the axis to its mean direction in the tracker, degrees.
    pub wobble_deg: f64,
}

impl Default for Limits {
    /// 30 and 2 degrees.
    fn default() -> Self {
        Self {
            range_deg: 30.0,
            wobble_deg: 2.0,
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
    /// Root mean square of these, rad: divides by the number of poses.
    pub wobble_rms_rad: f64,
    /// Distance across the axis of each pose's point from its mean place, mm.
    pub residuals_mm: Vec<f64>,
    /// Root mean square of these, mm.
    pub rms_mm: f64,
    /// The range of the turn, rad: a full turn less the widest gap.
    pub range_rad: f64,
    /// Covariance of the axis as a direction in the marker, rad^2; its null vector is the axis.
    pub axis_covariance: Matrix3<f64>,
    /// Covariance of the point in the marker, mm^2: across the axis by the residuals, along it by the axis' tilt.
    pub point_covariance: Matrix3<f64>,
    /// `1 / sqrt(1 - rho^2)`: error of the axis per error of the mean direction.
    pub condition: f64,
    /// The turns about their mean.
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
    let needed = NEEDED;
    let too_few = || Refused::TooFew {
        found: poses.len(),
        needed,
    };
    if poses.len() < NEEDED {
        return Err(too_few());
    }
    let bad = |p: &Rigid<To, From>| !p.translation_mm().iter().all(|x| x.abs() < 1e100);
    if let Some(pose) = poses.iter().position(bad) {
        let found = poses[pose].translation_mm();
        return Err(Refused::NotFinite { pose, found });
    }
    let coverage = Coverage::of(poses.iter().map(Rigid::rotation)).ok_or_else(too_few)?;
    let axes = Axes::of(poses, hint)?;
    let range_rad = range(&axes.turns);
    axes.check(range_rad, &coverage, limits)?;
    axes.result(poses, range_rad, coverage).ok_or(Refused::NoFrame)
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
    /// Of the angle between `u` and the hint, of either sign.
    cosine: f64,
}

fn matrix<To, From>(pose: &Rigid<To, From>) -> Matrix3<f64> {
    let rows = pose.rotation().matrix().rows();
    Matrix3::from_fn(|i, j| rows[i][j])
}

/// Two unit vectors that make a right-handed frame with `axis`.
fn completed(axis: &Vector3<f64>) -> [Vector3<f64>; 2] {
    let other = Matrix3::identity().column(axis.iamin()).into_owned();
    let first = other.cross(axis).try_normalize(0.0).unwrap_or_else(Vector3::x);
    [first, axis.cross(&first)]
}

impl Axes {
    fn of<To: Frame, From: Frame>(poses: &[Rigid<To, From>], hint: Direction<From>) -> Result<Self, Refused> {
        let rotations: Vec<Matrix3<f64>> = poses.iter().map(matrix).collect();
        let mean = rotations.iter().sum::<Matrix3<f64>>() / poses.len() as f64;
        let spread = rotations.iter().map(|r| (r - mean).transpose() * (r - mean));
        let (values, vectors) = symmetric3(spread.sum());
        let u: Vector3<f64> = vectors.column(values.imin()).into_owned();
        let cosine = u.dot(&Vector3::from(hint.components()));
        let u = u * cosine.signum();
        let v = (mean * u).try_normalize(0.0).ok_or(Refused::NoFrame)?;
        let across = [completed(&u), completed(&v)];
        let [[a, b], [c, d]] = &across;
        let turn = |r: &Matrix3<f64>| {
            let (ra, rb) = (r * a, r * b);
            let z = Complex::new(ra.dot(c) + rb.dot(d), ra.dot(d) - rb.dot(c));
            z / z.norm().max(f64::MIN_POSITIVE)
        };
        let wobble = |r: &Matrix3<f64>| {
            let w = r * u;
            w.cross(&v).norm().atan2(w.dot(&v))
        };
        let (turns, wobble) = (
            rotations.iter().map(turn).collect(),
            rotations.iter().map(wobble).collect(),
        );
        Ok(Self {
            u,
            v,
            across,
            turns,
            wobble,
            cosine: cosine.abs(),
        })
    }

    /// Refuses a motion that does not determine the axis.
    fn check<From: Frame>(&self, range_rad: f64, coverage: &Coverage<From>, limits: Limits) -> Result<(), Refused> {
        if range_rad.to_degrees() < limits.range_deg {
            return Err(Refused::SmallRange {
                axis: coverage.principal[0].axis.into(),
                found_deg: range_rad.to_degrees(),
                needed_deg: limits.range_deg,
            });
        }
        let found_deg = self.wobble_rms().to_degrees();
        if found_deg > limits.wobble_deg {
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

    fn wobble_rms(&self) -> f64 {
        let squares = self.wobble.iter().map(|w| w * w).sum::<f64>();
        (squares / self.wobble.len() as f64).sqrt()
    }

    fn result<To: Frame, From: Frame>(
        self,
        poses: &[Rigid<To, From>],
        range_rad: f64,
        coverage: Coverage<From>,
    ) -> Option<Spin<To, From>> {
        let n = poses.len() as f64;
        let (open, place, residuals) = self.place(poses);
        let [[a, b], _] = &self.across;
        let point = a * place.re + b * place.im;
        let squares = residuals.iter().map(|r| r * r).sum::<f64>();
        let flat = Matrix3::identity() - self.u * self.u.transpose();
        // Two components a pose; four numbers were fitted, to directions and to places alike.
        let freedom = 2.0 * n - 4.0;
        let tilt = self.wobble_rms().powi(2) * n / freedom / (n * open);
        // A tilt of the axis carries its nearest point along it.
        let along = self.u * self.u.transpose() * (tilt * place.norm_sqr());
        Some(Spin {
            axis: Vector::new(self.u.x, self.u.y, self.u.z).direction()?,
            axis_in_to: Vector::new(self.v.x, self.v.y, self.v.z).direction()?,
            point: Point::new(point.x, point.y, point.z),
            wobble_rms_rad: self.wobble_rms(),
            wobble_rad: self.wobble,
            rms_mm: (squares / n).sqrt(),
            residuals_mm: residuals,
            range_rad,
            axis_covariance: flat * tilt,
            point_covariance: flat * (squares / freedom / (n * open)) + along,
            condition: 1.0 / open.sqrt(),
            coverage,
        })
    }

    /// `1 - rho^2`, the point across the axis, and the residuals.
    fn place<To, From>(&self, poses: &[Rigid<To, From>]) -> (f64, Complex, Vec<f64>) {
        let n = poses.len() as f64;
        let [_, [c, d]] = &self.across;
        let places = poses.iter().map(|p| {
            let t = Vector3::from(p.translation_mm());
            Complex::new(t.dot(c), t.dot(d))
        });
        let places: Vec<Complex> = places.collect();
        let mean = |list: &[Complex]| list.iter().sum::<Complex>() / n;
        let (turn, centre) = (mean(&self.turns), mean(&places));
        let pairs = || self.turns.iter().zip(&places).map(|(z, t)| (z - turn, t - centre));
        let open = pairs().map(|(z, _)| z.norm_sqr()).sum::<f64>() / n;
        let place = -pairs().map(|(z, t)| z.conj() * t).sum::<Complex>() / (n * open);
        let residuals = pairs().map(|(z, t)| (z * place + t).norm()).collect();
        (open, place, residuals)
    }
}

/// The range of angles on the circle: a full turn less the widest gap.
fn range(turns: &[Complex]) -> f64 {
    let mut angles: Vec<f64> = turns.iter().map(|z| z.im.atan2(z.re)).collect();
    angles.sort_by(f64::total_cmp);
    let around = angles.first().zip(angles.last());
    let around = around.map_or(0.0, |(first, last)| first + std::f64::consts::TAU - last);
    let gaps = angles.windows(2).map(|w| w[1] - w[0]);
    std::f64::consts::TAU - gaps.fold(around, f64::max)
}
