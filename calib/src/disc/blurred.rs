//! The image of an ellipse through a Gaussian blur, with all its derivatives: the model that every fit here rests on.

use nalgebra::{Matrix2, Vector2};

use super::ellipse::Ellipse;
use super::normal::Normal;

/// Beyond so many deviations of the blur from its edge a disc is all there or not at all (2e-4).
pub(crate) const REACH: f64 = 3.5;
/// Chords lie at most so many deviations apart: the trapezoid rule then errs by `2 exp(-2 pi^2 / 1.2^2)` = 2e-6.
const CHORD_STEP: f64 = 1.2;
/// The most chords: for a disc of 700 deviations.
const MAX_CHORDS: usize = 2000;

/// What a pixel sees of a disc.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coverage {
    /// The share of the pixel's light that comes from the disc, 0 to 1.
    pub value: f64,
    /// Derivatives by centre x, centre y, shape xx, shape xy, shape yy, and the blur's deviation.
    pub slope: [f64; 6],
}

/// An ellipse seen through a Gaussian of deviation `sigma` pixels, which holds the pixel's own area too (a square of
/// side 1 counts as a Gaussian of variance 1/12).
///
/// `f(x) = integral over the ellipse of N(x - y; sigma^2) dy`: along the short axis in closed form, along the long one
/// by the trapezoid rule in the angle, where the integrand is periodic and analytic.
#[derive(Debug, Clone)]
pub struct Blurred {
    ellipse: Ellipse,
    sigma: f64,
    semi: [f64; 2],
    /// So far from the centre along both axes nothing of the disc is left, pixels.
    limits: [f64; 2],
    /// All there is within the ellipse of so much of both semi-axes, squared; 0 for a disc too small for that.
    core: f64,
    long: Vector2<f64>,
    /// Cosine and sine of the chords' angles, and the chords' places along the long axis and half lengths in deviations
    /// of the blur.
    chords: Vec<[f64; 4]>,
    normal: Normal,
}

/// What a point sees.
enum Place {
    /// All of the disc, or nothing of it.
    Flat(f64),
    /// Its edge, from so far along the long and the short axis, pixels.
    Edge(f64, f64),
}

/// Sums over chords: value, and derivatives along the long and short axis, by both semi-axes, by the shear, and twice
/// along both axes.
type Sums = [f64; 7];

impl Blurred {
    /// Prepares an ellipse. `sigma` above 0.
    pub fn new(ellipse: Ellipse, sigma: f64) -> Self {
        let axes = ellipse.axes();
        let semi = axes.semi.map(|s| s.max(1e-3));
        let needed = std::f64::consts::PI * semi[0] / (CHORD_STEP * sigma);
        let n = (needed.ceil() as usize).clamp(7, MAX_CHORDS);
        let chord = |k: usize| {
            let (s, c) = (std::f64::consts::PI * k as f64 / (n + 1) as f64).sin_cos();
            [c, s, semi[0] * c / sigma, semi[1] * s / sigma]
        };
        let reach = REACH * sigma;
        Self {
            ellipse,
            sigma,
            semi,
            limits: semi.map(|s| s + reach),
            // The affine map from the unit disc stretches the distance to its edge at least by the short semi-axis.
            core: (1.0 - reach / semi[1]).max(0.0).powi(2),
            long: axes.long,
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
        match self.place(x, y) {
            Place::Edge(u, v) => self.coverage(&self.sums(u, v)),
            Place::Flat(value) => Coverage { value, slope: [0.0; 6] },
        }
    }

    /// The value of [`Blurred::at`] alone.
    pub(crate) fn value(&self, x: f64, y: f64) -> f64 {
        let (u, v) = match self.place(x, y) {
            Place::Edge(u, v) => (u / self.sigma, v / self.sigma),
            Place::Flat(value) => return value,
        };
        let mut sum = 0.0;
        for [_, w, along, half] in &self.chords {
            let t = u - along;
            if t.abs() <= 5.0 {
                sum += w * self.normal.density(t) * (self.normal.below(v + half) - self.normal.below(v - half));
            }
        }
        std::f64::consts::PI / (self.chords.len() + 1) as f64 * self.semi[0] / self.sigma * sum
    }

    /// Whether a point sees the edge, and where it is along the axes.
    fn place(&self, x: f64, y: f64) -> Place {
        let d = Vector2::new(x, y) - self.ellipse.centre;
        let (u, v) = (d.dot(&self.long), d.y * self.long.x - d.x * self.long.y);
        if u.abs() > self.limits[0] || v.abs() > self.limits[1] {
            return Place::Flat(0.0);
        }
        let (p, q) = (u / self.semi[0], v / self.semi[1]);
        if p * p + q * q < self.core {
            return Place::Flat(1.0);
        }
        Place::Edge(u, v)
    }

    fn sums(&self, u: f64, v: f64) -> Sums {
        let r = 1.0 / self.sigma;
        let (u, v) = (u * r, v * r);
        let mut sums = [0.0; 7];
        for [p, w, along, half] in &self.chords {
            let t = u - along;
            if t.abs() > 5.0 {
                continue;
            }
            let weight = w * self.normal.density(t);
            let (above, below) = (v + half, v - half);
            let [high, at_high] = self.normal.at(above);
            let [low, at_low] = self.normal.at(below);
            let inside = high - low;
            let (rise, both) = (at_high - at_low, at_high + at_low);
            sums[0] += weight * inside;
            sums[1] -= weight * t * inside;
            sums[2] += weight * rise;
            sums[3] += weight * t * p * inside;
            sums[4] += weight * w * both;
            sums[5] -= weight * p * rise;
            let bend = above * at_high - below * at_low;
            sums[6] += weight * ((t * t - 1.0) * inside - bend);
        }
        sums
    }

    fn coverage(&self, sums: &Sums) -> Coverage {
        let ([a, b], r) = (self.semi, 1.0 / self.sigma);
        let step = std::f64::consts::PI / (self.chords.len() + 1) as f64;
        let scale = step * a * r;
        let value = scale * sums[0];
        let [du, dv, by_b, by_shear] = [1, 2, 4, 5].map(|k| scale * r * sums[k]);
        let by_a = value / a + scale * r * sums[3];
        let (l, s) = (self.long, Vector2::new(-self.long.y, self.long.x));
        // In the axes' frame shape = L L^T with L = [a, 0; shear, b], so that d shape = [2a da, a dshear; ., 2b db].
        let in_axes = Matrix2::new(
            by_a / (2.0 * a),
            by_shear / (2.0 * a),
            by_shear / (2.0 * a),
            by_b / (2.0 * b),
        );
        let frame = Matrix2::from_columns(&[l, s]);
        let shape = frame * in_axes * frame.transpose();
        let centre = -(l * du + s * dv);
        // Blurring is diffusion: d/dsigma = sigma (d^2/du^2 + d^2/dv^2).
        let by_sigma = scale * r * sums[6];
        let slope = [
            centre.x,
            centre.y,
            shape[(0, 0)],
            2.0 * shape[(0, 1)],
            shape[(1, 1)],
            by_sigma,
        ];
        Coverage { value, slope }
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
                // The same sum in another order: roundings of numbers below 1.
                assert!((model.value(at[0], at[1]) - found).abs() < 1e-14, "{p:?} {at:?}");
            }
        }
    }

    #[test]
    fn derivatives_agree_with_differences() {
        for (p, sigma) in CASES {
            for at in [[0.3, 0.1], [3.0, 1.0], [6.2, 0.7], [-2.0, -2.5], [5.0, 3.0]] {
                let slope = Blurred::new(ellipse(p), sigma).at(at[0], at[1]).slope;
                for (k, slope) in slope.into_iter().enumerate() {
                    // The axes of a circle turn with its shape, and the chords with them: the quadrature's 2e-6 jumps.
                    let turns = p[2] == p[4] && (2..5).contains(&k);
                    let (step, allowed) = if turns { (1e-2, 2e-4) } else { (1e-4, 1e-4) };
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
                    // The quadrature's 2e-6 (over the step where it jumps) and the table's 1e-9 / 1e-4 of the difference.
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
