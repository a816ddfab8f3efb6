//! A law with its coefficients.

use nalgebra::{Matrix2, Matrix4, Vector4};

use super::response::{Response, Volume, vector};
use super::{Lame, Modes, Ogden, Refused, linear, neo_hookean, saint_venant};

/// The form of the energy.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Law {
    /// `(lambda / 2) tr(E)^2 + mu tr(E^2)`: the thesis's. Inverts without a sign; see the least determinant.
    StVenantKirchhoff,
    /// Of the symmetric gradient: small rotations only.
    Linear,
    /// `mu/2 (|F|^2 - 2) - mu ln J + lambda/2 (ln J)^2`: never inverts.
    NeoHookean,
    /// Finite at inversion, and pushes back from it.
    StableNeoHookean,
    /// In powers of the principal stretches.
    Ogden(Ogden),
}

/// A homogeneous elastic material in plane strain.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Material {
    /// The form of the energy.
    pub law: Law,
    /// Its coefficients.
    pub lame: Lame,
}

impl Material {
    /// The material of a law, a Young's modulus (units of stress) and a Poisson's ratio.
    ///
    /// # Errors
    /// [`Refused::Young`], [`Refused::Poisson`].
    pub fn new(law: Law, young: f64, poisson: f64) -> Result<Self, Refused> {
        let lame = Lame::new(young, poisson)?;
        Ok(Self { law, lame })
    }

    /// True where the energy is infinite at `det F = 0`, so that no state of finite energy is inverted.
    pub fn forbids_inversion(&self) -> bool {
        matches!(self.law, Law::NeoHookean | Law::Ogden(_))
    }

    /// The energy of a unit of reference area. `None` where the law has none: `det F <= 0`, or not a number.
    #[inline]
    pub fn density(&self, g: &Matrix2<f64>) -> Option<f64> {
        // Their closed forms share one logarithm or one strain, which the two parts would each compute.
        if matches!(self.law, Law::NeoHookean | Law::StVenantKirchhoff) {
            return self.stress(g).map(|(density, _)| density);
        }
        let theta = self.volume(g)?.theta;
        let density = self.shear_density(g)? + 0.5 * self.lame.lambda * theta * theta;
        density.is_finite().then_some(density)
    }

    /// Energy, first Piola-Kirchhoff stress and tangent. `None` as [`Self::density`].
    #[inline]
    pub fn response(&self, g: &Matrix2<f64>) -> Option<Response> {
        let volume = self.volume(g)?;
        let response = self.shear(g)?.with_volume(self.lame.lambda, &volume);
        response.density.is_finite().then_some(response)
    }

    /// Energy and stress alone. `None` as [`Self::density`].
    pub(crate) fn stress(&self, g: &Matrix2<f64>) -> Option<(f64, Vector4<f64>)> {
        let (lame, entries) = ([self.lame.lambda, self.lame.mu], vector(g));
        let found = match &self.law {
            Law::NeoHookean => neo_hookean::stress(lame, &entries)?,
            Law::StVenantKirchhoff => saint_venant::stress(lame, &entries),
            _ => self.response(g).map(|at| (at.density, at.stress))?,
        };
        found.0.is_finite().then_some(found)
    }

    /// The tangent alone. `None` where the law has no energy.
    pub(crate) fn tangent(&self, g: &Matrix2<f64>) -> Option<Matrix4<f64>> {
        match &self.law {
            Law::NeoHookean => neo_hookean::tangent([self.lame.lambda, self.lame.mu], &vector(g)),
            _ => self.response(g).map(|at| at.tangent),
        }
    }

    /// The part of the energy without `lambda`.
    pub(crate) fn shear_density(&self, g: &Matrix2<f64>) -> Option<f64> {
        let (mu, g) = (self.lame.mu, vector(g));
        match &self.law {
            Law::StVenantKirchhoff => Some(saint_venant::shear_density(mu, &g)),
            Law::Linear => Some(linear::shear_density(mu, &g)),
            Law::NeoHookean => neo_hookean::shear_density(mu, &g),
            Law::StableNeoHookean => Some(neo_hookean::stable_shear_density(mu, &g)),
            Law::Ogden(ogden) => ogden.shear_density(mu, &g),
        }
    }

    /// The part without `lambda`, with derivatives.
    #[inline]
    pub(crate) fn shear(&self, g: &Matrix2<f64>) -> Option<Response> {
        let (mu, g) = (self.lame.mu, vector(g));
        match &self.law {
            Law::StVenantKirchhoff => Some(saint_venant::shear(mu, &g)),
            Law::Linear => Some(linear::shear(mu, &g)),
            Law::NeoHookean => neo_hookean::shear(mu, &g),
            Law::StableNeoHookean => Some(neo_hookean::stable_shear(mu, &g)),
            Law::Ogden(ogden) => ogden.shear(mu, &g),
        }
    }

    /// The measure of volume whose square `lambda / 2` multiplies.
    #[inline]
    pub(crate) fn volume(&self, g: &Matrix2<f64>) -> Option<Volume> {
        let g = vector(g);
        match &self.law {
            Law::StVenantKirchhoff => Some(saint_venant::volume(&g)),
            Law::Linear => Some(linear::volume(&g)),
            Law::NeoHookean | Law::Ogden(_) => neo_hookean::log_volume(&g),
            Law::StableNeoHookean => Some(neo_hookean::stable_volume(&g)),
        }
    }

    /// The tangent with its negative eigenvalues lifted to zero, by closed form.
    pub(crate) fn convex(&self, tangent: &Matrix4<f64>, g: &Matrix2<f64>) -> Matrix4<f64> {
        Modes::of(tangent, &(Matrix2::identity() + g)).lifted(tangent, 0.0)
    }
}
