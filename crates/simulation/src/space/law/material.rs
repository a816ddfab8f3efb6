//! A law with its coefficients.

use nalgebra::Matrix3;

use super::response::{Response, Tangent, Tensor, Volume, add_square, vector};
use super::{Fibre, linear, neo_hookean, ogden, project, saint_venant};
use crate::law::{Lame, Law, Refused};

/// A homogeneous elastic material in three dimensions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Material {
    /// The form of the energy.
    pub law: Law,
    /// Its coefficients.
    pub lame: Lame,
    /// Fibres that stiffen it along one direction.
    pub fibre: Option<Fibre>,
}

impl Material {
    /// The material of a law, a Young's modulus (units of stress) and a Poisson's ratio, without fibres.
    ///
    /// # Errors
    /// [`Refused::Young`], [`Refused::Poisson`].
    pub fn new(law: Law, young: f64, poisson: f64) -> Result<Self, Refused> {
        let lame = Lame::new(young, poisson)?;
        Ok(Self { law, lame, fibre: None })
    }

    /// True where the energy is infinite at `det F = 0`, so that no state of finite energy is inverted.
    pub fn forbids_inversion(&self) -> bool {
        matches!(self.law, Law::NeoHookean | Law::Ogden(_))
    }

    /// The energy of a unit of reference volume. `None` where the law has none: `det F <= 0` where it forbids inversion,
    /// or not a finite number.
    #[inline]
    pub fn density(&self, g: &Matrix3<f64>) -> Option<f64> {
        let g = vector(g);
        let theta = self.theta(&g)?;
        // Asked of the sum: where either part is not finite, neither is it.
        finite(self.shear_density(&g)? + 0.5 * self.lame.lambda * theta * theta)
    }

    /// Energy and first Piola-Kirchhoff stress `P = dw/dF`. `None` as [`Self::density`].
    #[inline]
    pub fn stress(&self, g: &Matrix3<f64>) -> Option<(f64, Tensor)> {
        let g = vector(g);
        let ((theta, slope), (density, stress)) = (self.volume_slope(&g)?, self.shear_stress(&g)?);
        let pressure = self.lame.lambda * theta;
        let density = finite(density + 0.5 * pressure * theta)?;
        Some((density, stress + slope * pressure))
    }

    /// The tangent `dP/dF`. `None` where the law has no energy.
    pub fn tangent(&self, g: &Matrix3<f64>) -> Option<Tangent> {
        let g = vector(g);
        // `lambda theta` is the pressure here; its derivative adds the square of theta's.
        let (theta, slope) = self.volume_slope(&g)?;
        let mut tangent = self.tangent_at_pressure(&g, self.lame.lambda * theta)?;
        add_square(&mut tangent, &slope, self.lame.lambda);
        Some(tangent)
    }

    /// Energy, first Piola-Kirchhoff stress and tangent. `None` as [`Self::density`].
    pub fn response(&self, g: &Matrix3<f64>) -> Option<Response> {
        // Density and stress first, as a tangent may be finite where they are not.
        let (density, stress) = self.stress(g)?;
        let tangent = self.tangent(g)?;
        Some(Response {
            density,
            stress,
            tangent,
        })
    }

    /// The part without `lambda`, the fibre's with it.
    pub fn shear(&self, g: &Matrix3<f64>) -> Option<Response> {
        let g = vector(g);
        let (density, stress) = self.shear_stress(&g)?;
        let tangent = self.shear_tangent(&g)?;
        Some(Response {
            density: finite(density)?,
            stress,
            tangent,
        })
    }

    /// The measure of volume whose square `lambda / 2` multiplies.
    pub fn volume(&self, g: &Matrix3<f64>) -> Option<Volume> {
        let g = vector(g);
        let (theta, gradient) = self.volume_slope(&g)?;
        let hessian = self.volume_hessian(&g)?;
        Some(Volume {
            theta: finite(theta)?,
            gradient,
            hessian,
        })
    }

    /// The nearest positive semidefinite matrix to a tangent of this material at `g`.
    pub fn convex(&self, tangent: &Tangent, g: &Matrix3<f64>) -> Tangent {
        match (&self.fibre, &self.law) {
            (Some(_), _) => project::general(tangent),
            // Constant, and positive for every pair of coefficients that is not refused; no function of stretches.
            (None, Law::Linear) => *tangent,
            (None, _) => project::isotropic(tangent, &vector(g)),
        }
    }

    /// The energy without `lambda`.
    #[inline]
    pub(crate) fn shear_density(&self, g: &Tensor) -> Option<f64> {
        let mu = self.lame.mu;
        let density = match &self.law {
            Law::NeoHookean => neo_hookean::shear_density(mu, g)?,
            Law::StableNeoHookean => neo_hookean::stable_shear_density(mu, g),
            Law::Ogden(law) => ogden::shear_density(law, mu, g)?,
            Law::StVenantKirchhoff => saint_venant::shear_stress(mu, g).0,
            Law::Linear => linear::shear_stress(mu, g).0,
        };
        Some(density + self.fibre.map_or(0.0, |fibre| fibre.stress(g).0))
    }

    /// Energy and stress without `lambda`.
    #[inline]
    pub(crate) fn shear_stress(&self, g: &Tensor) -> Option<(f64, Tensor)> {
        let mu = self.lame.mu;
        let (density, stress) = match &self.law {
            Law::NeoHookean => neo_hookean::shear_stress(mu, g)?,
            Law::StableNeoHookean => neo_hookean::stable_shear_stress(mu, g),
            Law::Ogden(law) => ogden::shear_stress(law, mu, g)?,
            Law::StVenantKirchhoff => saint_venant::shear_stress(mu, g),
            Law::Linear => linear::shear_stress(mu, g),
        };
        let (more, pull) = self.fibre.map_or((0.0, Tensor::zeros()), |fibre| fibre.stress(g));
        let stress = stress + pull;
        // High powers may overflow in a derivative before they do in the energy.
        stress.sum().is_finite().then_some((density + more, stress))
    }

    fn shear_tangent(&self, g: &Tensor) -> Option<Tangent> {
        self.tangent_at_pressure(g, 0.0)
    }

    #[inline]
    pub(crate) fn theta(&self, g: &Tensor) -> Option<f64> {
        match &self.law {
            Law::NeoHookean | Law::Ogden(_) => neo_hookean::log_theta(g),
            // The slopes of the others take no logarithm: a form of theta alone would save little.
            _ => self.volume_slope(g).map(|(theta, _)| theta),
        }
    }

    /// `theta` and its derivative.
    #[inline]
    pub(crate) fn volume_slope(&self, g: &Tensor) -> Option<(f64, Tensor)> {
        match &self.law {
            Law::NeoHookean | Law::Ogden(_) => neo_hookean::log_volume(g),
            Law::StableNeoHookean => Some(neo_hookean::stable_volume(g)),
            Law::StVenantKirchhoff => Some(saint_venant::volume(g)),
            Law::Linear => Some(linear::volume(g)),
        }
    }

    fn volume_hessian(&self, g: &Tensor) -> Option<Tangent> {
        match &self.law {
            Law::NeoHookean | Law::Ogden(_) => neo_hookean::log_hessian(g),
            Law::StableNeoHookean => Some(neo_hookean::stable_hessian(g)),
            Law::StVenantKirchhoff => Some(Tangent::identity()),
            Law::Linear => Some(Tangent::zeros()),
        }
    }

    /// The second derivative of `w_s + pressure theta`: the tangent but for what the derivative of the pressure adds.
    pub(crate) fn tangent_at_pressure(&self, g: &Tensor, pressure: f64) -> Option<Tangent> {
        let mu = self.lame.mu;
        let mut tangent = match &self.law {
            Law::NeoHookean => neo_hookean::tangent_at_pressure(mu, g, pressure)?,
            Law::StableNeoHookean => neo_hookean::stable_tangent_at_pressure(mu, g, pressure),
            Law::Ogden(law) => ogden::shear_tangent(law, mu, g)? + neo_hookean::log_hessian(g)? * pressure,
            Law::StVenantKirchhoff => saint_venant::shear_tangent(mu, g) + Tangent::identity() * pressure,
            // `tr G` has no second derivative: no pressure stiffens the linear law.
            Law::Linear => linear::shear_tangent(mu),
        };
        // Part of what is not projected: fibres bear stretch, not volume.
        if let Some(fibre) = &self.fibre {
            fibre.add_tangent(g, &mut tangent);
        }
        // That of the linear law is the same everywhere, even where there is no energy.
        (tangent.sum().is_finite() && g.sum().is_finite()).then_some(tangent)
    }
}

fn finite(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}
