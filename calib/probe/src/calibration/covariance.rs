//! The covariance of a fit: noise, what frames share, and what is known before.

use nalgebra::{DMatrix, DVector, SMatrix};

use crate::error::ProbeError;
use crate::free;
use crate::solve::{Ended, Poses, Solver};

/// Covariance of all unknowns, and what it rests on.
pub(super) struct Covariance {
    pub(super) all: DMatrix<f64>,
    /// Root of the residuals' mean square in the deviations told.
    pub(super) noise_ratio: f64,
    /// By how much the frames' pulls vary more than independent ones would: 1 where they are independent.
    pub(super) frame_correlation: f64,
}

/// Blocks that the frames are put into, in their order, for their correlation: neighbours in time share what noise
/// is slow.
const BLOCKS: usize = 16;

pub(super) fn of(solver: &Solver<'_>, ended: &Ended, poses: &Poses) -> Result<Covariance, ProbeError> {
    let sum = solver.sum(&ended.state, poses, &ended.weights);
    let prior = solver.prior(&ended.state);
    let data = &sum.normal - &prior.normal;
    let Some(solved) = sum.normal.clone().cholesky() else {
        let what = free::open(&sum.normal, &ended.state.image.matrix());
        return Err(ProbeError::Open { what });
    };
    let inverse = solved.inverse();
    let rows = ended.weights.iter().sum::<f64>() * solver.components() as f64;
    // What is known before adds as many equations as unknowns; only the others use up freedom.
    let known = if solver.options.priors.pixel_mm.is_some() {
        2.0
    } else {
        0.0
    };
    let own = 8.0 - known + if solver.layout.wall.is_some() { 3.0 } else { 0.0 };
    let noise_ratio = (sum.cost / (rows - own).max(1.0)).max(0.0).sqrt();
    let frame_correlation = correlation(&sum.pulls, &data, noise_ratio);
    // Noise larger than told, and frames that are not independent, make what the data say less sure; what is known
    // before stays.
    let factor = noise_ratio.max(1.0).powi(2) * frame_correlation;
    let meat = data * factor + prior.normal;
    let all = &inverse * meat * &inverse;
    let all = (&all + all.transpose()) * 0.5;
    Ok(Covariance {
        all,
        noise_ratio,
        frame_correlation,
    })
}

/// The mean, over the image's eight unknowns, of how much more the sums of neighbouring frames vary than their noise
/// says.
fn correlation(pulls: &[DVector<f64>], data: &DMatrix<f64>, noise_ratio: f64) -> f64 {
    let size = pulls.len().div_ceil(BLOCKS);
    if size < 2 {
        return 1.0;
    }
    let mut meat = SMatrix::<f64, 8, 8>::zeros();
    for block in pulls.chunks(size) {
        let total: SMatrix<f64, 8, 1> = block.iter().map(|p| p.fixed_rows::<8>(0).into_owned()).sum();
        meat += total * total.transpose();
    }
    let told = data.fixed_view::<8, 8>(0, 0).into_owned() * noise_ratio.powi(2);
    // A direction without any information has no pull either: an eighth of nothing.
    let Some(solved) = told.cholesky() else { return 1.0 };
    let blocks = pulls.len().div_ceil(size) as f64;
    // Pulls add up to 0 at the minimum: of so many blocks one is given by the others.
    (solved.solve(&meat).trace() / 8.0 * blocks / (blocks - 1.0)).max(1.0)
}
