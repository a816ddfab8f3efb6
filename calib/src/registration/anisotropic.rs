//! Registration of points whose noise has a direction: a covariance per pair.

use ::fit::{Damping, End, Limits, Step, least_squares};
use geometry::{Frame, Rigid};
use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};

use super::fit::place;
use super::quaternion::{Quaternion, matrix, unit};
use super::statistics::{moved_to_origin, skew};
use super::{Fit, Method, Pairs, Refused, fit};

/// Gauss-Newton steps; four are usual.
const MAX_STEPS: usize = 50;
/// A step below this, in radians and radii, ends the iteration.
const STEP_END: f64 = 1e-12;
/// More damping than this makes a step short however far the end is.
const MOST_AT_END: f64 = 0.1;

/// The transform of greatest likelihood.
#[derive(Debug, Clone, Copy)]
pub struct Anisotropic<To: Frame, From: Frame> {
    /// `to_from_from`.
    pub transform: Rigid<To, From>,
    /// `(J^T W J)^-1`: (rotation vector, translation) in `To`, rad and mm, turning about `To`'s origin; see
    /// [`super::Registration::covariance`] for the convention.
    pub covariance: Matrix6<f64>,
    /// Sum of the squared residuals in units of their deviations; about 3 N - 6 where the covariances are right.
    pub chi_squared: f64,
    /// Steps taken.
    pub steps: usize,
}

/// Registers pairs whose residuals `a_i - (R b_i + t)` have the covariances `covariances_mm2[i]`, in `To`, mm^2.
///
/// Minimises `sum r^T C^-1 r` by damped Gauss-Newton from the isotropic fit weighted by `3 / tr C`. Noise of
/// both sides is `C = Ca + R Cb R^T`; where `Cb` is not isotropic, take `R` from a first fit. Weights of the pairs are
/// ignored: they are in the covariances. Domain: clouds of 1e-50 to 1e50 mm.
///
/// # Errors
/// [`Refused::Unmatched`], [`Refused::BadCovariance`], [`Refused::NoConvergence`], and those of [`fit()`].
pub fn register_anisotropic<To: Frame, From: Frame>(
    pairs: Pairs<'_, To, From>,
    covariances_mm2: &[Matrix3<f64>],
) -> Result<Anisotropic<To, From>, Refused> {
    let information = inverses(covariances_mm2, pairs.len())?;
    // The inverse of the mean variance over the axes: the isotropic noise nearest to C. It only has to start near the
    // end.
    let weights: Vec<f64> = covariances_mm2.iter().map(|c| 3.0 / c.trace()).collect();
    let pairs = Pairs::new(pairs.to, pairs.from)?.weighted(&weights)?;
    let start = fit(pairs, Method::Newton)?;
    let problem = Problem::new(&start, pairs, &information);
    let state = State {
        q: start.transform.quaternion(),
        shift: Vector3::zeros(),
    };
    let end = least_squares(&problem, state, Damping::GAUSS_NEWTON, Limits::steps(MAX_STEPS));
    match end {
        Some(end) if end.end == End::Last => problem.result(&start, &end.state, end.steps),
        end => Err(Refused::NoConvergence {
            steps: end.as_ref().map_or(0, |end| end.steps),
            last: end.map_or(f64::INFINITY, |end| end.length),
        }),
    }
}

fn inverses(covariances: &[Matrix3<f64>], pairs: usize) -> Result<Vec<Matrix3<f64>>, Refused> {
    if covariances.len() != pairs {
        return Err(Refused::Unmatched {
            what: "covariances",
            found: covariances.len(),
            pairs,
        });
    }
    let inverse = |(pair, c): (usize, &Matrix3<f64>)| {
        // A Cholesky factor is made from the lower triangle alone, so that it takes no notice of asymmetry.
        // `amax` passes over a NaN, which may stand in the upper triangle only.
        let even = c.iter().all(|x| x.is_finite()) && (c - c.transpose()).amax() <= 1e-12 * c.amax();
        let factor = c.cholesky().filter(|_| even);
        factor.map(|f| f.inverse()).ok_or(Refused::BadCovariance { pair })
    };
    covariances.iter().enumerate().map(inverse).collect()
}

/// A rotation, and a shift of the centre of `To`.
#[derive(Clone, Copy)]
struct State {
    q: Quaternion,
    shift: Vector3<f64>,
}

/// Both clouds about their centres.
struct Problem<'a> {
    points: Vec<[Vector3<f64>; 2]>,
    information: &'a [Matrix3<f64>],
    radius: f64,
}

impl<'a> Problem<'a> {
    fn new<To, From>(start: &Fit<To, From>, pairs: Pairs<'_, To, From>, information: &'a [Matrix3<f64>]) -> Self {
        let m = &start.moments;
        let both = pairs.to.iter().zip(pairs.from);
        let points = both.map(|(a, b)| [m.centred(0, *a), m.centred(1, *b)]).collect();
        Self {
            points,
            information,
            radius: m.energy[0].sqrt() / m.scale[0],
        }
    }

    /// `sum r^T W r`.
    fn cost(&self, state: &State) -> f64 {
        let r = matrix(&state.q);
        let term = |([a, b], w): (&[Vector3<f64>; 2], &Matrix3<f64>)| {
            let residual = a - r * b - state.shift;
            residual.dot(&(w * residual))
        };
        self.points.iter().zip(self.information).map(term).sum()
    }

    /// `J^T W J` and `J^T W r`, `J = (-[R b']x, I)`.
    fn normal(&self, state: &State) -> (Matrix6<f64>, Vector6<f64>) {
        let r = matrix(&state.q);
        let (mut matrix, mut vector) = (Matrix6::zeros(), Vector6::zeros());
        for ([a, b], w) in self.points.iter().zip(self.information) {
            let y = r * b;
            // Turning on about the moved centre makes y + w x y = y - [y]x w of the image y, hence the sign in J.
            let residual = a - y - state.shift;
            let mut j = nalgebra::Matrix3x6::zeros();
            j.fixed_view_mut::<3, 3>(0, 0).copy_from(&-skew(&y));
            j.fixed_view_mut::<3, 3>(0, 3).copy_from(&Matrix3::identity());
            let weighted = j.transpose() * w;
            matrix += weighted * j;
            vector += weighted * residual;
        }
        (matrix, vector)
    }

    fn result<To: Frame, From: Frame>(
        &self,
        start: &Fit<To, From>,
        state: &State,
        steps: usize,
    ) -> Result<Anisotropic<To, From>, Refused> {
        // At the end itself, after the last step: the equations of the iteration are those before it.
        let (normal, _) = self.normal(state);
        let inverse = normal.cholesky().map(|c| c.inverse());
        let inverse = inverse.ok_or_else(|| Refused::MethodFails(start.singular_values()))?;
        // t carries the centre of `From` to that of `To` plus the shift; the covariance is about the same point.
        let centre = start.moments.mean(0) + state.shift;
        let t = centre - matrix(&state.q) * start.moments.mean(1);
        Ok(Anisotropic {
            transform: place(state.q, t)?,
            covariance: moved_to_origin(inverse, &centre),
            chi_squared: self.cost(state),
            steps,
        })
    }
}

impl ::fit::Problem for Problem<'_> {
    type State = State;
    /// Left side and right side, from where a step is made.
    type At = Option<(Matrix6<f64>, Vector6<f64>)>;

    fn look(&self, state: &State) -> Option<(f64, Self::At)> {
        Some((self.cost(state), None))
    }

    fn prepare(&self, state: &State, at: &mut Self::At, _steps: usize) -> bool {
        *at = Some(self.normal(state));
        true
    }

    fn step(&self, state: &State, at: &Self::At, damping: f64) -> Option<Step<State>> {
        let (matrix, vector) = at.as_ref()?;
        let mut damped = *matrix;
        // Marquardt's scaling: in proportion to the diagonal the damping has no unit, for radians and mm alike.
        damped.set_diagonal(&(matrix.diagonal() * (1.0 + damping)));
        let step = damped.cholesky()?.solve(vector);
        Some(Step {
            to: moved(state, &step),
            // Both in radii: a turn of w moves points at the radius by w radii.
            length: step.fixed_rows::<3>(0).norm() + step.fixed_rows::<3>(3).norm() / self.radius,
            // Of an undamped step N d = g the model falls by 2 d^T g - d^T N d = d^T g.
            gain: step.dot(vector),
        })
    }

    /// At the end the cost is flat to rounding and may not fall any more.
    fn is_last(&self, step: &Step<State>, _: &Self::At, damping: f64) -> bool {
        step.length <= STEP_END && damping <= MOST_AT_END
    }
}

/// `exp(w) R` and the shift plus `v`, for a step `(w, v)` about the moved centre.
fn moved(state: &State, step: &Vector6<f64>) -> State {
    // (1, w / 2) times q, normalised: right to second order in w, and steps end near zero.
    let half = step.fixed_rows::<3>(0) * 0.5;
    let [w, x, y, z] = state.q;
    let v = Vector3::new(x, y, z);
    let turned = v + half * w + half.cross(&v);
    State {
        q: unit([w - half.dot(&v), turned.x, turned.y, turned.z]),
        shift: state.shift + step.fixed_rows::<3>(3),
    }
}
