//! Tissue, cortex and what is inside, as a scanner shows them across a bone's surface.
//!
//! With x the distance outwards from a smooth surface of curvatures k1, k2, of which the bone's is the parallel surface at p, and Phi the
//! distribution of the blur, normal but for its kurtosis ([`crate::normal::step`]):
//!
//! ```text
//! f(x) = a + (c - a) Phi((p - h(p) - x) / s) + (b - c) Phi((p - t - h(p - t) - x) / s)
//! h(q) = 1/2 tr(S K(q)),    K(q) = K / (1 + K q)
//! ```
//!
//! a, c and b are the HU of tissue, cortex and inside, t is the cortex's thickness, `s^2 = n' S n` the blur along the normal. h is what
//! blurring a bent surface moves it by, of first order in the curvature: a Gaussian's convolution is the heat equation after the time
//! s^2 / 2, and the Laplacian of a function of the distance alone is its second derivative and (k1 + k2) times its first. Of a ball of
//! radius R it is s^2 / R, inwards.

use nalgebra::SVector;

use crate::normal::{by_kurtosis, slope, step};

/// Unknowns of a place: position outwards (mm), logarithm of the thickness (mm), HU of cortex, inside and tissue.
pub(crate) type Unknowns = SVector<f64, 5>;

/// What is known of a place.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Place {
    /// Blur along the normal, mm.
    pub(crate) blur_mm: f64,
    /// Excess kurtosis of the blur.
    pub(crate) kurtosis: f64,
    /// The two products of the tangential blur's variance and the curvature, 1/2 of whose sum moves the surface: [variance mm^2, 1/mm].
    pub(crate) bends: [[f64; 2]; 2],
}

/// A value and its derivatives.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Value {
    pub(crate) hu: f64,
    pub(crate) by: Unknowns,
    /// By the blur along the normal, HU/mm.
    pub(crate) by_blur: f64,
    /// By the blur's kurtosis, HU.
    pub(crate) by_kurtosis: f64,
}

impl Place {
    /// How far blur moves the surface that is parallel at `q`, inwards, mm.
    fn moved(&self, q: f64) -> f64 {
        let bend = |[variance, k]: [f64; 2]| 0.5 * variance * k / (1.0 + k * q).max(0.3);
        bend(self.bends[0]) + bend(self.bends[1])
    }

    /// The two interfaces, mm.
    fn interfaces(&self, at: &Unknowns) -> [f64; 2] {
        let (outer, inner) = (at[0], at[0] - at[1].exp());
        [outer - self.moved(outer), inner - self.moved(inner)]
    }

    /// The shares of cortex and inside at `x`: the model is linear in the three HU.
    pub(crate) fn shares(&self, outer: f64, thickness: f64, x: f64) -> [f64; 3] {
        let inner = outer - thickness;
        let [o, i] =
            [outer - self.moved(outer), inner - self.moved(inner)].map(|p| step((p - x) / self.blur_mm, self.kurtosis));
        [o - i, i, 1.0 - o]
    }

    pub(crate) fn hu(&self, at: &Unknowns, x: f64) -> f64 {
        let [outer, inner] = self.interfaces(at).map(|p| step((p - x) / self.blur_mm, self.kurtosis));
        at[4] + (at[2] - at[4]) * outer + (at[3] - at[2]) * inner
    }

    pub(crate) fn value(&self, at: &Unknowns, x: f64) -> Value {
        let s = self.blur_mm;
        let [outer, inner] = self.interfaces(at).map(|p| (p - x) / s);
        let (po, pi) = (step(outer, self.kurtosis), step(inner, self.kurtosis));
        let (do_, di) = (slope(outer, self.kurtosis) / s, slope(inner, self.kurtosis) / s);
        let [step_out, step_in] = [at[2] - at[4], at[3] - at[2]];
        // The move by curvature changes so little with p and t that its derivative is left out.
        let by_inner = step_in * di;
        let by = Unknowns::new(
            step_out * do_ + by_inner,
            -by_inner * at[1].exp(),
            po - pi,
            pi,
            1.0 - po,
        );
        Value {
            hu: at[4] + step_out * po + step_in * pi,
            by,
            by_blur: -(step_out * do_ * outer + by_inner * inner),
            by_kurtosis: -(step_out * by_kurtosis(outer) + step_in * by_kurtosis(inner)) / 24.0,
        }
    }
}
