//! Pairs of points with their weights, borrowed from the caller.

use geometry::{Point, Vector};
use nalgebra::Vector3;

use super::Refused;

/// The same points seen in two frames: `to[i]` and `from[i]` are one point. Weights are optional.
///
/// A weight is proportional to the inverse of the variance of the pair's distance; only ratios matter. A pair of weight
/// zero is as if absent. Duplicated pairs are allowed and count twice.
pub struct Pairs<'a, To, From> {
    pub(crate) to: &'a [Point<To>],
    pub(crate) from: &'a [Point<From>],
    pub(crate) weights: Option<&'a [f64]>,
}

impl<To, From> Clone for Pairs<'_, To, From> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<To, From> Copy for Pairs<'_, To, From> {}

impl<'a, To, From> Pairs<'a, To, From> {
    /// Pairs of equal weight.
    ///
    /// # Errors
    /// [`Refused::Unpaired`].
    pub fn new(to: &'a [Point<To>], from: &'a [Point<From>]) -> Result<Self, Refused> {
        if to.len() != from.len() {
            return Err(Refused::Unpaired {
                to: to.len(),
                from: from.len(),
            });
        }
        Ok(Self {
            to,
            from,
            weights: None,
        })
    }

    /// The same pairs with a weight each.
    ///
    /// # Errors
    /// [`Refused::Unmatched`]. Bad weights are found when the pairs are used.
    pub fn weighted(self, weights: &'a [f64]) -> Result<Self, Refused> {
        if weights.len() != self.to.len() {
            return Err(Refused::Unmatched {
                what: "weights",
                found: weights.len(),
                pairs: self.to.len(),
            });
        }
        Ok(Self {
            weights: Some(weights),
            ..self
        })
    }

    /// The number of pairs.
    pub fn len(&self) -> usize {
        self.to.len()
    }

    /// True where there is no pair.
    pub fn is_empty(&self) -> bool {
        self.to.is_empty()
    }

    /// The weight of pair `i` as given; 1 without weights.
    pub(crate) fn weight(&self, i: usize) -> f64 {
        self.weights.map_or(1.0, |w| w[i])
    }

    /// Names what is wrong with numbers that have spoilt a sum, or that weigh nothing.
    pub(crate) fn check(&self) -> Result<(), Refused> {
        // Pairs of weight zero too: zero times NaN is NaN, and would spoil the sums all the same.
        let bad = |p: &[f64; 3]| p.iter().any(|x| !x.is_finite());
        let points = self.to.iter().map(|p| p.mm()).zip(self.from.iter().map(|p| p.mm()));
        for (pair, (a, b)) in points.enumerate() {
            let found = if bad(&a) { a } else { b };
            if bad(&found) {
                return Err(Refused::NotFinite { pair, found });
            }
        }
        self.check_weights()
    }

    fn check_weights(&self) -> Result<(), Refused> {
        let Some(weights) = self.weights else {
            return enough(self.len());
        };
        if let Some(pair) = weights.iter().position(|w| !w.is_finite() || *w < 0.0) {
            let found = weights[pair];
            return Err(Refused::BadWeight { pair, found });
        }
        match weights.iter().filter(|w| **w > 0.0).count() {
            0 if !self.is_empty() => Err(Refused::NoWeight { pairs: self.len() }),
            positive => enough(positive),
        }
    }
}

fn enough(found: usize) -> Result<(), Refused> {
    if found < 3 {
        return Err(Refused::TooFew { found, needed: 3 });
    }
    Ok(())
}

pub(crate) fn coordinates<F>(p: Point<F>) -> Vector3<f64> {
    Vector3::from(p.mm())
}

pub(crate) fn vector<F>(v: Vector3<f64>) -> Vector<F> {
    Vector::new(v.x, v.y, v.z)
}
