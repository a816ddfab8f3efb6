//! Contact of two deformable solids, without friction: points of one's surface stay out of the other.
//!
//! Each point of the surface of `body` that lies where the material of `other` is now is pulled back there, and presses by
//! how deep it is (see `pulled`). Points of one surface only: with those of both, pressures would be found twice for one
//! surface and have two answers. Of the two, `body` should be the one with the smaller cubes (and the softer): a surface of
//! larger cubes does not see where the other's slope changes between its points, and what it presses with is off there.
//!
//! # Derivatives
//!
//! Of the gap `g = D(X)`, `x = X + u(X)`: with `y` the change of `x` less that of the material there, `dX = F^-1 y` and
//! `dg = q . y`, `q = F^-T n`. What the point is pushed by, the other's nodes are pushed by in return, each by its weight at
//! `X`: forces and moments sum to nothing. Once more differentiated: `d2g = dX . B dX - 2 sum over nodes of (q . du) (slope . dX)`,
//! `B = d2D - sum of q[k] d2u[k]`. All of it is exact.

mod now;

use nalgebra::Vector3;

use super::pressures::{BadStiffness, Pressures, Touch};
use super::rigid::ContactForce;
use super::{Change, DEEPEST_PART, Fit, Term};
use crate::space::bodies::Bodies;
use crate::space::gap::gap_at;
use crate::space::level_set::LevelSet;
use crate::space::solid::Solid;
use crate::sparse::Triplets;
use now::Now;

/// Contact of points of a body's surface with another body.
#[derive(Debug, Clone)]
pub struct OrganContact {
    body: usize,
    other: usize,
    /// The other's surface in its reference configuration.
    surface: LevelSet,
    pressures: Pressures,
    /// How far apart points of the other's surface are at most, about.
    spacing: f64,
}

impl OrganContact {
    /// Contact of the points of the surface of `body` for which `wanted(reference place, normal)` holds with `other`, whose
    /// surface in the reference configuration is `surface`, that of the field that it is meshed from. `stiffness` as for a tube, by the stiffer of the two.
    ///
    /// The other must be a solid that knows its [`Solid::shares`]; with any other there is no contact.
    ///
    /// # Errors
    /// [`BadStiffness`].
    pub fn new(
        bodies: &Bodies,
        [body, other]: [usize; 2],
        surface: LevelSet,
        stiffness: f64,
        wanted: impl Fn(&Vector3<f64>, &Vector3<f64>) -> bool,
    ) -> Result<Self, BadStiffness> {
        let solid = bodies.solid(other);
        let areas = (0..solid.points()).map(|point| solid.reference(point).2);
        Ok(Self {
            body,
            other,
            surface,
            pressures: Pressures::new(bodies.solid(body), stiffness, wanted)?,
            spacing: 1.5 * areas.fold(0.0, f64::max).sqrt(),
        })
    }

    /// What moved solids or loads asks for: stiffness as at first, pressures at hand as a first guess.
    pub fn restart(&mut self) {
        self.pressures.restart();
    }

    /// Deeper than this, in the other's reference configuration, a point might leave on the other side, mm.
    pub fn deepest(&self) -> f64 {
        DEEPEST_PART * self.surface.radius()
    }

    /// What the body does to the other at `a`, by the pressures found; moments are about the origin. The other does
    /// the same to the body, with the other sign.
    pub fn force(&self, bodies: &Bodies, a: &[f64]) -> ContactForce {
        let now = self.now(bodies, a);
        let mut sum = ContactForce {
            force: Vector3::zeros(),
            moment: Vector3::zeros(),
            points: 0,
            area: 0.0,
            depth: now.depth(),
        };
        for touch in self.pressures.touches.iter().filter(|touch| touch.pressure > 0.0) {
            if let Some((_, pulled)) = now.gap(touch) {
                let on_other = pulled.slope * (-touch.area * touch.pressure);
                sum.force += on_other;
                sum.moment += now.point(touch).cross(&on_other);
                sum.points += 1;
                sum.area += touch.area;
            }
        }
        sum
    }

    fn now<'a>(&'a self, bodies: &'a Bodies, a: &'a [f64]) -> Now<'a> {
        Now::new(self, bodies, a)
    }
}

impl Term for OrganContact {
    fn energy(&self, bodies: &Bodies, a: &[f64]) -> Option<f64> {
        self.now(bodies, a).visit(|_, _, _| {})
    }

    fn gradient(&self, bodies: &Bodies, a: &[f64], gradient: &mut [f64]) -> Option<f64> {
        let (now, mut row) = (self.now(bodies, a), Vec::new());
        now.visit(|touch, pressure, pulled| {
            now.row(touch, pulled, &mut row);
            let slope = pulled.slope * (-touch.area * pressure);
            row.iter().for_each(|m| gradient[m.unknown] += m.way.dot(&slope));
        })
    }

    fn hessian(&self, bodies: &Bodies, a: &[f64], convex: bool, sink: &mut Triplets) -> Option<()> {
        let (now, mut row, mut block) = (self.now(bodies, a), Vec::new(), Vec::new());
        let (solid, part) = now.solid();
        now.visit(|touch, pressure, pulled| {
            now.row(touch, pulled, &mut row);
            block.clear();
            let (force, slope) = (touch.area * pressure, pulled.slope);
            let mut matrix = slope * slope.transpose() * (touch.area * self.pressures.stiffness());
            if !convex {
                matrix -= pulled.inverse.transpose() * pulled.bent * pulled.inverse * force;
                let offset = bodies.offset(self.body);
                solid.bend(part, touch.point, slope * -force, sink, offset);
            }
            for (i, one) in row.iter().enumerate() {
                let (pulled_way, way) = (matrix * one.way, pulled.inverse * one.way);
                for other in &row[..=i] {
                    let mut value = pulled_way.dot(&other.way);
                    if !convex {
                        // Of two of the body itself, slopes are zero.
                        let back = pulled.inverse * other.way;
                        value += force
                            * (slope[other.axis] * other.slope.dot(&way) + slope[one.axis] * one.slope.dot(&back));
                    }
                    block.push(value);
                }
            }
            sink.add_block(row.iter().map(|moving| moving.unknown), &block);
        })?;
        Some(())
    }

    fn reach(&self, bodies: &Bodies, a: &[f64], step: &[f64]) -> f64 {
        let now = self.now(bodies, a);
        let ((solid, part), (other, others)) = (now.solid(), now.other());
        let (moved, carried) = (bodies.part(self.body, step), bodies.part(self.other, step));
        let way = |solid: &dyn Solid, part: &[f64], step: &[f64], point: usize| {
            let mut way = Vector3::zeros();
            solid.rows(part, point, &mut |p, by| way += by * step[p]);
            way
        };
        // No point of the other comes nearer by more than the way of the fastest.
        let fastest = (0..other.points()).map(|k| way(other, others, carried, k).norm());
        let fastest = fastest.fold(0.0, f64::max);
        let mut reach = 1.0_f64;
        for touch in &self.pressures.touches {
            let own = way(solid, part, moved, touch.point);
            let (way, room) = match now.pulled(touch) {
                Some(pulled) => {
                    let room = (pulled.distance.value + self.deepest()) / pulled.slope.norm();
                    ((own - pulled.way(carried)).norm(), room)
                }
                None => {
                    let apart = now.tree.nearest(&now.point(touch)).1;
                    (own.norm() + fastest, apart - self.spacing + self.deepest())
                }
            };
            if way > room {
                reach = reach.min((room / way).max(0.0));
            }
        }
        reach
    }

    fn reaction(&self, bodies: &Bodies, a: &[f64]) -> f64 {
        let mut largest = 0.0_f64;
        // Without an energy there is no reaction to speak of.
        let _ = self.now(bodies, a).visit(|touch, pressure, pulled| {
            largest = largest.max(touch.area * pressure * pulled.slope.norm());
        });
        largest
    }

    /// As for what is rigid, by the forces on the unknowns of both.
    fn update(&mut self, bodies: &Bodies, a: &[f64]) -> Change {
        let (mut forces, mut lost, mut row) = (vec![0.0; a.len()], 0.0_f64, Vec::new());
        let mut pressures = self.pressures.clone();
        let now = self.now(bodies, a);
        let depth = pressures.update(
            |touch| now.gap(touch),
            |_, pulled| -pulled.now(),
            |touch, more, pulled| {
                let Some(pulled) = pulled else {
                    lost = lost.max(more.abs() * touch.area);
                    return;
                };
                now.row(touch, pulled, &mut row);
                let more = pulled.slope * (more * touch.area);
                row.iter().for_each(|m| forces[m.unknown] += m.way.dot(&more));
            },
        );
        let force = forces.iter().fold(lost, |most: f64, f| most.max(f.abs()));
        // Pressures that push the stiffer of two organs alone change it too little to be found by depths.
        pressures.stiffen(depth, force);
        self.pressures = pressures;
        Change { force, depth }
    }

    fn fit(&self, bodies: &Bodies, a: &[f64]) -> Option<Fit> {
        let now = self.now(bodies, a);
        let gap = |touch: &Touch| now.pulled(touch).map_or(0.0, |pulled| gap_at(touch.gap, pulled.now()));
        Some(Fit {
            inside: 0.0,
            depth: now.depth().max(now.far_depth()),
            gap: self.pressures.touches.iter().map(gap).fold(0.0, f64::max),
            deepest: self.deepest(),
            unproved: None,
        })
    }
}
