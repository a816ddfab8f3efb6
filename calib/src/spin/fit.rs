//! The two linear problems of a spin: the direction of the axis, and its place.

use geometry::{Frame, Rigid};
use nalgebra::{Matrix3, Vector3};

use super::robust::Fit;
use super::{Axes, Complex};
use crate::registration::jacobi::symmetric3;

/// Relative rounding of residuals: below it they say nothing.
const RESIDUAL_ROUNDING: f64 = 1e-12;

pub(super) fn matrix<To, From>(pose: &Rigid<To, From>) -> Matrix3<f64> {
    pose.rotation().matrix().into()
}

/// Two unit vectors that make a right-handed frame with `axis`.
pub(super) fn completed(axis: &Vector3<f64>) -> [Vector3<f64>; 2] {
    // The coordinate axis least along it is 54 degrees away at least, so that the product is well above zero.
    let other = Matrix3::identity().column(axis.iamin()).into_owned();
    let first = other.cross(axis).try_normalize(0.0).unwrap_or_else(Vector3::x);
    [first, axis.cross(&first)]
}

/// The turn of a rotation about the axis, as a complex number of norm 1.
pub(super) fn turned(r: &Matrix3<f64>, [[a, b], [c, d]]: &[[Vector3<f64>; 2]; 2]) -> Complex {
    let (ra, rb) = (r * a, r * b);
    // Of the turn by h: R a = cos h c + sin h d and R b = -sin h c + cos h d; both vectors together are the best fit
    // where the shaft wobbles.
    let z = Complex::new(ra.dot(c) + rb.dot(d), ra.dot(d) - rb.dot(c));
    z / z.norm().max(f64::MIN_POSITIVE)
}

/// `1 - rho^2` of some turns.
pub(super) fn openness(turns: impl Iterator<Item = Complex> + Clone) -> f64 {
    let n = turns.clone().count() as f64;
    let mean = turns.clone().sum::<Complex>() / n;
    // Equal to 1 - rho^2 for turns of norm 1, without the cancellation of a small range.
    turns.map(|z| (z - mean).norm_sqr()).sum::<f64>() / n
}

/// The rotations: `R_i u = v`.
pub(super) struct Directions(pub(super) Vec<Matrix3<f64>>);

impl Fit for Directions {
    type Found = (Vector3<f64>, Vector3<f64>);

    fn count(&self) -> usize {
        self.0.len()
    }

    fn fit(&self, weights: &[f64]) -> Option<Self::Found> {
        let both = || self.0.iter().zip(weights);
        let total: f64 = weights.iter().sum();
        let mean = both().map(|(r, w)| r * *w).sum::<Matrix3<f64>>() / total;
        let spread = both().map(|(r, w)| (r - mean).transpose() * (r - mean) * *w);
        let (values, vectors) = symmetric3(spread.sum());
        let u: Vector3<f64> = vectors.column(values.imin()).into_owned();
        // The best v for a given u: sum w |R u - v|^2 over unit vectors is least along the mean of R u.
        let v = (mean * u).try_normalize(0.0)?;
        (total > 0.0).then_some((u, v))
    }

    fn square(&self, (u, v): &Self::Found, i: usize) -> f64 {
        (self.0[i] * u - v).norm_squared()
    }

    fn rounding(&self) -> f64 {
        RESIDUAL_ROUNDING * RESIDUAL_ROUNDING
    }
}

/// The places of the marker's origin across the axis, of the poses whose direction counts.
pub(super) struct Places {
    turns: Vec<Complex>,
    places: Vec<Complex>,
}

impl Places {
    pub(super) fn of<To: Frame, From: Frame>(axes: &Axes, poses: &[Rigid<To, From>]) -> Self {
        Self {
            turns: axes.inside().map(|(i, _)| axes.turns[i]).collect(),
            places: axes.inside().map(|(i, _)| axes.place_of(&poses[i])).collect(),
        }
    }
}

impl Fit for Places {
    /// The point across the axis in the marker, and in the tracker.
    type Found = (Complex, Complex);

    fn count(&self) -> usize {
        self.turns.len()
    }

    fn fit(&self, weights: &[f64]) -> Option<Self::Found> {
        let total: f64 = weights.iter().sum();
        let mean = |list: &[Complex]| list.iter().zip(weights).map(|(z, w)| z * *w).sum::<Complex>() / total;
        let (turn, centre) = (mean(&self.turns), mean(&self.places));
        let triples = self.turns.iter().zip(&self.places).zip(weights);
        let (mut open, mut pull) = (0.0, Complex::default());
        for ((z, t), w) in triples {
            // About the means, which eliminates c: the normal equation of p alone is a complex number.
            open += w * (z - turn).norm_sqr();
            pull += (z - turn).conj() * (t - centre) * *w;
        }
        let place = -pull / open;
        (open > 0.0).then_some((place, turn * place + centre))
    }

    fn square(&self, (place, centre): &Self::Found, i: usize) -> f64 {
        (self.turns[i] * place + self.places[i] - centre).norm_sqr()
    }

    fn rounding(&self) -> f64 {
        // Residuals are differences of numbers of this size, and so is their rounding.
        let largest = self.places.iter().map(|t| t.norm_sqr()).fold(0.0, f64::max);
        largest * RESIDUAL_ROUNDING * RESIDUAL_ROUNDING
    }
}
