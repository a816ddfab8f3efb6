//! The solids of a system, and where each has its parameters.

use nalgebra::Vector2;

use crate::solid::{Cursor, Local, Solid};

/// Places this many sizes of the largest solid away from zero are measured from a nearer one.
// A place 8 sizes away has three bits less for its gaps than one within a size of zero.
const FAR_EXTENTS: f64 = 8.0;
/// Below the largest stiffness by this factor a solid counts as softer, and above the softest as stiff beside it.
const SOFTER_FACTOR: f64 = 10.0;

/// Solids, and where the parameters of each lie in the vector of all.
#[derive(Debug, Default)]
pub struct Bodies {
    solids: Vec<Box<dyn Solid>>,
    offsets: Vec<usize>,
    size: usize,
    /// Of each solid, beside the largest.
    stiffness: Vec<f64>,
    origin: Vector2<f64>,
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
        &a[self.range(body)]
    }

    /// The parameters of a solid among all, to change them.
    pub fn part_mut<'a>(&self, body: usize, a: &'a mut [f64]) -> &'a mut [f64] {
        &mut a[self.range(body)]
    }

    pub(crate) fn range(&self, body: usize) -> std::ops::Range<usize> {
        let end = self.offsets.get(body + 1).copied().unwrap_or(self.size);
        self.offsets[body]..end
    }

    /// Where a node of a boundary is.
    pub fn point(&self, body: usize, node: usize, a: &[f64]) -> Vector2<f64> {
        self.solid(body).point(self.part(body, a), node)
    }

    /// Where a cursor is, and how the boundary runs there.
    pub fn local(&self, body: usize, cursor: &Cursor, a: &[f64]) -> Local {
        cursor.local(self.solid(body), self.part(body, a))
    }

    /// `(solid, its parameters)` of each.
    pub(crate) fn each<'a>(&'a self, a: &'a [f64]) -> impl Iterator<Item = (usize, &'a dyn Solid, &'a [f64])> {
        (0..self.len()).map(move |k| (self.offsets[k], self.solid(k), self.part(k, a)))
    }

    /// The largest side of the box of any reference configuration: the scale of lengths.
    pub fn extent(&self) -> f64 {
        let extents = self.solids.iter().map(|s| s.boundary().extent());
        extents.fold(0.0, f64::max)
    }

    /// The stiffness of a solid beside a tenth of the largest of all, at most 1: solids within a decade of one another count as alike. A rigid one counts as the softest that is not: its contacts give it
    /// what it has.
    pub fn relative_stiffness(&self, body: usize) -> f64 {
        self.stiffness[body]
    }

    /// The point that constraints measure places from: zero, or where solids lie farther from it than `FAR_EXTENTS` times the largest, a point among
    /// them. A gap is a difference of places: about zero it would have the rounding of their distance from it.
    pub fn origin(&self) -> Vector2<f64> {
        self.origin
    }

    /// Adds a solid; its number.
    pub(crate) fn add(&mut self, solid: impl Solid + 'static) -> usize {
        self.offsets.push(self.size);
        self.size += solid.parameters();
        self.solids.push(Box::new(solid));
        self.compare_stiffness();
        self.find_origin();
        self.solids.len() - 1
    }

    /// Bodies that are stiff beside the softest.
    pub(crate) fn stiff(&self) -> impl Iterator<Item = usize> {
        let softest = self.stiffness.iter().copied().fold(1.0, f64::min);
        (0..self.len()).filter(move |k| self.stiffness[*k] > SOFTER_FACTOR * softest)
    }

    fn find_origin(&mut self) {
        let boxes = self.solids.iter().flat_map(|s| s.boundary().reference.iter().flatten());
        let infinity = Vector2::repeat(f64::INFINITY);
        let [low, high] = boxes.fold([infinity, -infinity], |b, x| [b[0].inf(x), b[1].sup(x)]);
        // Halves before the sum: no overflow of two large coordinates.
        let centre = low * 0.5 + high * 0.5;
        // Near zero a shift would gain nothing.
        let far = centre.amax() > FAR_EXTENTS * self.extent() && centre.iter().all(|x| x.is_finite());
        self.origin = if far { centre } else { Vector2::zeros() };
    }

    fn compare_stiffness(&mut self) {
        let own = self.solids.iter().map(|s| s.stiffness_scale());
        let soft = own.clone().filter(|s| *s > 0.0).fold(f64::INFINITY, f64::min);
        let largest = self.stiffness_scale();
        let relative = |s: f64| (SOFTER_FACTOR * if s > 0.0 { s } else { soft } / largest).min(1.0);
        self.stiffness = own.map(|s| if largest > 0.0 { relative(s) } else { 1.0 }).collect();
    }

    /// The largest stiffness, units of stress.
    pub fn stiffness_scale(&self) -> f64 {
        self.solids.iter().map(|s| s.stiffness_scale()).fold(0.0, f64::max)
    }
}
