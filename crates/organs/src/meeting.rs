//! Whether organs have come into one another: a model without contact between organs lets them, and such a state is wrong.
//!
//! Found from the elements' own displacement at places of each organ (`meeting::samples`), which pictures do not use: a place of one organ's surface is pulled
//! back through the other's displacement by Newton's method, and lies in it where it lies in its region at rest. Boxes first, then the nearest
//! places; what is left to be pulled back are places at the other's surface.
//!
//! Organs that have gone through one another are apart again: the way from the state before is looked at, too ([`Meetings::deepest_between`]).
//!
//! What is missed: two organs that are together thinner than [`WAY_MM`] where one goes through the other, and organs that come into one another between such places. They are [`Meetings::step`] apart at most, as the surface is at rest:
//! two surfaces of which one bends by a radius `R` are in one another by less than about `step^2 / (3 R)` before a place is in (0.13 mm for 1 mm and 2.5 mm),
//! times what the surface is stretched by, squared. And where one organ is stretched by more than twice what `REACH` holds.

mod nearest;
mod samples;

use nalgebra::{Matrix3, Vector3};
use simulation::space::bodies::Bodies;
use simulation::space::cells::{Field, LabelField, Mesh};

use crate::body::Body;
use nearest::Nearest;
use samples::Samples;

/// No place inside an organ is farther than half as much from the nearest of its places, in their distance: as much as it is stretched twofold.
const REACH: f64 = 6.0;
/// Farther from the nearest place of a surface than this, in their distance, the side of it is told by the normal there.
const BESIDE: f64 = 2.0;
/// Newton's method: steps at most, and the last one, mm.
const MOST_STEPS: usize = 20;
const LAST_STEP: f64 = 1e-9;
/// Organs that are nearer than this at rest touch, mm: far below what a label map tells.
const TOUCH_MM: f64 = 0.05;

/// From one look at organs on their way to the next a place goes so far at most, mm; and so many looks are taken at most: organs go no farther in
/// a frame than a tube is walked.
pub const WAY_MM: f64 = 1.0;
const MOST_LOOKS: f64 = 256.0;

/// Two organs in one another, or at one another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Meeting {
    /// Their numbers, the smaller one first.
    pub organs: [usize; 2],
    /// How deep a place of one's surface lies in the other, mm; below 0 where they are so far apart. Infinite where a place is none.
    pub depth: f64,
}

/// Organs and places of them.
#[derive(Debug)]
pub struct Meetings {
    organs: Vec<Organ>,
}

#[derive(Debug)]
struct Organ {
    mesh: Mesh,
    field: LabelField,
    samples: Samples,
}

impl Meetings {
    /// Of organs in the order of a system's solids.
    pub fn new(bodies: &[Body]) -> Self {
        let organ = |body: &Body| Organ {
            samples: Samples::new(&body.mesh, &body.field),
            mesh: body.mesh.clone(),
            field: body.field.clone(),
        };
        // Of one alone nothing is asked.
        let many = if bodies.len() > 1 { bodies } else { &[] };
        Self {
            organs: many.iter().map(organ).collect(),
        }
    }

    /// How far places of the surfaces are apart at most, mm; 0 of one organ, which meets none.
    pub fn step(&self) -> f64 {
        self.organs.iter().map(|organ| organ.samples.step).fold(0.0, f64::max)
    }

    /// How many places are looked at.
    pub fn places(&self) -> usize {
        self.organs.iter().map(|organ| organ.samples.len()).sum()
    }

    /// The two organs that lie deepest in one another in a state; `None` where no place of a surface lies in another organ.
    pub fn deepest(&self, bodies: &Bodies, a: &[f64]) -> Option<Meeting> {
        self.all(|organ| bodies.part(organ, a), &|here, there| here.depth_in(there))
    }

    /// The same on the way from one state to the next, taken straight and looked at wherever a place has gone by [`WAY_MM`]: organs that were
    /// apart in both may have gone through one another between them.
    pub fn deepest_between(&self, bodies: &Bodies, from: &[f64], to: &[f64]) -> Option<Meeting> {
        let ways = self.organs.iter().enumerate().map(|(organ, one)| {
            let [from, to] = [from, to].map(|a| one.samples.moved(bodies.part(organ, a)));
            from.iter()
                .zip(&to)
                .map(|(from, to)| (to - from).norm())
                .fold(0.0, larger)
        });
        let steps = (ways.fold(0.0, larger) / WAY_MM).ceil().clamp(1.0, MOST_LOOKS);
        let met = (1..=steps as u32).filter_map(|step| {
            let part = f64::from(step) / steps;
            let each = from.iter().zip(to).map(|(from, to)| from + part * (to - from));
            // The last one to the bit.
            let between: Vec<f64> = if part < 1.0 { each.collect() } else { to.to_vec() };
            self.deepest(bodies, &between)
        });
        met.reduce(|one, other| if other.depth > one.depth { other } else { one })
    }

    /// The same at rest, and organs that touch there.
    pub fn at_rest(&self) -> Option<Meeting> {
        let deep = self.all(|_| &[], &|here, there| here.depth_in(there));
        deep.or_else(|| self.all(|_| &[], &|here, there| here.touches(there)))
    }

    fn all<'a>(
        &self,
        part: impl Fn(usize) -> &'a [f64],
        depth: &dyn Fn(&Now<'_>, &Now<'_>) -> Option<f64>,
    ) -> Option<Meeting> {
        let now = self.organs.iter().enumerate();
        let now: Vec<Now<'_>> = now.map(|(k, organ)| Now::new(organ, part(k))).collect();
        let pairs = (0..now.len()).flat_map(|j| (0..j).map(move |i| [i, j]));
        let met = pairs.filter_map(|[i, j]| {
            let both = [depth(&now[i], &now[j]), depth(&now[j], &now[i])];
            let depth = both.into_iter().flatten().reduce(f64::max)?;
            Some(Meeting { organs: [i, j], depth })
        });
        met.reduce(|one, other| if other.depth > one.depth { other } else { one })
    }
}

/// An organ as it is now.
struct Now<'a> {
    organ: &'a Organ,
    part: &'a [f64],
    places: Vec<Vector3<f64>>,
    corners: [Vector3<f64>; 2],
}

impl<'a> Now<'a> {
    /// With these displacements of its nodes; none at rest.
    fn new(organ: &'a Organ, part: &'a [f64]) -> Self {
        let part = if part.iter().all(|u| *u == 0.0) { &[] } else { part };
        let places = organ.samples.moved(part);
        let whole = Vector3::repeat(f64::INFINITY);
        let corners = places
            .iter()
            .fold([whole, -whole], |[low, high], at| [low.inf(at), high.sup(at)]);
        Self {
            organ,
            part,
            places,
            corners,
        }
    }

    fn reach(&self) -> f64 {
        REACH * self.organ.samples.step
    }

    /// Places of the surface of this one that may be in the other or near it, and the other's that may be near these.
    fn near<'b>(&'b self, there: &'b Now<'_>) -> Option<(Vec<&'b Vector3<f64>>, Nearest<'b>)> {
        let reach = Vector3::repeat(there.reach());
        let low = self.corners[0].sup(&(there.corners[0] - reach));
        let high = self.corners[1].inf(&(there.corners[1] + reach));
        let within =
            |at: &Vector3<f64>, by: &Vector3<f64>| (0..3).all(|k| at[k] >= low[k] - by[k] && at[k] <= high[k] + by[k]);
        if (0..3).any(|k| low[k] > high[k]) {
            return None;
        }
        let own = self.places[..self.organ.samples.surface()].iter();
        let own: Vec<_> = own.filter(|at| within(at, &Vector3::zeros())).collect();
        let theirs = there.places.iter().enumerate().filter(|(_, at)| within(at, &reach));
        let nearest = Nearest::new(theirs, there.reach());
        (!own.is_empty()).then_some((own, nearest))
    }

    /// How deep the surface of this one lies in another organ, mm; `None` where no place of it does.
    fn depth_in(&self, there: &Now<'_>) -> Option<f64> {
        // A place that is none is in no box: nobody knows where it is.
        let is_known = |now: &Now<'_>| now.places.iter().all(|at| at.iter().all(|x| x.is_finite()));
        if !is_known(self) || !is_known(there) {
            return Some(f64::INFINITY);
        }
        let (own, nearest) = self.near(there)?;
        let mut normals = vec![None; there.organ.samples.surface()];
        let inside = own.into_iter().filter(|x| {
            let found = nearest.of(x);
            found.is_some_and(|number| there.holds(x, number, &mut normals))
        });
        let depths: Vec<f64> = inside.map(|x| there.depth_of(x)).collect();
        depths.into_iter().reduce(f64::max)
    }

    /// Whether a place lies in this organ, whose place of this number is the nearest.
    fn holds(&self, x: &Vector3<f64>, number: usize, normals: &mut [Option<Vector3<f64>>]) -> bool {
        let samples = &self.organ.samples;
        if let Some(normal) = normals.get_mut(number) {
            let way = x - self.places[number];
            if way.norm() > BESIDE * samples.step {
                // Computed once for all places that this one is nearest to.
                let normal = normal.get_or_insert_with(|| self.normal(number).unwrap_or_default());
                // More than that is beside it by hardly anything.
                if way.dot(normal) > 0.5 * way.norm() {
                    return false;
                }
            }
        }
        match self.pulled_back(x, &samples.places[number]) {
            Some(rest) => self.organ.field.value(&rest) < 0.0,
            // Turned inside out, or none: the side of the nearest place of the surface, and within all of it.
            None => {
                let outward = normals.get(number).and_then(|_| self.normal(number));
                outward.is_none_or(|normal| (x - self.places[number]).dot(&normal) < 0.0)
            }
        }
    }

    /// The place at rest of what is at a place now, looked for from one at rest on.
    fn pulled_back(&self, x: &Vector3<f64>, from: &Vector3<f64>) -> Option<Vector3<f64>> {
        if self.part.is_empty() {
            return Some(*x);
        }
        let (mut at, far) = (*from, 2.0 * self.reach());
        for _ in 0..MOST_STEPS {
            let (place, gradient) = self.at(&at)?;
            let step = gradient.try_inverse().filter(|_| gradient.determinant() > 0.0)? * (x - place);
            at += step;
            if step.norm() <= LAST_STEP {
                return Some(at);
            }
            // What leads so far away has not led to what is here.
            if (at - from).norm() > far {
                return None;
            }
        }
        None
    }

    /// Where a place at rest is now, and the deformation gradient there. `None` farther from all cubes than they tell.
    fn at(&self, rest: &Vector3<f64>) -> Option<(Vector3<f64>, Matrix3<f64>)> {
        let (mut place, mut gradient) = (*rest, Matrix3::identity());
        if !self.part.is_empty() {
            for share in self.organ.mesh.shares(rest)? {
                let u = Vector3::from_column_slice(&self.part[3 * share.node as usize..][..3]);
                place += u * share.weight;
                gradient += u * share.slope.transpose();
            }
        }
        Some((place, gradient))
    }

    /// The outward normal now at a place of the surface.
    fn normal(&self, number: usize) -> Option<Vector3<f64>> {
        let samples = &self.organ.samples;
        let (_, gradient) = self.at(&samples.places[number])?;
        let inverse = gradient.try_inverse()?;
        (inverse.transpose() * samples.normals[number]).try_normalize(0.0)
    }

    /// How deep a place inside lies, mm: beyond the plane at the nearest place of the surface.
    fn depth_of(&self, x: &Vector3<f64>) -> f64 {
        let surface = self.places[..self.organ.samples.surface()].iter().enumerate();
        let nearest = surface
            .map(|(k, at)| (k, (x - at).norm()))
            .min_by(|a, b| a.1.total_cmp(&b.1));
        let Some((number, apart)) = nearest else {
            return f64::INFINITY;
        };
        match self.normal(number) {
            Some(normal) => (self.places[number] - x).dot(&normal).clamp(0.0, apart),
            None => apart,
        }
    }

    /// By how much too little they are apart, below 0, where the surface of this one comes as near to another organ's as touching is.
    fn touches(&self, there: &Now<'_>) -> Option<f64> {
        let (own, nearest) = self.near(there)?;
        let apart = own.into_iter().filter_map(|x| {
            let number = nearest.of(x).filter(|number| *number < there.organ.samples.surface())?;
            let way = x - there.places[number];
            let is_beside = way.norm() <= BESIDE * there.organ.samples.step;
            is_beside.then(|| way.dot(&there.organ.samples.normals[number]))
        });
        let least = apart.fold(f64::INFINITY, f64::min);
        (least < TOUCH_MM).then_some(-least.max(0.0))
    }
}

/// The larger one; what is no number counts as farther than any.
fn larger(one: f64, other: f64) -> f64 {
    if one.is_nan() || other.is_nan() {
        f64::INFINITY
    } else {
        one.max(other)
    }
}
