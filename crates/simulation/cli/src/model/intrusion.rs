//! Where solids are inside one another, or inside walls: the deepest point of each pair, and the way out.
//!
//! Which pairs overlap or touch is proved for true arcs (`simulation::constraint::intersections`); points of each arc only tell how
//! deep and which way, and where none of them lies inside, the point that the proof found.

use nalgebra::Vector2;
use simulation::constraint::{Intersections, intersections, nearest};
use simulation::solid::{Cursor, Local};

use super::Model;

/// Points of each arc that are looked at.
const PIECES: u32 = 8;
/// Boundaries this near touch, in sizes of the smaller solid: barriers have no room to begin, and to find it would take more digits than
/// the parameters have.
const TOUCH: f64 = 1e-12;

/// What a solid overlaps with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Partner {
    Solid(usize),
    Wall(usize),
}

impl Partner {
    /// Among those of its kind.
    pub(super) fn number(self) -> usize {
        match self {
            Self::Solid(k) | Self::Wall(k) => k,
        }
    }
}

/// The deepest point of a solid in another, or in a wall.
#[derive(Debug, Clone, Copy)]
pub(super) struct Intrusion {
    /// The solid that intrudes.
    pub(super) solid: usize,
    /// Its deepest point.
    pub(super) cursor: Cursor,
    /// What it intrudes into.
    pub(super) into: Partner,
    /// The point of the other solid that is nearest to it.
    pub(super) foot: Option<Cursor>,
    /// The unit vector along which it must move.
    pub(super) way: Vector2<f64>,
    /// How far, 0 where both touch; infinite where the pair can be proved neither apart nor together.
    pub(super) depth: f64,
    /// Where its deepest point is.
    pub(super) at: Vector2<f64>,
}

/// A boundary in one state.
struct Outline {
    /// Points with their cursors, in the order of the arcs.
    points: Vec<(Cursor, Vector2<f64>)>,
    chords: Vec<[Vector2<f64>; 2]>,
    arcs: Vec<[Vector2<f64>; 3]>,
    low: Vector2<f64>,
    high: Vector2<f64>,
}

impl Outline {
    fn of(model: &Model, body: usize, a: &[f64]) -> Self {
        let (solid, part) = (model.system.bodies.solid(body), model.system.bodies.part(body, a));
        let arcs: Vec<_> = solid
            .boundary()
            .arcs
            .iter()
            .map(|arc| arc.map(|n| solid.point(part, n)))
            .collect();
        let place = |arc: usize, k: u32| {
            let cursor = Cursor {
                arc,
                u: f64::from(k) * 2.0 / f64::from(PIECES) - 1.0,
            };
            let at: Vector2<f64> = arcs[arc].iter().zip(cursor.weights()).map(|(p, w)| p * w).sum();
            (cursor, at)
        };
        let each = || (0..arcs.len()).flat_map(|arc| (0..PIECES).map(move |k| (arc, k)));
        let points: Vec<_> = each().map(|(arc, k)| place(arc, k)).collect();
        let chords = each().map(|(arc, k)| [place(arc, k).1, place(arc, k + 1).1]).collect();
        let low = points.iter().fold(Vector2::repeat(f64::INFINITY), |m, p| m.inf(&p.1));
        let high = points
            .iter()
            .fold(Vector2::repeat(f64::NEG_INFINITY), |m, p| m.sup(&p.1));
        Self {
            points,
            chords,
            arcs,
            low,
            high,
        }
    }

    /// True where the boundary winds round the point: crossings of the ray to the right.
    fn holds(&self, point: &Vector2<f64>) -> bool {
        let crosses = |[p, q]: &&[Vector2<f64>; 2]| {
            let spans = (p.y > point.y) != (q.y > point.y);
            spans && point.x < p.x + (q.x - p.x) * (point.y - p.y) / (q.y - p.y)
        };
        self.chords.iter().filter(crosses).count() % 2 == 1
    }

    /// The nearest point of the boundary: `(cursor, from the point to it, distance)`.
    fn foot(&self, point: &Vector2<f64>) -> Option<(Cursor, Vector2<f64>, f64)> {
        let feet = self.arcs.iter().map(|arc| nearest(arc, *point)).enumerate();
        let best = feet.min_by(|a, b| a.1.distance.total_cmp(&b.1.distance));
        best.map(|(arc, foot)| (Cursor { arc, u: foot.u }, -foot.offset, foot.distance))
    }
}

/// All pairs that overlap or touch, each once in each order in which a point of the first lies in the second.
pub(super) fn intrusions(model: &Model, a: &[f64]) -> Vec<Intrusion> {
    let outlines: Vec<Outline> = (0..model.solids.len()).map(|k| Outline::of(model, k, a)).collect();
    let mut found = Vec::new();
    if model.touch.is_some() {
        let proved = proved(model, a);
        let pairs = pairs(&proved);
        for &[i, j] in &pairs {
            found.extend(in_solid(&outlines, i, j));
            found.extend((i != j).then(|| in_solid(&outlines, j, i)).flatten());
        }
        found.sort_by_key(|i| (i.solid, i.into.number()));
        let unseen = pairs.into_iter().filter(|pair| !found.iter().any(|i| i.among(*pair)));
        let unseen: Vec<Intrusion> = unseen.map(|pair| unseen_at(model, a, &proved, pair)).collect();
        found.extend(unseen);
    }
    for (k, wall) in model.walls.iter().enumerate() {
        let each = wall.keeps.iter();
        found.extend(each.filter_map(|solid| in_wall(&outlines[*solid], *solid, k, wall.normal, wall.offset)));
    }
    found
}

/// What is proved of all pairs that keep apart.
fn proved(model: &Model, a: &[f64]) -> Intersections {
    let bodies = &model.system.bodies;
    let size = |k: usize| bodies.solid(k).boundary().extent();
    let tolerance = |i: usize, j: usize| TOUCH * size(i).min(size(j));
    intersections(bodies, a, &|i, j| model.meets(i, j), &tolerance)
}

/// The pairs that overlap, touch, or can be proved neither apart nor together, the lower number first, each once.
fn pairs(proved: &Intersections) -> Vec<[usize; 2]> {
    let overlapping = proved.overlaps.iter().map(|o| [o.first, o.second]);
    let touching = proved.touching.iter().map(|t| [t.first, t.second]);
    let all = overlapping.chain(touching).chain(proved.undecided.iter().copied());
    let mut all: Vec<[usize; 2]> = all.map(|[i, j]| [i.min(j), i.max(j)]).collect();
    all.sort_unstable();
    all.dedup();
    all
}

/// The intrusion of a pair of which no point that stands for an arc lies inside: as the proof found it.
fn unseen_at(model: &Model, a: &[f64], proved: &Intersections, pair: [usize; 2]) -> Intrusion {
    let own = |i: usize, j: usize| [i.min(j), i.max(j)] == pair;
    let overlaps = proved.overlaps.iter().filter(|o| own(o.first, o.second));
    let deepest = overlaps.max_by(|a, b| a.depth.total_cmp(&b.depth));
    let touching = || proved.touching.iter().find(|t| own(t.first, t.second));
    let undecided = proved.undecided.contains(&pair);
    let ([solid, other], cursor, depth) = match (deepest, touching()) {
        (Some(o), _) => ([o.first, o.second], o.at, o.depth),
        (None, Some(t)) => ([t.first, t.second], t.at, 0.0),
        (None, None) => (pair, Cursor { arc: 0, u: -1.0 }, 0.0),
    };
    let local = |body: usize, cursor: &Cursor| -> Local { model.system.bodies.local(body, cursor, a) };
    let at = local(solid, &cursor).position;
    let foot = foot_on(model, a, [solid, other], &cursor, at);
    Intrusion {
        solid,
        cursor,
        into: Partner::Solid(other),
        way: foot.map_or(Vector2::zeros(), |foot| local(other, &foot).normal()),
        foot,
        depth: if undecided { f64::INFINITY } else { depth },
        at,
    }
}

/// The nearest point of the other boundary; of the same one, not on the arc itself or next to it.
fn foot_on(model: &Model, a: &[f64], [solid, other]: [usize; 2], at: &Cursor, point: Vector2<f64>) -> Option<Cursor> {
    let (body, part) = (model.system.bodies.solid(other), model.system.bodies.part(other, a));
    let boundary = body.boundary();
    let beside = |k: usize| k == at.arc || boundary.next[k] == at.arc || boundary.previous[k] == at.arc;
    let outline = body.outline(part).into_iter().enumerate();
    let feet = outline
        .filter(|(k, _)| solid != other || !beside(*k))
        .map(|(arc, nodes)| (arc, nearest(&nodes, point)));
    let best = feet.min_by(|a, b| a.1.distance.total_cmp(&b.1.distance));
    best.map(|(arc, foot)| Cursor { arc, u: foot.u })
}

impl Intrusion {
    /// True where it is one of these two in the other.
    fn among(&self, [i, j]: [usize; 2]) -> bool {
        let Partner::Solid(other) = self.into else { return false };
        (self.solid, other) == (i, j) || (self.solid, other) == (j, i)
    }
}

fn in_solid(outlines: &[Outline], solid: usize, other: usize) -> Option<Intrusion> {
    if solid == other {
        return None;
    }
    let (own, into) = (&outlines[solid], &outlines[other]);
    let apart = (own.low - into.high).max() > 0.0 || (into.low - own.high).max() > 0.0;
    if apart {
        return None;
    }
    let depth = |(cursor, point): &(Cursor, Vector2<f64>)| {
        let near = (point - into.low).min() >= 0.0 && (into.high - point).min() >= 0.0;
        let (foot, way, distance) = if near { into.foot(point)? } else { return None };
        (into.holds(point) || distance == 0.0).then_some((*cursor, *point, foot, way, distance))
    };
    let deepest = own.points.iter().filter_map(depth).max_by(|a, b| a.4.total_cmp(&b.4));
    deepest.map(|(cursor, at, foot, way, depth)| Intrusion {
        solid,
        cursor,
        into: Partner::Solid(other),
        foot: Some(foot),
        way: way.try_normalize(0.0).unwrap_or_default(),
        depth,
        at,
    })
}

fn in_wall(own: &Outline, solid: usize, wall: usize, normal: Vector2<f64>, offset: f64) -> Option<Intrusion> {
    let lowest = own
        .arcs
        .iter()
        .enumerate()
        .map(|(arc, points)| lowest(arc, points, normal));
    let (cursor, height) = lowest.min_by(|a, b| a.1.total_cmp(&b.1))?;
    let depth = offset - height;
    let at: Vector2<f64> = own.arcs[cursor.arc]
        .iter()
        .zip(cursor.weights())
        .map(|(p, w)| p * w)
        .sum();
    // Touching counts: a barrier cannot begin there.
    (depth >= 0.0).then_some(Intrusion {
        solid,
        cursor,
        into: Partner::Wall(wall),
        foot: None,
        way: normal,
        depth,
        at,
    })
}

/// The point of an arc that lies lowest along a direction, and its height: the height is quadratic.
fn lowest(arc: usize, points: &[Vector2<f64>; 3], normal: Vector2<f64>) -> (Cursor, f64) {
    let [low, middle, high] = points.map(|p| p.dot(&normal));
    let (slope, bend) = (0.5 * (high - low), high + low - 2.0 * middle);
    let u = -slope / bend;
    if bend > 0.0 && u.abs() < 1.0 {
        return (Cursor { arc, u }, middle - 0.5 * slope * slope / bend);
    }
    if low <= high {
        (Cursor { arc, u: -1.0 }, low)
    } else {
        (Cursor { arc, u: 1.0 }, high)
    }
}
