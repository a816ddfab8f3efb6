//! The result of a registration that allocates nothing.

use geometry::{Frame, Point, Rigid, checked};
use nalgebra::{Matrix3, Vector3};

use super::quaternion::matrix;
use super::{Certificate, Method, Moments, Pairs, Refused, SingularValues};

/// The transform `to_from_from` that fits paired points best, with the moments it came from. Holds no allocation.
pub struct Fit<To, From> {
    /// Maps a point of `From` to its place in `To`.
    pub transform: Rigid<To, From>,
    pub(crate) moments: Moments,
}

impl<To, From> Clone for Fit<To, From> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<To, From> Copy for Fit<To, From> {}

impl<To: Frame, From: Frame> std::fmt::Debug for Fit<To, From> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Fit({:?}, {})", self.transform, self.singular_values())
    }
}

/// Fits the transform. Allocates nothing; see [`super::register`] for residuals and error estimates.
///
/// # Errors
/// Those of [`Moments::of`] and [`Moments::solve`].
#[inline]
pub fn fit<To: Frame, From: Frame>(pairs: Pairs<'_, To, From>, method: Method) -> Result<Fit<To, From>, Refused> {
    let moments = Moments::of(pairs)?;
    let q = moments.solve(method)?;
    // The best translation lays the centres on one another, whatever the rotation (4.4 to 4.6).
    let t = moments.mean(0) - matrix(&q) * moments.mean(1);
    let transform = place(q, t)?;
    Ok(Fit { transform, moments })
}

/// A transform from a unit quaternion and a translation, mm.
#[inline]
pub(crate) fn place<To: Frame, From: Frame>(q: [f64; 4], t: Vector3<f64>) -> Result<Rigid<To, From>, Refused> {
    // Only an overflow of the translation can be refused here: the quaternion was normalised.
    checked::rigid(q, t.into(), 1e-12).map_err(|_| Refused::NotFinite {
        pair: 0,
        found: t.into(),
    })
}

impl<To, From> Fit<To, From> {
    /// The rotation matrix.
    pub(crate) fn rotation(&self) -> Matrix3<f64> {
        matrix(&self.transform.quaternion())
    }

    /// The singular values of `Psi`, relative to the clouds' sizes. A decomposition is made at each call.
    pub fn singular_values(&self) -> SingularValues {
        self.moments.singular_values()
    }

    /// `s1 / (s2 + sgn s3)`: radians of rotation error per relative error of the data's correlation.
    pub fn condition(&self) -> f64 {
        self.singular_values().condition()
    }

    /// The proof that the rotation is the global optimum.
    pub fn certificate(&self) -> Certificate {
        Certificate::of(&self.moments.correlation(), &self.rotation())
    }

    /// `a - (R b + t)` in `To`, mm, formed about the centres: no digit is lost where both lie far from the origins.
    pub(crate) fn residual(&self, to: Point<To>, from: Point<From>) -> Vector3<f64> {
        self.moments.centred(0, to) - self.rotation() * self.moments.centred(1, from)
    }

    /// The distance of a pair after registration, mm.
    pub fn residual_mm(&self, to: Point<To>, from: Point<From>) -> f64 {
        // Scaled as the moments were, so that squares neither overflow nor vanish.
        let scale = self.moments.scale[0];
        (self.residual(to, from) * scale).norm() / scale
    }

    /// Fiducial registration error: the root of the weighted mean of the squared distances, mm. It divides by the
    /// number of pairs (by the sum of the weights), not by the degrees of freedom.
    pub fn fre_rms_mm(&self, pairs: Pairs<'_, To, From>) -> f64 {
        let scale = self.moments.scale[0];
        let (mut sum, mut total) = (0.0, 0.0);
        for (i, (a, b)) in pairs.to.iter().zip(pairs.from).enumerate() {
            let w = pairs.weight(i);
            total += w;
            sum += w * (self.residual(*a, *b) * scale).norm_squared();
        }
        (sum / total).sqrt() / scale
    }
}
