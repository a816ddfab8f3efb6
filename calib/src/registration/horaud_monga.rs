//! Horaud and Monga's linear solution (4.31 to 4.35).

use geometry::Frame;
use nalgebra::{Matrix3, Vector3};

use super::fit::place;
use super::quaternion::{matrix, unit};
use super::{Fit, Moments, Pairs, Refused};

/// Fits by the linear equations of Horaud and Monga: `(a' + b') x K = b' - a'` with `K = tan(theta / 2) k` (4.31),
/// solved in the sense of least squares (4.34).
///
/// Not one of the [`super::Method`]s: it is **not** the optimum of 4.1 where the data have noise (by 4e-4 rad at 24
/// points and 1e-3 of the size, by radians at a tenth), and it has no answer at a half-turn, where `K` is infinite. It
/// is here because the thesis compares it; [`Fit::certificate`] tells how far off the optimum it is.
///
/// # Errors
/// Those of [`Moments::of`]; [`Refused::Collinear`] and [`Refused::Reflected`]; [`Refused::MethodFails`] at a
/// half-turn.
pub fn fit_horaud_monga<To: Frame, From: Frame>(pairs: Pairs<'_, To, From>) -> Result<Fit<To, From>, Refused> {
    let moments = Moments::of(pairs)?;
    let (normal, right) = equations(pairs, &moments);
    // K = adjugate right / det, so that the quaternion needs no division: (1, K) is (det, adjugate right).
    let (x, y, z) = (normal.column(0), normal.column(1), normal.column(2));
    let k = Vector3::new(
        right.dot(&y.cross(&z)),
        x.dot(&right.cross(&z)),
        x.dot(&y.cross(&right)),
    );
    let det = x.dot(&y.cross(&z));
    // Determinant and adjugate are of third degree in the normal matrix, whose size is its trace.
    let length = det.hypot(k.norm());
    let trace = normal.trace();
    // Below the rounding of the determinant nothing is known of the rotation.
    let known = length > 64.0 * f64::EPSILON * trace * trace * trace;
    let q = known.then(|| unit([det / length, k.x / length, k.y / length, k.z / length]));
    let q = moments.checked(q)?;
    let transform = place(q, moments.mean(0) - matrix(&q) * moments.mean(1))?;
    Ok(Fit { transform, moments })
}

/// The normal equations 4.34, both clouds in units of their common size.
fn equations<To, From>(pairs: Pairs<'_, To, From>, moments: &Moments) -> (Matrix3<f64>, Vector3<f64>) {
    let (mut normal, mut right, scale) = (Matrix3::zeros(), Vector3::zeros(), moments.scale[0]);
    // 4.31 adds points of both clouds, so that one scale serves both.
    let size = moments.energy[0].sqrt();
    for (i, (a, b)) in pairs.to.iter().zip(pairs.from).enumerate() {
        let a = moments.centred(0, *a) * scale / size;
        let b = moments.centred(1, *b) * scale / size;
        let h = (a + b).cross_matrix();
        normal += h.transpose() * h * pairs.weight(i);
        right += h.transpose() * (b - a) * pairs.weight(i);
    }
    (normal, right)
}
