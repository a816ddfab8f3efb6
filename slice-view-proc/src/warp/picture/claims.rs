//! Pixels that the pieces of an organ claim twice, or turned inside out: what the quadratic maps themselves say of them.
//!
//! A piece that the organ's surface passes through reaches beyond it. Nothing keeps a map from folding there, and it does so beside a
//! tube that presses: that is no tissue, and none is there twice. So all places of the organ are found that a map takes to such a pixel: by
//! halving cubes as long as the pixel may lie in them and some of the organ may, then by Newton's method.

use crate::warp::cut::inverse;
use crate::warp::image::Organ;
use crate::warp::kinds::eight;
use crate::warp::placed::{Held, Placed};
use crate::warp::quadratic::{at, bernstein, halves, weights};
use crate::warp::raster::{Canvas, FOLDED};
use crate::warp::region::Region;
use crate::warp::view::View;

/// Pixels that are looked at, at most, as each takes some 40 us: a fold of more is told as it was drawn.
const MOST: usize = 256;
/// A cube is halved so often, as parts of a 16th are hardly bent; and so often where a fold begins within such a part.
const HALVED: u32 = 4;
const MOST_HALVED: u32 = 8;
/// Newton's method: steps at most, and how near to the pixel is enough, pixels and mm.
const STEPS: usize = 20;
const NEAR: f64 = 1e-7;
/// Of a cube's side: so far outside a place is still its own, as rounding leaves it. Its neighbour finds the same.
const BESIDE: f64 = 1e-6;
/// Places at rest that are nearer are one, mm: found from two cubes, or from two parts of one. Newton's method leaves them 1e-7 of a pixel
/// apart, times the stretch; of a fold's two places one is inside out.
const SAME_MM: f64 = 1e-3;
/// Of nodes' places: so much further than their range a quadratic map may reach, of half of it.
const BEYOND: f64 = 1.0;

/// What of the organ is at a pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Tissue {
    Nothing,
    /// At this place at rest, in the cube of this number.
    Once([f64; 3], usize),
    /// Or turned inside out, or not known.
    Twice,
}

impl Tissue {
    /// A place that a cube's map takes here. Two cubes find the same one only where they meet.
    fn add(&mut self, place: [f64; 3], cube: usize, is_at_face: bool) {
        let is_near = |own: &[f64; 3]| (0..3).all(|a| (own[a] - place[a]).abs() < SAME_MM);
        match self {
            Self::Nothing => *self = Self::Once(place, cube),
            Self::Once(own, of) if is_near(own) && (*of == cube || is_at_face) => {}
            Self::Once(..) | Self::Twice => *self = Self::Twice,
        }
    }
}

/// Looks at what was drawn of an organ, and leaves its pixels covered once where they are.
pub(super) fn settle(view: &View, organ: &Organ<'_>, canvas: &mut Canvas) {
    let pixels = doubtful(canvas);
    if pixels.is_empty() || pixels.len() > MOST {
        return;
    }
    let width = canvas.size[0];
    let mut found: Vec<([f64; 3], Tissue)> = pixels
        .iter()
        .map(|at| ([(at % width) as f64, (at / width) as f64, 0.0], Tissue::Nothing))
        .collect();
    for (number, cube) in organ.shape.cubes.iter().enumerate() {
        let nodes = cube.nodes.map(|node| view.seen(organ.places[node as usize]));
        if cube.uniform != Some(Held::Nothing) && found.iter().any(|(pixel, _)| may_reach(&nodes, pixel)) {
            let search = Search::of((number, cube), organ, &nodes);
            for (pixel, tissue) in &mut found {
                search.look(&search.whole, [0.0; 3], 0, pixel, tissue);
            }
        }
    }
    for (at, (_, tissue)) in pixels.into_iter().zip(found) {
        canvas.marks[at] = 0;
        canvas.covered[at] = match tissue {
            Tissue::Nothing => 0,
            Tissue::Once(place, _) => {
                canvas.rest[at] = place.map(|x| x as f32);
                1
            }
            Tissue::Twice => 2,
        };
    }
}

/// Pixels that are not covered once or not at all; some more than [`MOST`] where there are so many.
#[inline(always)]
fn doubtful(canvas: &Canvas) -> Vec<usize> {
    let mut found = Vec::new();
    for (row, [low, high]) in canvas.touched.iter().copied().enumerate() {
        let first = row * canvas.size[0] + low.min(high);
        let pixels = first..row * canvas.size[0] + high;
        let (counts, rest) = canvas.covered[pixels.clone()].as_chunks::<8>();
        let (marks, _) = canvas.marks[pixels].as_chunks::<8>();
        for (k, (counts, marks)) in counts.iter().zip(marks).enumerate() {
            // Nearly always all eight are in order.
            let [counts, marks] = [*counts, *marks].map(u64::from_ne_bytes);
            if counts & eight(!1) != 0 || marks & eight(FOLDED) != 0 {
                found.extend((first + 8 * k..first + 8 * k + 8).filter(|at| is_doubtful(canvas, *at)));
            }
        }
        let last = first + 8 * counts.len();
        found.extend((last..last + rest.len()).filter(|at| is_doubtful(canvas, *at)));
        if found.len() > MOST {
            break;
        }
    }
    found
}

fn is_doubtful(canvas: &Canvas, at: usize) -> bool {
    canvas.covered[at] > 1 || canvas.marks[at] & FOLDED != 0
}

/// Whether a map with these nodes may take some place to a pixel.
fn may_reach(nodes: &[[f64; 3]; 27], pixel: &[f64; 3]) -> bool {
    (0..3).all(|a| {
        let range = nodes.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |range, node| {
            [range[0].min(node[a]), range[1].max(node[a])]
        });
        let beyond = BEYOND * 0.5 * (range[1] - range[0]);
        (range[0] - beyond..=range[1] + beyond).contains(&pixel[a])
    })
}

/// Bernstein's coefficients of a map: columns, rows, mm behind the plane.
type Coefficients = [[f64; 27]; 3];

/// The places of one cube. Parameters run from 0 to 1 along each axis.
struct Search<'a> {
    number: usize,
    nodes: &'a [[f64; 3]; 27],
    whole: Coefficients,
    region: &'a Region,
    low: [f64; 3],
    side: f64,
}

impl<'a> Search<'a> {
    fn of((number, cube): (usize, &Placed), organ: &Organ<'a>, nodes: &'a [[f64; 3]; 27]) -> Self {
        let shape = organ.shape;
        Self {
            number,
            nodes,
            whole: [0, 1, 2].map(|a| bernstein(&nodes.map(|node| node[a]))),
            region: &shape.region,
            low: shape.at(cube.corner),
            side: shape.piece_mm * f64::from(cube.span),
        }
    }

    fn place(&self, part: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|a| self.low[a] + self.side * part[a])
    }

    /// Looks in the part of the cube from `corner` on, halved so often, whose map has these coefficients.
    fn look(&self, map: &Coefficients, corner: [f64; 3], halved: u32, pixel: &[f64; 3], tissue: &mut Tissue) {
        if *tissue == Tissue::Twice || !holds(map, pixel) {
            return;
        }
        let half = 0.5 / f64::from(1 << halved);
        let middle = corner.map(|x| x + half);
        // The nearest of the organ lies beyond the part's corners.
        let (is_inside, clear) = self.region.clear(self.place(middle));
        if !is_inside && clear > half * self.side * 3.0_f64.sqrt() {
            return;
        }
        let is_alike = halved >= HALVED && self.is_alike(middle, half);
        if is_alike {
            return self.solve(middle, half, pixel, tissue);
        }
        if halved == MOST_HALVED {
            *tissue = Tissue::Twice;
            return;
        }
        for (x, along_x) in divided(map, 0).iter().enumerate() {
            for (y, along_y) in divided(along_x, 1).iter().enumerate() {
                for (z, part) in divided(along_y, 2).iter().enumerate() {
                    let step = [x, y, z].map(|k| k as f64 * half);
                    let low = std::array::from_fn(|a| corner[a] + step[a]);
                    self.look(part, low, halved + 1, pixel, tissue);
                }
            }
        }
    }

    /// Whether the map turns nothing inside out in a part, or all of it: by its corners. Within both there may be two places, of which Newton's
    /// method would find one.
    fn is_alike(&self, middle: [f64; 3], half: f64) -> bool {
        let corner = |k: usize| std::array::from_fn(|a| middle[a] + half * (2.0 * f64::from((k >> a & 1) as u8) - 1.0));
        let upright = (0..8).filter(|k| inverse(&self.slope(corner(*k))).is_some_and(|(_, volume)| volume > 0.0));
        matches!(upright.count(), 0 | 8)
    }

    /// Newton's method from the middle of a part.
    fn solve(&self, middle: [f64; 3], half: f64, pixel: &[f64; 3], tissue: &mut Tissue) {
        let mut part = middle;
        for _ in 0..STEPS {
            let found = at(self.nodes, &part.map(weights));
            let off: [f64; 3] = std::array::from_fn(|a| pixel[a] - found[a]);
            let Some((rows, volume)) = inverse(&self.slope(part)) else {
                break;
            };
            if off.iter().all(|x| x.abs() < NEAR) {
                self.take(part, middle, half, volume, tissue);
                return;
            }
            for a in 0..3 {
                part[a] += rows[a].iter().zip(off).map(|(row, off)| row * off).sum::<f64>();
            }
        }
        // Beside a fold, and some of the organ may be within: nobody knows how often.
        *tissue = Tissue::Twice;
    }

    /// Takes up a place that was found from the middle of a part, where it is the cube's, the organ's, and no farther than the next part.
    fn take(&self, part: [f64; 3], middle: [f64; 3], half: f64, volume: f64, tissue: &mut Tissue) {
        let place = self.place(part);
        let is_own = part.iter().all(|x| (-BESIDE..=1.0 + BESIDE).contains(x));
        let is_near = (0..3).all(|a| (part[a] - middle[a]).abs() <= 3.0 * half);
        if !(is_own && is_near && self.region.clear(place).0) {
            return;
        }
        if volume <= 0.0 {
            *tissue = Tissue::Twice;
        } else {
            let from_face = |x: f64| x.min(1.0 - x) * self.side;
            tissue.add(place, self.number, part.into_iter().any(|x| from_face(x) < SAME_MM));
        }
    }

    /// The derivatives of the map along the cube's axes.
    fn slope(&self, part: [f64; 3]) -> [[f64; 3]; 3] {
        let changes = |t: f64| [4.0 * t - 3.0, 4.0 - 8.0 * t, 4.0 * t - 1.0];
        std::array::from_fn(|axis| {
            let along = std::array::from_fn(|a| if a == axis { changes(part[a]) } else { weights(part[a]) });
            at(self.nodes, &along)
        })
    }
}

/// Whether a pixel lies within the coefficients, between which the map stays.
fn holds(map: &Coefficients, pixel: &[f64; 3]) -> bool {
    map.iter().zip(pixel).all(|(own, x)| {
        let least = own.iter().copied().fold(f64::INFINITY, f64::min);
        let most = own.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        (least - NEAR..=most + NEAR).contains(x)
    })
}

/// The coefficients of both halves along an axis.
fn divided(map: &Coefficients, axis: usize) -> [Coefficients; 2] {
    let both = map.map(|own| halves(&own, axis));
    [both.map(|halves| halves[0]), both.map(|halves| halves[1])]
}
