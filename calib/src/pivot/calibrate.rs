//! The way from poses to a result.

use geometry::{Frame, Rigid, Uncertain};

use super::each::Each;
use super::linear::{Problem, State};
use super::method::{Method, Options};
use super::noise::PoseNoise;
use super::result::Pivot;
use super::robust::{Noise, settle};
use super::statistics::{Solved, covariance, result, weighted};
use super::{LEAST_CONE_DEG, Refused};
use crate::coverage::Coverage;

/// The fewest poses.
const MIN_POSES: usize = 3;
/// A motion whose widest principal angle is below this is noise, degrees.
const STILL_DEG: f64 = 0.5;
/// So many deviations of the rotations' noise is the second principal angle at least: one that is noise alone is twice its deviation,
/// and a sixteenth of the square of one that is just taken.
const NOISES: f64 = 8.0;
/// Where the first principal angle is this many times the second, the motion has one axis.
const ONE_AXIS: f64 = 4.0;

/// Calibrates tip and pivot from poses `to_from_from` of the marker `From` in the tracker `To`.
///
/// Errors of the result: to rounding, some 1e-13 of the lengths times the square of the condition number; by the noise,
/// the covariance in the result.
///
/// # Errors
/// [`Refused`].
pub fn calibrate<To: Frame, From: Frame>(
    poses: &[Rigid<To, From>],
    options: &Options,
) -> Result<Pivot<To, From>, Refused> {
    check(poses, &options.noise)?;
    // Before solving: equations that a motion leaves singular would only say that the method fails.
    covered(poses.iter())?;
    let problem = Problem::new(poses);
    let solved = solve(&problem, options)?;
    // And once more of those that agree: slipped poses may have made most of the motion.
    let coverage = agreeing(poses, &solved, options.method)?;
    let covariance = covariance(&problem, &solved, options);
    let found = result(&problem, &solved, coverage, covariance, options);
    if solved.squares.is_none() {
        // why: of a method that forgets no slip the residuals show the slips, and no noise.
        let judge = Options {
            method: Method::ErrorsInVariables,
            ..*options
        };
        return match calibrate::<To, From>(poses, &judge) {
            Ok(_) | Err(Refused::NoConsensus { .. }) => Ok(found),
            Err(refused) => Err(refused),
        };
    }
    turned(found)
}

/// Calibrates tip and pivot from poses with a covariance each, by errors-in-variables with weights that forget poses that
/// slipped. Only the ratios of the covariances count: their size is measured by the residuals and told as
/// [`Pivot::noise_ratio`]. The errors of different poses are taken as independent.
///
/// # Errors
/// [`Refused`], of these [`Refused::BadCovariance`].
pub fn calibrate_each<To: Frame, From: Frame>(poses: &[Uncertain<To, From>]) -> Result<Pivot<To, From>, Refused> {
    let plain: Vec<Rigid<To, From>> = poses.iter().map(Uncertain::transform).collect();
    // The noise comes with the poses, and `Each` checks it.
    check(&plain, &PoseNoise::default())?;
    covered(plain.iter())?;
    let problem = Problem::new(&plain);
    let noise = Each::new(poses, &problem)?;
    let method = Method::ErrorsInVariables;
    let solved = robust(&problem, &noise, method)?;
    let coverage = agreeing(&plain, &solved, method)?;
    let covariance = weighted(&problem, &solved, &noise);
    let options = Options {
        method,
        noise: noise.typical,
    };
    turned(result(&problem, &solved, coverage, covariance, &options))
}

/// A calibration whose second axis of turning is more than the noise of the rotations.
///
/// Noise counts as turning: of a hinge it is all that there is about a second axis, and the tip along the first is then made of noise, with a
/// covariance of first order that knows nothing of it.
fn turned<To: Frame, From: Frame>(found: Pivot<To, From>) -> Result<Pivot<To, From>, Refused> {
    let noise_deg = found.estimated.sigma_rad.to_degrees();
    let angles_deg = found.coverage.angles_deg();
    if angles_deg[1] >= NOISES * noise_deg {
        return Ok(found);
    }
    Err(Refused::Noise {
        missing: found.coverage.principal[1].axis.into(),
        angles_deg,
        noise_deg,
        least_deg: NOISES * noise_deg,
    })
}

/// The coverage by the poses of weight above zero, where it determines a tip.
fn agreeing<To, From: Frame>(
    poses: &[Rigid<To, From>],
    solved: &Solved,
    method: Method,
) -> Result<Coverage<From>, Refused> {
    let kept = poses.iter().zip(&solved.weights).filter(|(_, w)| **w > 0.0);
    let coverage = covered(kept.map(|(pose, _)| pose))?;
    if solved.singular {
        let method = method.name();
        return Err(Refused::MethodFails { method });
    }
    Ok(coverage)
}

fn check<To, From>(poses: &[Rigid<To, From>], noise: &PoseNoise) -> Result<(), Refused> {
    if poses.len() < MIN_POSES {
        let found = poses.len();
        return Err(Refused::TooFew {
            found,
            needed: MIN_POSES,
        });
    }
    if !noise.is_good() {
        let PoseNoise { sigma_mm, sigma_rad } = *noise;
        return Err(Refused::BadNoise { sigma_mm, sigma_rad });
    }
    // Squares of lengths must be finite too.
    let bad = |p: &Rigid<To, From>| !p.translation_mm().iter().all(|x| x.abs() < 1e100);
    match poses.iter().position(bad) {
        Some(pose) => Err(Refused::NotFinite {
            pose,
            found: poses[pose].translation_mm(),
        }),
        None => Ok(()),
    }
}

/// The coverage, where it determines a tip.
fn covered<'a, To: 'a, From: Frame>(
    poses: impl Iterator<Item = &'a Rigid<To, From>> + Clone,
) -> Result<Coverage<From>, Refused> {
    let too_few = Refused::TooFew {
        found: 0,
        needed: MIN_POSES,
    };
    let coverage = Coverage::of(poses.map(Rigid::rotation)).ok_or(too_few)?;
    let angles_deg = coverage.angles_deg();
    let [widest, second, _] = angles_deg;
    let missing = coverage.principal[1].axis.into();
    // Turns about one axis leave the tip free along it: the second widest axis decides.
    if second >= LEAST_CONE_DEG {
        return Ok(coverage);
    }
    // Which of the three mistakes it was, for the person at the tracker.
    if widest < STILL_DEG {
        return Err(Refused::NoRotation { angles_deg });
    }
    if widest > ONE_AXIS * second && widest >= LEAST_CONE_DEG {
        let axis = coverage.principal[0].axis.into();
        return Err(Refused::OneAxis {
            axis,
            missing,
            angles_deg,
        });
    }
    let least_deg = LEAST_CONE_DEG;
    Err(Refused::NarrowCone {
        missing,
        angles_deg,
        least_deg,
    })
}

fn solve(problem: &Problem, options: &Options) -> Result<Solved, Refused> {
    let method = options.method;
    let fails = Refused::MethodFails { method: method.name() };
    let all = |state: Option<State>| Ok(Solved::unweighted(state.ok_or(fails.clone())?, problem.poses.len()));
    let noise = match method {
        Method::Algebraic => return all(problem.algebraic()),
        Method::TwoStep => return all(problem.two_step()),
        Method::Sphere => return all(problem.sphere()),
        Method::Robust => PoseNoise {
            sigma_rad: 0.0,
            ..options.noise
        },
        Method::ErrorsInVariables => options.noise,
    };
    robust(problem, &noise, method)
}

/// By weights that forget poses that slipped.
fn robust<N: Noise>(problem: &Problem, noise: &N, method: Method) -> Result<Solved, Refused> {
    let fails = Refused::MethodFails { method: method.name() };
    let start = problem.algebraic().ok_or(fails)?;
    let settled = settle(problem, start, noise)?;
    let (found, poses) = (
        settled.weights.iter().filter(|w| **w > 0.0).count(),
        problem.poses.len(),
    );
    // A majority, as the scale is that of the better half of the residuals: any half agrees with itself.
    let needed = MIN_POSES.max(poses / 2 + 1);
    if found < needed {
        return Err(Refused::NoConsensus { found, poses, needed });
    }
    Ok(Solved {
        state: settled.state,
        weights: settled.weights,
        squares: Some(settled.squares),
        scale: settled.scale,
        singular: settled.singular,
    })
}
