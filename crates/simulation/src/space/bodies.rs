//! The solids of a system, and where each has its parameters.

use super::solid::Solid;

/// Solids, and where the parameters of each lie in the vector of all.
#[derive(Debug, Default)]
pub struct Bodies {
    solids: Vec<Box<dyn Solid>>,
    offsets: Vec<usize>,
    size: usize,
}

impl Bodies {
    /// The number of solids.
    pub fn len(&self) -> usize {
        self.solids.len()
    }

    /// True without any.
    pub fn is_empty(&self) -> bool {
        self.solids.is_empty()
    }

    /// Parameters of all solids together.
    pub fn size(&self) -> usize {
        self.size
    }

    /// A solid.
    pub fn solid(&self, body: usize) -> &dyn Solid {
        self.solids[body].as_ref()
    }

    /// The first unknown of a solid.
    pub fn offset(&self, body: usize) -> usize {
        self.offsets[body]
    }

    /// The parameters of a solid among all.
    pub fn part<'a>(&self, body: usize, a: &'a [f64]) -> &'a [f64] {
        let end = self.offsets.get(body + 1).copied().unwrap_or(self.size);
        &a[self.offsets[body]..end]
    }

    /// The largest side of any, the scale of lengths.
    pub fn extent(&self) -> f64 {
        self.solids.iter().map(|s| s.extent()).fold(0.0, f64::max)
    }

    /// The largest stiffness, force by length.
    pub fn stiffness_scale(&self) -> f64 {
        self.solids.iter().map(|s| s.stiffness_scale()).fold(0.0, f64::max)
    }

    /// Adds a solid; its number.
    pub(super) fn add(&mut self, solid: impl Solid + 'static) -> usize {
        self.offsets.push(self.size);
        self.size += solid.parameters();
        self.solids.push(Box::new(solid));
        self.solids.len() - 1
    }

    /// The solids.
    pub(super) fn all(&self) -> impl Iterator<Item = &dyn Solid> {
        self.solids.iter().map(AsRef::as_ref)
    }

    /// `(offset, solid, its parameters)` of each.
    pub(super) fn each<'a>(&'a self, a: &'a [f64]) -> impl Iterator<Item = (usize, &'a dyn Solid, &'a [f64])> {
        (0..self.len()).map(move |k| (self.offsets[k], self.solid(k), self.part(k, a)))
    }
}
