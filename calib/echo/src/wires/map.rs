//! The affine map of a phantom's cross-section (mm) to an image (pixels).

use super::drawing::{Along, Drawing, area};
use super::{WiresError, WiresOptions};

type V2 = [f64; 2];

/// `px = matrix q + shift`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Map {
    matrix: [V2; 2],
    inverse: [V2; 2],
    shift: V2,
}

/// The largest deviation of rows and columns from a right angle, degrees: what centres and a bent beam leave.
const MOST_SKEW_DEG: f64 = 12.0;
/// Three cuts tell the slope where their triangle has this area, mm^2: 20 mm wide and 6 mm high. A centre that is 0.3 mm
/// off moves the depth by up to 0.6 mm, and so the angle by 6 degrees at most.
const LEAST_CUTS: f64 = 60.0;

/// Whether two dots may be the first two wires of three: their distance is that of pixels within bounds. In the image
/// a way is never shorter than seen along the wires, and longer by the tilt.
pub(super) fn is_likely_pair(triple: &[(usize, V2); 3], places: [V2; 2], options: &WiresOptions) -> bool {
    let apart = |a: V2, b: V2| (a[0] - b[0]).hypot(a[1] - b[1]);
    let per_mm = apart(places[0], places[1]) / apart(triple[0].1, triple[1].1).max(1e-9);
    (1.0 / options.pixel_mm[1]..=options.most_stretch / options.pixel_mm[0]).contains(&per_mm)
}

impl Map {
    /// The map of three places to three others; `None` where either three lie on a line.
    pub(super) fn through(from: [V2; 3], to: [V2; 3]) -> Option<Self> {
        let side = |p: [V2; 3], k: usize| [p[k][0] - p[0][0], p[k][1] - p[0][1]];
        let (a, b) = (side(from, 1), side(from, 2));
        let (p, q) = (side(to, 1), side(to, 2));
        let determinant = a[0] * b[1] - a[1] * b[0];
        if determinant.abs() < 1e-9 {
            return None;
        }
        // [p q] = M [a b], so M = [p q] [a b]^-1.
        let row = |k: usize| {
            [
                (p[k] * b[1] - q[k] * a[1]) / determinant,
                (q[k] * a[0] - p[k] * b[0]) / determinant,
            ]
        };
        Self::new([row(0), row(1)], from[0], to[0])
    }

    /// The map with the matrix that takes `from` to `to`.
    fn new(matrix: [V2; 2], from: V2, to: V2) -> Option<Self> {
        let [[a, b], [c, d]] = matrix;
        let determinant = a * d - b * c;
        if !(determinant.abs() > 1e-9 && determinant.is_finite()) {
            return None;
        }
        Some(Self {
            matrix,
            inverse: [[d / determinant, -b / determinant], [-c / determinant, a / determinant]],
            shift: [to[0] - a * from[0] - b * from[1], to[1] - c * from[0] - d * from[1]],
        })
    }

    /// The least squares of three pairs or more, with distances in the image; `None` where they lie on a line.
    pub(super) fn fitted(pairs: &[(V2, V2)]) -> Option<Self> {
        let count = pairs.len() as f64;
        let mean = |of: &dyn Fn(&(V2, V2)) -> V2| {
            let sum = pairs.iter().map(of).fold([0.0; 2], |s, p| [s[0] + p[0], s[1] + p[1]]);
            sum.map(|x| x / count)
        };
        let (from, to) = (mean(&|pair| pair.0), mean(&|pair| pair.1));
        // M = (sum of p q^T) (sum of q q^T)^-1 about the means.
        let (mut cross, mut square) = ([[0.0; 2]; 2], [[0.0; 2]; 2]);
        for (q, p) in pairs {
            let (q, p) = ([q[0] - from[0], q[1] - from[1]], [p[0] - to[0], p[1] - to[1]]);
            for i in 0..2 {
                for j in 0..2 {
                    cross[i][j] += p[i] * q[j];
                    square[i][j] += q[i] * q[j];
                }
            }
        }
        let determinant = square[0][0] * square[1][1] - square[0][1] * square[1][0];
        // In mm^4: places 1 mm apart both ways have 1.
        if determinant.is_nan() || determinant < 1.0 {
            return None;
        }
        let row = |c: V2| {
            [
                (c[0] * square[1][1] - c[1] * square[1][0]) / determinant,
                (c[1] * square[0][0] - c[0] * square[0][1]) / determinant,
            ]
        };
        Self::new([row(cross[0]), row(cross[1])], from, to)
    }

    /// The place seen along the wires (mm) of a pixel.
    pub(super) fn back(&self, px: V2) -> V2 {
        let at = [px[0] - self.shift[0], px[1] - self.shift[1]];
        self.inverse.map(|row| row[0] * at[0] + row[1] * at[1])
    }

    /// What 1 pixel along a row and along a column is, seen along the wires, mm.
    fn steps(&self) -> [V2; 2] {
        [0, 1].map(|a| [self.inverse[0][a], self.inverse[1][a]])
    }

    /// The unit directions of the phantom in which columns and rows run, seen along the wires.
    pub(super) fn runs(&self, drawing: &Drawing) -> [[f64; 3]; 2] {
        self.steps().map(|step| {
            let length = step[0].hypot(step[1]);
            drawing.in_phantom(step.map(|x| x / length))
        })
    }

    /// Whether pixels within the bounds, on a plane tilted within them, can be mapped so, the way round that is known.
    pub(super) fn is_likely(&self, drawing: &Drawing, options: &WiresOptions) -> bool {
        let [[a, b], [c, d]] = self.matrix;
        // Singular values of the matrix: the most and the fewest pixels that 1 mm may have.
        let (sum, half) = (0.5 * (a * a + b * b + c * c + d * d), (a * d - b * c).abs());
        let root = (sum * sum - half * half).max(0.0).sqrt();
        let (most, fewest) = ((sum + root).sqrt(), (sum - root).max(0.0).sqrt());
        let [small, large] = options.pixel_mm;
        let is_sized = fewest >= 1.0 / large && most <= options.most_stretch / small;
        let along = |step: V2, direction: Option<[f64; 3]>| {
            let direction = direction.map(|direction| drawing.across(&direction));
            direction.is_none_or(|d| step[0] * d[0] + step[1] * d[1] > 0.0)
        };
        let [right, down] = self.steps();
        is_sized && most <= options.most_stretch * fewest && along(right, options.right) && along(down, options.down)
    }
}

/// Whether the cuts of wires that run across lie in a plane whose rows and columns are square to one another.
///
/// How far along the parallel wires the image is, is a linear function of the place in it: three cuts tell it, where
/// they are far enough from one line. Fewer, and such on one line, say nothing.
pub(super) fn check_plane(
    map: &Map,
    pairs: &[(usize, usize)],
    places: &[V2],
    drawing: &Drawing,
) -> Result<(), WiresError> {
    let cuts: Vec<(V2, f64)> = pairs
        .iter()
        .filter_map(|(wire, dot)| match &drawing.seen[*wire] {
            Along::Point(_) => None,
            Along::Line { ends, depth } => {
                let at = map.back(places[*dot]);
                let share = share_of(at, ends);
                Some((at, depth[0] + share * (depth[1] - depth[0])))
            }
        })
        .collect();
    let Some(slope) = slope(&cuts) else { return Ok(()) };
    let [right, down] = map
        .steps()
        .map(|step| [step[0], step[1], slope[0] * step[0] + slope[1] * step[1]]);
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let cosine = dot(right, down) / (dot(right, right) * dot(down, down)).sqrt();
    let degrees = cosine.clamp(-1.0, 1.0).acos().to_degrees();
    match (degrees - 90.0).abs() <= MOST_SKEW_DEG {
        true => Ok(()),
        false => Err(WiresError::Plane { degrees }),
    }
}

/// Where along a line, 0 at its first end and 1 at its other, a place is nearest to it.
pub(super) fn share_of(p: V2, [a, b]: &[V2; 2]) -> f64 {
    let way = [b[0] - a[0], b[1] - a[1]];
    let length = way[0] * way[0] + way[1] * way[1];
    (((p[0] - a[0]) * way[0] + (p[1] - a[1]) * way[1]) / length.max(1e-12)).clamp(0.0, 1.0)
}

/// The slope of the depth along the wires by least squares; `None` where the cuts do not hold it.
fn slope(cuts: &[(V2, f64)]) -> Option<V2> {
    let mut widest = 0.0_f64;
    for (k, c) in cuts.iter().enumerate() {
        for (j, b) in cuts[..k].iter().enumerate() {
            for a in &cuts[..j] {
                widest = widest.max(area(a.0, b.0, c.0).abs());
            }
        }
    }
    if widest < LEAST_CUTS {
        return None;
    }
    let count = cuts.len() as f64;
    let mean = |of: &dyn Fn(&(V2, f64)) -> f64| cuts.iter().map(of).sum::<f64>() / count;
    let (x, y, depth) = (mean(&|c| c.0[0]), mean(&|c| c.0[1]), mean(&|c| c.1));
    let mut sums = [0.0; 5];
    for ([a, b], d) in cuts {
        let (a, b, d) = (a - x, b - y, d - depth);
        let terms = [a * a, a * b, b * b, a * d, b * d];
        sums = [0, 1, 2, 3, 4].map(|k| sums[k] + terms[k]);
    }
    let [aa, ab, bb, ad, bd] = sums;
    let determinant = aa * bb - ab * ab;
    Some([(ad * bb - bd * ab) / determinant, (bd * aa - ad * ab) / determinant])
}
