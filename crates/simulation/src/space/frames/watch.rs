//! What the tube does to the surface: the force on it, and places where it may not be.

use nalgebra::Vector3;

use super::Frames;
use super::around::Around;
use super::report::Refused;
use super::touch::is_moved;
use crate::space::gap::{gap_at, seen_from, widest_on_the_way};
use crate::space::level_set::Unproved;
use crate::space::solid::Inner;
use crate::space::system::System;
use crate::space::term::{ContactForce, DEEPEST_PART, MOST_INSIDE, ObstacleContact, TubeForce, depth_or_all};
use crate::space::tube::Tube;

/// Cubes are near the tube whose middle is within so many of their sides.
const NEAR_SIDES: f64 = 2.0;

/// A point of a surface where no contact with the tube (number 0) or bone is prepared: its solid, its number there, and half of the way to the next at rest.
#[derive(Debug, Clone)]
struct Other {
    with: usize,
    body: usize,
    point: usize,
    gap: f64,
}

/// What a state looks like at the tube and at bones.
#[derive(Debug, Clone)]
struct Seen {
    /// The deepest point where no contact is prepared, mm.
    unprepared: f64,
    /// By number, the deepest point where one is, and the widest gap between points, mm.
    each: Vec<(f64, f64)>,
}

/// Points of surfaces where no contact is prepared; and points inside solids.
#[derive(Debug, Clone)]
pub(super) struct Others {
    points: Vec<Other>,
    inner: Vec<(usize, Inner)>,
}

impl Others {
    pub(super) fn new(
        system: &System,
        bones: &[ObstacleContact],
        wanted: &impl Fn(usize, &Vector3<f64>, &Vector3<f64>) -> bool,
    ) -> Self {
        let all = (0..system.bodies.len()).flat_map(|b| (0..system.bodies.solid(b).points()).map(move |p| (b, p)));
        let other = |with: usize, body: usize, point: usize| Other {
            with,
            body,
            point,
            gap: system.bodies.solid(body).gap(point),
        };
        // At the tube also those that nothing moves: the tube may not be in them.
        let at_tube = all.filter(|(b, point)| {
            let (at, normal, _) = system.bodies.solid(*b).reference(*point);
            !wanted(*b, &at, &normal) || !is_moved(system, *b, *point)
        });
        let mut points: Vec<Other> = at_tube.map(|(b, point)| other(0, b, point)).collect();
        for (number, bone) in bones.iter().enumerate() {
            let mut prepared: Vec<usize> = bone.points().map(|(point, _)| point).collect();
            prepared.sort_unstable();
            // What is held in bone stays there.
            let at_bone = (0..system.bodies.solid(bone.body()).points())
                .filter(|point| prepared.binary_search(point).is_err() && is_moved(system, bone.body(), *point));
            points.extend(at_bone.map(|point| other(number + 1, bone.body(), point)));
        }
        let inner =
            (0..system.bodies.len()).flat_map(|b| system.bodies.solid(b).inner().into_iter().map(move |i| (b, i)));
        Self {
            points,
            inner: inner.collect(),
        }
    }

    /// How far points of the tissue, of surfaces and inside, lie apart in two states at most, along an axis, mm. Not nodes: one of a cube that the
    /// surface cuts may lie outside, where hardly any material holds it, and moves by millimetres where no tissue moves by a hundredth of one.
    pub(super) fn apart(&self, system: &System, a: &[f64], b: &[f64]) -> f64 {
        let bodies = &system.bodies;
        // Places, not displacements: solids that are moved as blocks turn, too.
        let surfaces = (0..bodies.len()).flat_map(|body| {
            let (solid, a, b) = (bodies.solid(body), bodies.part(body, a), bodies.part(body, b));
            (0..solid.points()).map(move |point| solid.point(b, point) - solid.point(a, point))
        });
        let inside = self.inner.iter();
        let inside =
            inside.map(|(body, inner)| inner.place(bodies.part(*body, b)) - inner.place(bodies.part(*body, a)));
        surfaces
            .chain(inside)
            .map(|moved| depth_or_all(moved.amax()))
            .fold(0.0, f64::max)
    }

    /// The deepest that a point inside solids is in what has a number, mm; 0 where none is. In a tube points of all, in bone of the solid that may touch it.
    fn inside(&self, system: &System, a: &[f64], around: &Around<'_>, number: usize) -> f64 {
        let own = |body: usize| number == 0 || around.bones[number - 1].body() == body;
        let depth = |(body, inner): &(usize, Inner)| {
            let at = inner.place(system.bodies.part(*body, a));
            let near = around.within(number, &at, 0.0);
            near.map_or(0.0, |distance| depth_or_all(-distance.value))
        };
        let inner = self.inner.iter().filter(|(body, _)| own(*body));
        inner.map(depth).fold(0.0, f64::max)
    }

    /// How deep the tube and bones are in surfaces where no contact is prepared, and the widest gap between their points at the tube, mm; 0 where none is.
    fn look(&self, system: &System, a: &[f64], around: &Around<'_>, gaps: bool) -> (f64, f64) {
        let (mut depth, mut gap) = (0.0_f64, 0.0_f64);
        for other in &self.points {
            let (solid, part) = (system.bodies.solid(other.body), system.bodies.part(other.body, a));
            let most = match other.with {
                0 if gaps => seen_from(around.rigid(0).radius(), other.gap),
                _ => 0.0,
            };
            let near = around.within(other.with, &solid.point(part, other.point), most);
            // What is no number is deeper than any.
            let Some(near) = near.filter(|near| near.value.is_nan() || near.value <= most) else {
                continue;
            };
            depth = depth.max(depth_or_all(-near.value));
            if other.with == 0 && gaps {
                let stretch = solid.stretch(part, other.point);
                gap = gap.max(gap_at(other.gap * stretch, near.value));
            }
        }
        (depth, gap)
    }
}

fn widest(seen: &Seen) -> f64 {
    seen.each.iter().map(|(_, gap)| *gap).fold(0.0, f64::max)
}

impl Frames {
    /// Depths; and gaps too, which cost more.
    fn seen(&self, tube: &Tube, a: &[f64], v: &[f64], gaps: bool) -> Seen {
        let (touches, around) = (&self.contact.touches, self.around(tube));
        let (unprepared, wide) = self.others.look(&self.system, a, &around, gaps);
        let mut each = vec![(0.0_f64, 0.0_f64); 1 + self.bones.len()];
        each[0].1 = wide;
        for point in 0..touches.len() {
            let with = touches.with(point);
            let most = match gaps {
                true => seen_from(around.rigid(with).radius(), touches.gap(point)),
                false => 0.0,
            };
            let near = touches.within(point, v, &around, most);
            let Some(near) = near.filter(|near| near.value.is_nan() || near.value <= most) else {
                continue;
            };
            let (depth, gap) = &mut each[with];
            *depth = depth.max(depth_or_all(-near.value));
            if gaps {
                // The widest way of a long thin part counts for all of it.
                let wide = touches.gap(point) * touches.stretch(point, &self.system, a);
                *gap = gap.max(gap_at(wide, near.value));
            }
        }
        Seen { unprepared, each }
    }

    /// The widest gap between points of the surface at tube or bone, mm.
    pub(super) fn gap(&self, tube: &Tube, a: &[f64]) -> f64 {
        let mut v = Vec::new();
        self.contact.touches.take(a, &mut v);
        widest(&self.seen(tube, a, &v, true))
    }

    /// Refuses a tube that points of surfaces cannot tell of, or that is too deep for a way out; the widest gap between points else, mm,
    /// where `gaps` are looked at.
    pub(super) fn watch(&self, tube: &Tube, a: &[f64], v: &[f64], gaps: bool) -> Result<f64, Refused> {
        let (seen, around) = (self.seen(tube, a, v, gaps), self.around(tube));
        let most = |number: usize| DEEPEST_PART * around.rigid(number).radius();
        let each = || {
            seen.each
                .iter()
                .enumerate()
                .map(|(number, found)| (most(number), found))
        };
        if let Some((most, &(depth, _))) = each().find(|(most, (depth, _))| depth > most) {
            return Err(Refused::TooDeep { depth, most });
        }
        if seen.unprepared > self.settings.depth {
            return Err(Refused::OutOfReach { depth: seen.unprepared });
        }
        if let Some((most, &(_, gap))) = each().find(|(most, (_, gap))| gap > most) {
            return Err(Refused::TooCoarse { gap, most });
        }
        match gaps.then(|| self.unproved(tube, a, v)).flatten() {
            Some(why) => Err(Refused::Unproved(why)),
            None => Ok(widest(&seen)),
        }
    }

    /// Why it is not proved that surfaces have met nothing but what is known of bones.
    fn unproved(&self, tube: &Tube, a: &[f64], v: &[f64]) -> Option<Unproved> {
        let (touches, around) = (&self.contact.touches, self.around(tube));
        (0..touches.len()).find_map(|point| {
            let (rigid, at_rest) = (around.rigid(touches.with(point)), touches.gap(point));
            let way = [&touches.at_rest(point), &touches.at(point, v)];
            let gap = || widest_on_the_way(at_rest, touches.stretch(point, &self.system, a));
            rigid.unproved(way, seen_from(rigid.radius(), at_rest), &gap)
        })
    }

    /// Refuses a state in which tissue is in the tube or bone though its surface is not: that has come through between points, which press
    /// on it no more. The deepest that a point inside is else, mm.
    pub(super) fn look_inside(&self, tube: &Tube, a: &[f64]) -> Result<f64, Refused> {
        let around = self.around(tube);
        (0..=self.bones.len()).try_fold(0.0_f64, |deepest, number| {
            let depth = self.others.inside(&self.system, a, &around, number);
            let most = MOST_INSIDE * DEEPEST_PART * around.rigid(number).radius();
            match depth > most {
                true => Err(Refused::Through { depth, most }),
                false => Ok(deepest.max(depth)),
            }
        })
    }

    /// Whether solids are not turned inside out near the tube, between the points of elements neither: see [`super::State::Settled`].
    pub(super) fn is_upright(&self) -> bool {
        let (bodies, tube) = (&self.system.bodies, &self.now.tube);
        // What is no number is deeper than any: nothing is proved there.
        let near = |at: &Vector3<f64>, side: f64| depth_or_all(-tube.signed_distance(at).value) >= -NEAR_SIDES * side;
        (0..bodies.len()).all(|body| bodies.solid(body).is_upright(bodies.part(body, &self.now.a), &near))
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
