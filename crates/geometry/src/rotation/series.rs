//! Cosine, cardinal sine and arc tangent of the angles that rotations are made of, as polynomials in squares.
//!
//! The exponential needs cos(h) and sin(h) / h, the logarithm h / sin(h): even functions of the angle, so they are had from
//! its square without a root, without a division by a small number, and so without a special case near 0. The polynomials
//! are Chebyshev interpolants computed with 60 digits; what they leave out is stated beside each, and below 2^-59 of the
//! result. A library's sine and cosine reduce arguments of any size, which costs more than the whole of this.

/// Up to this squared half angle [`cos_sinc`] holds: a rotation vector of 3.2, a little above pi.
pub(crate) const MOST: f64 = 2.5625;

/// (cos(h) - 1 + y / 2) / y^2 and (sin(h) / h - 1) / y in y = h^2 up to [`MOST`]: to 2^-65 and 2^-60.
const COS_SINC: [[f64; 2]; 8] = [
    [0.041666666666666664, -0.16666666666666666],
    [-0.0013888888888888879, 0.00833333333333331],
    [2.4801587301577964e-05, -0.00019841269841251204],
    [-2.7557319221068934e-07, 2.755731921816451e-06],
    [2.087675654034631e-09, -2.505210749225692e-08],
    [-1.1470708296184496e-11, 1.6058969379736373e-10],
    [4.7777533779019735e-14, -7.643721844093792e-13],
    [-1.5203402141957486e-16, 2.7284054061717343e-15],
];

/// (atan(t) / t - 1) / z in z = t^2 up to 0.172: to 2^-59.
const ATAN: [f64; 12] = [
    -0.3333333333333333,
    0.19999999999999798,
    -0.14285714285658574,
    0.11111111105033467,
    -0.09090908747438506,
    0.07692296199967973,
    -0.06666421745351814,
    0.058788929347181634,
    -0.052301889934494805,
    0.04550384655278787,
    -0.034539518756678086,
    0.01625139658592304,
];

/// cos(h) and sin(h) / h for h^2 = `y`, 0 to [`MOST`]. Error: 1 ulp of 1, and what `y` is off by.
///
/// Both polynomials side by side, by Estrin's scheme: half the operations and a quarter of the waiting of Horner's.
#[inline]
pub(crate) fn cos_sinc(y: f64) -> [f64; 2] {
    let pair = |i: usize| [0, 1].map(|k| COS_SINC[i][k] + COS_SINC[i + 1][k] * y);
    let (y2, [a, b, c, d]) = (y * y, [pair(0), pair(2), pair(4), pair(6)]);
    let y4 = y2 * y2;
    let [p, q] = [0, 1].map(|k| (a[k] + b[k] * y2) + (c[k] + d[k] * y2) * y4);
    [(1.0 - 0.5 * y) + y2 * p, 1.0 + y * q]
}

/// The angle between a unit quaternion (s, u) and 1, divided by abs(u) and by abs(q), for s >= 0 and abs(u)^2 = `square`.
/// Error: 1.5 eps of itself. Where `square` underflows it is 1 / s all the same.
///
/// A quarter of the angle has the tangent abs(u) / d, d = 1 + s + sqrt(2 + 2 s), at most tan(pi / 8): twice the formula for
/// half an angle. Where the norm is 1 + e, d grows by 2.45 e to first order (2.41 at s = 0, 2.5 at s = 1).
#[inline]
pub(crate) fn arc(s: f64, square: f64) -> f64 {
    let e = 0.5 * ((s * s - 1.0) + square);
    let d = ((1.0 + s) + (2.0 + 2.0 * s).sqrt()) + 2.45 * e;
    // The tangent of a quarter of the angle is abs(u) r; the root of `square` is never taken, as z needs its square
    // only.
    let r = 1.0 / d;
    let z = square * (r * r);
    let arc = 4.0 * r * (1.0 + z * atan(z));
    // Never beyond a right angle: this bound is that at s = 0 to first order in the norm, and above the arc elsewhere.
    arc.min(std::f64::consts::FRAC_PI_2 * (1.5 - 0.5 * square))
}

/// The polynomial [`ATAN`].
#[inline]
fn atan(z: f64) -> f64 {
    let pair = |i: usize| ATAN[i] + ATAN[i + 1] * z;
    let (z2, [a, b, c, d, e, f]) = (z * z, [pair(0), pair(2), pair(4), pair(6), pair(8), pair(10)]);
    let z4 = z2 * z2;
    (a + b * z2) + z4 * ((c + d * z2) + z4 * (e + f * z2))
}
