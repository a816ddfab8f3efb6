//! The distortion of a lens (Brown 1966, in OpenCV's order and signs), its inverse, and the domain of both.
//!
//! On the plane at distance 1 in front of the camera, with `r^2 = x^2 + y^2`, `L = 1 + k1 r^2 + k2 r^4 + k3 r^6` and
//! `q = (p2, p1)`:
//!
//! ```text
//! f(x) = L x + 2 (q.x) x + r^2 q + t                                                                           (1)
//! f'(x) = (L + 2 q.x) 1 + 2 L' x x^T + 2 (x q^T + q x^T) + 2 t' x^T,     L' = k1 + 2 k2 r^2 + 3 k3 r^4           (2)
//! t = (s1, s3) r^2 + (s2, s4) r^4,     t' = (s1, s3) + 2 (s2, s4) r^2
//! ```
//!
//! The least eigenvalue of the derivative's symmetric part is at least
//! `min(L, L + 2 L' r^2) - 6 |q| r - 2 |(s1, s3)| r - 4 |(s2, s4)| r^3`. Up to the first radius at which that falls to
//! [`LEAST_SLOPE`] the function is strictly monotone on a disc, so that `f` is one to one there: this disc is the domain,
//! [`Lens::limit`].

use nalgebra::{Matrix2, SMatrix, Vector2};

/// The least slope in the domain: an error of an image point grows at most twentyfold when it is undistorted.
pub const LEAST_SLOPE: f64 = 0.05;
/// The largest radius considered: 85 degrees off the axis, where a plane in front of the camera ends as a model.
pub const WIDEST: f64 = 11.43;
/// How many coefficients there are.
pub(super) const COEFFICIENTS: usize = 9;
/// Steps of the inverse; five are usual, near the domain's edge ten.
const MAX_STEPS: usize = 100;

/// Coefficients of the distortion; all zero for a pinhole.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Lens {
    /// Radial, of r^2.
    pub k1: f64,
    /// Radial, of r^4.
    pub k2: f64,
    /// Radial, of r^6.
    pub k3: f64,
    /// Tangential: along y.
    pub p1: f64,
    /// Tangential: along x.
    pub p2: f64,
    /// Thin prism: s1 and s2 along x, of r^2 and r^4; s3 and s4 along y.
    pub s: [f64; 4],
}

impl Lens {
    /// The factor `L` at `r^2`.
    fn factor(&self, r2: f64) -> f64 {
        1.0 + r2 * (self.k1 + r2 * (self.k2 + r2 * self.k3))
    }

    /// `L'`.
    fn growth(&self, r2: f64) -> f64 {
        self.k1 + r2 * (2.0 * self.k2 + 3.0 * r2 * self.k3)
    }

    fn tangential(&self) -> Vector2<f64> {
        Vector2::new(self.p2, self.p1)
    }

    /// What the prism adds, and its derivative by `r^2`.
    fn prism(&self, r2: f64) -> [Vector2<f64>; 2] {
        let [a, b, c, d] = self.s;
        let [low, high] = [Vector2::new(a, c), Vector2::new(b, d)];
        [(low + high * r2) * r2, low + high * (2.0 * r2)]
    }

    /// (1), whether or not `x` is in the domain.
    pub fn distort(&self, x: Vector2<f64>) -> Vector2<f64> {
        let (q, r2) = (self.tangential(), x.norm_squared());
        x * (self.factor(r2) + 2.0 * q.dot(&x)) + q * r2 + self.prism(r2)[0]
    }

    /// (2): the derivative by the point.
    pub fn slope(&self, x: Vector2<f64>) -> Matrix2<f64> {
        let (q, r2) = (self.tangential(), x.norm_squared());
        let cross = x * q.transpose();
        Matrix2::identity() * (self.factor(r2) + 2.0 * q.dot(&x))
            + x * x.transpose() * (2.0 * self.growth(r2))
            + (cross + cross.transpose()) * 2.0
            + self.prism(r2)[1] * x.transpose() * 2.0
    }

    /// The derivative by (k1, k2, p1, p2, k3, s1, s2, s3, s4), one column each.
    pub fn slope_by_coefficients(&self, x: Vector2<f64>) -> SMatrix<f64, 2, COEFFICIENTS> {
        let r2 = x.norm_squared();
        let (radial, xy) = (x * r2, 2.0 * x.x * x.y);
        SMatrix::from_columns(&[
            radial,
            radial * r2,
            Vector2::new(xy, r2 + 2.0 * x.y * x.y),
            Vector2::new(r2 + 2.0 * x.x * x.x, xy),
            radial * (r2 * r2),
            Vector2::new(r2, 0.0),
            Vector2::new(r2 * r2, 0.0),
            Vector2::new(0.0, r2),
            Vector2::new(0.0, r2 * r2),
        ])
    }

    /// The radius of the domain, tangent of the angle off the axis: at most [`WIDEST`].
    pub fn limit(&self) -> f64 {
        let [a, b, c, d] = self.s;
        let q = 6.0 * self.tangential().norm() + 2.0 * a.hypot(c);
        let high = 4.0 * b.hypot(d);
        let fall = |a: f64, b: f64, c: f64| {
            let polynomial = [1.0 - LEAST_SLOPE, -q, a * self.k1, -high, b * self.k2, 0.0, c * self.k3];
            first_root(&polynomial, WIDEST).unwrap_or(WIDEST)
        };
        // L + 2 L' r^2 = 1 + 3 k1 r^2 + 5 k2 r^4 + 7 k3 r^6, and L itself.
        fall(3.0, 5.0, 7.0).min(fall(1.0, 1.0, 1.0))
    }

    /// The point of the domain that [`Lens::distort`] maps to `image`, to some roundings times `1 / LEAST_SLOPE`; none
    /// where no point of the domain does.
    ///
    /// Newton's method on a strictly monotone function, its steps halved while they lead away or out of the domain.
    pub fn undistort(&self, image: Vector2<f64>) -> Option<Vector2<f64>> {
        let limit = self.limit();
        let size = image.norm();
        if !size.is_finite() {
            return None;
        }
        // The distorted point is near the other where it lies well within the domain; else a start inside, in the same
        // direction.
        let mut x = if size < 0.9 * limit {
            image
        } else {
            image * (0.9 * limit / size)
        };
        let mut off = image - self.distort(x);
        for _ in 0..MAX_STEPS {
            let step = self.slope(x).try_inverse()? * off;
            let Some((next, left)) = self.nearer(x, step, image, off.norm(), limit) else {
                break;
            };
            (x, off) = (next, left);
        }
        // Half a dozen roundings of numbers of the size of the image.
        (off.norm() <= 16.0 * f64::EPSILON * size.max(f64::MIN_POSITIVE)).then_some(x)
    }

    /// The longest of the halved steps that stays in the domain and comes nearer.
    fn nearer(
        &self,
        x: Vector2<f64>,
        mut step: Vector2<f64>,
        image: Vector2<f64>,
        before: f64,
        limit: f64,
    ) -> Option<(Vector2<f64>, Vector2<f64>)> {
        // A shorter step is rounded away when it is added.
        while step.norm() > 0.25 * f64::EPSILON * x.norm() {
            let next = x + step;
            let off = image - self.distort(next);
            if next.norm() <= limit && off.norm() < before {
                return Some((next, off));
            }
            step *= 0.5;
        }
        None
    }
}

/// The value of a polynomial, the constant first.
fn value(polynomial: &[f64], x: f64) -> f64 {
    polynomial.iter().rev().fold(0.0, |sum, c| sum * x + c)
}

/// The least root in (0, `end`] at which the polynomial changes sign: between neighbouring extrema, the roots of its
/// derivative, there is at most one.
fn first_root(polynomial: &[f64], end: f64) -> Option<f64> {
    roots(polynomial, end).first().copied()
}

fn roots(polynomial: &[f64], end: f64) -> Vec<f64> {
    if polynomial.len() < 2 {
        return Vec::new();
    }
    let derivative: Vec<f64> = polynomial
        .iter()
        .enumerate()
        .skip(1)
        .map(|(i, c)| i as f64 * c)
        .collect();
    let mut stops = roots(&derivative, end);
    stops.push(end);
    let (mut from, mut found) = (0.0, Vec::new());
    for to in stops {
        // A root at the beginning lies at 0 or was found as the end before; up to the next extremum there is no second
        // one.
        if value(polynomial, from) * value(polynomial, to) <= 0.0 && value(polynomial, from) != 0.0 {
            found.push(bisected(polynomial, from, to));
        }
        from = to;
    }
    found
}

fn bisected(polynomial: &[f64], mut from: f64, mut to: f64) -> f64 {
    // The lower end is returned: of the bound of the slope that is the side on which it has not fallen too low.
    let sign = value(polynomial, from).signum();
    // A double has 53 bits, and its exponent some more.
    for _ in 0..80 {
        let middle = 0.5 * (from + to);
        if value(polynomial, middle) * sign > 0.0 {
            from = middle;
        } else {
            to = middle;
        }
    }
    from
}

#[cfg(test)]
mod tests {
    use super::*;

    /// With a prism, none, a laparoscope's, pincushion, and two that fold.
    const LENSES: [Lens; 6] = [
        Lens {
            k1: -0.4,
            k2: 0.4,
            k3: 0.0,
            p1: 0.0,
            p2: 0.0,
            s: [-0.02, 0.05, 0.04, -0.03],
        },
        Lens {
            k1: 0.0,
            k2: 0.0,
            k3: 0.0,
            p1: 0.0,
            p2: 0.0,
            s: [0.0; 4],
        },
        Lens {
            k1: -0.29,
            k2: -0.0019,
            k3: 0.3745,
            p1: 0.00716,
            p2: -0.00017,
            s: [0.0; 4],
        },
        Lens {
            k1: 0.3,
            k2: 0.1,
            k3: 0.02,
            p1: -0.01,
            p2: 0.02,
            s: [0.0; 4],
        },
        Lens {
            k1: -0.5,
            k2: 0.0,
            k3: 0.0,
            p1: 0.003,
            p2: 0.002,
            s: [0.0; 4],
        },
        Lens {
            k1: 0.1,
            k2: -0.4,
            k3: 0.05,
            p1: 0.0,
            p2: -0.03,
            s: [0.0; 4],
        },
    ];

    #[test]
    fn the_inverse_holds_twelve_digits_everywhere_in_the_domain() {
        for lens in LENSES {
            let limit = lens.limit();
            for i in 0..40 {
                for j in 0..=50 {
                    let (s, c) = (f64::from(i) * std::f64::consts::TAU / 40.0).sin_cos();
                    let x = Vector2::new(c, s) * (limit * f64::from(j) / 50.0 * (1.0 - 1e-9));
                    let back = lens.undistort(lens.distort(x)).unwrap();
                    assert!((back - x).norm() <= 1e-12 * x.norm().max(1.0), "{lens:?} {x} {back}");
                }
            }
        }
    }

    #[test]
    fn the_domain_is_where_the_slope_is_positive() {
        for lens in LENSES {
            let limit = lens.limit();
            for i in 0..4000 {
                let (s, c) = (f64::from(i % 40) * std::f64::consts::TAU / 40.0).sin_cos();
                let x = Vector2::new(c, s) * (limit * f64::from(i / 40) / 100.0);
                let slope = lens.slope(x);
                let least = ((slope + slope.transpose()) * 0.5).symmetric_eigenvalues().min();
                assert!(least >= LEAST_SLOPE - 1e-12, "{lens:?} {x} {least}");
            }
        }
        // 1 - 3 / 2 r^2 = 1 / 20 without tangential terms.
        let barrel = Lens {
            k1: -0.5,
            ..Lens::default()
        };
        assert!((barrel.limit() - (0.95_f64 / 1.5).sqrt()).abs() < 1e-14);
        assert_eq!(Lens::default().limit(), WIDEST);
    }

    #[test]
    fn images_from_beyond_the_domain_have_no_point() {
        let barrel = Lens {
            k1: -0.5,
            ..Lens::default()
        };
        let limit = barrel.limit();
        let edge = barrel.distort(Vector2::new(limit, 0.0));
        assert!(barrel.undistort(edge * 0.999_999).is_some());
        assert!(barrel.undistort(edge * 1.000_001).is_none());
        for image in [1e300, f64::NAN, f64::INFINITY] {
            assert!(barrel.undistort(Vector2::new(image, 0.0)).is_none());
        }
        assert_eq!(barrel.undistort(Vector2::zeros()), Some(Vector2::zeros()));
    }

    /// Central differences: their error is the third derivative times h^2 / 6, below 20 x 1e-10.
    #[test]
    fn derivatives_are_those_of_differences() {
        let h = 1e-5;
        for lens in LENSES {
            for x in [
                Vector2::new(0.3, -0.45),
                Vector2::new(-0.02, 0.01),
                Vector2::new(0.6, 0.5),
            ] {
                let slope = lens.slope(x);
                for k in 0..2 {
                    let step = Vector2::ith(k, h);
                    let by = (lens.distort(x + step) - lens.distort(x - step)) / (2.0 * h);
                    assert!((slope.column(k) - by).norm() < 1e-8);
                }
                let by_coefficients = lens.slope_by_coefficients(x);
                for k in 0..COEFFICIENTS {
                    let moved = |d: f64| {
                        let mut l = lens;
                        let [s1, s2, s3, s4] = &mut l.s;
                        *[&mut l.k1, &mut l.k2, &mut l.p1, &mut l.p2, &mut l.k3, s1, s2, s3, s4][k] += d;
                        l.distort(x)
                    };
                    let by = (moved(h) - moved(-h)) / (2.0 * h);
                    assert!((by_coefficients.column(k) - by).norm() < 1e-8);
                }
            }
        }
    }
}
