//! Contact of a surface with something rigid, without friction: a tube, or bone that does not move.

use nalgebra::{Matrix3, Vector3};

use super::pressures::{BadStiffness, Pressures, Touch, depth_or_all};
use super::rigid::{ContactForce, Rigid};
use super::{Change, DEEPEST_PART, Fit, Term};
use crate::space::bodies::Bodies;
use crate::space::gap::{gap_at, seen_from, widest_on_the_way};
use crate::space::level_set::{LevelSet, Unproved};
use crate::space::solid::Solid;
use crate::space::tube::{Distance, Tube};
use crate::sparse::Triplets;

/// Contact of points of a body's surface with something rigid.
#[derive(Debug, Clone)]
pub struct RigidContact<R> {
    body: usize,
    rigid: R,
    pressures: Pressures,
}

/// Contact with a tube; moments are about the origin of the tube's own frame.
pub type TubeContact = RigidContact<Tube>;

/// Contact with what does not move, such as bone; moments are about the origin of all places.
pub type ObstacleContact = RigidContact<LevelSet>;

/// What the tissue does to the tube.
pub type TubeForce = ContactForce;

impl RigidContact<Tube> {
    /// The tube.
    pub fn tube(&self) -> &Tube {
        &self.rigid
    }
}

impl<R: Rigid> RigidContact<R> {
    /// Contact of the points of a body's surface for which `wanted(reference place, normal)` holds. `stiffness`, stress by
    /// length, sets how fast pressures converge, not where to: some ten times Young's modulus over the side of an element.
    ///
    /// # Errors
    /// [`BadStiffness`]: with one below zero points would be drawn in.
    pub fn new(
        bodies: &Bodies,
        body: usize,
        rigid: R,
        stiffness: f64,
        wanted: impl Fn(&Vector3<f64>, &Vector3<f64>) -> bool,
    ) -> Result<Self, BadStiffness> {
        Ok(Self {
            body,
            rigid,
            pressures: Pressures::new(bodies.solid(body), stiffness, wanted)?,
        })
    }

    /// The solid whose points it is of.
    pub(in crate::space) fn body(&self) -> usize {
        self.body
    }

    /// Its points, and their pressures.
    pub(in crate::space) fn points(&self) -> impl Iterator<Item = (usize, f64)> {
        self.pressures.touches.iter().map(|touch| (touch.point, touch.pressure))
    }

    /// What the contact is with.
    pub fn rigid(&self) -> &R {
        &self.rigid
    }

    /// Puts it elsewhere; pressures stay as the first guess of the new ones.
    pub fn move_to(&mut self, rigid: R) {
        self.rigid = rigid;
        self.pressures.restart();
    }

    /// The deepest point in it, mm; 0 where none is.
    pub fn depth(&self, bodies: &Bodies, a: &[f64]) -> f64 {
        let (solid, part) = (bodies.solid(self.body), bodies.part(self.body, a));
        let depth = |touch: &Touch| {
            self.near(solid, part, touch, 0.0)
                .map_or(0.0, |d| depth_or_all(-d.value))
        };
        self.pressures.touches.iter().map(depth).fold(0.0, f64::max)
    }

    /// The widest gap between points of the surface at it, mm, as the surface is stretched there: what is so thick may lie between them unseen.
    pub fn widest_gap(&self, bodies: &Bodies, a: &[f64]) -> f64 {
        let (solid, part) = (bodies.solid(self.body), bodies.part(self.body, a));
        let gap = |touch: &Touch| {
            let most = seen_from(self.rigid.radius(), touch.gap);
            let Some(near) = self.near(solid, part, touch, most).filter(|near| near.value <= most) else {
                return 0.0;
            };
            // The widest way of a long thin part counts for all of it.
            let stretch = solid.stretch(part, touch.point);
            gap_at(touch.gap * stretch, near.value)
        };
        self.pressures.touches.iter().map(gap).fold(0.0, f64::max)
    }

    /// Why it is not proved that the surface has met nothing but what is known of the rigid; of all points the first such.
    fn unproved(&self, bodies: &Bodies, a: &[f64]) -> Option<Unproved> {
        let (solid, part) = (bodies.solid(self.body), bodies.part(self.body, a));
        self.pressures.touches.iter().find_map(|touch| {
            let way = [&solid.reference(touch.point).0, &solid.point(part, touch.point)];
            let gap = || widest_on_the_way(touch.gap, solid.stretch(part, touch.point));
            self.rigid
                .unproved(way, seen_from(self.rigid.radius(), touch.gap), &gap)
        })
    }

    /// Deeper than this a point might leave on the other side, mm.
    pub fn deepest(&self) -> f64 {
        DEEPEST_PART * self.rigid.radius()
    }

    /// What the tissue does to it at `a`, by the pressures found.
    pub fn force(&self, bodies: &Bodies, a: &[f64]) -> ContactForce {
        let (solid, part) = (bodies.solid(self.body), bodies.part(self.body, a));
        let centre = self.rigid.centre();
        let mut sum = ContactForce {
            force: Vector3::zeros(),
            moment: Vector3::zeros(),
            points: 0,
            area: 0.0,
            depth: self.depth(bodies, a),
        };
        for touch in self.pressures.touches.iter().filter(|touch| touch.pressure > 0.0) {
            let at = solid.point(part, touch.point);
            let on_it = self.rigid.signed_distance(&at).gradient * (-touch.area * touch.pressure);
            sum.force += on_it;
            sum.moment += (at - centre).cross(&on_it);
            sum.points += 1;
            sum.area += touch.area;
        }
        sum
    }

    /// The distance of a point, left out where it is certainly above `most`.
    fn near(&self, solid: &dyn Solid, part: &[f64], touch: &Touch, most: f64) -> Option<Distance> {
        near(&self.rigid, solid.point(part, touch.point), most)
    }

    /// The energy; calls `each` with points that press, their pressure at work and distance.
    fn visit(&self, bodies: &Bodies, a: &[f64], each: impl FnMut(&Touch, f64, &Distance)) -> Option<f64> {
        let (solid, part) = (bodies.solid(self.body), bodies.part(self.body, a));
        self.pressures.visit(|touch| gap(&self.rigid, solid, part, touch), each)
    }
}

/// The distance of a place, left out where it is certainly above `most`.
fn near<R: Rigid>(rigid: &R, at: Vector3<f64>, most: f64) -> Option<Distance> {
    (rigid.clearance(&at) <= most).then(|| rigid.signed_distance(&at))
}

/// The distance of a point that presses or might.
fn gap<R: Rigid>(rigid: &R, solid: &dyn Solid, part: &[f64], touch: &Touch) -> Option<(f64, Distance)> {
    let most = if touch.pressure > 0.0 { f64::INFINITY } else { 0.0 };
    near(rigid, solid.point(part, touch.point), most).map(|d| (d.value, d))
}

impl<R: Rigid> Term for RigidContact<R> {
    fn energy(&self, bodies: &Bodies, a: &[f64]) -> Option<f64> {
        self.visit(bodies, a, |_, _, _| {})
    }

    fn gradient(&self, bodies: &Bodies, a: &[f64], gradient: &mut [f64]) -> Option<f64> {
        let (solid, part) = (bodies.solid(self.body), bodies.part(self.body, a));
        let offset = bodies.offset(self.body);
        self.visit(bodies, a, |touch, pressure, distance| {
            let slope = distance.gradient * (-touch.area * pressure);
            solid.rows(part, touch.point, &mut |p, by| gradient[offset + p] += by.dot(&slope));
        })
    }

    fn hessian(&self, bodies: &Bodies, a: &[f64], convex: bool, sink: &mut Triplets) -> Option<()> {
        let (solid, part) = (bodies.solid(self.body), bodies.part(self.body, a));
        let offset = bodies.offset(self.body);
        let (mut row, mut block) = (Vec::new(), Vec::new());
        self.visit(bodies, a, |touch, pressure, distance| {
            let (k, area, normal) = (touch.point, touch.area, distance.gradient);
            let mut matrix = normal * normal.transpose() * (area * self.pressures.stiffness());
            // What is round lowers the energy sideways where it is pressed on.
            if !convex {
                matrix -= distance.hessian * (area * pressure);
                solid.bend(part, k, normal * (-area * pressure), sink, offset);
            }
            // Three unknowns of each node of its cube: all pairs of them lie in the cube's own stiffness already. Points of a cube follow one
            // another and mostly have the same nodes, so that one block takes them all: each of its own would be gigabytes where hundreds press.
            row.clear();
            solid.rows(part, k, &mut |p, by| row.push((offset + p, by)));
            pull(&row, &matrix, &mut block);
            sink.add_block(row.iter().map(|(p, _)| *p), &block);
        })?;
        Some(())
    }

    fn reach(&self, bodies: &Bodies, a: &[f64], step: &[f64]) -> f64 {
        let (solid, part) = (bodies.solid(self.body), bodies.part(self.body, a));
        let moved = bodies.part(self.body, step);
        let deepest = self.deepest();
        let mut reach = 1.0_f64;
        for touch in &self.pressures.touches {
            let mut way = Vector3::zeros();
            solid.rows(part, touch.point, &mut |p, by| way += by * moved[p]);
            // No point comes nearer by more than its way.
            let way = way.norm();
            let near = self.near(solid, part, touch, way - deepest);
            let room = near.map_or(f64::INFINITY, |distance| distance.value + deepest);
            if way > room {
                reach = reach.min((room / way).max(0.0));
            }
        }
        reach
    }

    fn reaction(&self, bodies: &Bodies, a: &[f64]) -> f64 {
        let mut largest = 0.0_f64;
        // Without an energy there is no reaction to speak of.
        let _ = self.visit(bodies, a, |touch, pressure, _| {
            largest = largest.max(touch.area * pressure)
        });
        largest
    }

    /// Pressures at points are more than the unknowns that they press on: some patterns of them push nothing and hardly
    /// settle. So their change is measured by the forces on the unknowns.
    fn update(&mut self, bodies: &Bodies, a: &[f64]) -> Change {
        let (solid, part) = (bodies.solid(self.body), bodies.part(self.body, a));
        let mut forces = vec![0.0; part.len()];
        let rigid = &self.rigid;
        let depth = self.pressures.update(
            |touch| gap(rigid, solid, part, touch),
            |gap, _| -gap,
            |touch, more, distance| {
                let Some(distance) = distance else { return };
                let more = distance.gradient * (more * touch.area);
                solid.rows(part, touch.point, &mut |p, by| forces[p] += by.dot(&more));
            },
        );
        self.pressures.stiffen(depth, 0.0);
        Change {
            force: forces.iter().fold(0.0, |most: f64, f| most.max(f.abs())),
            depth,
        }
    }

    fn fit(&self, bodies: &Bodies, a: &[f64]) -> Option<Fit> {
        let (solid, part) = (bodies.solid(self.body), bodies.part(self.body, a));
        let inside = solid.inner().into_iter().map(|inner| {
            let near = near(&self.rigid, inner.place(part), 0.0);
            near.map_or(0.0, |d| depth_or_all(-d.value))
        });
        Some(Fit {
            inside: inside.fold(0.0, f64::max),
            depth: self.depth(bodies, a),
            gap: self.widest_gap(bodies, a),
            deepest: self.deepest(),
            unproved: self.unproved(bodies, a),
        })
    }
}

/// `row . matrix row`, the lower triangle row by row.
fn pull(row: &[(usize, Vector3<f64>)], matrix: &Matrix3<f64>, block: &mut Vec<f64>) {
    block.clear();
    for (i, (_, by)) in row.iter().enumerate() {
        let pulled = matrix * by;
        block.extend(row[..=i].iter().map(|(_, other)| pulled.dot(other)));
    }
}
