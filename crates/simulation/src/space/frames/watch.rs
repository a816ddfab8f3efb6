//! What the tube does to the surface: the force on it, and places where it may not be.

use nalgebra::Vector3;

use super::Frames;
use super::report::Refused;
use crate::space::solid::Inner;
use crate::space::system::System;
use crate::space::term::{DEEPEST_PART, MOST_INSIDE, TubeForce, gap_at};
use crate::space::tube::Tube;

/// Points of surfaces where no contact is prepared, and the area that each stands for; and points inside solids.
#[derive(Debug, Clone)]
pub(super) struct Others {
    points: Vec<(usize, usize, f64)>,
    inner: Vec<(usize, Inner)>,
}

impl Others {
    pub(super) fn new(system: &System, body: usize, wanted: &impl Fn(&Vector3<f64>, &Vector3<f64>) -> bool) -> Self {
        let all = (0..system.bodies.len()).flat_map(|b| (0..system.bodies.solid(b).points()).map(move |p| (b, p)));
        let outside = all.filter_map(|(b, point)| {
            let (at, normal, area) = system.bodies.solid(b).reference(point);
            (b != body || !wanted(&at, &normal)).then_some((b, point, area))
        });
        let inner =
            (0..system.bodies.len()).flat_map(|b| system.bodies.solid(b).inner().into_iter().map(move |i| (b, i)));
        Self {
            points: outside.collect(),
            inner: inner.collect(),
        }
    }

    /// The deepest that a point inside a solid is in a tube, mm; 0 where none is.
    fn inside(&self, system: &System, a: &[f64], tube: &Tube) -> f64 {
        let depth = |(body, inner): &(usize, Inner)| {
            let at = inner.place(system.bodies.part(*body, a));
            -tube.signed_distance(&at).value
        };
        self.inner.iter().map(depth).fold(0.0, f64::max)
    }

    /// How deep a tube is in surfaces where no contact is prepared, and the widest gap between their points at it, mm; 0 where none is.
    fn look(&self, system: &System, a: &[f64], tube: &Tube) -> (f64, f64) {
        self.points
            .iter()
            .fold((0.0, 0.0), |(depth, gap), (body, point, area)| {
                let at = system.bodies.solid(*body).point(system.bodies.part(*body, a), *point);
                let distance = tube.signed_distance(&at).value;
                (f64::max(depth, -distance), f64::max(gap, gap_at(*area, distance)))
            })
    }
}

impl Frames {
    /// Refuses a tube that points of surfaces cannot tell of, or that is too deep for a way out.
    pub(super) fn watch(&self, tube: &Tube, a: &[f64], v: &[f64]) -> Result<(), Refused> {
        let (deep, wide) = self.others.look(&self.system, a, tube);
        if deep > self.settings.depth {
            return Err(Refused::OutOfReach { depth: deep });
        }
        let most = DEEPEST_PART * tube.least_radius();
        let touches = &self.contact.touches;
        let distances = (0..touches.len()).map(|point| (touches.area(point), touches.distance(point, v, tube).value));
        let (mut depth, mut gap) = (0.0_f64, wide);
        for (area, distance) in distances {
            (depth, gap) = (depth.max(-distance), gap.max(gap_at(area, distance)));
        }
        if depth > most {
            return Err(Refused::TooDeep { depth, most });
        }
        if gap > most {
            return Err(Refused::TooCoarse { gap, most });
        }
        Ok(())
    }

    /// Refuses a state in which tissue is in the tube though its surface is not: the tube has come through between points, which press
    /// on it no more.
    pub(super) fn look_inside(&self, tube: &Tube, a: &[f64]) -> Result<(), Refused> {
        let (depth, most) = (
            self.others.inside(&self.system, a, tube),
            MOST_INSIDE * DEEPEST_PART * tube.least_radius(),
        );
        if depth > most {
            return Err(Refused::Through { depth, most });
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
            // By the pressures, not by depths: at the end there are none.
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
