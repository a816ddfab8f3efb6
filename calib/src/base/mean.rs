//! The mean of transforms that were measured several times, each with its covariance.
//!
//! With `e_i` the small motion from the mean `X` to the i-th (as in [`geometry::uncertain`]) and `C_i` its covariance,
//! the mean of greatest likelihood minimises `sum e_i^T C_i^-1 e_i`; its covariance is `(sum C_i^-1)^-1`.

use geometry::motion::Motion;
use geometry::{Frame, Rigid, Uncertain};
use nalgebra::{Matrix6, Vector6};

use super::Refused;

/// A mean with what it says of its parts.
#[derive(Debug, Clone)]
pub struct Mean<To: Frame, From: Frame> {
    /// The mean, and the covariance that those given make.
    pub mean: Uncertain<To, From>,
    /// The root of chi-square over its degrees of freedom: about 1 where the covariances given are right. NaN for a
    /// single one.
    pub ratio: f64,
    /// The distance of each from the mean, deviations: the root of its chi-square, of six degrees of freedom.
    pub deviations: Vec<f64>,
}

/// Steps; three are usual.
const MAX_STEPS: usize = 30;
/// So many are made in any case: what they leave falls by the size of the motions, in radians, with each.
const LEAST_STEPS: usize = 3;
/// A step of so few deviations ends the iteration.
const STEP_END: f64 = 1e-10;
/// Roundings in a component of a motion: two products of quaternions, a logarithm and a turned place take fewer.
const ROUNDINGS: f64 = 32.0;

/// The mean of transforms whose errors are independent.
///
/// # Errors
/// [`Refused::NoFrame`] for none, [`Refused::Singular`], [`Refused::Moved`] where one is more than `gate` deviations off
/// (six are passed by one in 300 000), [`Refused::Covariance`].
pub fn mean<To: Frame, From: Frame>(list: &[Uncertain<To, From>], gate: f64) -> Result<Mean<To, From>, Refused> {
    // Any of them will do: they differ by some deviations, and the iteration forgets where it began.
    let mut at = list.first().ok_or(Refused::NoFrame)?.transform();
    let information = information(list)?;
    let total: Matrix6<f64> = information.iter().sum();
    // The Jacobian of e_i by a motion of the mean is -1 but for terms of the size of e_i, so that the normal matrix is
    // the same in every step.
    let covariance = inverse(&total).ok_or(Refused::Singular { frame: 0 })?;
    let reach_mm = list
        .iter()
        .map(|u| u.transform().translation().norm())
        .fold(0.0, f64::max);
    let mut is_settled = false;
    for count in 1..=MAX_STEPS {
        let motions: Vec<Vector6<f64>> = list.iter().map(|u| motion(&at, &u.transform())).collect();
        let pulls = motions.iter().zip(&information).map(|(e, i)| i * e);
        let step = covariance * pulls.sum::<Vector6<f64>>();
        at = moved(&at, &step).ok_or(Refused::Singular { frame: 0 })?;
        // Far below any deviation; of very exact frames no step is shorter than rounding makes it.
        let least = STEP_END.max(rounding(&motions, &information, (&covariance, reach_mm)));
        // Far away, and of frames as exact as that, rounding may be many deviations: no first step says that there is none left.
        is_settled = count >= LEAST_STEPS && step.dot(&(total * step)) <= least * least;
        if is_settled {
            break;
        }
    }
    if !is_settled {
        return Err(Refused::NoConvergence { steps: MAX_STEPS });
    }
    let chi_squared = |(u, i): (&Uncertain<To, From>, &Matrix6<f64>)| {
        let e = motion(&at, &u.transform());
        let square = e.dot(&(i * e));
        // Rounding may leave a square below zero, and its root would be NaN. A NaN stays one: `max` would make it 0, as if
        // this transform lay on the mean.
        if square < 0.0 { 0.0 } else { square }
    };
    let squares: Vec<f64> = list.iter().zip(&information).map(chi_squared).collect();
    still(&squares, gate)?;
    let freedom = 6.0 * (list.len() as f64 - 1.0);
    Ok(Mean {
        // The scaled inverse is symmetric to rounding only.
        mean: Uncertain::new(at, (covariance + covariance.transpose()) * 0.5)?,
        ratio: (squares.iter().sum::<f64>() / freedom).sqrt(),
        deviations: squares.iter().map(|x| x.sqrt()).collect(),
    })
}

/// The length in deviations, `sqrt(s^T C^-1 s)`, of the step `s = C sum C_i^-1 e_i` that rounding alone can make.
///
/// With `u = 2^-52`: a motion `e_i` between transforms whose places are up to `reach_mm` away is off by up to `d = 32 u` rad and
/// `32 u reach_mm` mm, and a sum of n products of six terms by `(n + 32) u` of its terms. So the sum is off by up to
///
/// ```text
/// p = sum |C_i^-1| ((n + 32) u |e_i| + d),   and   sqrt(p^T C p) <= sum p_k sqrt(C_kk)
/// ```
///
/// component by component, the last as `C` is semidefinite. At 2300 mm and 0.005 mm of noise in each of 180 frames of a marker of
/// 50 mm that is some 2e-5; at 1e4 mm and 1e-6 mm of noise it is more than a deviation, and says only that no step is known better.
fn rounding(
    motions: &[Vector6<f64>],
    information: &[Matrix6<f64>],
    (covariance, reach_mm): (&Matrix6<f64>, f64),
) -> f64 {
    let turn = ROUNDINGS * f64::EPSILON;
    let shift = turn * reach_mm;
    let off = Vector6::new(turn, turn, turn, shift, shift, shift);
    let sums = (motions.len() as f64 + ROUNDINGS) * f64::EPSILON;
    let pull = |(e, i): (&Vector6<f64>, &Matrix6<f64>)| i.abs() * (e.abs() * sums + off);
    let pulls: Vector6<f64> = motions.iter().zip(information).map(pull).sum();
    pulls.dot(&covariance.diagonal().map(f64::sqrt))
}

fn information<To: Frame, From: Frame>(list: &[Uncertain<To, From>]) -> Result<Vec<Matrix6<f64>>, Refused> {
    let of = |(frame, u): (usize, &Uncertain<To, From>)| inverse(&u.covariance()).ok_or(Refused::Singular { frame });
    list.iter().enumerate().map(of).collect()
}

/// The inverse of a covariance or an information, scaled by its diagonal first: turns and lengths differ by powers of ten.
fn inverse(matrix: &Matrix6<f64>) -> Option<Matrix6<f64>> {
    // A variance of zero scales by infinity, and the factor of what follows does not exist.
    let scale = matrix.diagonal().map(|x| 1.0 / x.sqrt());
    let scale = Matrix6::from_diagonal(&scale);
    let scaled = scale * matrix * scale;
    // No digit is left of a correlation matrix whose least pivot is rounding.
    let factor = scaled.cholesky().filter(|c| c.l().diagonal().min() > 1e-7)?;
    Some(scale * factor.inverse() * scale)
}

/// Refuses the worst beyond the gate.
fn still(squares: &[f64], gate: f64) -> Result<(), Refused> {
    let of = |frame: usize| squares[frame].sqrt();
    // NaN is the worst of all, whatever its sign, and a gate that is none lets nothing pass.
    let size = |frame: usize| if of(frame).is_nan() { f64::INFINITY } else { of(frame) };
    match (0..squares.len()).max_by(|a, b| size(*a).total_cmp(&size(*b))) {
        Some(frame) if gate.is_nan() || size(frame) > gate => Err(Refused::Moved {
            frame,
            found: of(frame),
            frames: squares.len(),
            gate,
        }),
        _ => Ok(()),
    }
}

/// `(w, v)` with `other = exp(w) at + v`.
fn motion<To, From>(at: &Rigid<To, From>, other: &Rigid<To, From>) -> Vector6<f64> {
    let Motion { turn: w, shift: v } = at.motion_to(other);
    Vector6::new(w.x, w.y, w.z, v.x, v.y, v.z)
}

/// `exp(w) at + v`.
fn moved<To, From>(at: &Rigid<To, From>, step: &Vector6<f64>) -> Option<Rigid<To, From>> {
    at.moved_by(&Motion {
        turn: step.fixed_rows::<3>(0).into(),
        shift: step.fixed_rows::<3>(3).into(),
    })
}

#[cfg(test)]
mod tests {
    use geometry::{Marker, Point, Tracker, Vector};

    use super::*;

    /// Nearly normal numbers of deviation 1: sums of twelve even ones.
    fn normals(mut state: u64) -> impl FnMut() -> f64 {
        move || {
            let mut even = || {
                state = state
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1_442_695_040_888_963_407);
                (state >> 11) as f64 / (1_u64 << 53) as f64
            };
            (0..12).map(|_| even()).sum::<f64>() - 6.0
        }
    }

    /// Frames of a marker of 50 mm radius so far away, with this noise, that state it, but for 1e-6 mm where they have none.
    fn frames(truth: &Rigid<Tracker, Marker>, sigma_mm: f64, count: usize) -> Vec<Uncertain<Tracker, Marker>> {
        let mut normal = normals(7 + count as u64);
        let stated = sigma_mm.max(1e-6);
        let [x, y, z] = truth.translation_mm();
        let at = Point::new(x, y, z);
        let variances = Vector6::new(1.0 / 50.0, 1.0 / 50.0, 1.0 / 50.0, 1.0, 1.0, 1.0).map(|s| (s * stated).powi(2));
        let mut one = || {
            let [a, b, c, d, e, f] = [0; 6].map(|_| sigma_mm * normal());
            let turn = Rigid::<Tracker, Tracker>::from_rotation_vector(
                Vector::new(a, b, c) * (1.0 / 50.0),
                Vector::new(0.0, 0.0, 0.0),
            );
            let turned = turn.unwrap().rotation() * truth.rotation();
            let pose = Rigid::from_parts(turned, Vector::new(x + d, y + e, z + f));
            Uncertain::from_covariance_about(at, pose, Matrix6::from_diagonal(&variances)).unwrap()
        };
        (0..count).map(|_| one()).collect()
    }

    /// Frames of 0.005 mm at 2300 mm were refused: no step was below 1e-10 deviations, which is less than rounding.
    #[test]
    fn very_exact_frames_far_away_settle() {
        let turn = Vector::new(0.4, -1.1, 2.0);
        for sigma_mm in [0.0, 1e-6, 0.005] {
            for far in [0.0, 2300.0, 1e4] {
                for count in [1, 2, 180, 2000] {
                    let truth =
                        Rigid::from_rotation_vector(turn, Vector::new(0.3 * far, -0.4 * far, 0.866 * far)).unwrap();
                    let list = frames(&truth, sigma_mm, count);
                    let case = format!("{sigma_mm} mm at {far} mm, {count} frames");
                    let found = mean(&list, 8.0).unwrap_or_else(|refused| panic!("{case}: {refused}"));
                    let off = motion(&found.mean.transform(), &truth);
                    let inverse = inverse(&found.mean.covariance()).unwrap();
                    // Chi-squared of six degrees of freedom is beyond 40 one time in two million; rounding adds less than a deviation.
                    let square = off.dot(&(inverse * off));
                    assert!(square < 40.0, "{case}: {square}");
                    if sigma_mm == 0.0 {
                        // The frames are all alike: the mean is one of them, to the roundings of `rounding`, sqrt(n) times as many
                        // deviations of the mean as of a frame.
                        let roundings = 32.0 * f64::EPSILON * (1.0 + far);
                        assert!(
                            found.deviations.iter().all(|d| *d < 1e6 * 64.0 * roundings + 1e-9),
                            "{case}: {found:?}"
                        );
                    } else if count > 100 {
                        // 6 n - 6 degrees of freedom: the root of the mean square is known to a share of sqrt(1 / (12 n)).
                        let share = 5.0 / (12.0 * count as f64).sqrt();
                        assert!((found.ratio - 1.0).abs() < share, "{case}: {}", found.ratio);
                    }
                }
            }
        }
    }
}
