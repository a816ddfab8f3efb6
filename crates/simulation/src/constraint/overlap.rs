//! Solids that lie in one another: proved for true arcs, in any state.
//!
//! Every two arcs that may not be in one another are cut until their parts are proved farther apart than the tolerance, or
//! together within it ([`cell`], [`meet`]). What is left of a boundary between such contacts lies wholly inside the other
//! solid or wholly outside of it, and one point of each such run tells by the turns that the other boundary makes round it
//! ([`run`], [`winding`]). So nothing is missed between samples: neither a crossing, nor a solid that lies whole inside
//! another. A solid that keeps out of itself has its own boundary round every point of it by half a turn.

mod bezier;
mod cell;
mod meet;
mod run;
mod winding;

use std::collections::BTreeMap;

use nalgebra::Vector2;

use super::broad_phase::near_arcs;
use super::nearest::nearest;
use super::shape::{Shape, box_distance, boxes_near};
use crate::bodies::Bodies;
use crate::q9::shape::line_slope;
use crate::solid::{Boundary, Cursor};
use bezier::Bezier;
use meet::{Joint, Meeting, meetings};
use run::{Parts, Run, Runs};
use winding::{turns, turns_on};

/// Two solids that overlap, or one that lies in itself.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error(
    "solids {first} and {second} overlap by {depth:.3e} at ({x:.6}, {y:.6}): move one of them away before the start"
)]
pub struct Overlap {
    /// A solid.
    pub first: usize,
    /// Another, or the same.
    pub second: usize,
    /// Where a point of the first lies in the second.
    pub x: f64,
    /// Where a point of the first lies in the second.
    pub y: f64,
    /// How deep that point lies; infinite where the pair could not be proved apart.
    pub depth: f64,
    /// The point on the first's boundary.
    pub at: Cursor,
}

/// Two solids that touch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Touching {
    /// A solid.
    pub first: usize,
    /// Another, or the same.
    pub second: usize,
    /// Where, on the first's boundary.
    pub at: Cursor,
}

/// What boundaries do to one another in a state.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Intersections {
    /// In either order: a piece of the first's boundary lies inside the second, each pair with the deepest point tried.
    pub overlaps: Vec<Overlap>,
    /// Pairs that come as near as the tolerance, once each, whether they overlap elsewhere or not.
    pub touching: Vec<Touching>,
    /// Pairs of which neither could be proved: a number that is not finite, or too much contact.
    pub undecided: Vec<[usize; 2]>,
}

/// In sizes of the largest solid: how deep [`overlapping`] and [`deepest`] take for contact. Exact contact leaves 1e-13.
const CONTACT_EXTENTS: f64 = 5e-13;
/// Points tried of each part of a run for the deepest.
const PLACES_PER_PART: u32 = 8;
/// Turns are whole up to rounding: nearer than this to a whole number.
const WHOLE_TURN_TOLERANCE: f64 = 0.25;

/// Pairs of different solids that overlap deeper than 1e-12 of the largest solid, in either order; from half of that on they may.
pub fn overlapping(bodies: &Bodies, a: &[f64]) -> Vec<Overlap> {
    overlaps(bodies, a, &|i, j| i != j)
}

/// The deepest overlap of the pairs of solids that `meets` names, of solids with themselves too; what counts as one is as in
/// [`overlapping`].
pub fn deepest(bodies: &Bodies, a: &[f64], meets: &dyn Fn(usize, usize) -> bool) -> Option<Overlap> {
    let all = overlaps(bodies, a, meets).into_iter();
    all.max_by(|a, b| a.depth.total_cmp(&b.depth))
}

/// With what is undecided as infinitely deep.
fn overlaps(bodies: &Bodies, a: &[f64], meets: &dyn Fn(usize, usize) -> bool) -> Vec<Overlap> {
    let tolerance = CONTACT_EXTENTS * bodies.extent();
    let found = intersections(bodies, a, meets, &|_, _| tolerance);
    let undecided = found.undecided.into_iter().map(|[first, second]| Overlap {
        first,
        second,
        x: f64::NAN,
        y: f64::NAN,
        depth: f64::INFINITY,
        at: Cursor { arc: 0, u: -1.0 },
    });
    found.overlaps.into_iter().chain(undecided).collect()
}

/// What the boundaries of all pairs that `meets` names do to one another, `meets(i, i)` for a solid with itself.
///
/// `tolerance` of a pair is a length, raised to the rounding of the arcs (64 times 2^-52 of their size). What is nearer counts as contact,
/// up to twice the tolerance it may; what is found inside another lies deeper there than the tolerance over 1.12.
pub fn intersections(
    bodies: &Bodies,
    a: &[f64],
    meets: &dyn Fn(usize, usize) -> bool,
    tolerance: &dyn Fn(usize, usize) -> f64,
) -> Intersections {
    let shapes: Vec<Shape> = (0..bodies.len()).map(|k| Shape::of(bodies, k, a)).collect();
    let mut search = Search {
        bodies,
        shapes: &shapes,
        contacts: BTreeMap::new(),
        found: Intersections::default(),
    };
    let count = shapes.len();
    let pairs = (0..count).flat_map(|i| (i..count).map(move |j| [i, j]));
    let pairs: Vec<[usize; 2]> = pairs.filter(|[i, j]| meets(*i, *j) || meets(*j, *i)).collect();
    // One search of near arcs for all pairs, by the widest tolerance; each pair is judged by its own.
    let widest = pairs.iter().map(|[i, j]| tolerance(*i, *j)).fold(0.0, f64::max);
    search.meet(&pairs, widest, tolerance);
    for pair in pairs {
        // Boundaries that do not cross may still lie one inside the other.
        let near = boxes_near(&shapes[pair[0]].bounds, &shapes[pair[1]].bounds, 0.0);
        if near && !search.found.undecided.contains(&pair) {
            search.look_inside(pair);
        }
    }
    search.found
}

/// What is known of a state so far.
struct Search<'a> {
    bodies: &'a Bodies,
    shapes: &'a [Shape],
    /// Of the first of two solids: the parts of its arcs that touch the second.
    contacts: BTreeMap<[usize; 2], Parts>,
    found: Intersections,
}

impl Search<'_> {
    /// Finds the contacts of all pairs.
    fn meet(&mut self, pairs: &[[usize; 2]], widest: f64, tolerance: &dyn Fn(usize, usize) -> f64) {
        // A number that is not finite compares as false everywhere: nothing would be found.
        let bad = |k: usize| {
            !self.shapes[k]
                .arcs
                .iter()
                .flatten()
                .all(|x| x.iter().all(|x| x.is_finite()))
        };
        let bad: Vec<bool> = (0..self.shapes.len()).map(bad).collect();
        let undecided = pairs.iter().filter(|[i, j]| bad[*i] || bad[*j]);
        self.found.undecided.extend(undecided);
        for mut places in near_arcs(self.shapes, widest) {
            places.sort_unstable();
            let [[first, arc], [second, other]] = places.map(|place| place.map(|k| k as usize));
            let pair = [first, second];
            // Pairs were made in ascending order, and so is this one.
            if pairs.binary_search(&pair).is_err() || self.found.undecided.contains(&pair) {
                continue;
            }
            let joint = self.joint(pair, [arc, other]);
            let nodes = [&self.shapes[first].arcs[arc], &self.shapes[second].arcs[other]];
            match meetings(nodes, joint, tolerance(first, second)) {
                Some(all) => all.iter().for_each(|m| self.take(pair, [arc, other], joint, m)),
                None => self.found.undecided.push(pair),
            }
        }
    }

    /// The nodes that two arcs of one solid have in common; arcs of two have none.
    fn joint(&self, [first, second]: [usize; 2], [arc, other]: [usize; 2]) -> Joint {
        if first != second {
            return Joint::default();
        }
        let arcs = &self.bodies.solid(first).boundary().arcs;
        Joint {
            after: arcs[arc][2] == arcs[other][0],
            before: arcs[other][2] == arcs[arc][0],
        }
    }

    /// Takes a contact down for both solids.
    fn take(&mut self, [first, second]: [usize; 2], [arc, other]: [usize; 2], joint: Joint, meeting: &Meeting) {
        let [one, two] = meeting;
        let mut note = |pair: [usize; 2], arc: usize, part: &[f64; 2]| {
            let parts = self.contacts.entry(pair).or_default();
            parts.entry(arc).or_default().push(*part);
        };
        note([first, second], arc, one);
        note([second, first], other, two);
        let touching = &mut self.found.touching;
        let known = touching.iter().any(|t| t.first == first && t.second == second);
        // Arcs with a node in common touch there by right.
        if !known && joint == Joint::default() {
            let u = one[0] + one[1] - 1.0;
            touching.push(Touching {
                first,
                second,
                at: Cursor { arc, u },
            });
        }
    }

    fn boundary(&self, body: usize) -> &Boundary {
        self.bodies.solid(body).boundary()
    }

    /// Tells on which side of one another the runs of two solids lie between their contacts.
    fn look_inside(&mut self, [first, second]: [usize; 2]) {
        let orders = [[first, second], [second, first]];
        // With itself both orders are the same question.
        let orders = if first == second { &orders[..1] } else { &orders[..] };
        let mut whole = None;
        for &pair in orders {
            let runs = Runs::of(self.boundary(pair[0]), self.contacts.get(&pair));
            let inside = runs.free.iter().filter(|run| self.inside(pair, run));
            let deepest = inside
                .map(|run| self.deepest_of(pair, run))
                .max_by(|a, b| a.depth.total_cmp(&b.depth));
            self.found.overlaps.extend(deepest);
            if whole.is_none() {
                whole = runs.covered.first().map(|arcs| (pair, arcs.clone()));
            }
        }
        let overlap = self
            .found
            .overlaps
            .iter()
            .any(|o| orders.contains(&[o.first, o.second]));
        if let (Some((pair, arcs)), false) = (whole, overlap) {
            self.coincident([first, second], pair, &arcs);
        }
    }

    /// True where a run of the first lies inside the second.
    fn inside(&self, [first, second]: [usize; 2], run: &Run) -> bool {
        let Some((arc, [from, to])) = run
            .iter()
            // The middle of the longest part is farthest from the contacts at the run's ends.
            .max_by(|a, b| (a.1[1] - a.1[0]).total_cmp(&(b.1[1] - b.1[0])))
        else {
            return false;
        };
        let (shape, s) = (&self.shapes[first], 0.5 * (from + to));
        if first == second {
            return (turns_on(shape, *arc, s) - 0.5).abs() > WHOLE_TURN_TOLERANCE;
        }
        let point = Bezier::of(&shape.arcs[*arc], Vector2::zeros()).at(s);
        let other = &self.shapes[second];
        // The box first: turns ask every arc. Without a sign, as a boundary turned inside out winds the other way
        // round.
        box_distance(&other.bounds, &point) == 0.0 && turns(other, point).abs() > WHOLE_TURN_TOLERANCE
    }

    /// The deepest of some points of a run that lies inside.
    fn deepest_of(&self, [first, second]: [usize; 2], run: &Run) -> Overlap {
        let mut deepest: Option<Overlap> = None;
        for (arc, [from, to]) in run {
            for k in 0..=PLACES_PER_PART {
                let s = from + (to - from) * f64::from(k) / f64::from(PLACES_PER_PART);
                let at = Cursor {
                    arc: *arc,
                    u: 2.0 * s - 1.0,
                };
                let point = self.shapes[first].place(&at);
                let depth = self.distance([first, second], *arc, point);
                if deepest.is_none_or(|d| d.depth < depth) {
                    let [x, y] = (point + self.bodies.origin()).into();
                    deepest = Some(Overlap {
                        first,
                        second,
                        x,
                        y,
                        depth,
                        at,
                    });
                }
            }
        }
        // A run has a part.
        deepest.unwrap_or(Overlap {
            first,
            second,
            x: f64::NAN,
            y: f64::NAN,
            depth: f64::INFINITY,
            at: Cursor { arc: 0, u: -1.0 },
        })
    }

    /// The distance of a point of an arc of the first to the second's boundary; of itself, to all arcs but its own and those next to it.
    fn distance(&self, [first, second]: [usize; 2], arc: usize, point: Vector2<f64>) -> f64 {
        let boundary = self.boundary(first);
        // At its own arcs and the two that share nodes with it the distance would be next to nothing anywhere near a
        // node.
        let own = |k: usize| first == second && (k == arc || boundary.next[arc] == k || boundary.previous[arc] == k);
        let others = self.shapes[second].arcs.iter().enumerate().filter(|(k, _)| !own(*k));
        let distances = others.map(|(_, nodes)| nearest(nodes, point).distance);
        distances.fold(f64::INFINITY, f64::min)
    }

    /// Two boundaries of which one has a contour in contact all round, and that do not cross: where both have the same normals there, one
    /// solid lies on the other; where opposite ones, it fills a hole or lies in one.
    fn coincident(&mut self, key: [usize; 2], [first, second]: [usize; 2], arcs: &[usize]) {
        let middle = |arc: usize| Bezier::of(&self.shapes[first].arcs[arc], Vector2::zeros());
        let aligned = |arc: &usize| {
            let (point, slope) = (middle(*arc).at(0.5), middle(*arc).slope(0.5));
            let feet = self.shapes[second]
                .arcs
                .iter()
                .map(|nodes| (nodes, nearest(nodes, point)));
            let foot = feet.min_by(|a, b| a.1.distance.total_cmp(&b.1.distance));
            foot.map_or(0.0, |(nodes, foot)| {
                let other: Vector2<f64> = nodes.iter().zip(line_slope(foot.u)).map(|(p, s)| p * s).sum();
                let unit = |v: Vector2<f64>| v.try_normalize(0.0).unwrap_or_default();
                unit(slope).dot(&unit(other))
            })
        };
        let cosines: Vec<f64> = arcs.iter().map(aligned).collect();
        // Opposite normals all round: what fills a hole touches its wall and lies in nothing.
        if first != second && cosines.iter().all(|c| *c < -0.5) {
            return;
        }
        // Neither the same way nor opposite everywhere: no proof, and none is claimed.
        if first == second || !cosines.iter().all(|c| *c > 0.5) {
            self.found.undecided.push(key);
            return;
        }
        let bounds = self.shapes[first].bounds;
        let point = middle(arcs[0]).at(0.5) + self.bodies.origin();
        self.found.overlaps.push(Overlap {
            first,
            second,
            x: point.x,
            y: point.y,
            depth: (bounds[1] - bounds[0]).min(),
            at: Cursor { arc: arcs[0], u: 0.0 },
        });
    }
}
