//! Cursors: points that move along a boundary and know its shape where they are.

use nalgebra::Vector2;

use super::Solid;
use crate::q9::shape::{line, line_slope};

/// A point of a boundary.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cursor {
    /// Which arc.
    pub arc: usize,
    /// Where on it, from -1 to 1.
    pub u: f64,
}

/// Position and derivatives of the deformed boundary at a cursor, by arc length `s` of the reference boundary (II 3.16).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Local {
    /// `M`.
    pub position: Vector2<f64>,
    /// `M_s = lambda C_u`, `lambda = 1 / |R_u|`.
    pub tangent: Vector2<f64>,
    /// `M_ss = lambda^2 C_uu - lambda^4 <R_u, R_uu> C_u`.
    pub second: Vector2<f64>,
    /// `lambda`, the inverse of a length.
    pub lambda: f64,
}

impl Local {
    /// The unit normal that points out of the solid; zero where the boundary has no tangent.
    pub fn normal(&self) -> Vector2<f64> {
        let out = Vector2::new(self.tangent.y, -self.tangent.x);
        out.try_normalize(0.0).unwrap_or_default()
    }
}

fn combine(points: &[Vector2<f64>; 3], weights: [f64; 3]) -> Vector2<f64> {
    points[0] * weights[0] + points[1] * weights[1] + points[2] * weights[2]
}

/// Second derivatives of the shape functions.
const BEND: [f64; 3] = [1.0, -2.0, 1.0];

impl Cursor {
    /// Weights of the three nodes of its arc in its position (II 3.15).
    pub fn weights(&self) -> [f64; 3] {
        line(self.u)
    }

    /// Where it is, and how the boundary runs there.
    pub fn local(&self, solid: &dyn Solid, a: &[f64]) -> Local {
        let boundary = solid.boundary();
        let current = boundary.arcs[self.arc].map(|n| solid.point(a, n));
        let reference = &boundary.reference[self.arc];
        let (c_u, c_uu) = (combine(&current, line_slope(self.u)), combine(&current, BEND));
        let (r_u, r_uu) = (combine(reference, line_slope(self.u)), combine(reference, BEND));
        let lambda = 1.0 / r_u.norm();
        Local {
            position: combine(&current, line(self.u)),
            tangent: c_u * lambda,
            second: c_uu * lambda.powi(2) - c_u * (lambda.powi(4) * r_u.dot(&r_uu)),
            lambda,
        }
    }

    /// Calls `visit` with every parameter that moves it, the derivative of its position `M` and of its tangent `M_s`.
    /// A parameter may come several times: the parts add up.
    pub fn rows(&self, solid: &dyn Solid, a: &[f64], visit: &mut dyn FnMut(usize, Vector2<f64>, Vector2<f64>)) {
        let lambda = self.local(solid, a).lambda;
        let arc = solid.boundary().arcs[self.arc];
        let (weights, slopes) = (line(self.u), line_slope(self.u));
        for k in 0..3 {
            let mut scaled = |parameter, by: Vector2<f64>| visit(parameter, by * weights[k], by * (lambda * slopes[k]));
            solid.rows(a, arc[k], &mut scaled);
        }
    }

    /// The cursor `by` further along the contour, arc length of the reference boundary; it goes on over corners.
    ///
    /// The length is integrated by Gauss's rule on each piece and found by Newton's method: to about 1e-12 of an arc
    /// that turns less than a quarter.
    #[must_use]
    pub fn moved(&self, solid: &dyn Solid, by: f64) -> Self {
        let boundary = solid.boundary();
        let (mut at, mut left) = (*self, by);
        // A contour is passed whole at most this often: more would be a mistake of the caller.
        for _ in 0..4 * boundary.arcs.len() {
            let end = if left >= 0.0 { 1.0 } else { -1.0 };
            let room = length(&boundary.reference[at.arc], at.u, end);
            if left.abs() <= room.abs() {
                at.u = at.reach(&boundary.reference[at.arc], left);
                return at;
            }
            // `room` has the sign of `left`: both go to zero.
            left -= room;
            at = if left > 0.0 {
                Self {
                    arc: boundary.next[at.arc],
                    u: -1.0,
                }
            } else {
                Self {
                    arc: boundary.previous[at.arc],
                    u: 1.0,
                }
            };
        }
        at
    }

    fn reach(&self, reference: &[Vector2<f64>; 3], by: f64) -> f64 {
        let mut u = self.u;
        for _ in 0..20 {
            let speed = combine(reference, line_slope(u)).norm();
            let step = (by - length(reference, self.u, u)) / speed;
            u = (u + step).clamp(-1.0, 1.0);
            // Some four times 2^-52, of a parameter of at most 1: the rounding of the length.
            if step.abs() < 1e-15 {
                break;
            }
        }
        u
    }
}

/// Signed length of a reference arc between two of its parameters.
fn length(reference: &[Vector2<f64>; 3], from: f64, to: f64) -> f64 {
    // Four pieces of a three-point rule.
    let (pieces, mut sum) = (4, 0.0);
    let half = 0.5 * (to - from) / f64::from(pieces);
    for piece in 0..pieces {
        let middle = from + half * f64::from(2 * piece + 1);
        for (x, weight) in crate::q9::GAUSS {
            sum += weight * half * combine(reference, line_slope(middle + half * x)).norm();
        }
    }
    sum
}
