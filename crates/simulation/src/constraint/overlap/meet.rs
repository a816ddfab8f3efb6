//! Where two arcs come as near as the tolerance: both are cut in halves until every two parts are proved apart, together, or are
//! smaller than it.

use nalgebra::Vector2;

use super::bezier::Bezier;
use super::cell::{Lie, lie};

/// Pairs of parts looked at before two arcs are given up.
const MOST_CELLS: usize = 200_000;
/// Arcs that leave a node on either side of a line by this sine meet there only.
const LEAVES_SINE: f64 = 0.01;

/// The parts of two arcs that are near one another: from and to on the first, from and to on the second, parameters from 0 to 1.
pub(super) type Meeting = [[f64; 2]; 2];

/// Which ends two arcs of one boundary have in common.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Joint {
    /// The second begins where the first ends.
    pub(super) after: bool,
    /// The first begins where the second ends.
    pub(super) before: bool,
}

impl Joint {
    /// True where these parts of both lead from the node in common to different sides, so that they meet there only.
    fn parts(self, [p, q]: &Meeting, first: &Bezier, second: &Bezier) -> bool {
        let after = self.after && p[1] == 1.0 && q[0] == 0.0;
        let before = self.before && p[0] == 0.0 && q[1] == 1.0;
        // Neither end in common here, or both, as of two arcs that close a contour: no one line tells.
        if after == before {
            return false;
        }
        let ([a, b, c], [d, e, f]) = (first.0, second.0);
        let (one, other) = if after {
            ([a - c, b - c], [f - d, e - d])
        } else {
            ([c - a, b - a], [d - f, e - f])
        };
        // Across the line between them: from the middle of the second's directions to that of the first's.
        let unit = |v: Vector2<f64>| v.try_normalize(0.0).unwrap_or_default();
        let middle = |v: &[Vector2<f64>; 2]| unit(v[0]) + unit(v[1]);
        let across = unit(middle(&one) - middle(&other));
        let leaves = |v: &Vector2<f64>, way: Vector2<f64>| way.dot(v) > LEAVES_SINE * v.norm();
        one.iter().all(|v| leaves(v, across)) && other.iter().all(|v| leaves(v, -across))
    }
}

/// All parts of two arcs as near as the tolerance, up to twice; what is not in them is farther apart than the tolerance over 1.12.
/// `None` where that takes too long, or a number is not finite.
pub(super) fn meetings(nodes: [&[Vector2<f64>; 3]; 2], joint: Joint, tolerance: f64) -> Option<Vec<Meeting>> {
    // About a node of them: rounding is then that of the arcs' size, not of where they lie.
    let origin = nodes[1][0];
    let [first, second] = nodes.map(|nodes| Bezier::of(nodes, origin));
    let size = first.0.iter().chain(&second.0).map(|p| p.amax()).fold(0.0, f64::max);
    let finite = first.0.iter().chain(&second.0).all(|p| p.iter().all(|x| x.is_finite()));
    if !finite {
        return None;
    }
    // Rounding of the parts' own control points.
    let tolerance = tolerance.max(64.0 * f64::EPSILON * size).max(f64::MIN_POSITIVE);
    let (mut found, mut open) = (Vec::new(), vec![[[0.0, 1.0]; 2]]);
    for _ in 0..MOST_CELLS {
        let Some(cell) = open.pop() else {
            return Some(found);
        };
        let (a, b) = (first.part(cell[0]), second.part(cell[1]));
        if joint.parts(&cell, &a, &b) {
            continue;
        }
        match lie(&a, &b, tolerance) {
            Lie::Apart => {}
            Lie::Together(part) => {
                let [from, to] = cell[1];
                found.push([cell[0], part.map(|t| from + (to - from) * t)]);
            }
            // Only the first is cut where it leaves the second's ends: of two that are cut alike no part ever lies beside one of the other.
            Lie::Beside => open.extend(halves(&cell, [a.size(), 0.0], 0.0).into_iter().flatten()),
            Lie::Open => match halves(&cell, [a.size(), b.size()], tolerance) {
                Some(halves) => open.extend(halves),
                None => found.push(cell),
            },
        }
    }
    None
}

/// The halves of the larger part; `None` where both are below the tolerance.
fn halves(cell: &Meeting, sizes: [f64; 2], tolerance: f64) -> Option<[Meeting; 2]> {
    if sizes[0].max(sizes[1]) <= 0.5 * tolerance {
        return None;
    }
    let larger = usize::from(sizes[1] > sizes[0]);
    let [from, to] = cell[larger];
    let middle = 0.5 * (from + to);
    // No number lies between: the part is as short as parameters can tell.
    if middle <= from || middle >= to {
        return None;
    }
    let mut both = [*cell; 2];
    (both[0][larger], both[1][larger]) = ([from, middle], [middle, to]);
    Some(both)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn arc(points: [(f64, f64); 3]) -> [Vector2<f64>; 3] {
        points.map(|(x, y)| Vector2::new(x, y))
    }

    #[test]
    fn a_crossing_is_found_to_the_tolerance() {
        let (one, other) = (
            arc([(-1.0, 0.0), (0.0, 0.2), (1.0, 0.0)]),
            arc([(0.3, -1.0), (0.31, 0.0), (0.3, 1.0)]),
        );
        let found = meetings([&one, &other], Joint::default(), 1e-13).unwrap();
        assert!(!found.is_empty());
        for [[from, to], [start, end]] in found {
            // Where 0.2 (1 - x^2) meets x = 0.3 + 0.01 (1 - y^2).
            let (s, t) = (from + to - 1.0, start + end - 1.0);
            let place = Vector2::new(s, 0.2 * (1.0 - s * s));
            assert!((place.x - 0.3 - 0.01 * (1.0 - t * t)).abs() < 1e-12 && (place.y - t).abs() < 1e-12);
            assert!(to - from < 1e-12 && end - start < 1e-12);
        }
    }

    #[test]
    fn arcs_as_near_as_rounding_are_told_in_few_cells() {
        // A parabola over itself, moved along it: tangent at one point, a hair above and below.
        for gap in [1e-11, -1e-11, 1e-6, 0.0] {
            let height = |x: f64, by: f64| 0.1 * (x - by) * (x - by) + 0.02 * by;
            let one = arc([-1.0, 0.0, 1.0].map(|x| (x, height(x, 0.0))));
            let other = arc([-0.5, 0.2, 0.9].map(|x| (x, height(x, 0.0) - gap)));
            let found = meetings([&one, &other], Joint::default(), 1e-13).unwrap();
            assert_eq!(found.is_empty(), gap != 0.0, "{gap}");
            let far = other.map(|p| p + Vector2::new(0.0, 10.0));
            assert!(meetings([&one, &far], Joint::default(), 1e-13).unwrap().is_empty());
        }
        let bad = arc([(0.0, 0.0), (f64::NAN, 0.0), (1.0, 0.0)]);
        assert_eq!(meetings([&bad, &bad], Joint::default(), 1e-13), None);
    }

    #[test]
    fn neighbours_meet_at_their_node_only() {
        let after = Joint {
            after: true,
            before: false,
        };
        let one = arc([(0.0, 0.0), (0.5, 0.1), (1.0, 0.0)]);
        for angle in [0.0, 1.0, 2.0, 2.7, -3.0] {
            let (sin, cos) = f64::sin_cos(angle);
            let other = arc([0.0, 0.5, 1.0].map(|t| (1.0 + t * cos, t * sin)));
            assert!(meetings([&one, &other], after, 1e-12).unwrap().is_empty(), "{angle}");
        }
        // The second turns back through the first.
        let other = arc([(1.0, 0.0), (0.7, 0.2), (0.5, -0.3)]);
        let found = meetings([&one, &other], after, 1e-12).unwrap();
        assert!(!found.is_empty() && found.iter().all(|m| m[0][1] < 0.9), "{found:?}");
    }
}
