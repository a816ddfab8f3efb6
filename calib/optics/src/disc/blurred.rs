//! The image of an ellipse through a Gaussian blur, with all its derivatives: the model that every fit here rests on.

use nalgebra::{Matrix2, Vector2};

use super::ellipse::Ellipse;
use super::normal::Normal;

/// Beyond so many deviations of the blur from its edge a disc is all there or not at all (2e-4).
pub(crate) const REACH: f64 = 3.5;
/// Chords' ends lie at most so many deviations apart: the trapezoid rule then errs by `2 exp(-2 pi^2 / 1.2^2)` = 2e-6.
const CHORD_STEP: f64 = 1.2;
/// The most chords: for a disc of 700 deviations.
const MAX_CHORDS: usize = 2000;
/// Chords farther from a point, in deviations, say nothing of it: the density there is 1.5e-6, what lies beyond 3e-7.
const FAR_CHORD_DEVIATIONS: f64 = 5.0;

/// What a pixel sees of a disc.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coverage {
    /// The share of the pixel's light that comes from the disc, 0 to 1.
    pub value: f64,
    /// Derivatives by centre x, centre y, shape xx, shape xy, shape yy, and the blur's deviation.
    pub slope: [f64; 6],
}

impl Coverage {
    /// All of the disc, or nothing of it.
    pub(super) fn flat(value: f64) -> Self {
        Self { value, slope: [0.0; 6] }
    }
}

/// An ellipse seen through a Gaussian of deviation `sigma` pixels, which holds the pixel's own area too (a square of
/// side 1 counts as a Gaussian of variance 1/12).
///
/// `f(x) = integral over the ellipse of N(x - y; sigma^2) dy`: along the image's columns in closed form, across them by
/// the trapezoid rule in the angle, where the integrand is periodic and analytic. A chord's weight is a product of what
/// depends on the point's column (`Along`) and of what depends on its row (`Across`).
#[derive(Debug, Clone)]
pub struct Blurred {
    ellipse: Ellipse,
    sigma: f64,
    /// `[[x, 0], [shear, y]]`, pixels: with its transpose it makes the shape; a chord of angle `t` lies at `x cos t`, its
    /// middle at `shear cos t`, and half of it is `y sin t` long.
    root: [f64; 3],
    /// One over the root's x and y and the blur: divisions take longer than all else that a pixel asks for.
    over: [f64; 3],
    /// The weight of a chord.
    scale: f64,
    /// The short semi-axis, pixels.
    short: f64,
    chords: Vec<Chord>,
    normal: Normal,
}

/// A chord along y: cosine and sine of its angle, and its place, its middle and its half length in deviations of the blur.
#[derive(Debug, Clone, Copy)]
struct Chord {
    cos: f64,
    sin: f64,
    at: f64,
    middle: f64,
    half: f64,
}

/// Two chords as a column sees them: weight, and that times the distance `t`, and `t cos`.
pub(super) type Along = [[f64; 2]; 3];
/// Two chords as a row sees them: the share inside, its slope along y, and its slopes by half length and by shear.
pub(super) type Across = [[f64; 2]; 4];
/// Sums over chords: value, and derivatives along x and y, and by the root's x, y and shear.
type Sums = [f64; 6];

impl Blurred {
    /// Prepares an ellipse. `sigma` above 0.
    pub fn new(ellipse: Ellipse, sigma: f64) -> Self {
        let (xx, xy, yy) = (ellipse.shape[(0, 0)], ellipse.shape[(0, 1)], ellipse.shape[(1, 1)]);
        // The Cholesky root of the shape takes the unit circle to the outline; a floor keeps a line an ellipse.
        let x = xx.max(1e-6).sqrt();
        let shear = xy / x;
        let y = (yy - shear * shear).max(1e-6).sqrt();
        let [long, short] = ellipse.axes().semi;
        // Chords lie closer than the blur is wide, as far as there is room for them: the sum over them is then an integral.
        let needed = std::f64::consts::PI * long / (CHORD_STEP * sigma);
        let n = (needed.ceil() as usize).clamp(7, MAX_CHORDS);
        let chord = |k: usize| {
            let (sin, cos) = (std::f64::consts::PI * k as f64 / (n + 1) as f64).sin_cos();
            Chord {
                cos,
                sin,
                at: x * cos / sigma,
                middle: shear * cos / sigma,
                half: y * sin / sigma,
            }
        };
        Self {
            ellipse,
            sigma,
            root: [x, shear, y],
            over: [x, y, sigma].map(f64::recip),
            scale: std::f64::consts::PI / (n + 1) as f64 * x / sigma,
            short: short.max(1e-3),
            chords: (1..=n).map(chord).collect(),
            normal: Normal::new(),
        }
    }

    /// Columns and rows, first and behind the last, that see the disc or its surroundings up to `margin` pixels from
    /// its edge, clipped to an image.
    pub fn window(&self, margin: f64, width: usize, height: usize) -> [[usize; 2]; 2] {
        let extent = self.ellipse.extent().add_scalar(margin);
        let range = |centre: f64, reach: f64, size: usize| {
            let clip = |v: f64| v.clamp(0.0, size as f64) as usize;
            [clip((centre - reach).ceil()), clip((centre + reach).floor() + 1.0)]
        };
        let centre = self.ellipse.centre;
        [range(centre.x, extent.x, width), range(centre.y, extent.y, height)]
    }

    /// The coverage at a point, pixels.
    pub fn at(&self, x: f64, y: f64) -> Coverage {
        let off = Vector2::new(x, y) - self.ellipse.centre;
        let [seen, full] = self
            .rims()
            .map(|rim| rim.at(off.y))
            .map(|[a, b]| (a..b).contains(&off.x));
        if full || !seen {
            return Coverage::flat(f64::from(u8::from(full)));
        }
        let (mut along, mut across) = (Vec::new(), Vec::new());
        let first = self.column(x, &mut along);
        self.row(y, &mut across);
        self.coverage(&along, across.get(first..).unwrap_or_default(), off.into())
    }

    /// Outside of the first ellipse nothing of the disc is left; inside the second all of it.
    ///
    /// The first holds all that is nearer than the reach `d`: for any positive `p`, `(1 + p) d^2 I + (1 + 1 / p) shape` does,
    /// as supports add up; this `p` is exact for a circle. In the second, as in the map from the unit disc, the
    /// distance to the edge is at least its share of the short semi-axis.
    pub(super) fn rims(&self) -> [Rim; 2] {
        let (shape, reach) = (self.ellipse.shape, REACH * self.sigma);
        let p = (0.5 * shape.trace()).sqrt() / reach;
        let outer = shape * (1.0 + 1.0 / p) + Matrix2::identity() * ((1.0 + p) * reach * reach);
        let core = shape * (1.0 - reach / self.short).max(0.0).powi(2);
        [outer, core].map(|s| Rim::new(&s))
    }

    pub(super) fn centre(&self) -> Vector2<f64> {
        self.ellipse.centre
    }

    /// What a column sees, behind what `to` holds, and the pair of chords that it begins with.
    pub(super) fn column(&self, x: f64, to: &mut Vec<Along>) -> usize {
        let u = (x - self.ellipse.centre.x) / self.sigma;
        // Cosines fall along the list: chords lie from the right to the left.
        let from = self.chords.partition_point(|c| c.at > u + FAR_CHORD_DEVIATIONS);
        let end = self.chords.partition_point(|c| c.at >= u - FAR_CHORD_DEVIATIONS);
        // Pairs begin with an even chord, so that those of columns and of rows are the same.
        let first = from / 2;
        for pair in self.chords[2 * first..end.max(2 * first)].chunks(2) {
            let mut out = Along::default();
            for (l, chord) in pair.iter().enumerate() {
                let t = u - chord.at;
                let weight = chord.sin * self.normal.density(t);
                (out[0][l], out[1][l]) = (weight, weight * t);
                out[2][l] = weight * t * chord.cos;
            }
            to.push(out);
        }
        first
    }

    /// What a row sees, behind what `to` holds.
    pub(super) fn row(&self, y: f64, to: &mut Vec<Across>) {
        let v = (y - self.ellipse.centre.y) / self.sigma;
        for pair in self.chords.chunks(2) {
            let mut out = Across::default();
            for (l, chord) in pair.iter().enumerate() {
                let (above, below) = (v - chord.middle + chord.half, v - chord.middle - chord.half);
                if above < -FAR_CHORD_DEVIATIONS || below > FAR_CHORD_DEVIATIONS {
                    continue;
                }
                if above > FAR_CHORD_DEVIATIONS && below < -FAR_CHORD_DEVIATIONS {
                    out[0][l] = 1.0;
                    continue;
                }
                let [high, at_high] = self.normal.at(above);
                let [low, at_low] = self.normal.at(below);
                let (inside, rise) = (high - low, at_high - at_low);
                (out[0][l], out[1][l]) = (inside, rise);
                (out[2][l], out[3][l]) = (chord.sin * (at_high + at_low), chord.cos * rise);
            }
            to.push(out);
        }
    }

    /// The value of [`Blurred::coverage`] alone.
    pub(super) fn value(&self, along: &[Along], across: &[Across]) -> f64 {
        let mut sum = [0.0; 2];
        for (a, b) in along.iter().zip(across) {
            (0..2).for_each(|l| sum[l] += a[0][l] * b[0][l]);
        }
        self.scale * (sum[0] + sum[1])
    }

    /// What is seen by a column and a row, whose pairs of chords begin with the same one, and which meet at a place off the
    /// centre.
    #[inline]
    pub(super) fn coverage(&self, along: &[Along], across: &[Across], off: [f64; 2]) -> Coverage {
        let sums = sums(along, across);
        let ([x, shear, y], [over_x, over_y, r], scale) = (self.root, self.over, self.scale);
        let value = scale * sums[0];
        let [du, dv, by_y, by_shear] = [1, 2, 4, 5].map(|k| scale * r * sums[k]);
        let by_x = value * over_x + scale * r * sums[3];
        // d shape = d root root^T + root d root^T, solved for x, then shear, then y.
        let (s, t) = (shear * over_x, by_shear - by_y * shear * over_y);
        let slope = [
            -du,
            -dv,
            (by_x - s * t) * 0.5 * over_x,
            t * over_x,
            by_y * 0.5 * over_y,
            // Twice as large at twice the distance with twice the blur, a disc looks the same (Euler): the derivatives by
            // all lengths, times those, have the sum 0.
            -r * (off[0] * du + off[1] * dv + x * by_x + shear * by_shear + y * by_y),
        ];
        Coverage { value, slope }
    }
}

/// The sums over chords that a column and a row see.
#[inline]
fn sums(along: &[Along], across: &[Across]) -> Sums {
    let mut sums = [[0.0; 2]; 6];
    for (a, b) in along.iter().zip(across) {
        for l in 0..2 {
            sums[0][l] += a[0][l] * b[0][l];
            sums[1][l] -= a[1][l] * b[0][l];
            sums[2][l] += a[0][l] * b[1][l];
            sums[3][l] += a[2][l] * b[0][l];
            sums[4][l] += a[0][l] * b[2][l];
            sums[5][l] -= a[0][l] * b[3][l];
        }
    }
    sums.map(|[a, b]| a + b)
}

/// An ellipse about the origin, asked row by row.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Rim {
    /// Half of the row in the middle; the middle's shift from row to row; one over half the height squared.
    half: f64,
    lean: f64,
    flat: f64,
}

impl Rim {
    fn new(shape: &Matrix2<f64>) -> Self {
        let yy = shape[(1, 1)].max(1e-300);
        Self {
            half: (shape.determinant().max(0.0) / yy).sqrt(),
            lean: shape[(0, 1)] / yy,
            flat: 1.0 / yy,
        }
    }

    /// From where to where, along x, a row `y` off the middle lies inside; nowhere where both are equal.
    pub(super) fn at(&self, y: f64) -> [f64; 2] {
        let half = self.half * (1.0 - y * y * self.flat).max(0.0).sqrt();
        [self.lean * y - half, self.lean * y + half]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ellipse(p: [f64; 5]) -> Ellipse {
        Ellipse {
            centre: Vector2::new(p[0], p[1]),
            shape: Matrix2::new(p[2], p[3], p[3], p[4]),
        }
    }

    const CASES: [([f64; 5], f64); 5] = [
        ([0.3, -0.2, 36.0, 0.3, 35.5], 0.75),
        ([0.3, -0.2, 36.0, 0.0, 36.0], 0.75),
        ([0.1, 0.4, 40.0, 11.0, 6.0], 0.8),
        ([0.0, 0.0, 0.3, 0.1, 0.25], 0.76),
        ([0.0, 0.0, 49.0, 2.0, 0.5], 0.76),
    ];

    /// The plain double sum over the ellipse.
    fn brute(e: &Ellipse, sigma: f64, at: Vector2<f64>) -> f64 {
        let (h, inverse, extent) = (0.02, e.shape.try_inverse().unwrap(), e.extent());
        let mut sum = 0.0;
        let n = (extent / h).map(f64::ceil);
        for i in -(n.x as i32)..=n.x as i32 {
            for j in -(n.y as i32)..=n.y as i32 {
                let d = Vector2::new(f64::from(i), f64::from(j)) * h;
                if (d.transpose() * inverse * d)[0] <= 1.0 {
                    sum += (-0.5 * (at - e.centre - d).norm_squared() / (sigma * sigma)).exp();
                }
            }
        }
        sum * h * h / (std::f64::consts::TAU * sigma * sigma)
    }

    #[test]
    fn coverage_is_the_integral_over_the_ellipse() {
        for (p, sigma) in CASES {
            let e = ellipse(p);
            let model = Blurred::new(e, sigma);
            for at in [[0.0, 0.0], [3.0, 1.0], [6.2, 0.7], [-2.0, -4.0], [5.0, 3.0]] {
                let (found, sum) = (model.at(at[0], at[1]).value, brute(&e, sigma, at.into()));
                // The sum's edge is a staircase of steps 0.02: a relative error of the order of h^1.5 / r.
                assert!((found - sum).abs() < 2e-3, "{p:?} {at:?}: {found} {sum}");
            }
        }
    }

    #[test]
    fn derivatives_agree_with_differences() {
        for (p, sigma) in CASES {
            for at in [[0.3, 0.1], [3.0, 1.0], [6.2, 0.7], [-2.0, -2.5], [5.0, 3.0]] {
                let slope = Blurred::new(ellipse(p), sigma).at(at[0], at[1]).slope;
                for (k, slope) in slope.into_iter().enumerate() {
                    let (step, allowed) = (1e-4, 1e-4);
                    let moved = |sign: f64| {
                        let (mut q, mut s, h) = (p, sigma, step * sign);
                        if k < 5 {
                            q[k] += h
                        } else {
                            s += h
                        }
                        Blurred::new(ellipse(q), s).at(at[0], at[1]).value
                    };
                    let difference = (moved(1.0) - moved(-1.0)) / (2.0 * step);
                    // The quadrature's 2e-6 and the table's 1e-9 / 1e-4 of the difference.
                    let error = (slope - difference).abs();
                    assert!(error < allowed, "{p:?} {at:?} {k}: {slope} {difference}");
                }
            }
        }
    }

    #[test]
    fn far_inside_is_one_and_far_outside_nothing() {
        let model = Blurred::new(Ellipse::circle(Vector2::zeros(), 20.0), 1.0);
        assert_eq!(model.at(2.0, 3.0).value, 1.0);
        assert_eq!(model.at(25.0, 3.0).value, 0.0);
        assert!((model.at(15.5, 0.0).value - 1.0).abs() < 3e-4);
    }
}
