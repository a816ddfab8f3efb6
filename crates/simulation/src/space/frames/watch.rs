//! What the tube does to the surface: the force on it, and places where it may not be.

use nalgebra::Vector3;

use super::Frames;
use super::around::Around;
use super::report::Refused;
use crate::space::solid::Inner;
use crate::space::system::System;
use crate::space::term::{ContactForce, DEEPEST_PART, MOST_INSIDE, SEEN_AT, TubeForce, gap_at};
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

    /// The deepest that a point inside solids is in what has a number, mm; 0 where none is. In a tube points of all, in bone of the solid that may touch it.
    fn inside(&self, system: &System, a: &[f64], around: &Around<'_>, number: usize) -> f64 {
        let own = |body: usize| number == 0 || around.bones[number - 1].body() == body;
        let depth = |(body, inner): &(usize, Inner)| {
            let at = inner.place(system.bodies.part(*body, a));
            around.within(number, &at, 0.0).map_or(0.0, |distance| -distance.value)
        };
        let inner = self.inner.iter().filter(|(body, _)| own(*body));
        inner.map(depth).fold(0.0, f64::max)
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
        let (touches, around) = (&self.contact.touches, self.around(tube));
        // Depth and gap by what points are at.
        let mut found = vec![(0.0_f64, 0.0_f64); 1 + self.bones.len()];
        found[0].1 = wide;
        for point in 0..touches.len() {
            let area = touches.area(point);
            if let Some(distance) = touches.within(point, v, &around, SEEN_AT * area.sqrt()) {
                let (depth, gap) = &mut found[touches.with(point)];
                (*depth, *gap) = (depth.max(-distance.value), gap.max(gap_at(area, distance.value)));
            }
        }
        for (number, (depth, gap)) in found.into_iter().enumerate() {
            let most = DEEPEST_PART * around.rigid(number).radius();
            if depth > most {
                return Err(Refused::TooDeep { depth, most });
            }
            if gap > most {
                return Err(Refused::TooCoarse { gap, most });
            }
        }
        Ok(())
    }

    /// Refuses a state in which tissue is in the tube or bone though its surface is not: that has come through between points, which press
    /// on it no more.
    pub(super) fn look_inside(&self, tube: &Tube, a: &[f64]) -> Result<(), Refused> {
        let around = self.around(tube);
        (0..=self.bones.len()).try_for_each(|number| {
            let depth = self.others.inside(&self.system, a, &around, number);
            let most = MOST_INSIDE * DEEPEST_PART * around.rigid(number).radius();
            match depth > most {
                true => Err(Refused::Through { depth, most }),
                false => Ok(()),
            }
        })
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
        self.force_on(0)
    }

    /// What the tissue does to bone `bone`, counted as in [`System::obstacles`], by the pressures of the last frame; moments are about the origin of all places.
    /// `None` where there is no such bone.
    pub fn bone_force(&self, bone: usize) -> Option<ContactForce> {
        (bone < self.bones.len()).then(|| self.force_on(bone + 1))
    }

    fn force_on(&self, number: usize) -> ContactForce {
        let (mut v, touches) = (Vec::new(), &self.contact.touches);
        touches.take(&self.now.a, &mut v);
        let around = self.around(&self.now.tube);
        let origin = around.rigid(number).centre();
        let mut sum = ContactForce {
            force: Vector3::zeros(),
            moment: Vector3::zeros(),
            points: 0,
            area: 0.0,
            depth: 0.0,
        };
        for point in (0..touches.len()).filter(|point| touches.with(*point) == number) {
            let pressure = self.now.pressures[point];
            let most = if pressure > 0.0 { f64::INFINITY } else { 0.0 };
            let Some(distance) = touches.within(point, &v, &around, most) else {
                continue;
            };
            sum.depth = sum.depth.max(-distance.value);
            // By the pressures, not by depths: at the end there are none.
            if pressure > 0.0 {
                let area = touches.area(point);
                let on_it = distance.gradient * (-area * pressure);
                sum.force += on_it;
                sum.moment += (touches.at(point, &v) - origin).cross(&on_it);
                sum.points += 1;
                sum.area += area;
            }
        }
        sum
    }
}
