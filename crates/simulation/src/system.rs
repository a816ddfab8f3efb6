//! A system: solids, what is fixed, dead loads, and the terms that constraints add to the energy.

use crate::bodies::Bodies;
use crate::constraint::{Change, Constraint, Force, Stage};
use crate::control::Potential;
use crate::solid::Solid;
use crate::sparse::Triplets;
use crate::turn;

/// A system of solids. It holds no state: the vector of all parameters is the caller's.
#[derive(Debug, Default)]
pub struct System {
    /// The solids.
    pub bodies: Bodies,
    /// Unknowns that keep their value.
    pub fixed: Vec<bool>,
    /// Dead forces on the unknowns.
    pub loads: Vec<f64>,
    /// What weights and dead forces are multiplied by: 1, less on the way to a large load. Only loads scale: the weight
    /// inside a solid's energy is scaled by adding the rest as a dead force.
    pub load_factor: f64,
    /// Terms that constraints add.
    pub terms: Vec<Box<dyn Constraint>>,
    weights: Vec<f64>,
}

impl System {
    /// A system without solids.
    pub fn new() -> Self {
        Self {
            load_factor: 1.0,
            ..Self::default()
        }
    }

    /// Adds a solid; its number.
    pub fn add(&mut self, solid: impl Solid + 'static) -> usize {
        let mut weights = vec![0.0; solid.parameters()];
        solid.weight(&mut weights);
        let body = self.bodies.add(solid);
        self.weights.extend(weights);
        self.fixed.resize(self.bodies.size(), false);
        self.loads.resize(self.bodies.size(), 0.0);
        body
    }

    /// The parameters of all reference configurations.
    pub fn initial(&self) -> Vec<f64> {
        (0..self.bodies.len())
            .flat_map(|k| self.bodies.solid(k).initial())
            .collect()
    }

    /// Keeps all parameters that move a node of a boundary as they are: for meshes, where they are the node's own.
    pub fn clamp(&mut self, body: usize, nodes: &[usize]) {
        let start = self.bodies.offset(body);
        let at_rest = self.bodies.solid(body).initial();
        for node in nodes {
            let fixed = &mut self.fixed;
            self.bodies
                .solid(body)
                .rows(&at_rest, *node, &mut |p, _| fixed[start + p] = true);
        }
    }

    /// Adds dead forces `(parameter, force)` on a solid.
    pub fn load(&mut self, body: usize, forces: &[(usize, f64)]) {
        let start = self.bodies.offset(body);
        for (parameter, force) in forces {
            self.loads[start + parameter] += force;
        }
    }

    /// Lets every term take the state found as its next start; how far they were from it.
    pub fn update(&mut self, a: &[f64]) -> Change {
        let bodies = &self.bodies;
        let each = self.terms.iter_mut().map(|term| term.update(bodies, a));
        each.fold(Change::default(), Change::max)
    }

    /// The forces of all constraints at work.
    pub fn forces(&self, a: &[f64]) -> Vec<Force> {
        self.terms
            .iter()
            .flat_map(|term| term.forces(&self.bodies, a))
            .collect()
    }

    /// What is missing of the loads at the factor: forces, to be added to the gradient and, times `a`, to the energy.
    fn missing(&self, i: usize) -> f64 {
        // Solids hold `-w a` of their whole weight: `(1 - f) w a` leaves `-f w a` of it, and `-f l a` is that of the
        // dead force.
        (1.0 - self.load_factor) * self.weights[i] - self.load_factor * self.loads[i]
    }

    fn load_energy(&self, a: &[f64]) -> f64 {
        a.iter().enumerate().map(|(i, a)| self.missing(i) * a).sum()
    }

    /// The least determinant of any solid.
    pub fn least_determinant(&self, a: &[f64]) -> f64 {
        let each = self
            .bodies
            .each(a)
            .map(|(_, solid, part)| solid.least_determinant(part));
        each.fold(f64::INFINITY, f64::min)
    }
}

impl Potential for System {
    fn size(&self) -> usize {
        self.bodies.size()
    }

    fn energy(&self, a: &[f64]) -> Option<f64> {
        let mut energy = self.load_energy(a);
        for (_, solid, part) in self.bodies.each(a) {
            energy += solid.energy(part)?;
        }
        for term in &self.terms {
            energy += term.energy(&self.bodies, a)?;
        }
        Some(energy)
    }

    fn gradient(&self, a: &[f64], gradient: &mut [f64]) -> Option<f64> {
        let mut energy = self.load_energy(a);
        for (i, g) in gradient.iter_mut().enumerate() {
            *g = self.missing(i);
        }
        for (offset, solid, part) in self.bodies.each(a) {
            energy += solid.gradient(part, &mut gradient[offset..offset + part.len()])?;
        }
        for term in &self.terms {
            energy += term.gradient(&self.bodies, a, gradient)?;
        }
        Some(energy)
    }

    fn hessian(&self, a: &[f64], convex: bool, sink: &mut Triplets) -> Option<()> {
        sink.reset(self.size());
        for (offset, solid, part) in self.bodies.each(a) {
            solid.hessian(part, convex, sink, offset)?;
        }
        for term in &self.terms {
            term.hessian(&self.bodies, a, convex, sink)?;
        }
        Some(())
    }

    fn reach(&self, a: &[f64], step: &[f64]) -> f64 {
        let each = self.terms.iter().map(|term| term.reach(&self.bodies, a, step));
        each.fold(1.0, f64::min)
    }

    fn fixed(&self) -> &[bool] {
        &self.fixed
    }

    fn load(&self, i: usize) -> f64 {
        self.load_factor * (self.weights[i] + self.loads[i])
    }

    fn reaction(&self, a: &[f64]) -> f64 {
        let forces = self.forces(a).into_iter();
        forces.map(|f| f.force.norm()).fold(0.0, f64::max)
    }

    /// Of solids with their displacements, and where nothing is loaded with their sizes; of barriers and links with the places that they
    /// take differences of. Rows of exact contact have forces of their own, which gaps do not enter.
    fn rounding(&self, a: &[f64], sizes: &mut Vec<f64>) {
        let (mut elastic, mut held) = (Triplets::new(self.size()), Triplets::new(self.size()));
        let unloaded = (0..self.size()).all(|i| Potential::load(self, i) == 0.0);
        let (mut lengths, mut places) = (Vec::new(), Vec::new());
        for (offset, solid, part) in self.bodies.each(a) {
            let known = solid.hessian(part, false, &mut elastic, offset).is_some();
            // A displacement of zero has no rounding, yet an unloaded solid needs a scale of forces: its size gives
            // one.
            let size = if unloaded && known {
                solid.boundary().extent()
            } else {
                0.0
            };
            lengths.extend(part.iter().map(|u| u.abs() + size));
            let outline = solid.outline_about(part, self.bodies.origin());
            let far = outline.into_iter().flatten().map(|x| x.amax());
            places.resize(offset + part.len(), far.fold(0.0, f64::max));
        }
        for term in self.terms.iter().filter(|t| t.stage() != Stage::Exact) {
            // Without second derivatives nothing is taken for rounding.
            let _ = term.hessian(&self.bodies, a, false, &mut held);
        }
        let held = held.absolute_product(&places);
        sizes.clear();
        sizes.extend(elastic.absolute_product(&lengths).iter().zip(held).map(|(e, h)| e + h));
    }

    fn extent(&self) -> f64 {
        self.bodies.extent()
    }

    fn stiffness(&self) -> f64 {
        let scale = self.bodies.stiffness_scale();
        // Rigid solids alone have no scale: infinite, it leaves the matrix's own in a minimum of both.
        if scale > 0.0 { scale } else { f64::INFINITY }
    }

    fn turned(&self, a: &[f64], step: &[f64]) -> Option<Vec<f64>> {
        let bodies = &self.bodies;
        let mut turned: Option<Vec<f64>> = None;
        for body in bodies.stiff() {
            // What is held somewhere cannot turn as a whole.
            if self.fixed[bodies.range(body)].contains(&true) {
                continue;
            }
            let more = turn::bent(bodies.solid(body), bodies.part(body, a), bodies.part(body, step));
            let all = turned.get_or_insert_with(|| step.to_vec());
            bodies
                .part_mut(body, all)
                .iter_mut()
                .zip(more)
                .for_each(|(s, m)| *s += m);
        }
        turned
    }

    fn relative_stiffness(&self, parts: &mut Vec<f64>) {
        parts.clear();
        for body in 0..self.bodies.len() {
            let own = self.bodies.relative_stiffness(body);
            parts.extend(std::iter::repeat_n(own, self.bodies.solid(body).parameters()));
        }
    }

    fn least_determinant(&self, a: &[f64]) -> f64 {
        Self::least_determinant(self, a)
    }
}
