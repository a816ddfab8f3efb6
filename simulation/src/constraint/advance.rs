//! How far a step may go before solids touch: proved by bounds, for straight and for turning motion.
//!
//! A sample `p` and an arc are apart as long as a direction `e` keeps every control point `c` of the arc behind the
//! sample: `e . (p - c) > 0`, for an arc lies in the triangle of its control points. Along a step this falls by
//! `t e . (v_p - v_c)` and, where solids turn, by at most `t^2 / 2` times a bound of the second derivatives. The step
//! advances to where the first pair has lost nine tenths of its distance, takes new directions there, and goes on: sliding
//! along one another is not slowed. Only pairs whose swept boxes meet are looked at, and from one advance to the next only
//! those that were not proved free for the rest of the step.

use nalgebra::Vector2;

use super::shape::{Shape, box_distance};
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
        let swerves = arcs.iter().map(swerve).collect();
        Self { velocities, swerves }
    }
}

/// A sample and an arc that may meet in a step.
#[derive(Debug, Clone, Copy)]
pub(super) struct Track {
    pub(super) on: [usize; 2],
    pub(super) sample: Cursor,
    pub(super) arc: usize,
}

/// How a sample lies to an arc.
#[derive(Debug, Clone, Copy)]
pub(super) struct Facing {
    /// Unit vector from the arc to the sample.
    pub(super) direction: Vector2<f64>,
    /// Along it; below zero inside the solid, where that is allowed.
    pub(super) distance: f64,
}

/// What may be asked of whoever knows which samples keep out of which arcs.
pub(super) trait Pairing {
    /// All samples that could meet an arc, from shapes whose boxes hold all that each arc passes in the step.
    fn tracks(&self, swept: &[Shape]) -> Vec<Track>;

    /// How they lie in a state; `None` where this sample does not keep out of this arc now.
    fn facing(&self, shapes: &[Shape], track: &Track) -> Option<Facing>;
}

/// The part of `step` in which no pair of a sample and an arc is proved to touch; where a `depth` is allowed, to come
/// deeper than it.
pub(super) fn pairs(bodies: &Bodies, a: &[f64], step: &[f64], depth: f64, pairing: &impl Pairing) -> f64 {
    let along = |t: f64| -> Vec<f64> { a.iter().zip(step).map(|(a, s)| a + t * s).collect() };
    let shapes_at = |at: &[f64]| -> Vec<Shape> { (0..bodies.len()).map(|k| Shape::of(bodies, k, at)).collect() };
    let mut shapes = shapes_at(a);
    let swept: Vec<Shape> = (0..bodies.len())
        .map(|k| {
            swept(
                &shapes[k],
                &Shape::of(bodies, k, &along(1.0)),
                &Motion::of(bodies, k, a, step),
            )
        })
        .collect();
    // Each with the part of the step up to which it is proved free.
    let mut tracks: Vec<(f64, Track)> = pairing.tracks(&swept).into_iter().map(|track| (0.0, track)).collect();
    let mut t = 0.0;
    for _ in 0..MOST_ADVANCES {
        if tracks.is_empty() {
            return 1.0;
        }
        let at = along(t);
        if t > 0.0 {
            shapes = shapes_at(&at);
            // Those that bind first: they leave little to prove of the others.
            tracks.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        }
        let motions: Vec<Motion> = (0..bodies.len()).map(|k| Motion::of(bodies, k, &at, step)).collect();
        let (left, advance) = (1.0 - t, round(&mut tracks, &shapes, &motions, pairing, depth, t));
        t += advance;
        if advance >= left || advance < LITTLE * t {
            break;
        }
    }
    t.min(1.0)
}

/// How much farther than `t` all tracks are proved free, from the state there; those that are for all of the step are left out.
fn round(
    tracks: &mut Vec<(f64, Track)>,
    shapes: &[Shape],
    motions: &[Motion],
    pairing: &impl Pairing,
    depth: f64,
    t: f64,
) -> f64 {
    let left = 1.0 - t;
    let mut advance = left;
    tracks.retain_mut(|(until, track)| {
        if *until >= t + advance {
            return true;
        }
        let pair = Pair::new(track, shapes, motions);
        let mut free = pair.far(depth, left);
        if free < advance {
            let Some(facing) = pairing.facing(shapes, track) else {
                return true;
            };
            free = pair.free(&facing, depth, left).max(free);
        }
        advance = advance.min(free);
        *until = t + free;
        // Who is proved free for all that is left needs no further look.
        free < left
    });
    advance
}

/// Boxes that hold every arc all along the step: those of its ends, and what it swerves from straight lines between them.
fn swept(start: &Shape, end: &Shape, motion: &Motion) -> Shape {
    let mut swept = start.clone();
    for ((bounds, other), swerve) in swept.boxes.iter_mut().zip(&end.boxes).zip(&motion.swerves) {
        let about = Vector2::repeat(0.125 * swerve);
        *bounds = [bounds[0].inf(&other[0]) - about, bounds[1].sup(&other[1]) + about];
    }
    swept
}

/// A sample and the control points of an arc on their way.
struct Pair {
    point: Vector2<f64>,
    velocity: Vector2<f64>,
    places: [Vector2<f64>; 3],
    speeds: [Vector2<f64>; 3],
    /// At least how far apart they are.
    apart: f64,
    swerve: f64,
    /// A bound of the relative speed in any direction.
    speed: f64,
}

impl Pair {
    fn new(track: &Track, shapes: &[Shape], motions: &[Motion]) -> Self {
        let (on, sample, arc) = (track.on, &track.sample, track.arc);
        let (own, other) = (&motions[on[0]], &motions[on[1]]);
        let weights = sample.weights();
        let nodes = own.velocities[sample.arc];
        let velocity = nodes[0] * weights[0] + nodes[1] * weights[1] + nodes[2] * weights[2];
        let point = shapes[on[0]].place(sample);
        let swerve = own.swerves[sample.arc] + other.swerves[arc];
        // Weights of a quadratic arc sum to 1.25 at most.
        let arc_speed = 1.25 * other.velocities[arc].iter().map(|v| v.norm()).fold(0.0, f64::max);
        Self {
            point,
            velocity,
            places: control(&shapes[on[1]].arcs[arc]),
            speeds: control(&other.velocities[arc]),
            apart: box_distance(&shapes[on[1]].boxes[arc], &point),
            swerve,
            speed: velocity.norm() + arc_speed + 0.5 * swerve,
        }
    }

    /// The part of a step, up to `most`, that the box of the arc alone says is free.
    fn far(&self, depth: f64, most: f64) -> f64 {
        if self.apart > 0.0 {
            ((1.0 - LEFT) * (self.apart + depth) / self.speed.max(f64::MIN_POSITIVE)).min(most)
        } else {
            0.0
        }
    }

    /// The largest part of a step, up to `most`, after which a tenth of the distance, and of the depth allowed, is left.
    fn free(&self, facing: &Facing, depth: f64, most: f64) -> f64 {
        let e = facing.direction;
        let room = (facing.distance + depth).max(0.0);
        let kept = LEFT * room - depth;
        let any_direction = (1.0 - LEFT) * room / self.speed.max(f64::MIN_POSITIVE);
        let one = |k: usize| {
            let (gap, rate) = (
                e.dot(&(self.point - self.places[k])),
                e.dot(&(self.velocity - self.speeds[k])),
            );
            first_fall(gap - kept, rate, 0.5 * self.swerve)
        };
        let along = (0..3).map(one).fold(f64::INFINITY, f64::min);
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
