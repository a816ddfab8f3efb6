//! The signed distance of a point to a quadratic arc, negative inside the solid, with its two derivatives.
//!
//! The foot `q(v)` moves with the unknowns so that `<p - q, q'> = 0`. With `t` the unit tangent, `n` the outward normal,
//! `s = |q'|`, `h` the distance and `D = s^2 - h <q'', n>`, the differentials `tau = <t, dp - dq>` and `beta = <n, dq'>` at
//! fixed `v` give
//!
//! `dh = <n, dp - dq>`, `d2 h = -(2 s tau beta + h beta^2 + <q'', n> tau^2) / D`:
//!
//! finite where the point lies on the arc, unlike the derivatives of the distance without a sign.

use nalgebra::Vector2;

use super::nearest::{combine, nearest};
use super::shape::Shape;
use crate::q9::shape::{line, line_slope};
use crate::solid::{Boundary, Cursor};

/// A foot that has its point this near, in sizes of the shape's box, at a corner has no direction of its own.
const AT_CORNER: f64 = 1e-6;
/// The cosine of the angle that a corner turns by at most, where distances along one of its sides will do for that to it.
const BLUNT_COSINE: f64 = 0.9;

/// The foot of a point on an arc.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Foot {
    /// Where.
    pub(super) on: Cursor,
    /// The signed distance.
    pub(super) gap: f64,
    /// Its derivative by the point.
    pub(super) normal: Vector2<f64>,
    /// Where the foot slides with the point: `(t, s, <q'', n>, D)`.
    slides: Option<Slides>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct Slides {
    tangent: Vector2<f64>,
    speed: f64,
    bend: f64,
    denominator: f64,
}

/// The differential of a point against its foot by one unknown.
#[derive(Debug, Clone, Copy)]
pub(super) struct Moves {
    /// `dp - dq`.
    pub(super) by: Vector2<f64>,
    /// `dq'`.
    pub(super) slope: Vector2<f64>,
}

/// The outward normal of an arc with the solid on its left.
fn outward(slope: Vector2<f64>) -> Vector2<f64> {
    Vector2::new(slope.y, -slope.x).try_normalize(0.0).unwrap_or_default()
}

impl Foot {
    /// The foot inside an arc, at `v` where `<p - q, q'>` vanishes. `None` past the arc's centre of curvature.
    pub(super) fn inside(arc: usize, nodes: &[Vector2<f64>; 3], point: Vector2<f64>, v: f64) -> Option<Self> {
        let slope = combine(nodes, line_slope(v));
        let (speed, normal) = (slope.norm(), outward(slope));
        let gap = normal.dot(&(point - combine(nodes, line(v))));
        let bend = normal.dot(&(nodes[0] - nodes[1] * 2.0 + nodes[2]));
        // Minus the derivative of `<p - q, q'>` along the arc: positive where the foot is the nearest point and not the
        // farthest.
        let denominator = speed * speed - gap * bend;
        let slides = Slides {
            tangent: slope / speed,
            speed,
            bend,
            denominator,
        };
        (denominator > 0.0).then_some(Self {
            on: Cursor { arc, u: v },
            gap,
            normal,
            slides: Some(slides),
        })
    }

    /// The bilinear form of `d2 h`; zero where the foot sits in a corner, whose own curvature is left out.
    pub(super) fn second(&self, p: &Moves, q: &Moves) -> f64 {
        let Some(s) = self.slides else { return 0.0 };
        let (tau_p, tau_q) = (s.tangent.dot(&p.by), s.tangent.dot(&q.by));
        let (beta_p, beta_q) = (self.normal.dot(&p.slope), self.normal.dot(&q.slope));
        let crossed = s.speed * (tau_p * beta_q + tau_q * beta_p);
        -(crossed + self.gap * beta_p * beta_q + s.bend * tau_p * tau_q) / s.denominator
    }
}

/// The zero of `<p - q, q'>` on an arc near `v`, kept within its ends.
fn settle(nodes: &[Vector2<f64>; 3], point: Vector2<f64>, mut v: f64) -> Option<f64> {
    let bend = nodes[0] - nodes[1] * 2.0 + nodes[2];
    for _ in 0..30 {
        let (offset, slope) = (point - combine(nodes, line(v)), combine(nodes, line_slope(v)));
        let derivative = bend.dot(&offset) - slope.norm_squared();
        // Past the centre of curvature Newton's method would climb to the farthest point; a NaN leads nowhere.
        if derivative.is_nan() || derivative >= 0.0 {
            return None;
        }
        // A zero beyond an end lies on the next arc, to which `walk` goes on.
        let next = (v - slope.dot(&offset) / derivative).clamp(-1.0, 1.0);
        // The parameter is at most 1: such a change is its rounding.
        if (next - v).abs() <= f64::EPSILON {
            return Some(next);
        }
        v = next;
    }
    Some(v)
}

/// The foot of a point on a boundary: walks from `start` over the ends of arcs to the next. In a corner that goes in, where a
/// point may rest on both sides, it stays on its own arc as long as both are as near but for `margin`.
pub(super) fn walk(
    shape: &Shape,
    boundary: &Boundary,
    start: Cursor,
    point: Vector2<f64>,
    margin: f64,
) -> Option<Foot> {
    let mut at = start;
    // A step moves a foot by an arc or two; a foot that goes farther has lost its contact.
    for _ in 0..4 {
        let nodes = &shape.arcs[at.arc];
        let v = settle(nodes, point, at.u).unwrap_or_else(|| nearest(nodes, point).u);
        if v.abs() < 1.0 {
            return Foot::inside(at.arc, nodes, point, v);
        }
        if let Some(foot) = corner(shape, boundary, [at.arc, usize::from(v > 0.0)], point, margin) {
            return Some(foot);
        }
        at = if v > 0.0 {
            Cursor {
                arc: boundary.next[at.arc],
                u: -1.0,
            }
        } else {
            Cursor {
                arc: boundary.previous[at.arc],
                u: 1.0,
            }
        };
    }
    None
}

/// The foot in the corner at an end of an arc, where it is the nearest point of the next arc too.
///
/// Of a corner that stands out, along the line to it, where that is long enough; in a valley's cone, along the arc's own normal at its end.
fn corner(
    shape: &Shape,
    boundary: &Boundary,
    [arc, end]: [usize; 2],
    point: Vector2<f64>,
    margin: f64,
) -> Option<Foot> {
    let last = end == 1;
    let other = if last {
        boundary.next[arc]
    } else {
        boundary.previous[arc]
    };
    let end = if last { 1.0 } else { -1.0 };
    let (own, next) = (&shape.arcs[arc], &shape.arcs[other]);
    let vertex = if last { own[2] } else { own[0] };
    let offset = point - vertex;
    let slopes = [combine(own, line_slope(end)), combine(next, line_slope(-end))];
    let normals = slopes.map(outward);
    // Times `end` it is the turn of the contour, counter-clockwise: above zero the corner stands out.
    let turns = slopes[0].x * slopes[1].y - slopes[0].y * slopes[1].x;
    let both = turns * end < 0.0 && (normals[0] - normals[1]).dot(&offset).abs() <= margin;
    // The next arc leads on from the corner: the foot goes there.
    if slopes[1].dot(&offset) * end > 0.0 && !both {
        return None;
    }
    let on = Cursor { arc, u: end };
    let flat = |normal: Vector2<f64>| Foot {
        on,
        gap: normal.dot(&offset),
        normal,
        slides: None,
    };
    // In a valley each side holds the point by a row of its own: this one by the line along its arc's end.
    if turns * end <= 0.0 {
        return Some(flat(normals[0]));
    }
    let size = (shape.bounds[1] - shape.bounds[0]).amax();
    let distance = offset.norm();
    // Next to the corner the point keeps out of the side that it is farther out of: tip on tip, it slides off. Forces on
    // a tip itself would have no direction.
    if distance <= AT_CORNER * size || normals[0].dot(&normals[1]) > BLUNT_COSINE {
        let farther = if normals[1].dot(&offset) > normals[0].dot(&offset) {
            1
        } else {
            0
        };
        return Some(flat(normals[farther]));
    }
    Some(Foot {
        on,
        gap: distance,
        normal: offset / distance,
        slides: None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The gap and its gradient by the coordinates of the point and of the three nodes.
    fn gap(x: &[f64; 8], start: f64) -> (Foot, [Moves; 8]) {
        let point = Vector2::new(x[0], x[1]);
        let nodes = [1, 2, 3].map(|k| Vector2::new(x[2 * k], x[2 * k + 1]));
        let v = settle(&nodes, point, start).unwrap();
        let foot = Foot::inside(0, &nodes, point, v).unwrap();
        let moves = std::array::from_fn(|k| {
            let axis = if k % 2 == 0 { Vector2::x() } else { Vector2::y() };
            match k / 2 {
                0 => Moves {
                    by: axis,
                    slope: Vector2::zeros(),
                },
                n => Moves {
                    by: -axis * line(v)[n - 1],
                    slope: axis * line_slope(v)[n - 1],
                },
            }
        });
        (foot, moves)
    }

    #[test]
    fn second_derivatives_are_those_of_the_moving_foot() {
        let mut state = 3_u64;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        };
        for round in 0..40 {
            // From the arc itself to a distance beside its radius of curvature, on either side.
            let away = if round % 4 == 0 { 0.0 } else { 0.4 * next() };
            let x = [
                0.6 * next(),
                away,
                -1.0,
                0.2 * next(),
                0.1 * next(),
                0.2 * next(),
                1.0,
                0.2 * next(),
            ];
            let (foot, moves) = gap(&x, 0.0);
            if foot.on.u.abs() > 0.99 {
                continue;
            }
            let h = 1e-5;
            for k in 0..8 {
                let at = |by: f64| {
                    let mut y = x;
                    y[k] += by;
                    let (foot, moves) = gap(&y, foot.on.u);
                    (foot.gap, moves.map(|m| foot.normal.dot(&m.by)))
                };
                let (plus, minus) = (at(h), at(-h));
                // h^2 / 6 times third derivatives of some tens, and rounding over h.
                let slope = (plus.0 - minus.0) / (2.0 * h);
                assert!((slope - foot.normal.dot(&moves[k].by)).abs() < 1e-8, "{round} {k}");
                for j in 0..8 {
                    let difference = (plus.1[j] - minus.1[j]) / (2.0 * h);
                    let exact = foot.second(&moves[j], &moves[k]);
                    assert!(
                        (difference - exact).abs() < 1e-6 * exact.abs().max(1.0),
                        "{round} {j} {k}: {difference} {exact}"
                    );
                }
            }
        }
    }
}
