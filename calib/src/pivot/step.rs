//! One Gauss-Newton step of the errors-in-variables problem, with each pose's own rotation error eliminated.
//!
//! The model: the true rotation is `exp(-e_i) R_i`, the true translation `t_i - d_i`, and all true poses put the tip `x`
//! at the pivot `c`. The most likely `x, c, e_i` minimise
//!
//! ```text
//! sum |t_i - c + exp(-e_i) R_i x|^2 / st^2 + |e_i|^2 / sr^2                                                      (1)
//! ```
//!
//! For given `x` and `c`, to first order `e = (sr^2 / across) y x r` with `y = R x`, `r = y + t - c`. About that `e`, with
//! `y' = exp(-e) y`, the residual of the linear problem is `r' = y' + t - c - y' x e`, its weight `S(y')^-1 = a I + b y'
//! y'^T` ([`Spread`]), and its Jacobian `(exp(-e) R, -I)`. That Jacobian is what removes the bias: with the measured `R`
//! in its place, the noise of `R` meets itself in the normal equations and pulls the tip to the marker. Since `(exp(-e)
//! R)^T y' = x`, the block of the tip is `a I + b x x^T` for every pose alike.

use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};

use super::linear::{Pose, Problem, State};
use super::noise::{PoseNoise, Spread};

/// A pose once its own rotation error is taken out.
#[derive(Debug, Clone, Copy)]
pub(super) struct Corrected {
    /// `-e`, rad.
    turn: Vector3<f64>,
    /// `y'`, mm.
    pub(super) lever: Vector3<f64>,
    /// `r'`, mm.
    pub(super) residual: Vector3<f64>,
}

/// `exp(turn) v` for a small `turn`, to `|turn|^3 / 6` of its length: below 1e-6 up to 0.018 rad, ten deviations of the
/// usual 0.1 degrees.
pub(super) fn turned(turn: &Vector3<f64>, v: &Vector3<f64>) -> Vector3<f64> {
    let once = turn.cross(v);
    v + once + turn.cross(&once) * 0.5
}

impl Corrected {
    #[inline]
    pub(super) fn new(pose: &Pose, state: &State, spread: &Spread) -> Self {
        let y = pose.r * state.tip;
        let apart = pose.t - state.pivot;
        let residual = y + apart;
        if spread.turn == 0.0 {
            let turn = Vector3::zeros();
            return Self {
                turn,
                lever: y,
                residual,
            };
        }
        // -e = -(sr^2 / across) y x r = (sr^2 / across) r x y.
        let turn = residual.cross(&y) * spread.turn;
        let lever = turned(&turn, &y);
        let residual = lever + apart + lever.cross(&turn);
        Self { turn, lever, residual }
    }

    /// `exp(-e) R`.
    fn rotation(&self, pose: &Pose, spread: &Spread) -> Matrix3<f64> {
        if spread.turn == 0.0 {
            return pose.r;
        }
        let cross = self.turn.cross_matrix();
        pose.r + cross * (pose.r + cross * pose.r * 0.5)
    }
}

/// Normal equations of (tip, pivot): mm.
#[derive(Debug, Clone, Copy)]
pub(super) struct Normal {
    pub(super) matrix: Matrix6<f64>,
    pub(super) vector: Vector6<f64>,
}

impl Normal {
    /// At `state`, each pose with the weight given.
    pub(super) fn new(problem: &Problem, state: &State, noise: &PoseNoise, weights: &[f64]) -> Self {
        let x = state.tip;
        let spread = Spread::new(noise, &x);
        let mut sums = Sums::default();
        for (pose, w) in problem.poses.iter().zip(weights) {
            if *w > 0.0 {
                sums.add(pose, &Corrected::new(pose, state, &spread), &spread, *w);
            }
        }
        sums.assembled(&x, &spread)
    }

    /// The step `(dx, dc)`, or `None` where singular.
    pub(super) fn step(&self) -> Option<Vector6<f64>> {
        Some(self.matrix.cholesky()?.solve(&-self.vector))
    }
}

/// The sums over poses of what differs between them.
#[derive(Default)]
struct Sums {
    weight: f64,
    rotation: Matrix3<f64>,
    lever: Vector3<f64>,
    outer: Matrix3<f64>,
    back: Vector3<f64>,
    along: f64,
    residual: Vector3<f64>,
    along_lever: Vector3<f64>,
}

impl Sums {
    #[inline]
    fn add(&mut self, pose: &Pose, corrected: &Corrected, spread: &Spread, w: f64) {
        let (y, r) = (&corrected.lever, &corrected.residual);
        let rotation = corrected.rotation(pose, spread);
        let along = w * y.dot(r);
        self.weight += w;
        self.rotation += rotation * w;
        self.lever += y * w;
        self.outer += y * y.transpose() * w;
        self.back += rotation.tr_mul(r) * w;
        self.along += along;
        self.residual += r * w;
        self.along_lever += y * along;
    }

    fn assembled(&self, x: &Vector3<f64>, spread: &Spread) -> Normal {
        let (a, b) = (spread.a, spread.b);
        let identity = Matrix3::identity() * (a * self.weight);
        // -sum w W R' with W = a I + b y' y'^T and y'^T R' = x^T; the blocks of tip and pivot are R'^T W R' and W.
        let mixed = -(self.rotation * a + self.lever * x.transpose() * b);
        let mut matrix = Matrix6::zeros();
        let tip = identity + x * x.transpose() * (b * self.weight);
        matrix.fixed_view_mut::<3, 3>(0, 0).copy_from(&tip);
        matrix.fixed_view_mut::<3, 3>(3, 0).copy_from(&mixed);
        matrix.fixed_view_mut::<3, 3>(0, 3).copy_from(&mixed.transpose());
        let pivot = identity + self.outer * b;
        matrix.fixed_view_mut::<3, 3>(3, 3).copy_from(&pivot);
        let mut vector = Vector6::zeros();
        let tip = self.back * a + x * (b * self.along);
        vector.fixed_rows_mut::<3>(0).copy_from(&tip);
        let pivot = -(self.residual * a + self.along_lever * b);
        vector.fixed_rows_mut::<3>(3).copy_from(&pivot);
        Normal { matrix, vector }
    }
}

/// The state a step further.
pub(super) fn moved(state: &State, step: &Vector6<f64>) -> State {
    State {
        tip: state.tip + step.fixed_rows::<3>(0),
        pivot: state.pivot + step.fixed_rows::<3>(3),
    }
}

/// The squares of all poses in units of their deviations.
pub(super) fn squares(problem: &Problem, state: &State, noise: &PoseNoise, squares: &mut [f64]) {
    let spread = Spread::new(noise, &state.tip);
    for (pose, square) in problem.poses.iter().zip(squares) {
        let corrected = Corrected::new(pose, state, &spread);
        *square = spread.square(&corrected.lever, &corrected.residual);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::{Marker, Rigid, Tracker, Vector};

    fn problem() -> Problem {
        let pose = |i: usize| {
            let a = i as f64;
            let turn = Vector::new(0.5 * a.cos(), 0.6 * (1.7 * a).sin(), 0.4 * (2.3 * a).cos());
            let t = Vector::new(10.0 * (3.1 * a).sin(), 20.0 * (0.9 * a).cos(), 5.0 * a.cos());
            Rigid::<Tracker, Marker>::from_rotation_vector(turn, t).unwrap()
        };
        Problem::new(&(0..8).map(pose).collect::<Vec<_>>())
    }

    const NOISE: PoseNoise = PoseNoise {
        sigma_mm: 0.1,
        sigma_rad: 0.003,
    };

    /// The inner minimum of (1) by Newton's method on `e`, to compare.
    fn profile(pose: &Pose, state: &State) -> f64 {
        let apart = pose.t - state.pivot;
        let y = pose.r * state.tip;
        // The best turn is in the plane of y and -apart: one angle, found by bisection of the derivative.
        let (wanted, length) = (-apart, y.norm());
        let between = y.cross(&wanted).norm().atan2(y.dot(&wanted));
        let slope = |angle: f64| {
            -length * wanted.norm() * (between - angle).sin() / NOISE.sigma_mm.powi(2) + angle / NOISE.sigma_rad.powi(2)
        };
        let (mut low, mut high) = (0.0, between);
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            if slope(middle) < 0.0 {
                low = middle
            } else {
                high = middle
            }
        }
        let square = length.powi(2) + wanted.norm_squared() - 2.0 * length * wanted.norm() * (between - low).cos();
        square / NOISE.sigma_mm.powi(2) + (low / NOISE.sigma_rad).powi(2)
    }

    /// Near the pivot, where residuals are of the size of the noise.
    fn near(problem: &mut Problem) -> State {
        let state = State {
            tip: Vector3::new(4.0, -3.0, 150.0),
            pivot: Vector3::new(1.0, 2.0, -1.0),
        };
        for (i, pose) in problem.poses.iter_mut().enumerate() {
            let a = i as f64;
            let off = Vector3::new(a.cos(), (2.0 * a).sin(), (3.0 * a).cos()) * 0.4;
            pose.t = state.pivot - pose.r * state.tip + off;
        }
        state
    }

    #[test]
    fn the_square_is_the_minimum_over_the_rotations_error() {
        let mut problem = problem();
        let state = near(&mut problem);
        let mut found = vec![0.0; 8];
        squares(&problem, &state, &NOISE, &mut found);
        for (pose, found) in problem.poses.iter().zip(found) {
            let expected = profile(pose, &state);
            // One step of Gauss-Newton from nothing: what it leaves is of the third order in residual / lever.
            let bound = 4.0 * (0.7_f64 / 150.0).powi(2);
            assert!((found / expected - 1.0).abs() < bound, "{found} {expected}");
        }
    }

    #[test]
    fn the_gradient_is_that_of_the_profile() {
        let mut problem = problem();
        let state = near(&mut problem);
        let normal = Normal::new(&problem, &state, &NOISE, &[1.0; 8]);
        let cost = |step: &Vector6<f64>| -> f64 {
            let state = moved(&state, step);
            problem.poses.iter().map(|p| profile(p, &state)).sum()
        };
        let largest = normal.vector.amax();
        for k in 0..6 {
            let h = 1e-4;
            let mut step = Vector6::zeros();
            step[k] = h;
            let slope = (cost(&step) - cost(&-step)) / (2.0 * h);
            // As above, beside the sum of terms that partly cancel; differences add h^2.
            assert!(
                (2.0 * normal.vector[k] - slope).abs() < 1e-3 * largest,
                "{k}: {slope} {}",
                normal.vector
            );
        }
    }

    #[test]
    fn the_matrix_is_the_sum_of_weighted_jacobians() {
        let mut problem = problem();
        let state = near(&mut problem);
        let normal = Normal::new(&problem, &state, &NOISE, &[1.0; 8]);
        let spread = Spread::new(&NOISE, &state.tip);
        let mut expected = Matrix6::zeros();
        for pose in &problem.poses {
            let corrected = Corrected::new(pose, &state, &spread);
            let mut j = nalgebra::Matrix3x6::zeros();
            j.fixed_view_mut::<3, 3>(0, 0)
                .copy_from(&corrected.rotation(pose, &spread));
            j.fixed_view_mut::<3, 3>(0, 3).copy_from(&-Matrix3::identity());
            let inverse = spread.covariance(&corrected.lever).try_inverse().unwrap();
            expected += j.transpose() * inverse * j;
        }
        // The turned rotation is good to the cube of an angle of 0.005.
        assert!((normal.matrix - expected).norm() < 1e-6 * expected.norm());
    }
}
