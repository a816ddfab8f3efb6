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
    let mut at = list.first().ok_or(Refused::NoFrame)?.transform();
    let information = information(list)?;
    let total: Matrix6<f64> = information.iter().sum();
    let covariance = inverse(&total).ok_or(Refused::Singular { frame: 0 })?;
    for _ in 0..MAX_STEPS {
        let pulls = list
            .iter()
            .zip(&information)
            .map(|(u, i)| i * motion(&at, &u.transform()));
        let step = covariance * pulls.sum::<Vector6<f64>>();
        at = moved(&at, &step).ok_or(Refused::Singular { frame: 0 })?;
        // Far below any deviation.
        if step.dot(&(total * step)) <= 1e-20 {
            break;
        }
    }
    let chi_squared = |(u, i): (&Uncertain<To, From>, &Matrix6<f64>)| {
        let e = motion(&at, &u.transform());
        e.dot(&(i * e)).max(0.0)
    };
    let squares: Vec<f64> = list.iter().zip(&information).map(chi_squared).collect();
    still(&squares, gate)?;
    let freedom = 6.0 * (list.len() as f64 - 1.0);
    Ok(Mean {
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
    let scale = matrix.diagonal().map(|x| 1.0 / x.sqrt());
    let scale = Matrix6::from_diagonal(&scale);
    let scaled = scale * matrix * scale;
    // No digit is left of a correlation matrix whose least pivot is rounding.
    let factor = scaled.cholesky().filter(|c| c.l().diagonal().min() > 1e-7)?;
    Some(scale * factor.inverse() * scale)
}

/// Refuses the worst beyond the gate.
fn still(squares: &[f64], gate: f64) -> Result<(), Refused> {
    let worst = (0..squares.len()).max_by(|a, b| squares[*a].total_cmp(&squares[*b]));
    match worst {
        Some(frame) if squares[frame].sqrt() > gate => Err(Refused::Moved {
            frame,
            found: squares[frame].sqrt(),
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
