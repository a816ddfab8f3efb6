//! A registration with all that is known of its error.

use geometry::{Frame, Point, Rigid, Uncertain, UncertainPoint};
use nalgebra::{Matrix3, Matrix6, SMatrix, Vector3};

use super::{RegisterError, transform};
use crate::points::{Points, SharedError};
use crate::search::{Minimum, Searched};
use crate::solve::{Exact, Matrix8, Priors, Problem, Solver, State, UNKNOWNS, apart_mm, motion};

use super::margin::Costs;
use super::moved::{Halves, OrderCheck, halves};
use super::normal::held;
use super::parts::{Class, PointResult, inflation, kept, one};
use super::rows::Rows;
use super::second::{SecondSurface, second};
use super::sensitivity::{GrossError, Sensitivity, sensitivity};
use super::trend::{Linear, Trend, Trends, trends};

/// Another minimum.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Other<To: Frame, From: Frame> {
    /// The pose there.
    pub transform: Rigid<To, From>,
    /// By how much its cost is higher, squares of deviations: of the points that lie beside the surface in both poses alone, unless more
    /// than half of all are beyond an open border there.
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
    /// What was known of depth scale, offset and bone before.
    pub priors: Priors,
    /// Covariance of (w, v) in `To`, depth scale and offset: rad, mm, 1, mm.
    pub covariance: SMatrix<f64, 8, 8>,
    /// What one unit of each number of the points' shared error moves the true pose against this one by, in the convention of its
    /// covariance; zeros where none was told.
    pub shared: SMatrix<f64, 6, 6>,
    /// Each point, in the order in which they were given.
    pub points: Vec<PointResult>,
    /// Root of the mean square of residuals within three deviations over what the noise that was told makes of it: 1 where it is right.
    pub noise_ratio: f64,
    /// Deviation of the noise ratio of a right registration: it falls with the number of points.
    pub noise_ratio_sigma: f64,
    /// Share, of the points of which the surface says something, that lie within three deviations and have a say; such as were taken by a
    /// probe held still count as one, and those beyond an open border not at all.
    pub share_kept: f64,
    /// How many points that is.
    pub kept: f64,
    /// Share, of the points of which the surface says something, whose beam comes from inside the bone.
    pub share_facing_away: f64,
    /// Share of the points whose nearest place is an open border.
    pub share_beyond: f64,
    /// Cost, squares of deviations, points beyond an open border at the price of the others.
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
    /// Whether it could be looked at all whether the bone moved: without it `halves` being `None` says nothing.
    pub order: OrderCheck,
    /// How the pose goes with the order of the points; `None` where too few are left to say.
    pub drift: Option<Trend>,
    /// The side on which points lie outside of the bone, against the others; `None` where too few are left to say.
    pub side: Option<Trend>,
    /// Touched points that were left out near the bone, and how unlikely so many are; `None` where none of them is near.
    pub second: Option<SecondSurface>,
    /// The image of the middle of the points, mm, and their root mean square distance from it.
    pub(crate) centre: Vector3<f64>,
    pub(crate) radius_mm: f64,
    /// What each point costs.
    costs: Costs,
    /// What a gross error at the place of each point that has a say does at most.
    sensitivity: Vec<Sensitivity>,
    /// As `covariance`, but for the turn about the middle of the points and its shift, where the two hardly correlate.
    about_points: Matrix8,
}

/// 99.9 % of normal errors of six degrees of freedom have a smaller square.
const SAME_CHI2: f64 = 22.46;
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
    let noise = &best.ended.noise;
    let problem = solver.last(cloud, exact, noise);
    let (cost, at) = problem.sum(&state);
    let each: Vec<PointResult> = (0..cloud.len()).map(|i| one(&problem, i, &state)).collect();
    let free = free(solver);
    let rows = Rows::new(&problem, &state);
    let own = free * rows.matrix() * free;
    let matrix = own + at.known();
    let held = free * held(&matrix, cloud.radius_mm) * free;
    let fitted = (own * held).trace().clamp(0.0, UNKNOWNS as f64);
    let kept = kept(&each, &cloud.votes, fitted);
    let inflation = inflation(solver, &each, &cloud.votes, fitted);
    let answer = answer(&rows, points, &state, &held);
    let of_shared = |shared: &SharedError| answer * shared.covariance * answer.transpose();
    // Of one start alone nothing is judged, and twenty of them a second have no time to spare.
    let trends = match searched.seeds {
        0 => Trends::none(),
        _ => trends(&Linear {
            points,
            rows: &rows,
            state: &state,
            held: &held,
            known: free * at.known() * free,
            fitted,
            end: solver.end,
            side_mm: solver.priors.side_mm,
        }),
    };
    let covariance = held * inflation + trends.adds + points.shared().map_or_else(Matrix8::zeros, of_shared);
    let pose = transform(&state, points)?;
    let centre = Point::<To>::new(state.shift.x, state.shift.y, state.shift.z);
    let about: Matrix6<f64> = covariance.fixed_view::<6, 6>(0, 0).into_owned();
    let uncertain = Uncertain::from_covariance_about(centre, pose, about).map_err(|_| nowhere())?;
    let costs = Costs::of(solver, cloud, &best.ended, exact);
    let (mut others, mut hits) = (Vec::new(), best.hits);
    let inverse = about.cholesky().map(|c| c.inverse());
    let total: f64 = cloud.votes.iter().sum();
    let votes = |class: Class| {
        let own = each.iter().zip(&cloud.votes).filter(|(p, _)| p.class == class);
        // Of none the sum is -0.
        own.map(|(_, vote)| vote).sum::<f64>().max(0.0)
    };
    // Of those beyond an open border nothing is known: they neither fit nor do they not.
    let known = (total - votes(Class::Beyond)).max(f64::MIN_POSITIVE);
    for other in &searched.minima[1..] {
        // What lies within the error that is promised is no other answer: the same one, with another point left out.
        if inverse.is_some_and(|inverse| off(&other.ended.state, &state, &inverse) < SAME_CHI2) {
            hits += other.hits;
            continue;
        }
        others.push(Other {
            transform: transform(&other.ended.state, points)?,
            margin: costs.margin(&Costs::of(solver, cloud, &other.ended, exact)),
            apart_mm: apart_mm(&other.ended.state, &state, cloud.radius_mm),
            hits: other.hits,
        });
    }
    others.sort_by(|a: &Other<To, From>, b| a.margin.total_cmp(&b.margin));
    let second = second(cloud, &each);
    let (halves, order) = halves(solver, cloud, points.shared(), noise, &state);
    Ok(SurfaceRegistration {
        transform: uncertain,
        depth_scale: state.scale,
        offset_mm: state.offset,
        priors: *solver.priors,
        covariance: about_origin(&covariance, &state.shift),
        shared: (carry(&state.shift) * answer).fixed_rows::<6>(0).into_owned(),
        noise_ratio: kept.ratio,
        noise_ratio_sigma: kept.sigma,
        share_kept: kept.count / known,
        kept: kept.count,
        share_facing_away: votes(Class::FacesAway) / known,
        share_beyond: votes(Class::Beyond) / total,
        points: each,
        cost,
        steps: best.ended.steps,
        is_settled: best.ended.is_settled,
        others,
        seeds: searched.seeds,
        fits: searched.fits,
        hits,
        landmark_ratio: landmark_ratio(&problem, &state),
        halves,
        order,
        drift: trends.order,
        side: trends.side,
        second,
        centre: state.shift,
        radius_mm: cloud.radius_mm,
        costs,
        sensitivity: sensitivity(&rows, &problem, [&matrix, &free], solver.end),
        about_points: covariance,
    })
}

/// Square of the motion between two states in the deviations of the pose.
fn off(a: &State, b: &State, inverse: &Matrix6<f64>) -> f64 {
    let motion = motion(a, b);
    motion.dot(&(inverse * motion))
}

/// 1 for what is unknown, 0 for what is held.
fn free(solver: &Solver<'_>) -> Matrix8 {
    let mut free = Matrix8::identity();
    for (place, sigma) in [(6, solver.priors.depth_scale), (7, solver.priors.offset_mm)] {
        free[(place, place)] = f64::from(u8::from(sigma > 0.0));
    }
    free
}

/// What one unit of each number of the error that all points share moves the unknowns by: it moves every residual at once, and the fit
/// answers.
fn answer<From: Frame>(rows: &Rows, points: &Points<From>, state: &State, held: &Matrix8) -> SMatrix<f64, UNKNOWNS, 6> {
    let mut pull = SMatrix::<f64, UNKNOWNS, 6>::zeros();
    let Some(shared) = points.shared() else { return pull };
    for row in &rows.rows {
        let normal = row.slope.fixed_rows::<3>(3).transpose();
        pull += row.slope * (normal * state.turn * shared.levers[row.point]) * row.weight;
    }
    held * pull
}

/// From (w, v about the centre, ...) to (w, v about the origin, ...): v = v_c - w x c.
fn about_origin(covariance: &Matrix8, centre: &Vector3<f64>) -> Matrix8 {
    let carry = carry(centre);
    let c = carry * covariance * carry.transpose();
    (c + c.transpose()) * 0.5
}

/// The same of a small motion itself.
fn carry(centre: &Vector3<f64>) -> Matrix8 {
    let mut carry = Matrix8::identity();
    carry.fixed_view_mut::<3, 3>(3, 0).copy_from(&centre.cross_matrix());
    carry
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

    /// The gross error of one place that puts a target furthest off; `None` where none has a say.
    pub fn gross_error(&self, target: Point<To>) -> Option<GrossError> {
        let arm = Vector3::from(target.mm()) - self.centre;
        let each = self.sensitivity.iter().map(|own| own.at(&arm));
        each.max_by(|a, b| a.target_mm.total_cmp(&b.target_mm))
    }

    /// What another registration of the same points, or of their mirror images in the same order, costs more, squares of deviations: by the
    /// points that lie beside the surface in both alone, unless more than half of all are beyond an open border there.
    pub fn margin_over(&self, other: &Self) -> f64 {
        self.costs.margin(&other.costs)
    }

    pub(crate) fn covariance_about_points(&self) -> Matrix8 {
        self.about_points
    }

    /// By how much the cost of the nearest other minimum is higher; `None` where no other was found.
    pub fn margin(&self) -> Option<f64> {
        self.others.first().map(|other| other.margin)
    }
}
