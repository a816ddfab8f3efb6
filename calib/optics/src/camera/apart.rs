//! How far apart the views are in what each says of the camera.
//!
//! At the end of the adjustment every view still pulls at the shared numbers with its own share of (4), `s_i` with the information
//! `S_i`, which sum to nothing. Let each view have focal lengths and a principal point of its own: the sum of squares falls by
//!
//! ```text
//! T = sum s_i^T S_i^+ s_i,    of   sum rank(S_i) - 4   more numbers                                               (9)
//! ```
//!
//! to first order, `S_i^+` the pseudo-inverse, as one view of a plane does not hold all four. Where all views are of one camera T over
//! those numbers is the square of the noise ratio; pictures of two cameras leave far more there than in the residuals, over
//! which it is spread.

use nalgebra::{Matrix4, Vector4};

use super::normal::Normal;

/// Focal lengths and principal point: the first of the shared numbers.
const CAMERA_NUMBERS: usize = 4;
/// A direction that a view holds so much less than its best is not held: rounding.
const LEAST_RELATIVE_CURVATURE: f64 = 1e-8;

/// The root of T over its numbers, in units of the deviations given; NaN where it is no number.
pub(super) fn view_ratio(normals: &[Normal]) -> f64 {
    let each: Option<Vec<(f64, usize)>> = normals.iter().map(of_view).collect();
    let Some(each) = each else { return f64::NAN };
    let (sum, rank) = each.iter().fold((0.0, 0), |(t, n), (own, rank)| (t + own, n + rank));
    (sum / rank.saturating_sub(CAMERA_NUMBERS).max(1) as f64).sqrt()
}

/// `s^T S^+ s` and the rank of `S`.
fn of_view(normal: &Normal) -> Option<(f64, usize)> {
    let inverse = normal.inverse(0.0)?;
    let carried = normal.mixed.fixed_rows::<CAMERA_NUMBERS>(0) * inverse;
    let own: Matrix4<f64> = normal.own.fixed_view::<CAMERA_NUMBERS, CAMERA_NUMBERS>(0, 0)
        - carried * normal.mixed.fixed_rows::<CAMERA_NUMBERS>(0).transpose();
    let pull: Vector4<f64> = normal.pull.fixed_rows::<CAMERA_NUMBERS>(0) - carried * normal.turn;
    if !own.iter().chain(&pull).all(|x| x.is_finite()) {
        return None;
    }
    // The Schur complement is symmetric but for rounding.
    let eigen = ((own + own.transpose()) * 0.5).symmetric_eigen();
    let most = eigen.eigenvalues.max();
    let held = (0..CAMERA_NUMBERS).filter(|k| eigen.eigenvalues[*k] > LEAST_RELATIVE_CURVATURE * most);
    Some(held.fold((0.0, 0), |(sum, rank), k| {
        let along = eigen.eigenvectors.column(k).dot(&pull);
        (sum + along * along / eigen.eigenvalues[k], rank + 1)
    }))
}
