//! Residuals and covariance of a pivot calibration.

use fit::robust::{biweight, biweight_slope};
use geometry::{Frame, Point};
use nalgebra::{Matrix3, Matrix3x6, Matrix6, Vector3};

use super::linear::{Problem, State};
use super::noise::{PoseNoise, Spread};
use super::robust::Noise;
use super::step::Corrected;
use super::{Method, Options, Pivot};
use crate::coverage::Coverage;

/// Parameters fitted, in poses: six of three components each.
const FITTED_POSES: f64 = 2.0;

/// A solution before it is described.
pub(super) struct Solved {
    pub(super) state: State,
    pub(super) weights: Vec<f64>,
    /// `s^2` of every pose where weights were found.
    pub(super) squares: Option<Vec<f64>>,
    pub(super) scale: f64,
    /// The poses of weight above zero do not determine a tip.
    pub(super) singular: bool,
}

impl Solved {
    pub(super) fn unweighted(state: State, poses: usize) -> Self {
        Self {
            state,
            weights: vec![1.0; poses],
            squares: None,
            scale: 1.0,
            singular: false,
        }
    }
}

/// Describes a solution.
pub(super) fn result<To: Frame, From: Frame>(
    problem: &Problem,
    solved: &Solved,
    coverage: Coverage<From>,
    covariance: Option<Matrix6<f64>>,
    options: &Options,
) -> Pivot<To, From> {
    let State { tip, pivot } = solved.state;
    // Residuals of all poses, also of those left out: the worst are what a person looks for.
    let all: Vec<f64> = problem.poses.iter().map(|p| (p.r * tip + p.t - pivot).norm()).collect();
    let used = || {
        all.iter()
            .zip(&solved.weights)
            .filter(|(_, w)| **w > 0.0)
            .map(|(r, _)| *r)
    };
    let inliers = used().count();
    let rms_mm = (used().map(|r| r * r).sum::<f64>() / inliers as f64).sqrt();
    let point = |v: Vector3<f64>| (v.x, v.y, v.z);
    let (tip_mm, pivot_mm) = (point(tip), point(pivot + problem.centre));
    Pivot {
        method: options.method,
        tip: Point::new(tip_mm.0, tip_mm.1, tip_mm.2),
        pivot: Point::new(pivot_mm.0, pivot_mm.1, pivot_mm.2),
        weights: solved.weights.clone(),
        inliers,
        rms_mm,
        rms_scalar_mm: rms_mm / 3.0_f64.sqrt(),
        rms_all_mm: (all.iter().map(|r| r * r).sum::<f64>() / all.len() as f64).sqrt(),
        worst_mm: used().fold(0.0, f64::max),
        residuals_mm: all,
        // Numbers that have overflowed make no covariance.
        covariance: covariance.filter(|c| c.iter().all(|x| x.is_finite())),
        noise_ratio: solved.squares.as_ref().map(|_| solved.scale),
        condition: problem.condition(),
        estimated: estimated(problem, solved, options),
        coverage,
    }
}

/// By the method.
pub(super) fn covariance(problem: &Problem, solved: &Solved, options: &Options) -> Option<Matrix6<f64>> {
    match options.method {
        Method::Algebraic => algebraic(problem, solved, options),
        Method::TwoStep | Method::Sphere => None,
        Method::Robust => weighted(
            problem,
            solved,
            &PoseNoise {
                sigma_rad: 0.0,
                ..options.noise
            },
        ),
        Method::ErrorsInVariables => weighted(problem, solved, &options.noise),
    }
}

/// Of the M-estimator: `scale^2 mean(w^2 s^2 / 3) / mean(slope)^2 (sum J^T S^-1 J)^-1` over the inliers (Huber 1981,
/// chapter 6), times `n / (n - 2)` for what was fitted.
pub(super) fn weighted<N: Noise>(problem: &Problem, solved: &Solved, noise: &N) -> Option<Matrix6<f64>> {
    let squares = solved.squares.as_ref()?;
    let inside: Vec<f64> = solved.weights.iter().map(|w| f64::from(u8::from(*w > 0.0))).collect();
    let (mut pull, mut turn, mut n) = (0.0, 0.0, 0.0);
    for (s, inside) in squares.iter().zip(&inside) {
        pull += inside * biweight(*s).powi(2) * s / 3.0;
        turn += inside * biweight_slope(*s, 3.0);
        n += inside;
    }
    // Once only: the same factor is in scale^2 and, as its reciprocal, in the squares that `pull` is made of.
    let freedom = n / (n - FITTED_POSES);
    let factor = solved.scale.powi(2) * freedom * (pull / n) / (turn / n).powi(2);
    // With weights of 1 or 0: how far Tukey's weights lose precision is in `pull` and `turn` already.
    let normal = noise.normal(problem, &solved.state, &inside);
    Some(normal.matrix.cholesky()?.inverse() * factor)
}

/// Of linear least squares under the noise `S`: `H^-1 (sum J^T S J) H^-1`, `H = sum J^T J`, scaled by the residuals.
fn algebraic(problem: &Problem, solved: &Solved, options: &Options) -> Option<Matrix6<f64>> {
    let spread = Spread::new(&options.noise, &solved.state.tip);
    let (mut h, mut b, mut squares) = (Matrix6::zeros(), Matrix6::zeros(), 0.0);
    for pose in &problem.poses {
        let mut j = Matrix3x6::zeros();
        j.fixed_view_mut::<3, 3>(0, 0).copy_from(&pose.r);
        j.fixed_view_mut::<3, 3>(0, 3).copy_from(&-Matrix3::identity());
        let y = pose.r * solved.state.tip;
        h += j.transpose() * j;
        b += j.transpose() * spread.covariance(&y) * j;
        squares += spread.square(&y, &(y + pose.t - solved.state.pivot));
    }
    // Chi-square over its freedom: only the ratio of the two noises has to be right.
    let scale = squares / (3.0 * (problem.poses.len() as f64 - FITTED_POSES));
    let inverse = h.cholesky()?.inverse();
    Some(inverse * b * inverse * scale)
}

/// The two noises from the components of the inliers' residuals along the lever and across it.
fn estimated(problem: &Problem, solved: &Solved, options: &Options) -> PoseNoise {
    let state = &solved.state;
    let spread = Spread::new(&options.noise, &state.tip);
    let length = state.tip.norm();
    let (mut along, mut across, mut n) = (0.0, 0.0, 0.0);
    for (pose, _) in problem.poses.iter().zip(&solved.weights).filter(|(_, w)| **w > 0.0) {
        // Along the corrected lever: along the measured one a turned lever leaves nothing to first order either, but
        // the residual of a wide error would leak into it.
        let corrected = Corrected::new(pose, state, &spread);
        // A tip at the marker's origin has no lever: then all of the residual counts as across.
        let direction = corrected.lever.try_normalize(0.0).unwrap_or_default();
        let part = direction.dot(&corrected.residual).powi(2);
        along += part;
        // Two components are across.
        across += 0.5 * (corrected.residual.norm_squared() - part);
        n += 1.0;
    }
    let (along, across) = (along / (n - FITTED_POSES), across / (n - FITTED_POSES));
    // st^2 + sr^2 |y|^2 across, st^2 along: the difference is the rotation's part, below zero by chance where it is
    // small.
    let turn = (across - along).max(0.0);
    PoseNoise {
        sigma_mm: along.sqrt(),
        sigma_rad: if length > 0.0 { turn.sqrt() / length } else { 0.0 },
    }
}
