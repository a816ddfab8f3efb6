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
    let mut is_settled = false;
    for _ in 0..MAX_STEPS {
        let pulls = list
            .iter()
            .zip(&information)
            .map(|(u, i)| i * motion(&at, &u.transform()));
        let step = covariance * pulls.sum::<Vector6<f64>>();
        at = moved(&at, &step).ok_or(Refused::Singular { frame: 0 })?;
        // Far below any deviation.
        is_settled = step.dot(&(total * step)) <= 1e-20;
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
