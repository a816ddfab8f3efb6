//! Forces of contact and of links, by who makes them.

use nalgebra::Vector2;

use crate::model::{Maker, Model};

/// A force of contact or of a link on a solid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Contact {
    /// Who makes it.
    pub(crate) maker: Maker,
    /// The solid.
    pub(crate) solid: usize,
    /// Where.
    pub(crate) point: Vector2<f64>,
    /// The force on the solid, of a unit of depth.
    pub(crate) force: Vector2<f64>,
    /// The distance to what is touched.
    pub(crate) gap: f64,
}

/// All of them in a state; `makers` is who makes each term of the system.
pub(super) fn contacts(model: &Model, a: &[f64], makers: &[Maker]) -> Vec<Contact> {
    let bodies = &model.system.bodies;
    let each = model.system.terms.iter().zip(makers);
    let all = each.flat_map(|(term, maker)| term.forces(bodies, a).into_iter().map(move |f| (f, *maker)));
    all.map(|(f, maker)| Contact {
        maker,
        solid: f.body,
        point: f.point,
        force: f.force,
        gap: f.gap,
    })
    .collect()
}
