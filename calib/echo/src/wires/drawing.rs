//! The drawing of a phantom's wires, seen along those that are parallel.

use super::WiresError;

type V3 = [f64; 3];

/// The wires of a phantom, by how an image cuts them.
///
/// Parallel wires are cut in points that are an affine image of where they stand seen along themselves: a plane
/// through parallel lines. A wire that runs across has, by the same map, its cut on the line that it is seen as.
#[derive(Debug, Clone, PartialEq)]
pub struct Drawing {
    pub(super) seen: Vec<Along>,
    /// Two unit vectors across the parallel wires, and the one along them.
    axes: [V3; 3],
}

/// A wire seen along the parallel ones, mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Along {
    /// One of the parallel ones.
    Point([f64; 2]),
    /// One that runs across: its ends, and how far along the parallel ones these lie.
    Line { ends: [[f64; 2]; 2], depth: [f64; 2] },
}

/// Wires whose directions differ by less are parallel: the cosine of 1 degree, 0.7 mm on 40.
const PARALLEL: f64 = 0.999_847_7;
/// Three parallel wires hold a map where their triangle has this area, mm^2: 10 mm wide and 2 mm high.
pub(super) const LEAST_TRIANGLE: f64 = 10.0;

impl Drawing {
    /// A drawing of wires by their ends, mm.
    ///
    /// # Errors
    /// [`WiresError::Count`], [`WiresError::Wire`], [`WiresError::Parallel`].
    pub fn new(wires: &[[V3; 2]]) -> Result<Self, WiresError> {
        if !(4..=32).contains(&wires.len()) {
            return Err(WiresError::Count { found: wires.len() });
        }
        let directions = wires.iter().enumerate().map(|(i, wire)| direction(i, wire));
        let directions: Vec<V3> = directions.collect::<Result<_, _>>()?;
        let is_parallel = |i: usize, j: usize| dot(&directions[i], &directions[j]).abs() >= PARALLEL;
        let family = |i: usize| (0..wires.len()).filter(|j| is_parallel(i, *j)).count();
        // The first of the largest families, so that the same drawing gives the same axes.
        let first = (0..wires.len()).rev().max_by_key(|i| family(*i)).unwrap_or(0);
        let axes = axes(directions[first]);
        let seen: Vec<Along> = wires
            .iter()
            .enumerate()
            .map(|(i, [front, back])| match is_parallel(first, i) {
                true => Along::Point([0, 1].map(|a| 0.5 * (dot(front, &axes[a]) + dot(back, &axes[a])))),
                false => Along::Line {
                    ends: [front, back].map(|end| [dot(end, &axes[0]), dot(end, &axes[1])]),
                    depth: [front, back].map(|end| dot(end, &axes[2])),
                },
            })
            .collect();
        let drawing = Self { seen, axes };
        match drawing.triples().is_empty() {
            false => Ok(drawing),
            true => Err(WiresError::Parallel { found: family(first) }),
        }
    }

    /// A direction of the phantom as it is seen along the parallel wires.
    pub(super) fn across(&self, direction: &V3) -> [f64; 2] {
        [dot(direction, &self.axes[0]), dot(direction, &self.axes[1])]
    }

    /// The direction of the phantom of one that is seen along the parallel wires.
    pub(super) fn in_phantom(&self, seen: [f64; 2]) -> V3 {
        [0, 1, 2].map(|k| seen[0] * self.axes[0][k] + seen[1] * self.axes[1][k])
    }

    /// The parallel wires, with where they are seen.
    pub(super) fn points(&self) -> Vec<(usize, [f64; 2])> {
        let all = self.seen.iter().enumerate();
        all.filter_map(|(i, seen)| match seen {
            Along::Point(at) => Some((i, *at)),
            Along::Line { .. } => None,
        })
        .collect()
    }

    /// Three parallel wires each that hold a map.
    pub(super) fn triples(&self) -> Vec<[(usize, [f64; 2]); 3]> {
        let points = self.points();
        let mut triples = Vec::new();
        for (k, c) in points.iter().enumerate() {
            for (j, b) in points[..k].iter().enumerate() {
                for a in &points[..j] {
                    if area(a.1, b.1, c.1).abs() >= LEAST_TRIANGLE {
                        triples.push([*a, *b, *c]);
                    }
                }
            }
        }
        triples
    }
}

/// The area of a triangle, with its sign.
pub(super) fn area(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))
}

fn dot(a: &V3, b: &V3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn direction(wire: usize, [front, back]: &[V3; 2]) -> Result<V3, WiresError> {
    let way = [0, 1, 2].map(|a| back[a] - front[a]);
    let length = dot(&way, &way).sqrt();
    let is_near = front.iter().all(|x| x.abs() <= 1e5);
    match (1.0..=1000.0).contains(&length) && is_near {
        true => Ok(way.map(|x| x / length)),
        false => Err(WiresError::Wire { wire, found: length }),
    }
}

/// Two unit vectors across a direction, and it.
fn axes(along: V3) -> [V3; 3] {
    // The axis that is least along it gives a well-defined direction across.
    let least = (0..3)
        .min_by(|a, b| along[*a].abs().total_cmp(&along[*b].abs()))
        .unwrap_or(0);
    let mut axis = [0.0; 3];
    axis[least] = 1.0;
    let cross = |a: &V3, b: &V3| {
        [
            a[1] * b[2] - a[2] * b[1],
            a[2] * b[0] - a[0] * b[2],
            a[0] * b[1] - a[1] * b[0],
        ]
    };
    let first = cross(&along, &axis);
    let length = dot(&first, &first).sqrt();
    let first = first.map(|x| x / length);
    [first, cross(&along, &first), along]
}
