//! The inverse of a cube's quadratic map at many pixels at once: a Taylor polynomial of degree two about the cube's middle, then Newton's
//! method.
//!
//! Coordinates of the cube run from -1 to 1; lengths in the image are pixels, the distance from the plane too. Single precision, relative
//! to the cube's middle: off by some 1e-6 of the cube.

use super::quadratic::LINES;

/// Steps of Newton's method, at most.
const MOST_STEPS: usize = 5;
/// What is left after the last step, in coordinates of the cube, by its bound.
pub(super) const LEFT: f64 = 2e-4;

/// A cube's map about its middle.
#[derive(Debug, Clone)]
pub(super) struct Map {
    /// By column, row, distance: coefficients of x^i y^j z^k at i + 3 j + 9 k.
    terms: [[f32; 27]; 3],
    middle: [f64; 3],
    /// The slope's inverse in the middle, by rows: coordinates of the cube a pixel.
    pub(super) slope: [[f32; 3]; 3],
}

/// What a slope's inverse, or the largest of several, can do.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Stretch {
    /// A bound of its norm, squared: by the largest sums of rows and of columns.
    pub(super) norm: f32,
    /// The sum of the squares of its columns within the plane.
    pub(super) within: f32,
}

/// What was found at pixels.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Found {
    pub(super) stretch: Stretch,
    /// The largest coordinate.
    pub(super) reach: f32,
    /// The largest part of the last step.
    step: f32,
}

/// Pixels in the cube's coordinates, beside the pixels themselves relative to the middle, in whole groups of eight.
#[derive(Debug, Clone, Default)]
pub(super) struct Nodes {
    pub(super) pixels: [Vec<f32>; 2],
    pub(super) places: [Vec<f32>; 3],
}

impl Map {
    /// Of the nodes in columns, rows and mm behind the plane, with the pixels of a mm; none where the middle is turned inside out or flat.
    #[inline(always)]
    pub(super) fn of(nodes: &[[f64; 3]; 27], pixels: f64) -> Option<Self> {
        let middle = nodes[13];
        let mut terms = [[0.0_f32; 27]; 3];
        for (k, node) in nodes.iter().enumerate() {
            terms[0][k] = (node[0] - middle[0]) as f32;
            terms[1][k] = (node[1] - middle[1]) as f32;
            terms[2][k] = ((node[2] - middle[2]) * pixels) as f32;
        }
        for values in &mut terms {
            for (step, first) in LINES {
                for at in first {
                    let [low, middle, high] = [values[at], values[at + step], values[at + 2 * step]];
                    values[at] = middle;
                    values[at + step] = 0.5 * (high - low);
                    values[at + 2 * step] = 0.5 * (high + low) - middle;
                }
            }
        }
        let [f, g, h] = &terms;
        let (slope, volume) = inverse([[f[1], g[1], h[1]], [f[3], g[3], h[3]], [f[9], g[9], h[9]]]);
        let usable = volume > 0.0 && slope.iter().flatten().all(|x| x.is_finite());
        let middle = [middle[0], middle[1], middle[2] * pixels];
        usable.then_some(Self { terms, middle, slope })
    }

    /// What the slope's inverse does in the middle.
    pub(super) fn stretch(&self) -> Stretch {
        stretch(&self.slope)
    }

    /// A bound of the second derivative along any direction where no coordinate is larger than `reach`: the root of the sum of squares of
    /// all of them.
    #[inline(always)]
    pub(super) fn bend(&self, reach: f32) -> f32 {
        let mut sum = 0.0;
        for terms in &self.terms {
            let mut size = [0.0; 27];
            for (size, term) in size.iter_mut().zip(terms) {
                *size = term.abs();
            }
            for [own, one, other] in [[1, 3, 9], [3, 1, 9], [9, 1, 3]] {
                let twice = 2.0 * layer(nine(&size, 2 * own, one, other), reach, reach)[0];
                // The slope along both of what is left when the own axis is summed up.
                let mut all = [0.0; 9];
                let parts = [0, own, 2 * own].map(|first| nine(&size, first, one, other));
                for k in 0..9 {
                    all[k] = parts[0][k] + reach * (parts[1][k] + reach * parts[2][k]);
                }
                let mixed = all[4] + 2.0 * reach * (all[5] + all[7]) + 4.0 * reach * reach * all[8];
                sum += twice * twice + 2.0 * mixed * mixed;
            }
        }
        sum.sqrt()
    }

    /// A pixel relative to the middle.
    #[inline(always)]
    pub(super) fn relative(&self, column: i32, row: i32) -> [f32; 2] {
        [
            (f64::from(column) - self.middle[0]) as f32,
            (f64::from(row) - self.middle[1]) as f32,
        ]
    }

    /// The cube's coordinates of pixels; none where the method does not converge. `bend` is the second derivative's bound.
    #[inline(always)]
    pub(super) fn solve(&self, nodes: &mut Nodes, bend: f32) -> Option<Found> {
        self.guess(nodes);
        for _ in 0..MOST_STEPS {
            let found = self.step(nodes);
            // The residual after a step is at most half the second derivative times the step's square.
            let left = 0.5 * 3.0 * found.step * found.step * bend * found.stretch.norm.sqrt();
            if f64::from(left) <= LEFT {
                return Some(found);
            }
        }
        None
    }

    /// The first two terms of the inverse.
    #[inline(always)]
    fn guess(&self, nodes: &mut Nodes) {
        let depth = -self.middle[2] as f32;
        let [xs, ys] = &nodes.pixels;
        let [us, vs, ws] = &mut nodes.places;
        let ([r, s, t], [f, g, h]) = (&self.slope, &self.terms);
        for ((((x, y), u), v), w) in xs.iter().zip(ys).zip(us).zip(vs).zip(ws) {
            let a = r[0] * x + r[1] * y + r[2] * depth;
            let b = s[0] * x + s[1] * y + s[2] * depth;
            let c = t[0] * x + t[1] * y + t[2] * depth;
            let (p, q, o) = (second(f, a, b, c), second(g, a, b, c), second(h, a, b, c));
            *u = a - (r[0] * p + r[1] * q + r[2] * o);
            *v = b - (s[0] * p + s[1] * q + s[2] * o);
            *w = c - (t[0] * p + t[1] * q + t[2] * o);
        }
    }

    #[inline(always)]
    fn step(&self, nodes: &mut Nodes) -> Found {
        let depth = -self.middle[2] as f32;
        let ([xs, ys], [us, vs, ws]) = (&nodes.pixels, &mut nodes.places);
        // Of what is not negative the bits ascend with the number, and those of what is no number are above all.
        let (mut norm, mut within, mut reach, mut longest) = (0_u32, 0_u32, 0_u32, 0_u32);
        for ((((x, y), u), v), w) in xs.iter().zip(ys).zip(us).zip(vs).zip(ws) {
            let (a, b, c) = (*u, *v, *w);
            let f = value(&self.terms[0], a, b, c);
            let g = value(&self.terms[1], a, b, c);
            let h = value(&self.terms[2], a, b, c);
            let (rows, _) = inverse([[f[1], g[1], h[1]], [f[2], g[2], h[2]], [f[3], g[3], h[3]]]);
            let [r, s, t] = rows;
            let (p, q, o) = (x - f[0], y - g[0], depth - h[0]);
            let i = r[0] * p + r[1] * q + r[2] * o;
            let j = s[0] * p + s[1] * q + s[2] * o;
            let k = t[0] * p + t[1] * q + t[2] * o;
            (*u, *v, *w) = (a + i, b + j, c + k);
            let own = stretch(&rows);
            norm = norm.max(own.norm.to_bits());
            within = within.max(own.within.to_bits());
            reach = reach.max(largest(a + i, b + j, c + k).to_bits());
            longest = longest.max(largest(i, j, k).to_bits());
        }
        Found {
            stretch: Stretch {
                norm: f32::from_bits(norm),
                within: f32::from_bits(within),
            },
            reach: f32::from_bits(reach),
            step: f32::from_bits(longest),
        }
    }
}

/// The largest size; what is no number is larger than all.
#[inline(always)]
fn largest(a: f32, b: f32, c: f32) -> f32 {
    f32::from_bits(a.abs().to_bits().max(b.abs().to_bits()).max(c.abs().to_bits()))
}

#[inline(always)]
fn stretch([r, s, t]: &[[f32; 3]; 3]) -> Stretch {
    let sum = |a: f32, b: f32, c: f32| a.abs() + b.abs() + c.abs();
    let squares = |a: f32, b: f32, c: f32| a * a + b * b + c * c;
    let rows = largest(sum(r[0], r[1], r[2]), sum(s[0], s[1], s[2]), sum(t[0], t[1], t[2]));
    let columns = largest(sum(r[0], s[0], t[0]), sum(r[1], s[1], t[1]), sum(r[2], s[2], t[2]));
    Stretch {
        norm: rows * columns,
        within: squares(r[0], s[0], t[0]) + squares(r[1], s[1], t[1]),
    }
}

/// The terms of degree two of a function.
#[inline(always)]
fn second(t: &[f32; 27], a: f32, b: f32, c: f32) -> f32 {
    a * (t[2] * a + t[4] * b + t[10] * c) + b * (t[6] * b + t[12] * c) + c * (t[18] * c)
}

/// Nine of 27 terms, by the steps along two axes.
#[inline(always)]
fn nine(t: &[f32; 27], first: usize, one: usize, other: usize) -> [f32; 9] {
    let mut found = [0.0; 9];
    for k in 0..3 {
        for j in 0..3 {
            found[3 * k + j] = t[first + j * one + k * other];
        }
    }
    found
}

/// A function of 27 terms with its three slopes.
#[inline(always)]
fn value(t: &[f32; 27], x: f32, y: f32, z: f32) -> [f32; 4] {
    let a = layer([t[0], t[1], t[2], t[3], t[4], t[5], t[6], t[7], t[8]], x, y);
    let b = layer([t[9], t[10], t[11], t[12], t[13], t[14], t[15], t[16], t[17]], x, y);
    let c = layer([t[18], t[19], t[20], t[21], t[22], t[23], t[24], t[25], t[26]], x, y);
    [
        a[0] + z * (b[0] + z * c[0]),
        a[1] + z * (b[1] + z * c[1]),
        a[2] + z * (b[2] + z * c[2]),
        b[0] + (z + z) * c[0],
    ]
}

/// A function of nine terms with its two slopes.
#[inline(always)]
fn layer(t: [f32; 9], x: f32, y: f32) -> [f32; 3] {
    let twice = x + x;
    let (a, b, c) = (
        t[0] + x * (t[1] + x * t[2]),
        t[3] + x * (t[4] + x * t[5]),
        t[6] + x * (t[7] + x * t[8]),
    );
    let (p, q, r) = (t[1] + twice * t[2], t[4] + twice * t[5], t[7] + twice * t[8]);
    [a + y * (b + y * c), p + y * (q + y * r), b + (y + y) * c]
}

/// The inverse of the matrix with these columns, by rows, and their determinant.
#[inline(always)]
fn inverse([a, b, c]: [[f32; 3]; 3]) -> ([[f32; 3]; 3], f32) {
    let [p, q, r] = [cross(b, c), cross(c, a), cross(a, b)];
    let volume = a[0] * p[0] + a[1] * p[1] + a[2] * p[2];
    let part = 1.0 / volume;
    let rows = [
        [p[0] * part, p[1] * part, p[2] * part],
        [q[0] * part, q[1] * part, q[2] * part],
        [r[0] * part, r[1] * part, r[2] * part],
    ];
    (rows, volume)
}

#[inline(always)]
fn cross(p: [f32; 3], q: [f32; 3]) -> [f32; 3] {
    [
        p[1] * q[2] - p[2] * q[1],
        p[2] * q[0] - p[0] * q[2],
        p[0] * q[1] - p[1] * q[0],
    ]
}
