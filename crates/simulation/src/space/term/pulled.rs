//! Places pulled back through a solid's deformation, and how far they are from its surface there.
//!
//! A place `x` is where the material of reference place `X` is: `x = X + u(X)`. The gap is the signed distance of `X` from the
//! surface in the reference configuration: zero where `x` is on the surface as it is now, whatever the deformation. Its slope there,
//! `F^-T n`, is along the surface's normal now, so what it presses with has no part along the surface. Its length is
//! how much shorter the reference distance is than that of now.

use nalgebra::{Matrix3, Vector3};

use crate::space::cells::Share;
use crate::space::level_set::LevelSet;
use crate::space::solid::Solid;
use crate::space::tube::Distance;

/// Steps of Newton's method at most; from a point of the surface next to it three or four are made.
const MOST_STEPS: usize = 25;
/// A step of so many units in the last place is the last.
const LAST_STEP: f64 = 8.0 * f64::EPSILON;

/// A place in a solid's reference configuration.
#[derive(Debug, Clone)]
pub(super) struct Pulled {
    /// From the surface, by the reference place.
    pub(super) distance: Distance,
    /// The derivative of the distance by the place now.
    pub(super) slope: Vector3<f64>,
    /// The inverse of the deformation gradient.
    pub(super) inverse: Matrix3<f64>,
    /// What moves it.
    pub(super) shares: Vec<Share>,
    /// `H - sum of slope[k] d2 u[k]`: second derivatives of the distance by the reference place at fixed parameters, on the
    /// way that keeps the place now.
    pub(super) bent: Matrix3<f64>,
}

/// The place now of a reference place, and the deformation gradient.
fn moved(part: &[f64], shares: &[Share], at: &Vector3<f64>) -> (Vector3<f64>, Matrix3<f64>) {
    let (mut place, mut gradient) = (*at, Matrix3::identity());
    for share in shares {
        let u = displacement(part, share);
        place += u * share.weight;
        gradient += u * share.slope.transpose();
    }
    (place, gradient)
}

fn displacement(part: &[f64], share: &Share) -> Vector3<f64> {
    Vector3::from_column_slice(&part[3 * share.node as usize..3 * share.node as usize + 3])
}

impl Pulled {
    /// Pulls `x` back, from the reference place `start` on. `None` where no material is near, or it is turned inside out.
    pub(super) fn new(
        solid: &dyn Solid,
        part: &[f64],
        surface: &LevelSet,
        x: &Vector3<f64>,
        start: &Vector3<f64>,
    ) -> Option<Self> {
        let (mut at, mut last) = (*start, f64::INFINITY);
        for _ in 0..MOST_STEPS {
            let shares = solid.shares(&at)?;
            let (place, gradient) = moved(part, &shares, &at);
            let inverse = gradient.try_inverse().filter(|_| gradient.determinant() > 0.0)?;
            let step = inverse * (x - place);
            let (length, rounding) = (step.norm(), LAST_STEP * (x.norm() + at.norm()));
            if length <= rounding || (length >= last && length <= 1e6 * rounding) {
                return Some(Self::at(part, surface, &at, shares, inverse));
            }
            at += step;
            last = length;
        }
        None
    }

    fn at(part: &[f64], surface: &LevelSet, at: &Vector3<f64>, shares: Vec<Share>, inverse: Matrix3<f64>) -> Self {
        let distance = surface.signed_distance(at);
        let slope = inverse.transpose() * distance.gradient;
        let mut bent = distance.hessian;
        for share in &shares {
            bent -= share.curvature * displacement(part, share).dot(&slope);
        }
        Self {
            distance,
            slope,
            inverse,
            shares,
            bent,
        }
    }

    /// The distance from the surface now, to first order, mm.
    pub(super) fn now(&self) -> f64 {
        self.distance.value / self.slope.norm()
    }

    /// How far a step moves what is at the place.
    pub(super) fn way(&self, step: &[f64]) -> Vector3<f64> {
        let ways = self.shares.iter().map(|share| displacement(step, share) * share.weight);
        ways.sum()
    }
}
