//! What a result says of itself, from the forces that it reports.

use nalgebra::Vector2;

use crate::control::Potential;
use crate::system::System;

/// Complementarity, the least gap, and the imbalance of the worst solid: see [`super::Equilibrium`].
pub(super) fn certify(system: &System, a: &[f64], load: f64) -> [f64; 3] {
    // Without any force the quotients below are zero, and not NaN.
    let (bodies, load) = (&system.bodies, load.max(f64::MIN_POSITIVE));
    let mut sums = vec![Vector2::zeros(); bodies.len()];
    let (mut work, mut least) = (0.0_f64, f64::INFINITY);
    for force in system.forces(a) {
        sums[force.body] += force.force;
        // What is pressed harder than by the loads, as walls that move may do, is measured by its own force.
        let size = force.force.norm();
        work = work.max(size * force.gap.abs() / size.max(load));
        least = least.min(force.gap);
    }
    let mut worst = 0.0_f64;
    for (body, sum) in sums.iter().enumerate() {
        let (start, count) = (bodies.offset(body), bodies.solid(body).parameters());
        // The reactions of its supports are not among the forces: their sum is not zero.
        if system.fixed[start..start + count].iter().any(|fixed| *fixed) {
            continue;
        }
        // The work of all generalised loads in a unit translation is their resultant, whatever the parameters are.
        let loads = [Vector2::x(), Vector2::y()].map(|axis| {
            let mut along = vec![0.0; count];
            bodies.solid(body).translate(&mut along, axis);
            let each = along
                .iter()
                .enumerate()
                .map(|(k, by)| by * Potential::load(system, start + k));
            each.sum::<f64>()
        });
        worst = worst.max((sum + Vector2::new(loads[0], loads[1])).norm());
    }
    let extent = bodies.extent().max(f64::MIN_POSITIVE);
    [work / extent, least, worst / load]
}
