//! Contact of a surface with a rigid tube, without friction.
//!
//! Pressures `p` at points of the surface are multipliers of `distance >= 0`, found by the augmented Lagrangian: the energy
//! `sum of A / (2 k) (max(0, p - k d)^2 - p^2)` is minimised and `p` becomes `max(0, p - k d)`, in turns. Its limit is exact:
//! no depth is left that a stiffness would have to hold, and no pressure where there is a gap.

use nalgebra::Vector3;

use super::{Change, Term};
use crate::space::bodies::Bodies;
use crate::space::tube::{Distance, Tube};
use crate::sparse::Triplets;

/// A point may be as deep as this part of the tube's radius, and no deeper: the way out must lead back where it came from.
const DEEPEST_PART: f64 = 0.5;

/// A round that leaves more than this part of the depth asks for more stiffness: so much of it, and so much in all.
const SLOW_PART: f64 = 0.25;
const STIFFENED: f64 = 3.0;
const MOST_STIFFENED: f64 = 1e4;

/// A stiffness of contact that is none.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("the stiffness of contact is {found}; it must be finite and above 0")]
pub struct BadStiffness {
    /// The number found.
    pub found: f64,
}

/// Contact of points of a body's surface with a tube.
#[derive(Debug, Clone)]
pub struct TubeContact {
    body: usize,
    tube: Tube,
    /// Stress by length: the one asked for, and the one at work.
    stiffness: [f64; 2],
    /// The depth that the last round left, mm.
    depth: f64,
    points: Vec<Touch>,
}

/// A point of the surface that may touch the tube.
#[derive(Debug, Clone, Copy)]
struct Touch {
    point: usize,
    area: f64,
    pressure: f64,
}

/// What the tissue does to the tube.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TubeForce {
    /// The sum of the forces on the tube.
    pub force: Vector3<f64>,
    /// Their moment about the origin of the tube's own frame.
    pub moment: Vector3<f64>,
    /// Points that press on it.
    pub points: usize,
    /// Area of the surface, in the reference configuration, that they stand for, mm^2.
    pub area: f64,
    /// The deepest point in the tube, mm; 0 where none is.
    pub depth: f64,
}

impl TubeContact {
    /// Contact of the points of a body's surface for which `wanted(reference place, normal)` holds. `stiffness`, stress by
    /// length, sets how fast pressures converge, not where to: some ten times Young's modulus over the side of an element.
    ///
    /// # Errors
    /// [`BadStiffness`]: with one below zero points would be drawn to the tube.
    pub fn new(
        bodies: &Bodies,
        body: usize,
        tube: Tube,
        stiffness: f64,
        wanted: impl Fn(&Vector3<f64>, &Vector3<f64>) -> bool,
    ) -> Result<Self, BadStiffness> {
        // With less than none, points would be drawn to the tube; with none, pressures would never change.
        if !(stiffness.is_finite() && stiffness > 0.0) {
            return Err(BadStiffness { found: stiffness });
        }
        let solid = bodies.solid(body);
        let points = (0..solid.points()).filter_map(|point| {
            let (at, normal, area) = solid.reference(point);
            wanted(&at, &normal).then_some(Touch {
                point,
                area,
                pressure: 0.0,
            })
        });
        Ok(Self {
            body,
            tube,
            stiffness: [stiffness; 2],
            depth: f64::INFINITY,
            points: points.collect(),
        })
    }

    /// The tube.
    pub fn tube(&self) -> &Tube {
        &self.tube
    }

    /// Puts the tube elsewhere; pressures stay as the first guess of the new ones.
    pub fn move_to(&mut self, tube: Tube) {
        self.tube = tube;
        self.stiffness[1] = self.stiffness[0];
        self.depth = f64::INFINITY;
    }

    /// The deepest point in the tube, mm; 0 where none is.
    pub fn depth(&self, bodies: &Bodies, a: &[f64]) -> f64 {
        let (solid, part) = (bodies.solid(self.body), bodies.part(self.body, a));
        let depth = |touch: &Touch| -self.tube.signed_distance(&solid.point(part, touch.point)).value;
        self.points.iter().map(depth).fold(0.0, f64::max)
    }

    /// The widest gap between points of the surface at the tube, mm: so thick a tube may lie between them unseen.
    pub fn widest_gap(&self, bodies: &Bodies, a: &[f64]) -> f64 {
        let (solid, part) = (bodies.solid(self.body), bodies.part(self.body, a));
        let gap = |touch: &Touch| {
            let side = touch.area.sqrt();
            let distance = self.tube.signed_distance(&solid.point(part, touch.point)).value;
            // Of Gauss points of a square the middle of four is three quarters of the root of their area away from them.
            if distance < 1.5 * side { 0.75 * side } else { 0.0 }
        };
        self.points.iter().map(gap).fold(0.0, f64::max)
    }

    /// Deeper than this a point might leave on the other side, mm.
    pub fn deepest(&self) -> f64 {
        DEEPEST_PART * self.tube.least_radius()
    }

    /// What the tissue does to the tube at `a`, by the pressures found.
    pub fn force(&self, bodies: &Bodies, a: &[f64]) -> TubeForce {
        let (solid, part) = (bodies.solid(self.body), bodies.part(self.body, a));
        let origin = self.tube.pose().translation.vector;
        let (mut force, mut moment) = (Vector3::zeros(), Vector3::zeros());
        let (mut points, mut area, mut depth) = (0, 0.0, 0.0_f64);
        for touch in &self.points {
            let at = solid.point(part, touch.point);
            let distance = self.tube.signed_distance(&at);
            depth = depth.max(-distance.value);
            if touch.pressure > 0.0 {
                let on_tube = distance.gradient * (-touch.area * touch.pressure);
                force += on_tube;
                moment += (at - origin).cross(&on_tube);
                points += 1;
                area += touch.area;
            }
        }
        TubeForce {
            force,
            moment,
            points,
            area,
            depth,
        }
    }

    /// Calls `each` with point, area, pressure at work and distance, for points that press.
    fn visit(&self, bodies: &Bodies, a: &[f64], mut each: impl FnMut(usize, f64, f64, &Distance)) -> Option<f64> {
        let (solid, part) = (bodies.solid(self.body), bodies.part(self.body, a));
        let mut energy = 0.0;
        let stiffness = self.stiffness[1];
        for touch in &self.points {
            let distance = self.tube.signed_distance(&solid.point(part, touch.point));
            let (pressure, half) = (
                touch.pressure - stiffness * distance.value,
                0.5 * touch.area / stiffness,
            );
            if pressure > 0.0 {
                energy += half * pressure * pressure;
                each(touch.point, touch.area, pressure, &distance);
            }
            energy -= half * touch.pressure * touch.pressure;
        }
        Some(energy).filter(|e| e.is_finite())
    }
}

impl Term for TubeContact {
    fn energy(&self, bodies: &Bodies, a: &[f64]) -> Option<f64> {
        self.visit(bodies, a, |_, _, _, _| {})
    }

    fn gradient(&self, bodies: &Bodies, a: &[f64], gradient: &mut [f64]) -> Option<f64> {
        let (solid, part, offset) = (
            bodies.solid(self.body),
            bodies.part(self.body, a),
            bodies.offset(self.body),
        );
        self.visit(bodies, a, |k, area, pressure, distance| {
            let slope = distance.gradient * (-area * pressure);
            solid.rows(part, k, &mut |p, by| gradient[offset + p] += by.dot(&slope));
        })
    }

    fn hessian(&self, bodies: &Bodies, a: &[f64], convex: bool, sink: &mut Triplets) -> Option<()> {
        let (solid, part, offset) = (
            bodies.solid(self.body),
            bodies.part(self.body, a),
            bodies.offset(self.body),
        );
        let mut row = Vec::new();
        self.visit(bodies, a, |k, area, pressure, distance| {
            let normal = distance.gradient;
            let mut matrix = normal * normal.transpose() * (area * self.stiffness[1]);
            // The tube is round: pressing on it lowers the energy sideways.
            if !convex {
                matrix -= distance.hessian * (area * pressure);
                solid.bend(part, k, normal * (-area * pressure), sink, offset);
            }
            // Three unknowns of each node of its cube: all pairs of them lie in the cube's own stiffness already.
            row.clear();
            solid.rows(part, k, &mut |p, by| row.push((p, by)));
            for (i, (p, by)) in row.iter().enumerate() {
                let pulled = matrix * by;
                for (q, other) in &row[..=i] {
                    sink.add(offset + p, offset + q, pulled.dot(other));
                }
            }
        })?;
        Some(())
    }

    fn reach(&self, bodies: &Bodies, a: &[f64], step: &[f64]) -> f64 {
        let (solid, part) = (bodies.solid(self.body), bodies.part(self.body, a));
        let moved = bodies.part(self.body, step);
        let deepest = self.deepest();
        let mut reach = 1.0_f64;
        for touch in &self.points {
            let mut way = Vector3::zeros();
            solid.rows(part, touch.point, &mut |p, by| way += by * moved[p]);
            // No point comes nearer to the tube than by its way.
            let (way, room) = (
                way.norm(),
                self.tube.signed_distance(&solid.point(part, touch.point)).value + deepest,
            );
            if way > room {
                reach = reach.min((room / way).max(0.0));
            }
        }
        reach
    }

    fn reaction(&self, bodies: &Bodies, a: &[f64]) -> f64 {
        let mut largest = 0.0_f64;
        // Without an energy there is no reaction to speak of.
        let _ = self.visit(bodies, a, |_, area, pressure, _| largest = largest.max(area * pressure));
        largest
    }

    /// Pressures at points are more than the unknowns that they press on: some patterns of them push nothing and hardly
    /// settle. So their change is measured by the forces on the unknowns.
    fn update(&mut self, bodies: &Bodies, a: &[f64]) -> Change {
        let (solid, part) = (bodies.solid(self.body), bodies.part(self.body, a));
        let (mut forces, mut depth) = (vec![0.0; part.len()], 0.0_f64);
        for touch in &mut self.points {
            let distance = self.tube.signed_distance(&solid.point(part, touch.point));
            let new = (touch.pressure - self.stiffness[1] * distance.value).max(0.0);
            // What the change of pressure does to the unknowns is what counts.
            let more = distance.gradient * ((new - touch.pressure) * touch.area);
            touch.pressure = new;
            depth = depth.max(-distance.value);
            if more != Vector3::zeros() {
                solid.rows(part, touch.point, &mut |p, by| forces[p] += by.dot(&more));
            }
        }
        // Where points are more than their unknowns can follow, depths shrink only as pressures outgrow one another.
        let slow = depth > SLOW_PART * self.depth;
        if slow && self.stiffness[1] < MOST_STIFFENED * self.stiffness[0] {
            self.stiffness[1] *= STIFFENED;
        }
        self.depth = depth;
        Change {
            force: forces.iter().fold(0.0, |most: f64, f| most.max(f.abs())),
            depth,
        }
    }
}
