//! Whether boundaries cross, by exact predicates on fine polygons: nothing here is shared with what is tested.
//!
//! Arcs are sampled, and points rounded to whole numbers of about 1e-12 of the scene, so that the signs of areas are exact in 128 bits. A
//! polygon of `n` chords stands off an arc by its bend over `n^2`: what is nearer than that, or less deep, is looked at again more finely.

/// A closed contour: quadratic arcs of three nodes each, one after the other.
pub(super) type Contour = Vec<[[f64; 2]; 3]>;

/// What two boundaries, or one with itself, are to one another.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Label {
    /// Farther apart than 1e-9 of their size.
    Free,
    /// Nearer and less deep than that, or not told by the finest polygons.
    Touching,
    /// One wholly inside the other.
    Contained,
    /// Boundaries cross, deeper than that.
    Crossing,
}

/// Chords of an arc, from coarse to fine.
const CHORDS: [u32; 4] = [12, 128, 1536, 16384];
/// In sizes of the scene: below it gaps and depths are left open.
const OPEN: f64 = 1e-9;
/// Whole numbers over the size.
const GRID: f64 = 1e12;

type Point = [i64; 2];

/// Twice the area of a triangle.
fn area(a: Point, b: Point, c: Point) -> i128 {
    let wide = |p: Point, q: Point| [i128::from(q[0] - p[0]), i128::from(q[1] - p[1])];
    let (u, v) = (wide(a, b), wide(a, c));
    u[0] * v[1] - u[1] * v[0]
}

/// True where two segments have a point in common.
fn meet([a, b]: [Point; 2], [c, d]: [Point; 2]) -> bool {
    let signs = [area(a, b, c), area(a, b, d), area(c, d, a), area(c, d, b)].map(i128::signum);
    if signs == [0; 4] {
        return (0..2).all(|k| a[k].max(b[k]) >= c[k].min(d[k]) && c[k].max(d[k]) >= a[k].min(b[k]));
    }
    signs[0] * signs[1] <= 0 && signs[2] * signs[3] <= 0
}

/// Distance of a point to a segment, in steps of the grid.
fn distance(p: Point, [a, b]: [Point; 2]) -> f64 {
    let v = |p: Point, q: Point| [(q[0] - p[0]) as f64, (q[1] - p[1]) as f64];
    let (u, w) = (v(a, b), v(a, p));
    let square = u[0] * u[0] + u[1] * u[1];
    let t = if square > 0.0 {
        ((u[0] * w[0] + u[1] * w[1]) / square).clamp(0.0, 1.0)
    } else {
        0.0
    };
    (w[0] - t * u[0]).hypot(w[1] - t * u[1])
}

/// Polygons of some contours.
struct Shape {
    sides: Vec<[Point; 2]>,
    /// How far chords stand off arcs, in steps.
    off: f64,
}

impl Shape {
    fn of(contours: &[Contour], chords: u32, origin: [f64; 2], step: f64) -> Self {
        let (mut sides, mut off) = (Vec::new(), 1.0_f64);
        for [a, b, c] in contours.iter().flatten() {
            let bend = [0, 1].map(|k| 0.5 * (a[k] - 2.0 * b[k] + c[k]));
            let straight = bend[0].hypot(bend[1]) < step;
            let count = if straight { 1 } else { chords };
            if !straight {
                off = off.max(1.0 + bend[0].hypot(bend[1]) / (f64::from(count).powi(2) * step));
            }
            let at = |i: u32| {
                let u = 2.0 * f64::from(i) / f64::from(count) - 1.0;
                let place = |k: usize| 0.5 * u * (u - 1.0) * a[k] + (1.0 - u * u) * b[k] + 0.5 * u * (u + 1.0) * c[k];
                [0, 1].map(|k| ((place(k) - origin[k]) / step).round() as i64)
            };
            sides.extend((0..count).map(|i| [at(i), at(i + 1)]));
        }
        Self { sides, off }
    }

    /// Crossings of a ray to the right, odd inside.
    fn holds(&self, p: Point) -> bool {
        let crosses = |[a, b]: &&[Point; 2]| {
            let (low, high) = if a[1] <= b[1] { (*a, *b) } else { (*b, *a) };
            low[1] <= p[1] && p[1] < high[1] && area(low, high, p) > 0
        };
        self.sides.iter().filter(crosses).count() % 2 == 1
    }

    fn distance(&self, p: Point) -> f64 {
        self.sides.iter().map(|s| distance(p, *s)).fold(f64::INFINITY, f64::min)
    }

    fn middle(&self, side: usize) -> Point {
        self.sides[side][0]
    }
}

/// Sides of two polygons that come within `reach` steps, by sweeping along x.
fn near(one: &Shape, other: &Shape, reach: f64, mut visit: impl FnMut(usize, usize)) {
    let reach = reach.ceil() as i64;
    let span = |s: &[Point; 2], k: usize| [s[0][k].min(s[1][k]), s[0][k].max(s[1][k])];
    let mut order: Vec<(i64, bool, usize)> = Vec::new();
    order.extend((0..one.sides.len()).map(|k| (span(&one.sides[k], 0)[0] - reach, true, k)));
    order.extend((0..other.sides.len()).map(|k| (span(&other.sides[k], 0)[0], false, k)));
    order.sort_unstable();
    let (mut first, mut second): (Vec<usize>, Vec<usize>) = (Vec::new(), Vec::new());
    for (x, own, k) in order {
        let (mine, shape, theirs, opposite) = if own {
            (&mut first, one, &mut second, other)
        } else {
            (&mut second, other, &mut first, one)
        };
        // Ends of the first's sides reach farther; a little more for both does no harm.
        theirs.retain(|j| span(&opposite.sides[*j], 0)[1] + reach >= x);
        let y = span(&shape.sides[k], 1);
        for &j in theirs.iter() {
            let z = span(&opposite.sides[j], 1);
            if y[0] - reach <= z[1] && z[0] - reach <= y[1] {
                if own { visit(k, j) } else { visit(j, k) }
            }
        }
        mine.push(k);
    }
}

/// What is found with polygons of one fineness; `None` where finer ones are needed.
fn told(one: &Shape, other: &Shape, open: f64) -> Option<Label> {
    let room = 2.0 * (one.off + other.off) + open;
    let (mut crossings, mut close) = ([Vec::new(), Vec::new()], false);
    near(one, other, room, |i, j| {
        let (p, q) = (one.sides[i], other.sides[j]);
        if meet(p, q) {
            crossings[0].push(i);
            crossings[1].push(j);
        } else {
            let apart = [
                distance(p[0], q),
                distance(p[1], q),
                distance(q[0], p),
                distance(q[1], p),
            ];
            close |= apart.into_iter().fold(f64::INFINITY, f64::min) <= room;
        }
    });
    if !crossings[0].is_empty() {
        let deep =
            deep_between(one, other, &mut crossings[0], room) || deep_between(other, one, &mut crossings[1], room);
        return deep.then_some(Label::Crossing);
    }
    if close {
        return None;
    }
    let inside = |a: &Shape, b: &Shape| b.holds(a.middle(0));
    Some(if inside(one, other) || inside(other, one) {
        Label::Contained
    } else {
        Label::Free
    })
}

/// True where a vertex about half way between two crossings lies deeper than `room` inside.
fn deep_between(own: &Shape, other: &Shape, crossings: &mut Vec<usize>, room: f64) -> bool {
    crossings.sort_unstable();
    crossings.dedup();
    let (all, count) = (own.sides.len(), crossings.len());
    let tried = (0..count.min(24)).flat_map(|k| {
        let (from, to) = (crossings[k], crossings[(k + 1) % count]);
        let length = if to > from { to - from } else { to + all - from };
        [1, 2, 3, 5, 7].map(|part| (from + (part * length / 8).max(1)) % all)
    });
    let mut tried: Vec<usize> = tried.collect();
    // Of a polygon a side may go through all of the other: its ends are as good.
    tried.dedup();
    tried.into_iter().any(|v| {
        let [a, b] = own.sides[v];
        let middle = [0, 1].map(|k| a[k] + (b[k] - a[k]) / 2);
        [a, middle]
            .into_iter()
            .any(|p| other.holds(p) && other.distance(p) > room)
    }) || halves_of_long(own, other, room, crossings)
}

/// The same of places on the sides that cross: what is thin is crossed between vertices.
fn halves_of_long(own: &Shape, other: &Shape, room: f64, crossings: &[usize]) -> bool {
    crossings.iter().take(24).any(|k| {
        let [a, b] = own.sides[*k];
        (1..200).any(|part| {
            let p = [0, 1].map(|k| a[k] + (b[k] - a[k]) / 200 * part);
            other.holds(p) && other.distance(p) > room
        })
    })
}

/// The size of a scene, the larger side of the box round it, and its corner.
fn extent<'a>(all: impl Iterator<Item = &'a [f64; 2]>) -> ([f64; 2], f64) {
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for p in all {
        for k in 0..2 {
            low[k] = low[k].min(p[k]);
            high[k] = high[k].max(p[k]);
        }
    }
    (low, (high[0] - low[0]).max(high[1] - low[1]))
}

/// What two solids are to one another, each given by its contours.
pub(super) fn label(one: &[Contour], other: &[Contour]) -> Label {
    let points = one.iter().chain(other).flatten().flatten();
    let (origin, size) = extent(points);
    let finest = |chords: u32| {
        let shape = |contours: &[Contour]| Shape::of(contours, chords, origin, size / GRID);
        told(&shape(one), &shape(other), OPEN * GRID)
    };
    CHORDS.into_iter().find_map(finest).unwrap_or(Label::Touching)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(x: f64, y: f64, side: f64) -> Contour {
        let corners = [[x, y], [x + side, y], [x + side, y + side], [x, y + side]];
        (0..4)
            .map(|k| {
                let (a, b) = (corners[k], corners[(k + 1) % 4]);
                [a, [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])], b]
            })
            .collect()
    }

    #[test]
    fn planted_squares_are_told() {
        let at = |x: f64, y: f64, side: f64| label(&[square(0.0, 0.0, 1.0)], &[square(x, y, side)]);
        assert_eq!(at(1.0 + 1e-8, 0.2, 1.0), Label::Free);
        assert_eq!(at(1.0 - 1e-8, 0.2, 1.0), Label::Crossing);
        assert_eq!(at(1.0, 0.2, 1.0), Label::Touching);
        assert_eq!(at(0.25, 0.25, 0.5), Label::Contained);
        assert_eq!(at(-1.0, -1.0, 5.0), Label::Contained);
        // A hole.
        let ring = [square(-2.0, -2.0, 5.0), square(-1.0, -1.0, 3.0)];
        assert_eq!(label(&ring, &[square(0.0, 0.0, 1.0)]), Label::Free);
    }
}
