//! A state, with what certifies it.

use nalgebra::Vector2;
use simulation::control::Potential;
use simulation::equilibrium::Equilibrium;

use super::contact::{Contact, contacts};
use super::criteria::{BALANCE, Measures};
use super::found::Found;
use super::moved::Moved;
use crate::model::{Maker, Model};

/// A state of a run.
#[derive(Debug, Clone)]
pub(crate) struct State {
    pub(crate) label: String,
    pub(crate) a: Vec<f64>,
    /// Offsets of the walls.
    pub(crate) walls: Vec<f64>,
    /// The equilibrium; `None` where none was looked for, or found.
    pub(crate) found: Option<Equilibrium>,
    /// What certifies it.
    pub(crate) measures: Option<Measures>,
    /// Steps of all searches of the frame.
    pub(crate) iterations: usize,
    pub(crate) milliseconds: f64,
    pub(crate) contacts: Vec<Contact>,
    /// What weight, loads, contacts and held nodes leave over, beside the largest of them, by solid.
    pub(crate) balance: Vec<f64>,
    /// How far walls and instruments went.
    pub(crate) moved: Vec<Moved>,
}

impl State {
    /// A state that is no equilibrium.
    pub(super) fn placed(model: &Model, label: &str, a: Vec<f64>) -> Self {
        Self {
            label: label.to_owned(),
            a,
            walls: model.walls.iter().map(|w| w.offset).collect(),
            found: None,
            measures: None,
            iterations: 0,
            milliseconds: 0.0,
            contacts: Vec::new(),
            balance: Vec::new(),
            moved: Vec::new(),
        }
    }

    /// An equilibrium.
    pub(super) fn settled(model: &Model, label: &str, a: &[f64], found: Found) -> Self {
        let contacts = contacts(model, a, &found.makers);
        let balance: Vec<f64> = (0..model.solids.len())
            .map(|k| balance(model, a, k, &contacts, found.equilibrium.minimum.rounding))
            .collect();
        Self {
            measures: Some(Measures::of(model, a, &found, &contacts, &balance)),
            found: Some(found.equilibrium),
            iterations: found.iterations,
            milliseconds: found.milliseconds,
            balance,
            contacts,
            ..Self::placed(model, label, a.to_vec())
        }
    }

    /// The force of contacts and links on a solid.
    pub(crate) fn force_on(&self, solid: usize) -> Vector2<f64> {
        self.contacts.iter().filter(|c| c.solid == solid).map(|c| c.force).sum()
    }

    /// The moment of the same about a point, counter-clockwise.
    pub(crate) fn moment_on(&self, solid: usize, about: Vector2<f64>) -> f64 {
        let own = self.contacts.iter().filter(|c| c.solid == solid);
        own.map(|c| (c.point - about).perp(&c.force)).sum()
    }

    /// The force on a wall: against that on the solids.
    pub(crate) fn force_on_wall(&self, wall: usize) -> Vector2<f64> {
        let own = self.contacts.iter().filter(|c| c.maker == Maker::Wall(wall));
        -own.map(|c| c.force).sum::<Vector2<f64>>()
    }
}

/// What is left of the forces on a solid in a translation, beside the largest of them: weight, loads and contacts as
/// they are reported, and what holds its nodes. Elastic forces sum to nothing, so that this is independent of them.
///
/// Forces below what rounding leaves of them over the part allowed are measured by that: without any load there are no others.
fn balance(model: &Model, a: &[f64], solid: usize, contacts: &[Contact], rounding: f64) -> f64 {
    let system = &model.system;
    let (first, body) = (system.bodies.offset(solid), system.bodies.solid(solid));
    let count = body.parameters();
    let mut weight = vec![0.0; count];
    body.weight(&mut weight);
    let mut gradient = vec![0.0; a.len()];
    system.gradient(a, &mut gradient);
    let (mut left, mut largest) = (Vector2::zeros(), 0.0_f64);
    let mut add = |force: Vector2<f64>| {
        left += force;
        largest = largest.max(force.norm());
    };
    let along = |part: &dyn Fn(usize) -> f64, way: Vector2<f64>| {
        let mut unit = vec![0.0; count];
        body.translate(&mut unit, way);
        unit.iter().enumerate().map(|(i, u)| u * part(i)).sum::<f64>()
    };
    let total = |part: &dyn Fn(usize) -> f64| Vector2::new(along(part, Vector2::x()), along(part, Vector2::y()));
    add(total(&|i| weight[i]));
    add(total(&|i| system.loads[first + i]));
    // At a held unknown the gradient is the force by which its holder balances all others.
    add(total(&|i| {
        if system.fixed[first + i] {
            gradient[first + i]
        } else {
            0.0
        }
    }));
    contacts.iter().filter(|c| c.solid == solid).for_each(|c| add(c.force));
    // A sum over all unknowns of the solid.
    let measure = largest.max(count as f64 * rounding / BALANCE);
    if measure > 0.0 { left.norm() / measure } else { 0.0 }
}
