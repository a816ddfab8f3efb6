//! What stands in the way of a line of sight.

use geometry::{Point, Tracker, Vector};

/// All points within a radius of a segment: a cylinder with round ends, or a ball where the ends meet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Capsule {
    from: Point<Tracker>,
    to: Point<Tracker>,
    radius_mm: f64,
}

impl Capsule {
    /// `None` where the radius is not above 0: there is nothing in the way.
    pub(super) fn new(from: Point<Tracker>, to: Point<Tracker>, radius_mm: f64) -> Option<Self> {
        (radius_mm > 0.0).then_some(Self { from, to, radius_mm })
    }

    /// Whether it touches the straight way from `eye` to `emitter`, ends included.
    pub(super) fn hides(&self, eye: Point<Tracker>, emitter: Point<Tracker>) -> bool {
        between_segments([self.from, self.to], [eye, emitter]) < self.radius_mm
    }
}

/// The distance between two segments, mm.
///
/// The nearest points are an end of one with the nearest point of the other, or both inside, where the squared distance
/// `|a + s u - b - t v|^2` is stationary: the least of these five is the distance. Parallel segments need no case of their
/// own: for them an end is among the nearest. Error: some roundings of the coordinates, about 1e-12 mm at 3 m, and the
/// square root of their product with the lengths where the segments meet.
pub(super) fn between_segments(a: [Point<Tracker>; 2], b: [Point<Tracker>; 2]) -> f64 {
    let ends = [
        to_segment(a[0], b),
        to_segment(a[1], b),
        to_segment(b[0], a),
        to_segment(b[1], a),
    ];
    let ends = ends.into_iter().fold(f64::INFINITY, f64::min);
    ends.min(inside(a, b).unwrap_or(f64::INFINITY))
}

/// The distance of the two lines, where they come nearest within both segments.
fn inside(a: [Point<Tracker>; 2], b: [Point<Tracker>; 2]) -> Option<f64> {
    let (u, v, w) = (a[1] - a[0], b[1] - b[0], a[0] - b[0]);
    let (uu, uv, vv, uw, vw) = (u.dot(u), u.dot(v), v.dot(v), u.dot(w), v.dot(w));
    let determinant = uu * vv - uv * uv;
    let (s, t) = ((uv * vw - vv * uw) / determinant, (uu * vw - uv * uw) / determinant);
    let in_both = (0.0..=1.0).contains(&s) && (0.0..=1.0).contains(&t);
    in_both.then(|| (w + u * s - v * t).norm())
}

fn to_segment(p: Point<Tracker>, [from, to]: [Point<Tracker>; 2]) -> f64 {
    let (along, out): (Vector<Tracker>, Vector<Tracker>) = (to - from, p - from);
    let square = along.dot(along);
    let share = if square > 0.0 {
        (out.dot(along) / square).clamp(0.0, 1.0)
    } else {
        0.0
    };
    p.distance(from + along * share)
}
