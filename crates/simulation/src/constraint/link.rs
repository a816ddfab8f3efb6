//! Links: a point of a solid held at a fixed point, or at a point of another solid (II 3.3.1).
//!
//! Soft: the energy `k/2 |M1 - M2|^2`, the square and not the distance of II 3.18, which has no derivative where the
//! link is satisfied. Hard: `f . (M1 - M2) + k/2 |M1 - M2|^2`, whose force `f` is raised by `k (M1 - M2)` until the
//! distance vanishes.

use nalgebra::Vector2;

use super::rows::{Rows, bend};
use super::{Active, Change, Constraint, Force, Progress, Term};
use crate::bodies::Bodies;
use crate::solid::Cursor;
use crate::sparse::Triplets;

/// An end of a link.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum End {
    /// A point of the plane.
    Fixed(Vector2<f64>),
    /// A point of a solid's boundary, which stays the same point of the solid.
    On {
        /// The solid.
        body: usize,
        /// Where on its boundary.
        cursor: Cursor,
    },
}

impl End {
    /// Where it is, about the origin that places are measured from.
    fn place(&self, bodies: &Bodies, a: &[f64]) -> Vector2<f64> {
        match self {
            Self::Fixed(point) => point - bodies.origin(),
            Self::On { body, cursor } => {
                let (solid, part) = (bodies.solid(*body), bodies.part(*body, a));
                let nodes = solid.boundary().arcs[cursor.arc].map(|n| solid.point_about(part, n, bodies.origin()));
                nodes.iter().zip(cursor.weights()).map(|(x, w)| x * w).sum()
            }
        }
    }

    fn add(&self, bodies: &Bodies, a: &[f64], sign: f64, rows: &mut Rows) {
        if let Self::On { body, cursor } = self {
            rows.add(bodies, *body, cursor, a, sign);
        }
    }
}

/// A link between two ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Link {
    ends: [End; 2],
    /// Force by length.
    stiffness: f64,
    /// The force that pulls the first end to the second, of a hard link.
    force: Option<Vector2<f64>>,
    /// The difference that the last Newton step aimed at.
    after: Vector2<f64>,
}

impl Link {
    /// A spring of zero length at rest: `stiffness / 2` times the squared distance.
    pub fn soft(ends: [End; 2], stiffness: f64) -> Self {
        Self {
            ends,
            stiffness,
            force: None,
            after: Vector2::zeros(),
        }
    }

    /// A link that holds exactly. `stiffness` only decides how fast its force settles: 10 to 1000 times the stiffness of
    /// what it holds is good.
    pub fn hard(ends: [End; 2], stiffness: f64) -> Self {
        Self {
            ends,
            stiffness,
            force: Some(Vector2::zeros()),
            after: Vector2::zeros(),
        }
    }

    fn difference(&self, bodies: &Bodies, a: &[f64]) -> Vector2<f64> {
        self.ends[0].place(bodies, a) - self.ends[1].place(bodies, a)
    }

    fn pull(&self, difference: Vector2<f64>) -> Vector2<f64> {
        self.force.unwrap_or_default() + difference * self.stiffness
    }

    fn moves(&self, bodies: &Bodies, a: &[f64]) -> Rows {
        let mut rows = Rows::default();
        self.ends[0].add(bodies, a, 1.0, &mut rows);
        self.ends[1].add(bodies, a, -1.0, &mut rows);
        rows
    }
}

impl Term for Link {
    fn energy(&self, bodies: &Bodies, a: &[f64]) -> Option<f64> {
        let c = self.difference(bodies, a);
        Some(self.force.unwrap_or_default().dot(&c) + 0.5 * self.stiffness * c.norm_squared())
    }

    fn gradient(&self, bodies: &Bodies, a: &[f64], gradient: &mut [f64]) -> Option<f64> {
        let pull = self.pull(self.difference(bodies, a));
        for row in self.moves(bodies, a).0 {
            gradient[row.unknown] += pull.dot(&row.by);
        }
        self.energy(bodies, a)
    }

    fn hessian(&self, bodies: &Bodies, a: &[f64], convex: bool, sink: &mut Triplets) -> Option<()> {
        let rows = self.moves(bodies, a);
        rows.add_form(sink, |p, q| self.stiffness * p.by.dot(&q.by));
        let pull = self.pull(self.difference(bodies, a));
        // The curvature of a turning end takes the sign of the pull: the convex matrix does without.
        for (end, sign) in self.ends.iter().zip([1.0, -1.0]).filter(|_| !convex) {
            if let End::On { body, cursor } = end {
                bend(bodies, *body, cursor, a, pull * sign, sink);
            }
        }
        Some(())
    }

    fn forces(&self, bodies: &Bodies, a: &[f64]) -> Vec<Force> {
        let difference = self.difference(bodies, a);
        // After the update of a hard link the force alone holds it.
        let pull = self.force.unwrap_or(difference * self.stiffness);
        let on = self.ends.iter().zip([-1.0, 1.0]).filter_map(|(end, sign)| match end {
            End::Fixed(_) => None,
            End::On { body, .. } => Some(Force {
                body: *body,
                point: end.place(bodies, a) + bodies.origin(),
                force: pull * sign,
                gap: difference.norm(),
            }),
        });
        on.collect()
    }
}

impl Constraint for Link {
    fn update(&mut self, bodies: &Bodies, a: &[f64]) -> Change {
        let c = self.difference(bodies, a);
        match &mut self.force {
            None => Change::default(),
            Some(force) => {
                *force += c * self.stiffness;
                let change = (c * self.stiffness).amax();
                Change {
                    force: change,
                    violation: c.norm(),
                    again: false,
                }
            }
        }
    }

    fn rows(&mut self) -> Option<&mut dyn Active> {
        self.force.is_some().then_some(self as &mut dyn Active)
    }

    fn copy(&self) -> Box<dyn Constraint> {
        Box::new(*self)
    }
}

impl Active for Link {
    fn aim(&mut self, _work: Option<f64>) {}

    fn limits(&mut self, bodies: &Bodies, a: &[f64], step: &[f64]) -> [f64; 2] {
        self.after = self.difference(bodies, a);
        for row in self.moves(bodies, a).0 {
            self.after += row.by * step[row.unknown];
        }
        [1.0; 2]
    }

    fn take(&mut self, [_, part]: [f64; 2]) {
        if let Some(force) = &mut self.force {
            // The difference that the step leads to in linear terms, times the stiffness: Newton's own new force.
            *force += self.after * (part * self.stiffness);
        }
    }

    fn review(&mut self, bodies: &Bodies, a: &[f64], _between: bool) -> Progress {
        Progress {
            violation: self.difference(bodies, a).norm(),
            ..Progress::default()
        }
    }
}
