//! An elastic bed: points of a surface held at their places.

use nalgebra::Vector3;

use super::Term;
use crate::space::bodies::Bodies;
use crate::sparse::Triplets;

/// Points of a solid's surface held at places by springs: `1/2 k A |x - place|^2` with the area `A` of each point.
#[derive(Debug, Clone)]
pub struct Springs {
    body: usize,
    /// Points, their places, and stiffness times area.
    held: Vec<(usize, Vector3<f64>, f64)>,
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
        Self {
            body,
            held: held.collect(),
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
        self.visit(bodies, a, |_, at, force, _| {
            sums[0] += force;
            sums[1] += (at - centre).cross(&force);
        });
        sums
    }

    /// Calls `each` with point, position, force on the solid and stiffness.
    fn visit(&self, bodies: &Bodies, a: &[f64], mut each: impl FnMut(usize, Vector3<f64>, Vector3<f64>, f64)) {
        let (solid, part) = (bodies.solid(self.body), bodies.part(self.body, a));
        for (point, place, stiff) in &self.held {
            let at = solid.point(part, *point);
            each(*point, at, (place - at) * *stiff, *stiff);
        }
    }
}

impl Term for Springs {
    fn energy(&self, bodies: &Bodies, a: &[f64]) -> Option<f64> {
        let mut energy = 0.0;
        self.visit(bodies, a, |_, _, force, stiff| {
            energy += 0.5 * force.norm_squared() / stiff
        });
        Some(energy)
    }

    fn gradient(&self, bodies: &Bodies, a: &[f64], gradient: &mut [f64]) -> Option<f64> {
        let (solid, part, offset) = (
            bodies.solid(self.body),
            bodies.part(self.body, a),
            bodies.offset(self.body),
        );
        let mut energy = 0.0;
        self.visit(bodies, a, |point, _, force, stiff| {
            energy += 0.5 * force.norm_squared() / stiff;
            solid.rows(part, point, &mut |p, by| gradient[offset + p] -= by.dot(&force));
        });
        Some(energy)
    }

    fn hessian(&self, bodies: &Bodies, a: &[f64], convex: bool, sink: &mut Triplets) -> Option<()> {
        let (solid, part, offset) = (
            bodies.solid(self.body),
            bodies.part(self.body, a),
            bodies.offset(self.body),
        );
        let mut row = Vec::new();
        self.visit(bodies, a, |point, _, force, stiff| {
            row.clear();
            solid.rows(part, point, &mut |p, by| row.push((p, by)));
            for (i, (p, by)) in row.iter().enumerate() {
                for (q, other) in &row[..=i] {
                    let product = by.dot(other);
                    // Axes do not mix where parameters are displacements.
                    if product != 0.0 {
                        sink.add(offset + p, offset + q, stiff * product);
                    }
                }
            }
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
        self.visit(bodies, a, |_, _, force, _| largest = largest.max(force.norm()));
        largest
    }
}
