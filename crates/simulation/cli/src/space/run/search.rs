//! The equilibrium at a stroke, from that before.

use organs::Model;
use simulation::control::Newton;
use simulation::space::equilibrium::{Equilibrium, NoEquilibrium, Tolerance, settle};

/// A step that fails is halved so many times.
const HALVINGS: u32 = 4;

/// Searches with the memory of those before.
pub(super) struct Search {
    pub(super) newton: Newton,
    pub(super) a: Vec<f64>,
    /// The stroke of the last equilibrium, and that where the tube is.
    pub(super) done: f64,
    pub(super) stroke: f64,
}

impl Search {
    /// The equilibrium with the tip at a stroke, and in how many parts it was reached. Where a step fails it goes on from the last
    /// equilibrium by half of the way.
    pub(super) fn to(&mut self, model: &mut Model, stroke: f64) -> Result<(Equilibrium, usize), NoEquilibrium> {
        let (mut part, mut parts, mut halved) = (stroke - self.done, 0, 0);
        loop {
            let next = if self.done + 1.001 * part >= stroke {
                stroke
            } else {
                self.done + part
            };
            let kept = (self.a.clone(), model.system.tubes.clone());
            match self.settle(model, next) {
                Ok(mut found) => {
                    parts += 1;
                    self.done = next;
                    if next == stroke {
                        found.1 = parts;
                        return Ok(found);
                    }
                }
                Err(why) if halved == HALVINGS => return Err(why),
                Err(_) => {
                    (self.a, model.system.tubes) = kept;
                    halved += 1;
                    part *= 0.5;
                }
            }
        }
    }

    fn settle(&mut self, model: &mut Model, stroke: f64) -> Result<(Equilibrium, usize), NoEquilibrium> {
        self.stroke = stroke;
        // The numbers of a checked way make a tube.
        if let Ok(tube) = model.way.tube(model.free + stroke) {
            model
                .system
                .tubes
                .iter_mut()
                .for_each(|contact| contact.move_to(tube.clone()));
        }
        let found = settle(&mut model.system, &mut self.newton, &mut self.a, &Tolerance::default())?;
        Ok((found, 1))
    }
}
