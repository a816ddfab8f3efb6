//! How far a step may go before solids touch: proved by bounds, for straight and for turning motion.
//!
//! A sample `p` and an arc are apart as long as a direction `e` keeps every control point `c` of the arc behind the
//! sample: `e . (p - c) > 0`, for an arc lies in the triangle of its control points. Along a step this falls by
//! `t e . (v_p - v_c)` and, where solids turn, by at most `t^2 / 2` times a bound of the second derivatives. The step
//! advances to where the first pair has lost nine tenths of its distance, takes new directions there, and goes on: sliding
//! along one another is not slowed.

use std::cell::Cell;

use nalgebra::Vector2;

use super::shape::Shape;
use crate::solid::Cursor;
use crate::system::Bodies;

/// A step leaves this part of every distance.
const LEFT: f64 = 0.1;
/// Advances before a step is taken as far as it is proved.
const MOST_ADVANCES: usize = 30;
/// An advance below this part of the way made ends the search.
const LITTLE: f64 = 1e-2;

/// Velocities and swerves of the control points of every arc of a solid.
struct Motion {
    /// By arc and node: derivative of the position by `t`.
    velocities: Vec<[Vector2<f64>; 3]>,
    /// By arc: a bound of the second derivatives of its points and control points.
    swerves: Vec<f64>,
    /// A bound of the way of any point over the whole step.
    way: f64,
}

/// `(e . x, its derivative)` of the control points of an arc from those of its nodes.
fn control(nodes: &[Vector2<f64>; 3]) -> [Vector2<f64>; 3] {
    [nodes[0], nodes[1] * 2.0 - (nodes[0] + nodes[2]) * 0.5, nodes[2]]
}

impl Motion {
    fn of(bodies: &Bodies, body: usize, a: &[f64], step: &[f64]) -> Self {
        let (solid, part, moves) = (bodies.solid(body), bodies.part(body, a), bodies.part(body, step));
        let velocity = |node: usize| {
            let mut v = Vector2::zeros();
            solid.rows(part, node, &mut |p, by| v += by * moves[p]);
            v
        };
        let arcs = &solid.boundary().arcs;
        let velocities: Vec<[Vector2<f64>; 3]> = arcs.iter().map(|arc| arc.map(velocity)).collect();
        // The middle control point is twice the middle node less the mean of the others: weights of 3 in all.
        let swerve = |arc: &[usize; 3]| 3.0 * arc.map(|n| solid.swerve(moves, n)).into_iter().fold(0.0, f64::max);
        let swerves: Vec<f64> = arcs.iter().map(swerve).collect();
        let fastest = velocities.iter().flatten().map(|v| v.norm()).fold(0.0, f64::max);
        let most = swerves.iter().copied().fold(0.0, f64::max);
        // Weights of a quadratic arc sum to 1.25 at most.
        Self {
            velocities,
            swerves,
            way: 1.25 * fastest + 0.5 * most,
        }
    }
}

/// A sample near an arc of another solid.
pub(super) struct Facing {
    pub(super) on: [usize; 2],
    pub(super) sample: Cursor,
    pub(super) arc: usize,
    /// Unit vector from the arc to the sample.
    pub(super) direction: Vector2<f64>,
    /// Along it; below zero inside the solid, where that is allowed.
    pub(super) distance: f64,
}

/// Calls a visitor with every pair nearer than a distance in the given state.
type Visit<'a> = dyn FnMut(&[Shape], &Cell<f64>, &mut dyn FnMut(Facing)) + 'a;

/// The part of `step` in which no pair of a sample and an arc is proved to touch; where a `depth` is allowed, to come
/// deeper than it.
pub(super) fn pairs(bodies: &Bodies, a: &[f64], step: &[f64], depth: f64, visit: &mut Visit<'_>) -> f64 {
    let mut t = 0.0;
    for _ in 0..MOST_ADVANCES {
        let at: Vec<f64> = a.iter().zip(step).map(|(a, s)| a + t * s).collect();
        let shapes: Vec<Shape> = (0..bodies.len()).map(|k| Shape::of(bodies, k, &at)).collect();
        let motions: Vec<Motion> = (0..bodies.len()).map(|k| Motion::of(bodies, k, &at, step)).collect();
        let left = 1.0 - t;
        let mut advance = left;
        // What is farther than two solids come in the advance left cannot shorten it.
        let fastest = two_largest(&motions);
        let within = Cell::new(left * fastest);
        visit(&shapes, &within, &mut |facing| {
            let pair = Pair::new(&facing, &shapes, &motions);
            advance = advance.min(pair.free(depth, advance));
            within.set(advance * fastest);
        });
        t += advance;
        if advance >= left || advance < LITTLE * t {
            break;
        }
    }
    t.min(1.0)
}

fn two_largest(motions: &[Motion]) -> f64 {
    let order = motions.iter().fold([0.0_f64; 2], |[first, second], motion| {
        let way = motion.way;
        if way > first {
            [way, first]
        } else {
            [first, second.max(way)]
        }
    });
    order[0] + order[1]
}

/// A sample and the control points of an arc, along the direction that joins them.
struct Pair {
    /// Of each control point: how far behind the sample, and how fast that grows.
    behind: [(f64, f64); 3],
    distance: f64,
    swerve: f64,
    /// A bound of the relative speed in any direction.
    speed: f64,
}

impl Pair {
    fn new(facing: &Facing, shapes: &[Shape], motions: &[Motion]) -> Self {
        let (e, on, sample, arc) = (facing.direction, facing.on, &facing.sample, facing.arc);
        let (own, other) = (&motions[on[0]], &motions[on[1]]);
        let weights = sample.weights();
        let nodes = own.velocities[sample.arc];
        let velocity = nodes[0] * weights[0] + nodes[1] * weights[1] + nodes[2] * weights[2];
        let point = shapes[on[0]].place(sample);
        let (places, speeds) = (control(&shapes[on[1]].arcs[arc]), control(&other.velocities[arc]));
        let behind = std::array::from_fn(|k| (e.dot(&(point - places[k])), e.dot(&(velocity - speeds[k]))));
        let arc_speed = 1.25 * other.velocities[arc].iter().map(|v| v.norm()).fold(0.0, f64::max);
        let swerve = own.swerves[sample.arc] + other.swerves[arc];
        Self {
            behind,
            distance: facing.distance,
            swerve,
            speed: velocity.norm() + arc_speed + 0.5 * swerve,
        }
    }

    /// The largest part of a step, up to `most`, after which a tenth of the distance, and of the depth allowed, is left.
    fn free(&self, depth: f64, most: f64) -> f64 {
        let room = (self.distance + depth).max(0.0);
        let kept = LEFT * room - depth;
        let any_direction = (1.0 - LEFT) * room / self.speed.max(f64::MIN_POSITIVE);
        let one = self
            .behind
            .iter()
            .map(|(gap, rate)| first_fall(gap - kept, *rate, 0.5 * self.swerve));
        let along = one.fold(f64::INFINITY, f64::min);
        along.max(any_direction).min(most)
    }
}

/// The first `t > 0` at which `gap + rate t - bend t^2` is zero; zero where it begins below.
pub(super) fn first_fall(gap: f64, rate: f64, bend: f64) -> f64 {
    if gap <= 0.0 {
        return 0.0;
    }
    let root = (rate * rate + 4.0 * bend * gap).sqrt();
    // The form without cancellation for either sign of the rate.
    if rate <= 0.0 {
        let denominator = root - rate;
        if denominator > 0.0 {
            2.0 * gap / denominator
        } else {
            f64::INFINITY
        }
    } else if bend > 0.0 {
        (rate + root) / (2.0 * bend)
    } else {
        f64::INFINITY
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_fall_is_a_root() {
        for (gap, rate, bend) in [
            (1.0, -2.0, 0.0),
            (1.0, -2.0, 3.0),
            (1.0, 2.0, 3.0),
            (1e-9, -1.0, 1e3),
            (2.0, 0.0, 0.5),
        ] {
            let t = first_fall(gap, rate, bend);
            let terms: f64 = gap + f64::abs(rate * t) + bend * t * t;
            assert!(
                (gap + rate * t - bend * t * t).abs() <= 1e-15 * terms,
                "{gap} {rate} {bend}: {t}"
            );
        }
        assert_eq!(first_fall(0.0, 1.0, 0.0), 0.0);
        assert_eq!(first_fall(1.0, 0.0, 0.0), f64::INFINITY);
    }
}
