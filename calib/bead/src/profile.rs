//! A ball as a scanner shows it: convolved with a Gaussian that is round in the slice's plane and of another width along
//! the slice's normal.
//!
//! With the chord of half length `h = r s` above the circle of radius `t = r sqrt(1 - s^2)`:
//!
//! ```text
//! f(rho, z) = int_0^1 r^2 s / p^2 exp(-(rho^2 + t^2) / (2 p^2)) I0(rho t / p^2) [Phi((z+h)/a) - Phi((z-h)/a)] ds
//! ```
//!
//! where rho is the distance from the ball's axis along the normal, z the height, p and a the Gaussian's deviations in the
//! plane and along the normal, all mm; where a slice is the mean over a thickness besides, so is the bracket. f is 1 deep
//! inside a large ball and 0 far away. The integral over s is smooth, and twelve Gauss-Legendre nodes give f to 1e-5 where r
//! is below six deviations.

use super::special::{bessel_scaled, erf_and_exp};

/// Gauss-Legendre nodes and weights on [0, 1]: from the twelve on [-1, 1] of Abramowitz and Stegun 1964, table 25.4.
const NODES: [(f64, f64); 6] = [
    (0.125_233_408_511_469, 0.249_147_045_813_403),
    (0.367_831_498_998_180, 0.233_492_536_538_355),
    (0.587_317_954_286_617, 0.203_167_426_723_066),
    (0.769_902_674_194_305, 0.160_078_328_543_346),
    (0.904_117_256_370_475, 0.106_939_325_995_318),
    (0.981_560_634_246_719, 0.047_175_336_386_512),
];
const SQRT_HALF: f64 = std::f64::consts::FRAC_1_SQRT_2;
/// `1 / sqrt(2 pi)`.
const DENSITY: f64 = 0.398_942_280_401_432_7;

/// A ball's radius and the Gaussian's deviations, mm, all above zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Blur {
    /// The ball's radius.
    pub radius_mm: f64,
    /// Deviation along every direction of the slice's plane.
    pub plane_mm: f64,
    /// Deviation along the slice's normal.
    pub axial_mm: f64,
    /// Width over which a slice is the mean along its normal besides; 0 where its profile is the Gaussian alone.
    pub slice_mm: f64,
}

/// The value and its derivatives.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Profile {
    /// Between 0 and 1.
    pub value: f64,
    /// By rho, 1/mm.
    pub by_rho: f64,
    /// By z, 1/mm.
    pub by_z: f64,
    /// By the radius, 1/mm.
    pub by_radius: f64,
    /// By the deviation in the plane, 1/mm.
    pub by_plane: f64,
    /// By the deviation along the normal, 1/mm.
    pub by_axial: f64,
}

impl Blur {
    /// Deviation of the slice's whole profile, mm.
    pub fn profile_mm(&self) -> f64 {
        self.axial_mm.hypot(self.slice_mm / 12.0_f64.sqrt())
    }

    /// The profile at the distance `rho >= 0` from the axis and the height `z` over the centre, mm.
    pub fn at(&self, rho: f64, z: f64) -> Profile {
        let mut sum = Profile::default();
        for (node, weight) in NODES {
            self.add(0.5 * (1.0 - node), 0.5 * weight, rho, z, &mut sum);
            self.add(0.5 * (1.0 + node), 0.5 * weight, rho, z, &mut sum);
        }
        sum
    }

    /// The value alone.
    pub fn value(&self, rho: f64, z: f64) -> f64 {
        self.at(rho, z).value
    }

    fn add(&self, s: f64, weight: f64, rho: f64, z: f64, sum: &mut Profile) {
        let (r, p2) = (self.radius_mm, self.plane_mm * self.plane_mm);
        let cosine = (1.0 - s * s).sqrt();
        let (t, h) = (r * cosine, r * s);
        let (i0, i1) = bessel_scaled(rho * t / p2);
        // The scaled Bessel functions have exp(-rho t / p^2) in them: left is the square of the difference, and nothing
        // overflows.
        let exp = (-0.5 * (rho - t) * (rho - t) / p2).exp();
        let factor = weight * r * r * s / p2 * exp;
        let chord = Chord::new(z, h, self);
        let ring = factor * i0;
        sum.value += ring * chord.value;
        sum.by_z += ring * chord.by_z;
        sum.by_axial += ring * chord.by_axial;
        // Each derivative of the ring follows from I0' = I1.
        sum.by_rho += factor * (t * i1 - rho * i0) / p2 * chord.value;
        let spread = ((rho * rho + t * t) * i0 - 2.0 * rho * t * i1) / p2 - 2.0 * i0;
        sum.by_plane += factor * spread / self.plane_mm * chord.value;
        let by_t = (rho * i1 - t * i0) / p2;
        // By the chain rule, as the radius is in r^2, in t = r sqrt(1 - s^2) and in h = r s.
        sum.by_radius += factor * ((2.0 / r * i0 + by_t * cosine) * chord.value + i0 * chord.by_h * s);
    }
}

/// The integral of the slice's profile from `z - h` to `z + h`.
struct Chord {
    value: f64,
    by_z: f64,
    by_h: f64,
    by_axial: f64,
}

impl Chord {
    fn new(z: f64, h: f64, blur: &Blur) -> Self {
        if blur.slice_mm > 0.0 {
            return Self::of_box(z, h, blur);
        }
        let a = blur.axial_mm;
        let (up, down) = ((z + h) / a, (z - h) / a);
        let (erf_up, exp_up) = erf_and_exp(up * SQRT_HALF);
        let (erf_down, exp_down) = erf_and_exp(down * SQRT_HALF);
        let (at_up, at_down) = (DENSITY * exp_up / a, DENSITY * exp_down / a);
        Self {
            value: 0.5 * (erf_up - erf_down),
            by_z: at_up - at_down,
            by_h: at_up + at_down,
            by_axial: down * at_down - up * at_up,
        }
    }

    /// The same as the mean over a slice, which is the difference of what is integrated once more, `t Phi(t/a) + a phi(t/a)`,
    /// whose derivatives by t and a are Phi and phi.
    fn of_box(z: f64, h: f64, blur: &Blur) -> Self {
        let (a, half) = (blur.axial_mm, 0.5 * blur.slice_mm);
        let mut chord = Self {
            value: 0.0,
            by_z: 0.0,
            by_h: 0.0,
            by_axial: 0.0,
        };
        for (end, edge) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
            let t = z + end * h + edge * half;
            let (erf, exp) = erf_and_exp(t / a * SQRT_HALF);
            let (below, density) = (0.5 * (1.0 + erf), DENSITY * exp);
            let sign = end * edge / blur.slice_mm;
            chord.value += sign * (t * below + a * density);
            chord.by_z += sign * below;
            chord.by_h += sign * end * below;
            chord.by_axial += sign * density;
        }
        chord
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The closed form where both deviations are equal, at the distance d from the centre.
    fn isotropic(r: f64, sigma: f64, d: f64) -> f64 {
        let phi = |x: f64| 0.5 * (1.0 + erf_and_exp(x * SQRT_HALF).0);
        let density = |x: f64| DENSITY * (-0.5 * x * x).exp();
        let [up, down] = [(r + d) / sigma, (r - d) / sigma];
        phi(up) + phi(down) - 1.0 - sigma / d * (density(down) - density(up))
    }

    #[test]
    fn agrees_with_the_closed_form_of_a_round_blur() {
        for (r, sigma, bound) in [
            (0.5, 0.5, 2e-6),
            (1.0, 0.45, 2e-6),
            (1.0, 1.5, 2e-6),
            (2.0, 0.4, 1e-5),
            (3.0, 0.5, 1e-5),
        ] {
            let blur = Blur {
                radius_mm: r,
                plane_mm: sigma,
                axial_mm: sigma,
                slice_mm: 0.0,
            };
            for i in 0..60 {
                let d = (f64::from(i) + 0.5) / 60.0 * (r + 4.0 * sigma);
                for angle in [0.0_f64, 0.4, 0.9, 1.5] {
                    let found = blur.value(d * angle.cos(), d * angle.sin());
                    let error = (found - isotropic(r, sigma, d)).abs();
                    assert!(error < bound, "r {r}, sigma {sigma}, d {d}, angle {angle}: {error:e}");
                }
            }
        }
    }

    #[test]
    fn a_box_is_the_mean_of_bells_over_a_slice() {
        let bell = Blur {
            radius_mm: 1.0,
            plane_mm: 0.5,
            axial_mm: 0.45,
            slice_mm: 0.0,
        };
        let slice = Blur { slice_mm: 3.0, ..bell };
        for i in 0..20 {
            let (rho, z) = (0.1 * f64::from(i), 0.2 * f64::from(i) - 1.5);
            let n = 3000;
            let part = |k: i32| bell.value(rho, z + 3.0 * ((f64::from(k) + 0.5) / f64::from(n) - 0.5));
            let mean = (0..n).map(part).sum::<f64>() / f64::from(n);
            // The error function is good to 1.5e-7; the antiderivative's terms are of up to 4 mm over 3 mm.
            assert!((slice.value(rho, z) - mean).abs() < 3e-6, "{i}");
        }
        assert!((slice.profile_mm() - (0.45_f64 * 0.45 + 0.75).sqrt()).abs() < 1e-12);
    }

    #[test]
    fn derivatives_are_those_of_finite_differences() {
        let step = 1e-4;
        for i in 0..200_u32 {
            let part = |k: u32| f64::from(i.wrapping_mul(k) >> 8 & 0xffff) / 65536.0;
            let blur = Blur {
                radius_mm: 0.4 + 1.6 * part(2_654_435_761),
                plane_mm: 0.4 + 0.5 * part(2_246_822_519),
                axial_mm: 0.4 + 1.2 * part(3_266_489_917),
                slice_mm: if i.is_multiple_of(2) {
                    0.0
                } else {
                    0.5 + 4.5 * part(2_246_822_507)
                },
            };
            let (rho, z) = (0.01 + 3.0 * part(668_265_263), 6.0 * part(374_761_393) - 3.0);
            let found = blur.at(rho, z);
            let difference = |f: &dyn Fn(f64) -> f64| (f(step) - f(-step)) / (2.0 * step);
            let pairs = [
                (found.by_rho, difference(&|e| blur.value(rho + e, z))),
                (found.by_z, difference(&|e| blur.value(rho, z + e))),
                (
                    found.by_radius,
                    difference(&|e| {
                        Blur {
                            radius_mm: blur.radius_mm + e,
                            ..blur
                        }
                        .value(rho, z)
                    }),
                ),
                (
                    found.by_plane,
                    difference(&|e| {
                        Blur {
                            plane_mm: blur.plane_mm + e,
                            ..blur
                        }
                        .value(rho, z)
                    }),
                ),
                (
                    found.by_axial,
                    difference(&|e| {
                        Blur {
                            axial_mm: blur.axial_mm + e,
                            ..blur
                        }
                        .value(rho, z)
                    }),
                ),
            ];
            for (which, (analytic, numeric)) in pairs.into_iter().enumerate() {
                // The special functions are good to 2e-7 each and the scales are tenths of a mm: a few 1e-6 per mm, and
                // their own kinks (1e-7 over a step of 1e-4) a few 1e-4 at worst.
                assert!(
                    (analytic - numeric).abs() < 5e-4,
                    "case {i}, {which}: {analytic} {numeric}"
                );
            }
        }
    }
}
