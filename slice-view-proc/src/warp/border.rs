//! Where cubes meet: how far the slope across their common face jumps, which is what a place drawn by the wrong side's map is off by.

use std::collections::BTreeMap;

use super::placed::Placed;

/// None beside a face.
const NONE: u32 = u32::MAX;
/// A neighbour is larger by this factor at most; beyond it is not looked for.
const MOST_RATIO: i32 = 8;
/// A function that is quadratic along two axes is at most so many times the largest of its nine values: 1.25 an axis.
pub(super) const FACE_BEYOND: f64 = 1.5625;

/// The cubes beside a cube's faces, by axis the lower and the upper one: of its size or larger.
pub(super) type Beside = [[u32; 2]; 3];

/// Finds what lies beside all cubes; none where their sizes are too far apart.
pub(super) fn neighbours(cubes: &[Placed]) -> Option<Vec<Beside>> {
    let spans: std::collections::BTreeSet<i32> = cubes.iter().map(|cube| cube.span).collect();
    let (least, most) = (spans.first().copied()?, spans.last().copied()?);
    if most > MOST_RATIO * least {
        return None;
    }
    let numbers: BTreeMap<([i32; 3], i32), u32> = (0..)
        .zip(cubes)
        .map(|(k, cube)| ((cube.corner, cube.span), k))
        .collect();
    let find = |cube: &Placed, axis: usize, upper: bool| {
        for span in spans.range(cube.span..) {
            let along = cube.corner[axis] + if upper { cube.span } else { -span };
            for p in (0..=span - cube.span).step_by(least as usize) {
                for q in (0..=span - cube.span).step_by(least as usize) {
                    let mut corner = cube.corner;
                    corner[axis] = along;
                    corner[(axis + 1) % 3] -= p;
                    corner[(axis + 2) % 3] -= q;
                    if let Some(number) = numbers.get(&(corner, *span)) {
                        return *number;
                    }
                }
            }
        }
        NONE
    };
    let of = |cube: &Placed| [0, 1, 2].map(|axis| [find(cube, axis, false), find(cube, axis, true)]);
    Some(cubes.iter().map(of).collect())
}

/// The largest jump of the slope across a face of a cube, mm now a mm at rest, by the nodes' places; 0 where nothing lies beside it.
/// `wanted` says of which neighbours, by number, axis and side.
pub(super) fn jump(
    cubes: &[Placed],
    beside: &Beside,
    number: usize,
    places: &[[f32; 3]],
    wanted: impl Fn(usize, usize, bool) -> bool,
) -> f64 {
    let cube = &cubes[number];
    let mut most = 0.0_f64;
    for (axis, sides) in beside.iter().enumerate() {
        for (upper, neighbour) in [false, true].into_iter().zip(sides) {
            let Some(other) = cubes
                .get(*neighbour as usize)
                .filter(|_| wanted(*neighbour as usize, axis, upper))
            else {
                continue;
            };
            let (own, there) = (slopes(cube, places, axis, upper), slopes(other, places, axis, !upper));
            let larger = if other.span == cube.span {
                there
            } else {
                within(&there, cube, other, axis)
            };
            for (a, b) in own.iter().zip(&larger) {
                let off = [0, 1, 2].map(|k| a[k] / f64::from(cube.span) - b[k] / f64::from(other.span));
                most = most.max(off[0] * off[0] + off[1] * off[1] + off[2] * off[2]);
            }
        }
    }
    FACE_BEYOND * most.sqrt()
}

/// The slopes along an axis, by the cube's side, at the nine nodes of its lower or upper face.
#[inline]
fn slopes(cube: &Placed, places: &[[f32; 3]], axis: usize, upper: bool) -> [[f64; 3]; 9] {
    let steps = [1, 3, 9];
    let (along, one, other) = (steps[axis], steps[(axis + 1) % 3], steps[(axis + 2) % 3]);
    let weights = if upper { [1.0, -4.0, 3.0] } else { [-3.0, 4.0, -1.0] };
    let mut found = [[0.0; 3]; 9];
    for (k, slope) in found.iter_mut().enumerate() {
        let first = one * (k % 3) + other * (k / 3);
        for (j, weight) in weights.into_iter().enumerate() {
            let place = places[cube.nodes[first + along * j] as usize];
            for a in 0..3 {
                slope[a] += weight * f64::from(place[a]);
            }
        }
    }
    found
}

/// A larger cube's values at the nine nodes of a smaller one's face.
fn within(values: &[[f64; 3]; 9], cube: &Placed, larger: &Placed, axis: usize) -> [[f64; 3]; 9] {
    let [one, other] = [(axis + 1) % 3, (axis + 2) % 3].map(|axis| {
        let from = f64::from(cube.corner[axis] - larger.corner[axis]);
        let part = |k: usize| (from + f64::from(cube.span) * k as f64 / 2.0) / f64::from(larger.span);
        [0, 1, 2].map(|k| super::quadratic::weights(part(k)))
    });
    std::array::from_fn(|k| {
        let (u, v) = (one[k % 3], other[k / 3]);
        std::array::from_fn(|a| (0..9).map(|j| u[j % 3] * v[j / 3] * values[j][a]).sum())
    })
}

/// Whether the plane may pass through a face, by the distances of its nodes.
#[inline]
pub(super) fn is_cut(cube: &Placed, behind: &[f64], axis: usize, upper: bool) -> bool {
    let steps = [1, 3, 9];
    let first = if upper { 2 * steps[axis] } else { 0 };
    let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
    for k in 0..9 {
        let node = first + steps[(axis + 1) % 3] * (k % 3) + steps[(axis + 2) % 3] * (k / 3);
        let own = behind[cube.nodes[node] as usize];
        (least, most) = (least.min(own), most.max(own));
    }
    // Half the width times what such a function goes beyond its values.
    let beyond = 0.5 * (FACE_BEYOND - 1.0) * (most - least);
    least - beyond <= 0.0 && most + beyond >= 0.0
}
