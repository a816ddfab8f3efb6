//! What the tube does to the surface: the force on it, and places where it may not be.

use nalgebra::Vector3;

use super::report::Refused;
use super::{Frames, PART_OF_RADIUS};
use crate::space::system::System;
use crate::space::term::TubeForce;
use crate::space::tube::Tube;

/// Points of surfaces where no contact is prepared.
#[derive(Debug, Clone)]
pub(super) struct Others {
    points: Vec<(usize, usize)>,
}

impl Others {
    pub(super) fn new(system: &System, body: usize, wanted: &impl Fn(&Vector3<f64>, &Vector3<f64>) -> bool) -> Self {
        let all = (0..system.bodies.len()).flat_map(|b| (0..system.bodies.solid(b).points()).map(move |p| (b, p)));
        let outside = all.filter(|(b, point)| {
            let (at, normal, _) = system.bodies.solid(*b).reference(*point);
            *b != body || !wanted(&at, &normal)
        });
        Self {
            points: outside.collect(),
        }
    }

    /// How deep a tube is in surfaces where no contact is prepared, mm; 0 where it is not.
    pub(super) fn depth(&self, system: &System, a: &[f64], tube: &Tube) -> f64 {
        let depth = |(body, point): &(usize, usize)| {
            let at = system.bodies.solid(*body).point(system.bodies.part(*body, a), *point);
            -tube.signed_distance(&at).value
        };
        self.points.iter().map(depth).fold(0.0, f64::max)
    }
}

impl Frames {
    /// Refuses a tube that the prepared points of the surface cannot tell of.
    pub(super) fn watch(&self, tube: &Tube, a: &[f64], v: &[f64]) -> Result<(), Refused> {
        let depth = self.others.depth(&self.system, a, tube);
        if depth > self.settings.depth {
            return Err(Refused::OutOfReach { depth });
        }
        let most = tube.least_radius() * (0.9 - PART_OF_RADIUS);
        let touches = &self.contact.touches;
        let gap = |point: usize| {
            let side = touches.area(point).sqrt();
            // Of Gauss points of a square the middle of four is three quarters of the root of their area away from them.
            let near = touches.distance(point, v, tube).value < 1.5 * side;
            if near { 0.75 * side } else { 0.0 }
        };
        let gap = (0..touches.len()).map(gap).fold(0.0, f64::max);
        if gap > most {
            return Err(Refused::TooCoarse { gap, most });
        }
        Ok(())
    }

    /// The work of the tube on its way from one pose to where it is, by the mean of its forces.
    pub(super) fn work(&self, from: &Tube, before: &TubeForce) -> f64 {
        let (from, to, after) = (from.pose(), self.now.tube.pose(), self.force());
        let way = to.translation.vector - from.translation.vector;
        let turn = from.rotation.rotation_to(&to.rotation).scaled_axis();
        -0.5 * ((before.force + after.force).dot(&way) + (before.moment + after.moment).dot(&turn))
    }

    /// What the tissue does to the tube, by the pressures of the last frame.
    pub fn force(&self) -> TubeForce {
        let mut v = Vec::new();
        let (contact, tube) = (&self.contact, &self.now.tube);
        contact.touches.take(&self.now.a, &mut v);
        let origin = tube.pose().translation.vector;
        let mut sum = TubeForce {
            force: Vector3::zeros(),
            moment: Vector3::zeros(),
            points: 0,
            area: 0.0,
            depth: 0.0,
        };
        for point in 0..contact.touches.len() {
            let at = contact.touches.at(point, &v);
            let distance = tube.signed_distance(&at);
            sum.depth = sum.depth.max(-distance.value);
            if self.now.pressures[point] > 0.0 {
                let area = contact.touches.area(point);
                let on_tube = distance.gradient * (-area * self.now.pressures[point]);
                sum.force += on_tube;
                sum.moment += (at - origin).cross(&on_tube);
                sum.points += 1;
                sum.area += area;
            }
        }
        sum
    }
}
