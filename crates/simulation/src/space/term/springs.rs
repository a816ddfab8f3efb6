//! An elastic bed: points of a surface held at their places.

mod patch;

use nalgebra::Vector3;

use super::Term;
use crate::space::bodies::Bodies;
use crate::space::solid::Solid;
use crate::sparse::Triplets;
use patch::{Held, Patch, Work, patches};

/// Points of a solid's surface held at places by springs: `1/2 k A |x - place|^2` with the area `A` of each point. Of points
/// that the same nodes move linearly ([`Solid::combination`]) the stiffness, which is constant, is summed once.
#[derive(Debug, Clone)]
pub struct Springs {
    body: usize,
    held: Vec<Held>,
    /// All points of `held` by the nodes that move them, and those that no nodes move linearly.
    patches: Vec<Patch>,
    others: Vec<Held>,
}

impl Springs {
    /// Springs at points of a body's surface for which `stiffness(reference place, normal)`, stress by length, is above 0;
    /// `place` says where the springs pull each to.
    pub fn new(
        bodies: &Bodies,
        body: usize,
        stiffness: impl Fn(&Vector3<f64>, &Vector3<f64>) -> f64,
        place: impl Fn(&Vector3<f64>) -> Vector3<f64>,
    ) -> Self {
        let solid = bodies.solid(body);
        let held = (0..solid.points()).filter_map(|k| {
            let (at, normal, area) = solid.reference(k);
            let stiff = stiffness(&at, &normal) * area;
            (stiff > 0.0).then(|| (k, place(&at), stiff))
        });
        let held: Vec<Held> = held.collect();
        let (patches, others) = patches(solid, held.clone());
        Self {
            body,
            held,
            patches,
            others,
        }
    }

    /// How many points are held.
    pub fn len(&self) -> usize {
        self.held.len()
    }

    /// True where none is.
    pub fn is_empty(&self) -> bool {
        self.held.is_empty()
    }

    /// The sum of the forces on the solid, and of their moments about a centre.
    pub fn reaction_about(&self, bodies: &Bodies, a: &[f64], centre: &Vector3<f64>) -> [Vector3<f64>; 2] {
        let mut sums = [Vector3::zeros(); 2];
        self.visit(&self.held, bodies, a, |_, at, force, _| {
            sums[0] += force;
            sums[1] += (at - centre).cross(&force);
        });
        sums
    }

    /// Calls `each` with point, position, force on the solid and stiffness of some of the points.
    fn visit(
        &self,
        held: &[Held],
        bodies: &Bodies,
        a: &[f64],
        mut each: impl FnMut(usize, Vector3<f64>, Vector3<f64>, f64),
    ) {
        let (solid, part) = self.solid(bodies, a);
        for (point, place, stiff) in held {
            let at = solid.point(part, *point);
            each(*point, at, (place - at) * *stiff, *stiff);
        }
    }

    /// The solid and its parameters.
    fn solid<'a>(&self, bodies: &'a Bodies, a: &'a [f64]) -> (&'a dyn Solid, &'a [f64]) {
        (bodies.solid(self.body), bodies.part(self.body, a))
    }

    /// The stiffness of a point of those that no nodes move linearly.
    fn add_point(row: &[(usize, Vector3<f64>)], stiff: f64, sink: &mut Triplets, offset: usize) {
        for (i, (p, by)) in row.iter().enumerate() {
            for (q, other) in &row[..=i] {
                let product = by.dot(other);
                if product != 0.0 {
                    sink.add(offset + p, offset + q, stiff * product);
                }
            }
        }
    }
}

impl Term for Springs {
    fn energy(&self, bodies: &Bodies, a: &[f64]) -> Option<f64> {
        let (part, mut work, mut energy) = (bodies.part(self.body, a), Work::default(), 0.0);
        for patch in &self.patches {
            energy += patch.energy(part, &mut work);
        }
        self.visit(&self.others, bodies, a, |_, _, force, stiff| {
            energy += 0.5 * force.norm_squared() / stiff
        });
        Some(energy)
    }

    fn gradient(&self, bodies: &Bodies, a: &[f64], gradient: &mut [f64]) -> Option<f64> {
        let ((solid, part), offset) = (self.solid(bodies, a), bodies.offset(self.body));
        let (mut work, mut energy) = (Work::default(), 0.0);
        for patch in &self.patches {
            energy += patch.gradient(part, &mut gradient[offset..], &mut work);
        }
        self.visit(&self.others, bodies, a, |point, _, force, stiff| {
            energy += 0.5 * force.norm_squared() / stiff;
            solid.rows(part, point, &mut |p, by| gradient[offset + p] -= by.dot(&force));
        });
        Some(energy)
    }

    fn hessian(&self, bodies: &Bodies, a: &[f64], convex: bool, sink: &mut Triplets) -> Option<()> {
        let ((solid, part), offset) = (self.solid(bodies, a), bodies.offset(self.body));
        self.patches.iter().for_each(|patch| patch.add_stiffness(sink, offset));
        let mut row = Vec::new();
        self.visit(&self.others, bodies, a, |point, _, force, stiff| {
            row.clear();
            solid.rows(part, point, &mut |p, by| row.push((p, by)));
            Self::add_point(&row, stiff, sink, offset);
            if !convex {
                solid.bend(part, point, -force, sink, offset);
            }
        });
        Some(())
    }

    fn changes(&self) -> bool {
        false
    }

    fn reaction(&self, bodies: &Bodies, a: &[f64]) -> f64 {
        let mut largest = 0.0_f64;
        self.visit(&self.held, bodies, a, |_, _, force, _| {
            largest = largest.max(force.norm())
        });
        largest
    }
}
