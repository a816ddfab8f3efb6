//! The equilibrium at a stroke, from those before.

use organs::Model;
use simulation::control::Newton;
use simulation::space::equilibrium::{Equilibrium, NoEquilibrium, Tolerance, settle};

use super::parts::Parts;

/// Searches with the memory of those before.
pub(super) struct Search {
    pub(super) newton: Newton,
    pub(super) a: Vec<f64>,
    /// The stroke of the last equilibrium, and that where the tube is.
    pub(super) done: f64,
    pub(super) stroke: f64,
    pub(super) parts: Parts,
}

impl Search {
    /// Begins where nothing touches yet.
    pub(super) fn new(newton: Newton, a: Vec<f64>, parts: Parts) -> Self {
        Self {
            newton,
            a,
            done: 0.0,
            stroke: 0.0,
            parts,
        }
    }

    /// The equilibrium at a stroke, and in how many parts it was reached. Where a part fails it goes on from the last equilibrium
    /// by half of it, down to the least.
    pub(super) fn to(&mut self, model: &mut Model, stroke: f64) -> Result<(Equilibrium, usize), NoEquilibrium> {
        let mut count = 0;
        loop {
            let next = self.parts.next(self.done, stroke);
            let kept = (self.a.clone(), model.system.tubes.clone());
            match self.settle(model, next) {
                Ok(found) => {
                    count += 1;
                    self.done = next;
                    self.parts.found();
                    if next == stroke {
                        return Ok((found, count));
                    }
                }
                Err(why) if !self.parts.failed(next - self.done) => return Err(why),
                Err(_) => (self.a, model.system.tubes) = kept,
            }
        }
    }

    fn settle(&mut self, model: &mut Model, stroke: f64) -> Result<Equilibrium, NoEquilibrium> {
        self.stroke = stroke;
        // The numbers of a checked way make a tube.
        if let Ok(tube) = model.way.tube(model.free + stroke) {
            model
                .system
                .tubes
                .iter_mut()
                .for_each(|contact| contact.move_to(tube.clone()));
        }
        settle(&mut model.system, &mut self.newton, &mut self.a, &Tolerance::default())
    }
}
