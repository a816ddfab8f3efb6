//! How far a step may go before solids touch: proved by bounds, for straight and for turning motion.
//!
//! A sample and an arc are apart as long as lines keep them apart ([`super::separating_lines`]). The step advances to where the first pair has
//! lost nine tenths of its distance, takes new lines there, and goes on: sliding along one another is not slowed. Only pairs
//! whose swept boxes meet are looked at, and from one advance to the next only those that were not proved free for the rest of the step.

use nalgebra::Vector2;

pub(super) use super::separating_lines::first_fall;
use super::separating_lines::{Facing, LEFT_OF_DISTANCE, Pair};
use super::shape::{Shape, boxes_near};
use crate::bodies::Bodies;
use crate::solid::Cursor;

/// Advances before a step is taken as far as it is proved.
const MOST_ADVANCES: usize = 30;
/// An advance below this part of the way made ends the search.
const LEAST_ADVANCE: f64 = 1e-2;

/// How the boundary of a solid moves in a step.
struct Motion {
    /// By arc and node: derivative of the position by `t`.
    velocities: Vec<[Vector2<f64>; 3]>,
    /// By arc: a bound of the second derivatives of its points and control points.
    swerves: Vec<f64>,
    /// By arc: a bound of how fast its points move.
    speeds: Vec<f64>,
}

impl Motion {
    fn of(bodies: &Bodies, body: usize, a: &[f64], step: &[f64]) -> Self {
        let (solid, part, moves) = (bodies.solid(body), bodies.part(body, a), bodies.part(body, step));
        let velocities = solid.velocities(part, moves);
        // The middle control point is twice the middle node less the mean of the others: weights of 3 in all.
        let swerve = |arc: &[usize; 3]| 3.0 * arc.map(|n| solid.swerve(moves, n)).into_iter().fold(0.0, f64::max);
        Self {
            swerves: solid.boundary().arcs.iter().map(swerve).collect(),
            speeds: speeds(&velocities),
            velocities,
        }
    }

    /// True where positions are linear in `t`.
    fn straight(&self) -> bool {
        self.swerves.iter().all(|s| *s == 0.0)
    }
}

/// Weights of a quadratic arc sum to 1.25 at most.
fn speeds(velocities: &[[Vector2<f64>; 3]]) -> Vec<f64> {
    let most = |arc: &[Vector2<f64>; 3]| arc.iter().map(|v| v.norm_squared()).fold(0.0, f64::max);
    velocities.iter().map(|arc| 1.25 * most(arc).sqrt()).collect()
}

/// A sample and an arc that may meet in a step.
#[derive(Debug, Clone, Copy)]
pub(super) struct Track {
    pub(super) on: [usize; 2],
    pub(super) sample: Cursor,
    pub(super) arc: usize,
}

/// What may be asked of whoever knows which samples keep out of which arcs.
pub(super) trait Pairing {
    /// All samples that could meet an arc, from shapes whose boxes hold all that each arc passes in the step.
    fn tracks(&self, swept: &[Shape]) -> Vec<Track>;

    /// How they lie in a state; `None` where this sample does not keep out of this arc now.
    fn facing(&self, shapes: &[Shape], track: &Track) -> Option<Facing>;
}

/// A step from a state.
pub(super) struct Way<'a> {
    pub(super) bodies: &'a Bodies,
    pub(super) a: &'a [f64],
    pub(super) step: &'a [f64],
    /// Where boundaries are at its start.
    pub(super) start: &'a [Shape],
    /// No sample is nearer to an arc that it keeps out of; 0 where that is not known.
    pub(super) least: f64,
}

impl Way<'_> {
    fn at(&self, t: f64) -> Vec<f64> {
        self.a.iter().zip(self.step).map(|(a, s)| a + t * s).collect()
    }

    /// Where boundaries are at the part `t`; and how those move that turn, in `motions`.
    fn shapes(&self, t: f64, motions: &mut [Motion]) -> Vec<Shape> {
        // Straight motion needs no new state: nodes move by `t` times their velocity.
        let turning = motions.iter().any(|m| !m.straight());
        let at = if turning { self.at(t) } else { Vec::new() };
        let each = motions.iter_mut().enumerate().map(|(k, motion)| {
            if motion.straight() {
                return self.start[k].moved(&motion.velocities, t);
            }
            *motion = Motion::of(self.bodies, k, &at, self.step);
            Shape::of(self.bodies, k, &at)
        });
        each.collect()
    }

    /// All samples that could meet an arc, with the part of the step up to which each is proved free: none yet.
    fn tracks(&self, motions: &[Motion], pairing: &impl Pairing) -> Vec<(f64, Track)> {
        let end = self.at(1.0);
        let end: Vec<Shape> = (0..motions.len()).map(|k| Shape::of(self.bodies, k, &end)).collect();
        let each = self.start.iter().zip(&end).zip(motions);
        let swept: Vec<Shape> = each.map(|((start, end), motion)| swept(start, end, motion)).collect();
        let mut tracks = pairing.tracks(&swept);
        tracks.retain(|track| {
            let ([own, other], sample) = (track.on, &track.sample);
            let (from, to) = (self.start[own].place(sample), end[own].place(sample));
            // A path whose second derivative is at most `c` leaves its chord by at most `c t (1 - t) / 2`, so `c / 8`.
            let about = Vector2::repeat(0.125 * motions[own].swerves[sample.arc]);
            let bounds = [from.inf(&to) - about, from.sup(&to) + about];
            boxes_near(&bounds, &swept[other].boxes[track.arc], 0.0)
        });
        tracks.into_iter().map(|track| (0.0, track)).collect()
    }
}

/// The part of a step in which no pair of a sample and an arc is proved to touch; where a `depth` is allowed, to come
/// deeper than it.
pub(super) fn pairs(way: &Way<'_>, depth: f64, pairing: &impl Pairing) -> f64 {
    let motion = |k| Motion::of(way.bodies, k, way.a, way.step);
    let mut motions: Vec<Motion> = (0..way.bodies.len()).map(motion).collect();
    // Nothing comes nearer than that in the whole step: no pair has to be looked for.
    if approach(&motions) <= (1.0 - LEFT_OF_DISTANCE) * way.least {
        return 1.0;
    }
    let mut tracks = way.tracks(&motions, pairing);
    let (mut t, mut moved) = (0.0, Vec::new());
    for _ in 0..MOST_ADVANCES {
        if tracks.is_empty() {
            return 1.0;
        }
        if t > 0.0 {
            moved = way.shapes(t, &mut motions);
            // The one that binds first leaves little to prove of the others.
            let all = tracks.iter().enumerate();
            let first = all.min_by(|a, b| a.1.0.total_cmp(&b.1.0)).map_or(0, |(k, _)| k);
            tracks.swap(0, first);
        }
        let shapes = if t > 0.0 { &moved } else { way.start };
        let (left, advance) = (1.0 - t, round(&mut tracks, shapes, &motions, pairing, depth, t));
        t += advance;
        // Short advances prove little more, each at the price of a round.
        if advance >= left || advance < LEAST_ADVANCE * t {
            break;
        }
    }
    t.min(1.0)
}

/// By how much a sample and an arc can come nearer in a whole step.
fn approach(motions: &[Motion]) -> f64 {
    let most = |of: fn(&Motion) -> &Vec<f64>| motions.iter().flat_map(of).copied().fold(0.0, f64::max);
    // Two speeds, and twice half a swerve.
    2.0 * most(|m| &m.speeds) + most(|m| &m.swerves)
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
        // Proved farther than this round can go: looked at again when it binds.
        if *until >= t + advance {
            return true;
        }
        let pair = pair(track, shapes, motions);
        let mut free = pair.far(depth, left);
        if free < advance {
            free = free.max(pair.beside(depth, left));
        }
        if free < advance {
            // It binds nothing now, but may after the next advance: the track stays.
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
    let each = start.boxes.iter().zip(&end.boxes).zip(&motion.swerves);
    let boxes = each.map(|((one, other), swerve)| {
        let about = Vector2::repeat(0.125 * swerve);
        [one[0].inf(&other[0]) - about, one[1].sup(&other[1]) + about]
    });
    Shape {
        arcs: Vec::new(),
        boxes: boxes.collect(),
        bounds: start.bounds,
    }
}

fn pair<'a>(track: &Track, shapes: &'a [Shape], motions: &'a [Motion]) -> Pair<'a> {
    let (on, sample, arc) = (track.on, &track.sample, track.arc);
    let (own, other) = (&motions[on[0]], &motions[on[1]]);
    let (weights, nodes) = (sample.weights(), own.velocities[sample.arc]);
    let velocity = nodes[0] * weights[0] + nodes[1] * weights[1] + nodes[2] * weights[2];
    let swerve = own.swerves[sample.arc] + other.swerves[arc];
    Pair {
        point: shapes[on[0]].place(sample),
        velocity,
        nodes: &shapes[on[1]].arcs[arc],
        velocities: &other.velocities[arc],
        bounds: &shapes[on[1]].boxes[arc],
        swerve,
        // With `t <= 1`: `v t + swerve t^2 / 2 <= (v + swerve / 2) t`.
        speed: velocity.norm() + other.speeds[arc] + 0.5 * swerve,
    }
}
