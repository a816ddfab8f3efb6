//! Away from a saddle in exact contact.

use super::aims::Aims;
use super::polish::polish;
use super::save;
use crate::control::{Newton, Potential};
use crate::system::System;

/// Lengths of the way along the falling direction, in largest solids, that are tried either way.
const WAYS_EXTENTS: [f64; 2] = [1e-3, 1e-2];
/// Of the way to the first touch.
const BEFORE_TOUCH: f64 = 0.9;
/// The energy must fall by this part of it: more than rounding.
const ENERGY_FALL: f64 = 1e-12;

/// Goes a little way in the direction in which the energy was last found to fall, and to the exact contact from there. `None`, and nothing
/// changed, where that has no less energy; else how many steps it took.
///
/// The rows have no energy, so a line search along the direction would go through walls: the steps to exact contact do not.
pub(super) fn leave(system: &mut System, newton: &mut Newton, a: &mut Vec<f64>) -> Option<usize> {
    let mut direction = newton.negative_curvature()?;
    for (d, fixed) in direction.iter_mut().zip(&system.fixed) {
        *d = if *fixed { 0.0 } else { *d };
    }
    let length = direction.iter().fold(0.0_f64, |m, d| m.max(d.abs()));
    let before = Potential::energy(system, a)?;
    let (start, terms) = save(system, a);
    let mut steps = 0;
    // Both ways and two lengths: the energy falls along the direction either way, and contact may stop one.
    for way in WAYS_EXTENTS.iter().flat_map(|way| [*way, -*way]) {
        let by: Vec<f64> = direction
            .iter()
            .map(|d| d * way * system.bodies.extent() / length)
            .collect();
        let reach = system.reach(&start, &by);
        let part = if reach < 1.0 { BEFORE_TOUCH * reach } else { 1.0 };
        *a = start.iter().zip(&by).map(|(a, b)| a + part * b).collect();
        let polished = polish(system, newton, a, Aims::Careful);
        steps += polished.steps;
        let lower = |energy: f64| energy < before - ENERGY_FALL * before.abs();
        if polished.done && Potential::energy(system, a).is_some_and(lower) {
            return Some(steps);
        }
        // The rows have gone with the try: back to those of the saddle.
        system.terms = terms.iter().map(|t| t.copy()).collect();
    }
    *a = start;
    None
}
