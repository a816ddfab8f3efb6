//! Exact contact from frame to frame: a wall has moved or a load has changed since the rows were solved.

use super::aims::Aims;
use super::polish::{Polished, polish};
use super::save;
use crate::control::Newton;
use crate::system::System;

/// Quickly, from the rows and forces that there are; where that does not converge, carefully from the same.
pub(super) fn follow(system: &mut System, newton: &mut Newton, a: &mut Vec<f64>) -> Polished {
    let saved = save(system, a);
    let quick = polish(system, newton, a, Aims::Quick);
    if quick.done {
        return quick;
    }
    (*a, system.terms) = saved;
    let careful = polish(system, newton, a, Aims::Careful);
    Polished {
        steps: quick.steps + careful.steps,
        ..careful
    }
}
