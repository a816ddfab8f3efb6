//! A system: solids, what is fixed, dead loads, and the terms that constraints add to the energy.

use super::bodies::Bodies;
use super::solid::Solid;
use super::term::{Change, ObstacleContact, OrganContact, Term, TubeContact};
use crate::control::Potential;
use crate::sparse::Triplets;

/// A system of solids. It holds no state: the vector of all parameters is the caller's.
#[derive(Debug, Default)]
pub struct System {
    /// The solids.
    pub bodies: Bodies,
    /// Unknowns that keep their value.
    pub fixed: Vec<bool>,
    /// Dead forces on the unknowns.
    pub loads: Vec<f64>,
    /// Tubes that the solids are pushed by.
    pub tubes: Vec<TubeContact>,
    /// Bones and other surfaces that do not move.
    pub obstacles: Vec<ObstacleContact>,
    /// Solids that touch one another.
    pub organs: Vec<OrganContact>,
    /// Other terms that constraints add.
    pub others: Vec<Box<dyn Term>>,
    weights: Vec<f64>,
}

impl System {
    /// A system without solids.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a solid; its number.
    pub fn add(&mut self, solid: impl Solid + 'static) -> usize {
        let mut weights = vec![0.0; solid.parameters()];
        solid.weight(&mut weights);
        self.weights.extend(weights);
        let body = self.bodies.add(solid);
        self.fixed.resize(self.bodies.size(), false);
        self.loads.resize(self.bodies.size(), 0.0);
        body
    }

    /// Adds dead forces `(parameter, force)` on a solid.
    pub fn load(&mut self, body: usize, forces: &[(usize, f64)]) {
        let start = self.bodies.offset(body);
        for (parameter, force) in forces {
            self.loads[start + parameter] += force;
        }
    }

    /// The parameters of all reference configurations.
    pub fn initial(&self) -> Vec<f64> {
        self.bodies.all().flat_map(Solid::initial).collect()
    }

    /// Lets every term take the forces at `a` as those to go on from; the largest change.
    pub fn update(&mut self, a: &[f64]) -> Change {
        let bodies = &self.bodies;
        let tubes = self.tubes.iter_mut().map(|tube| tube.update(bodies, a));
        let obstacles = self.obstacles.iter_mut().map(|bone| bone.update(bodies, a));
        let organs = self.organs.iter_mut().map(|organ| organ.update(bodies, a));
        let others = self.others.iter_mut().map(|term| term.update(bodies, a));
        let all = tubes.chain(obstacles).chain(organs).chain(others);
        all.fold(Change::default(), |one, other| Change {
            force: one.force.max(other.force),
            depth: one.depth.max(other.depth),
        })
    }

    /// The place of each unknown's node, for the order of elimination.
    pub fn places(&self) -> Vec<[f64; 3]> {
        self.bodies.all().flat_map(Solid::places).collect()
    }

    /// The terms of tubes, obstacles, organs and all others.
    pub(super) fn terms(&self) -> impl Iterator<Item = &dyn Term> {
        let tubes = self.tubes.iter().map(|tube| tube as &dyn Term);
        let obstacles = self.obstacles.iter().map(|bone| bone as &dyn Term);
        let organs = self.organs.iter().map(|organ| organ as &dyn Term);
        let others = self.others.iter().map(AsRef::as_ref);
        tubes.chain(obstacles).chain(organs).chain(others)
    }

    /// The second derivatives, overwritten: of solids where `convex` says so, of a positive semidefinite matrix near theirs, and of terms where any does.
    pub(super) fn hessian_where(&self, a: &[f64], convex: &[bool], sink: &mut Triplets) -> Option<()> {
        sink.reset(self.bodies.size());
        for ((offset, solid, part), convex) in self.bodies.each(a).zip(convex) {
            solid.hessian(part, *convex, sink, offset)?;
        }
        let any = convex.contains(&true);
        self.terms()
            .try_for_each(|term| term.hessian(&self.bodies, a, any, sink))
    }

    fn load_energy(&self, a: &[f64]) -> f64 {
        -self.loads.iter().zip(a).map(|(l, a)| l * a).sum::<f64>()
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
        for term in self.terms() {
            energy += term.energy(&self.bodies, a)?;
        }
        Some(energy)
    }

    fn gradient(&self, a: &[f64], gradient: &mut [f64]) -> Option<f64> {
        let mut energy = self.load_energy(a);
        gradient.iter_mut().zip(&self.loads).for_each(|(g, l)| *g = -l);
        for (offset, solid, part) in self.bodies.each(a) {
            energy += solid.gradient(part, &mut gradient[offset..offset + part.len()])?;
        }
        for term in self.terms() {
            energy += term.gradient(&self.bodies, a, gradient)?;
        }
        Some(energy)
    }

    fn hessian(&self, a: &[f64], convex: bool, sink: &mut Triplets) -> Option<()> {
        self.hessian_where(a, &vec![convex; self.bodies.len()], sink)
    }

    fn reach(&self, a: &[f64], step: &[f64]) -> f64 {
        let each = self.terms().map(|term| term.reach(&self.bodies, a, step));
        each.fold(1.0, f64::min)
    }

    fn fixed(&self) -> &[bool] {
        &self.fixed
    }

    fn load(&self, i: usize) -> f64 {
        self.weights[i] + self.loads[i]
    }

    fn work(&self, a: &[f64]) -> f64 {
        let each = a.iter().enumerate();
        each.map(|(i, a)| (Potential::load(self, i) * a).abs()).sum()
    }

    fn reaction(&self, a: &[f64]) -> f64 {
        let each = self.terms().map(|term| term.reaction(&self.bodies, a));
        each.fold(0.0, f64::max)
    }

    /// Of the solids: stiffness times displacement, and where nothing is loaded the size of the solid is counted in.
    fn rounding(&self, a: &[f64], sizes: &mut Vec<f64>) {
        // Contacts hold differences of places, which are not large beside the solids here: they are left out.
        let mut elastic = Triplets::new(self.size());
        let unloaded = (0..self.size()).all(|i| Potential::load(self, i) == 0.0);
        let mut lengths = Vec::with_capacity(a.len());
        for (offset, solid, part) in self.bodies.each(a) {
            let known = solid.hessian(part, false, &mut elastic, offset).is_some();
            let size = if unloaded && known { solid.extent() } else { 0.0 };
            lengths.extend(part.iter().map(|u| u.abs() + size));
        }
        sizes.clear();
        sizes.extend(elastic.absolute_product(&lengths));
    }

    fn extent(&self) -> f64 {
        self.bodies.extent()
    }

    fn stiffness(&self) -> f64 {
        let scale = self.bodies.stiffness_scale();
        if scale > 0.0 { scale } else { f64::INFINITY }
    }

    fn least_determinant(&self, a: &[f64]) -> f64 {
        let each = self
            .bodies
            .each(a)
            .map(|(_, solid, part)| solid.least_determinant(part));
        each.fold(f64::INFINITY, f64::min)
    }
}
