//! A registration with all that is known of its error.

use geometry::{Frame, Point, Rigid, Uncertain, UncertainPoint};
use nalgebra::{Matrix3, Matrix6, SMatrix, Vector3, Vector6};

use super::{RegisterError, transform};
use crate::kernel::tukey_variance;
use crate::points::Points;
use crate::search::{Minimum, Searched};
use crate::solve::{Exact, Matrix8, Problem, Solver, State, UNKNOWNS, apart_mm};

use super::moved::{Halves, halves};
use super::rows::Rows;

/// What became of a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Class {
    /// It has a say.
    Kept,
    /// Left out: it lies outside of the bone, where soft tissue echoes.
    InFront,
    /// Left out: it lies inside of the bone.
    Behind,
    /// Left out: its beam comes from inside the bone.
    FacesAway,
    /// Left out: the bone nearest to it is an open border of the surface, beyond which nothing is known.
    Beyond,
}

/// One point's part in a registration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointResult {
    /// Its distance to the surface with the offset taken off, mm: above 0 outside.
    pub residual_mm: f64,
    /// The same in its own deviations along the normal.
    pub deviations: f64,
    /// What it counts, 0 to 1.
    pub weight: f64,
    /// What became of it.
    pub class: Class,
}

/// Another minimum.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Other<To: Frame, From: Frame> {
    /// The pose there.
    pub transform: Rigid<To, From>,
    /// By how much its cost is higher, squares of deviations.
    pub margin: f64,
    /// How far it is from the result, mm: root mean square over a ball of the points' radius.
    pub apart_mm: f64,
    /// Fits of the search that ended there.
    pub hits: usize,
}

/// A registration of points to a surface.
#[derive(Debug, Clone)]
pub struct SurfaceRegistration<To: Frame, From: Frame> {
    /// The pose, with the covariance of its error in the convention of [`geometry::uncertain`].
    pub transform: Uncertain<To, From>,
    /// By what share depths are too long.
    pub depth_scale: f64,
    /// By how much the true bone lies outside of the surface, mm.
    pub offset_mm: f64,
    /// Covariance of (w, v) in `To`, depth scale and offset: rad, mm, 1, mm.
    pub covariance: SMatrix<f64, 8, 8>,
    /// Each point, in the order in which they were given.
    pub points: Vec<PointResult>,
    /// Root of the mean square of residuals within three deviations over what the noise that was told makes of it: 1 where it is right.
    pub noise_ratio: f64,
    /// Deviation of the noise ratio of a right registration: it falls with the number of points.
    pub noise_ratio_sigma: f64,
    /// Share of the points that lie within three deviations and have a say, such as were taken by a probe held still as one.
    pub share_kept: f64,
    /// How many points that is.
    pub kept: f64,
    /// Share of the points with a beam whose beam comes from inside the bone.
    pub share_facing_away: f64,
    /// Share of the points whose nearest place is an open border.
    pub share_beyond: f64,
    /// Cost, squares of deviations.
    pub cost: f64,
    /// Steps of the last fit.
    pub steps: usize,
    /// Whether the last fit settled.
    pub is_settled: bool,
    /// The other minima that were found, the least first.
    pub others: Vec<Other<To, From>>,
    /// Seeds that were scored; 0 where nothing was searched.
    pub seeds: usize,
    /// Fits from the best of them.
    pub fits: usize,
    /// Fits that ended at this result.
    pub hits: usize,
    /// Mean square of landmarks' misses over what their errors say; `None` without landmarks.
    pub landmark_ratio: Option<f64>,
    /// The two parts of the sweep, in the order of the points, that differ most as two poses; `None` where nothing goes with the order.
    pub halves: Option<Halves>,
    /// The image of the middle of the points, mm, and their root mean square distance from it.
    pub(crate) centre: Vector3<f64>,
    pub(crate) radius_mm: f64,
    /// As `covariance`, but for the turn about the middle of the points and its shift, where the two hardly correlate.
    about_points: Matrix8,
}

/// Residuals beyond so many deviations are not those of the noise.
const KEPT: f64 = 3.0;
/// The mean square of a normal residual that is within three deviations.
const MEAN_SQUARE: f64 = 0.973_34;
/// 99.9 % of normal errors of six degrees of freedom have a smaller square.
const SAME_CHI2: f64 = 22.46;
/// Deviation, mm, of what nothing holds.
pub(crate) const FREE_MM: f64 = 1000.0;

impl Searched {
    /// Of one start alone.
    pub(super) fn of_one(ended: crate::solve::Ended) -> Self {
        Self {
            minima: vec![Minimum { ended, hits: 1 }],
            seeds: 0,
            fits: 1,
        }
    }
}

pub(super) fn result<To: Frame, From: Frame>(
    solver: &Solver<'_>,
    exact: &Exact<'_>,
    points: &Points<From>,
    searched: Searched,
) -> Result<SurfaceRegistration<To, From>, RegisterError> {
    let cloud = &points.cloud;
    let nowhere = || RegisterError::Nowhere { seeds: searched.seeds };
    let best = searched.minima.first().ok_or_else(nowhere)?;
    let state = best.ended.state;
    let noise = solver.exact_noise(cloud, exact, &state);
    let problem = solver.last(cloud, exact, &noise);
    let (cost, at) = problem.sum(&state);
    let each: Vec<PointResult> = (0..cloud.len()).map(|i| one(&problem, i, &state)).collect();
    let free = free(solver);
    let rows = Rows::new(&problem, &state);
    let own = free * rows.matrix() * free;
    let held = free * held(&(own + at.known()), cloud.radius_mm) * free;
    let fitted = (own * held).trace().clamp(0.0, UNKNOWNS as f64);
    let kept = kept(&each, &cloud.votes, fitted);
    let inflation = inflation(solver, &each, &cloud.votes, fitted);
    let covariance = held * inflation + shared(&rows, points, &state, &held);
    let pose = transform(&state, points)?;
    let centre = Point::<To>::new(state.shift.x, state.shift.y, state.shift.z);
    let about: Matrix6<f64> = covariance.fixed_view::<6, 6>(0, 0).into_owned();
    let uncertain = Uncertain::from_covariance_about(centre, pose, about).map_err(|_| nowhere())?;
    let (mut others, mut hits) = (Vec::new(), best.hits);
    let inverse = about.cholesky().map(|c| c.inverse());
    for other in &searched.minima[1..] {
        // What lies within the error that is promised is no other answer: the same one, with another point left out.
        if inverse.is_some_and(|inverse| off(&other.ended.state, &state, &inverse) < SAME_CHI2) {
            hits += other.hits;
            continue;
        }
        others.push(Other {
            transform: transform(&other.ended.state, points)?,
            margin: other.ended.cost - best.ended.cost,
            apart_mm: apart_mm(&other.ended.state, &state, cloud.radius_mm),
            hits: other.hits,
        });
    }
    let total: f64 = cloud.votes.iter().sum();
    let share = |class: Class| {
        let own = each.iter().zip(&cloud.votes).filter(|(p, _)| p.class == class);
        own.map(|(_, vote)| vote).sum::<f64>() / total
    };
    Ok(SurfaceRegistration {
        transform: uncertain,
        depth_scale: state.scale,
        offset_mm: state.offset,
        covariance: about_origin(&covariance, &state.shift),
        noise_ratio: kept.ratio,
        noise_ratio_sigma: kept.sigma,
        share_kept: kept.count / total,
        kept: kept.count,
        share_facing_away: share(Class::FacesAway),
        share_beyond: share(Class::Beyond),
        points: each,
        cost,
        steps: best.ended.steps,
        is_settled: best.ended.is_settled,
        others,
        seeds: searched.seeds,
        fits: searched.fits,
        hits,
        landmark_ratio: landmark_ratio(&problem, &state),
        halves: halves(solver, cloud, points.shared(), &noise, &state),
        centre: state.shift,
        radius_mm: cloud.radius_mm,
        about_points: covariance,
    })
}

/// By how much the covariance exceeds the inverse of the weighted normal equations.
pub(super) fn inflation(solver: &Solver<'_>, each: &[PointResult], votes: &[f64], fitted: f64) -> f64 {
    let ratio = kept(each, votes, fitted).ratio;
    let told = tukey_variance(solver.end) * ratio.max(1.0).powi(2);
    told.max(scattered(each, votes, solver.end, fitted))
}

/// Square of the motion between two states in the deviations of the pose.
fn off(a: &State, b: &State, inverse: &Matrix6<f64>) -> f64 {
    let motion = motion(a, b);
    motion.dot(&(inverse * motion))
}

/// The motion from `b` to `a`: rotation vector, and shift of the points' centre.
pub(super) fn motion(a: &State, b: &State) -> Vector6<f64> {
    let turn = a.turn * b.turn.transpose();
    // The vector of a rotation up to its angle over its sine: a distance of 90 degrees and more is no small error of anything.
    let skew = Vector3::new(
        turn[(2, 1)] - turn[(1, 2)],
        turn[(0, 2)] - turn[(2, 0)],
        turn[(1, 0)] - turn[(0, 1)],
    ) * 0.5;
    let scale = if turn.trace() > 1.0 {
        1.0
    } else {
        std::f64::consts::PI / skew.norm().max(1e-3)
    };
    let (w, v) = (skew * scale, a.shift - b.shift);
    Vector6::new(w.x, w.y, w.z, v.x, v.y, v.z)
}

pub(super) fn one(problem: &Problem<'_, Exact<'_>>, i: usize, state: &State) -> PointResult {
    let (s, slope, has_say) = problem.residual(i, state);
    let (_, weight) = problem.kernel.at(s * s);
    let n = Vector3::new(slope[3], slope[4], slope[5]);
    let faces = n.dot(&(state.turn * problem.cloud.beams[i])) <= problem.facing.unwrap_or(1.0) * n.norm();
    let class = match (has_say, faces) {
        (false, false) => Class::FacesAway,
        (false, true) => Class::Beyond,
        _ if weight > 0.0 => Class::Kept,
        _ if s > 0.0 => Class::InFront,
        _ => Class::Behind,
    };
    PointResult {
        residual_mm: s / problem.sharp[i],
        deviations: s,
        weight: if has_say { weight * problem.cloud.votes[i] } else { 0.0 },
        class,
    }
}

/// The inverse of normal equations; what nothing holds has the deviation [`FREE_MM`].
///
/// Turns are counted in mm at the points' radius, so that a direction of all eight unknowns has one unit.
fn held(matrix: &Matrix8, radius_mm: f64) -> Matrix8 {
    let unit = units(radius_mm);
    let eigen = (unit * matrix * unit).symmetric_eigen();
    let least = FREE_MM.powi(-2);
    let inverse = eigen.eigenvalues.map(|value| 1.0 / value.max(least));
    unit * (eigen.eigenvectors * Matrix8::from_diagonal(&inverse) * eigen.eigenvectors.transpose()) * unit
}

/// 1 for what is unknown, 0 for what is held.
fn free(solver: &Solver<'_>) -> Matrix8 {
    let mut free = Matrix8::identity();
    for (place, sigma) in [(6, solver.priors.depth_scale), (7, solver.priors.offset_mm)] {
        free[(place, place)] = f64::from(u8::from(sigma > 0.0));
    }
    free
}

/// From mm at the points to rad, mm, share at a depth of 50 mm, mm.
fn units(radius_mm: f64) -> Matrix8 {
    let r = 1.0 / radius_mm;
    Matrix8::from_diagonal(&[r, r, r, 1.0, 1.0, 1.0, 0.02, 1.0].into())
}

/// What the residuals within three deviations say of the noise.
struct Kept {
    count: f64,
    ratio: f64,
    sigma: f64,
}

fn kept(each: &[PointResult], votes: &[f64], fitted: f64) -> Kept {
    let (mut count, mut squares) = (0.0, 0.0);
    for (point, vote) in each.iter().zip(votes) {
        if point.class == Class::Kept && point.deviations.abs() <= KEPT {
            count += vote;
            squares += vote * point.deviations * point.deviations;
        }
    }
    let freedom = MEAN_SQUARE * count - fitted;
    // Without anything left over nothing is known of the noise.
    let (ratio, sigma) = if freedom > 0.5 {
        ((squares / freedom).sqrt(), (0.5 / freedom).sqrt())
    } else {
        (f64::INFINITY, f64::INFINITY)
    };
    Kept { count, ratio, sigma }
}

/// By how much the variance exceeds the inverse of the weighted normal equations, by the residuals themselves (Huber 1981, section 6.6):
/// gross errors that lie near the surface have a say, and scatter the result more than the noise that was told does.
fn scattered(each: &[PointResult], votes: &[f64], end: f64, fitted: f64) -> f64 {
    let (mut count, mut squares, mut slope, mut weights) = (0.0, 0.0, 0.0, 0.0);
    for (point, vote) in each.iter().zip(votes).filter(|(point, _)| point.class == Class::Kept) {
        let share = (point.deviations / end).powi(2);
        let left = (1.0 - share).max(0.0);
        count += vote;
        squares += vote * (left * left * point.deviations).powi(2);
        slope += vote * (left * left - 4.0 * left * share);
        weights += vote * left * left;
    }
    let freedom = count - fitted;
    if freedom <= 0.5 || slope <= 0.0 {
        // The count of points refuses this; as the error of nothing it is large.
        return FREE_MM;
    }
    count / freedom * squares * weights / (slope * slope)
}

/// What the error that all points share adds: it moves every residual at once, and the fit answers.
fn shared<From: Frame>(rows: &Rows, points: &Points<From>, state: &State, held: &Matrix8) -> Matrix8 {
    let Some(shared) = points.shared() else {
        return Matrix8::zeros();
    };
    let mut pull = SMatrix::<f64, UNKNOWNS, 6>::zeros();
    for row in &rows.rows {
        let normal = row.slope.fixed_rows::<3>(3).transpose();
        pull += row.slope * (normal * state.turn * shared.levers[row.point]) * row.weight;
    }
    let answer = held * pull;
    answer * shared.covariance * answer.transpose()
}

/// From (w, v about the centre, ...) to (w, v about the origin, ...): v = v_c - w x c.
fn about_origin(covariance: &Matrix8, centre: &Vector3<f64>) -> Matrix8 {
    let mut carry = Matrix8::identity();
    carry.fixed_view_mut::<3, 3>(3, 0).copy_from(&centre.cross_matrix());
    let c = carry * covariance * carry.transpose();
    (c + c.transpose()) * 0.5
}

fn landmark_ratio(problem: &Problem<'_, Exact<'_>>, state: &State) -> Option<f64> {
    let misses = problem.anchors.iter().map(|anchor| {
        let off = state.turn * anchor.from + state.shift - anchor.to;
        off.norm_squared() / (3.0 * anchor.sigma_mm * anchor.sigma_mm)
    });
    (!problem.anchors.is_empty()).then(|| misses.sum::<f64>() / problem.anchors.len() as f64)
}

impl<To: Frame, From: Frame> SurfaceRegistration<To, From> {
    /// A target of the bone's frame with the covariance of where the registration shows it.
    pub fn at(&self, target: Point<To>) -> UncertainPoint<To> {
        self.transform * (self.transform.transform().inverse() * target)
    }

    /// Root mean square target registration error predicted at `target`, mm.
    pub fn predicted_tre_mm(&self, target: Point<To>) -> f64 {
        let c: Matrix3<f64> = self.at(target).covariance();
        c.trace().sqrt()
    }

    pub(crate) fn covariance_about_points(&self) -> Matrix8 {
        self.about_points
    }

    /// By how much the cost of the nearest other minimum is higher; `None` where no other was found.
    pub fn margin(&self) -> Option<f64> {
        self.others.first().map(|other| other.margin)
    }
}
