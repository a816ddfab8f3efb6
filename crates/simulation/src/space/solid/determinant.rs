//! Bounds of the determinant of the deformation gradient between the points of a cube of 27 nodes.
//!
//! In a cube each entry of `F` is a polynomial of degree 2 at most along each axis, so `det F` is one of degree 6 at most. The
//! coefficients of a polynomial in Bernstein's basis bound it on the cube, those at the corners are its values there, and both
//! come close to one another where the cube is halved (de Casteljau; Johnen, Remacle and Geuzaine 2013 for the Jacobians of
//! curved elements).

use nalgebra::Matrix3;

/// Bernstein coefficients of one degree along each axis, x fastest.
type Coefficients = Vec<f64>;

/// Binomials of degree 2, 4 and 6.
const TWO: [f64; 3] = [1.0, 2.0, 1.0];
const FOUR: [f64; 5] = [1.0, 4.0, 6.0, 4.0, 1.0];
const SIX: [f64; 7] = [1.0, 6.0, 15.0, 20.0, 15.0, 6.0, 1.0];

/// Parts of a cube that are looked at before bounds count as they are.
const MOST_PARTS: usize = 2000;

/// Bounds of the least value of a polynomial on a cube, up to the rounding of its coefficients.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Least {
    /// It is nowhere less.
    pub(super) lower: f64,
    /// It is so low somewhere.
    pub(super) reached: f64,
}

/// Of `det F` on a cube of this side with these displacements of its nodes. The cube is halved until both bounds are within
/// `near`, the lower one is above zero, or `depth` halvings of a part were made.
pub(super) fn least(u: &[[f64; 3]], side: f64, near: f64, depth: u32) -> Least {
    let mut waiting = vec![(determinant(u, side), depth)];
    let mut looked_at = 0;
    let mut found = Least {
        lower: f64::INFINITY,
        reached: f64::INFINITY,
    };
    while let Some((part, depth)) = waiting.pop() {
        let lower = smallest(part.iter().copied());
        let corners = (0..8).map(|k| {
            part[[0, 1, 2]
                .iter()
                .map(|axis| 6 * 7_usize.pow(*axis) * (k >> axis & 1))
                .sum::<usize>()]
        });
        found.reached = smallest([found.reached, smallest(corners)].into_iter());
        // Not where it is no number: such a cube has no bound.
        let good = lower > 0.0 || lower >= found.reached - near;
        looked_at += 1;
        if good || depth == 0 || lower.is_nan() || looked_at > MOST_PARTS {
            found.lower = smallest([found.lower, lower].into_iter());
        } else {
            waiting.extend(halved(&part).into_iter().map(|part| (part, depth - 1)));
        }
    }
    found
}

/// The least; what is no number stays.
fn smallest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(f64::INFINITY, |a, b| if a.is_nan() || b >= a { a } else { b })
}

/// `det F` in degree 6.
fn determinant(u: &[[f64; 3]], side: f64) -> Coefficients {
    let f = gradient(u, side);
    let minor = |i: usize, j: usize, k: usize, l: usize| {
        let (mut one, other) = (
            product::<3, 3, 5>(&f[i], &f[j], [&TWO, &TWO, &FOUR]),
            product::<3, 3, 5>(&f[k], &f[l], [&TWO, &TWO, &FOUR]),
        );
        one.iter_mut().zip(other).for_each(|(a, b)| *a -= b);
        one
    };
    // Along the first row: entries are numbered row by row.
    let minors = [minor(4, 8, 5, 7), minor(5, 6, 3, 8), minor(3, 7, 4, 6)];
    let mut sum = vec![0.0; 343];
    for (minor, entry) in minors.iter().zip(&f) {
        let part = product::<5, 3, 7>(minor, entry, [&FOUR, &TWO, &SIX]);
        sum.iter_mut().zip(part).for_each(|(a, b)| *a += b);
    }
    sum
}

/// Whether `det F` is above zero everywhere on the cube, as far as bounds prove that.
pub(super) fn is_positive(u: &[[f64; 3]], side: f64, near: f64, depth: u32) -> bool {
    is_near_one(&gradient(u, side)) || least(u, side, near, depth).lower > 0.0
}

/// Whether `det F` is above zero at all of these places of a cube, from -1 to 1 along each axis; nothing is said of what lies between, but for a cube of which
/// all is proved.
pub(super) fn is_positive_at(u: &[[f64; 3]], side: f64, places: impl Iterator<Item = [f64; 3]>) -> bool {
    let f = gradient(u, side);
    let bernstein = |x: f64| {
        let [low, high] = [0.5 * (1.0 - x), 0.5 * (1.0 + x)];
        [low * low, 2.0 * low * high, high * high]
    };
    // Most cubes are bent so little that no place needs to be looked at.
    is_near_one(&f)
        || places.into_iter().all(|place| {
            let [x, y, z] = place.map(bernstein);
            let weights: [f64; 27] = std::array::from_fn(|k| x[k % 3] * y[k / 3 % 3] * z[k / 9]);
            let at = |entry: &Coefficients| weights.iter().zip(entry).map(|(w, f)| w * f).sum::<f64>();
            // What is no number is not above zero.
            Matrix3::from_fn(|i, j| at(&f[3 * i + j])).determinant() > 0.0
        })
}

/// Whether `F M^-1` is nearer to 1 than 1, with `M` the mean of the coefficients: it then has an inverse everywhere, on the line to 1
/// as well, and so `det F` has the sign of `det M`, above zero. All of `F` is between its coefficients: one norm of each is enough.
fn is_near_one(f: &[Coefficients]) -> bool {
    let at = |place: usize| Matrix3::from_fn(|i, j| f[3 * i + j][place]);
    let mean = (0..27).map(at).sum::<Matrix3<f64>>() / 27.0;
    let off = |inverse: &Matrix3<f64>, place: usize| (at(place) * inverse - Matrix3::identity()).norm();
    mean.determinant() > 0.0
        && mean
            .try_inverse()
            .is_some_and(|inverse| (0..27).all(|place| off(&inverse, place) < 1.0 - 1e-9))
}

/// The nine entries of `F`, row by row, in degree 2.
fn gradient(u: &[[f64; 3]], side: f64) -> Vec<Coefficients> {
    let mut entries = vec![vec![0.0; 27]; 9];
    for (k, entry) in entries.iter_mut().enumerate() {
        let (row, step) = (k / 3, [1, 3, 9][k % 3]);
        let identity = if k % 4 == 0 { 1.0 } else { 0.0 };
        // Of a parabola by its values at -1, 0 and 1, at these places.
        for first in (0..27_usize).filter(|place| (place / step).is_multiple_of(3)) {
            let [low, middle, high] = [0, 1, 2].map(|i| u[first + i * step][row]);
            let (half, bend) = (0.5 * (high - low), low - 2.0 * middle + high);
            for (i, slope) in [half - bend, half, half + bend].into_iter().enumerate() {
                entry[first + i * step] = slope * (2.0 / side) + identity;
            }
        }
    }
    // From values at -1, 0 and 1 along each axis.
    for entry in &mut entries {
        for axis in [1, 3, 9] {
            for first in (0..27_usize).filter(|k| (k / axis).is_multiple_of(3)) {
                let [low, high] = [entry[first], entry[first + 2 * axis]];
                entry[first + axis] = 2.0 * entry[first + axis] - 0.5 * (low + high);
            }
        }
    }
    entries
}

/// A product: `c_k = sum of B_i B_j / B_k a_i b_j` with `i + j = k` along each axis, `B` the binomials.
fn product<const A: usize, const B: usize, const C: usize>(
    a: &[f64],
    b: &[f64],
    binomials: [&[f64]; 3],
) -> Coefficients {
    let split = |k: usize, n: usize| [k % n, k / n % n, k / n / n];
    let weight = |of: &[f64], at: [usize; 3]| at.iter().map(|k| of[*k]).product::<f64>();
    let mut c = vec![0.0; C * C * C];
    for (i, a) in a.iter().enumerate() {
        let at = split(i, A);
        let scaled = a * weight(binomials[0], at);
        for (j, b) in b.iter().enumerate() {
            let other = split(j, B);
            let sum = [0, 1, 2].map(|k| at[k] + other[k]);
            c[sum[0] + C * (sum[1] + C * sum[2])] += scaled * b * weight(binomials[1], other);
        }
    }
    for (k, c) in c.iter_mut().enumerate() {
        *c /= weight(binomials[2], split(k, C));
    }
    c
}

/// The eight halves along all axes, degree 6.
fn halved(whole: &[f64]) -> Vec<Coefficients> {
    let mut parts = vec![whole.to_vec()];
    for axis in [1, 7, 49] {
        parts = parts.iter().flat_map(|part| halved_along(part, axis)).collect();
    }
    parts
}

/// De Casteljau's scheme at the middle.
fn halved_along(whole: &[f64], axis: usize) -> [Coefficients; 2] {
    let (mut low, mut high) = (whole.to_vec(), whole.to_vec());
    for first in (0..343).filter(|k| (k / axis).is_multiple_of(7)) {
        let mut line: [f64; 7] = std::array::from_fn(|k| whole[first + k * axis]);
        for step in 0..7 {
            low[first + step * axis] = line[0];
            high[first + (6 - step) * axis] = line[6 - step];
            for k in 0..6 - step {
                line[k] = 0.5 * (line[k] + line[k + 1]);
            }
        }
    }
    [low, high]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::space::element::shape::gradients_27;

    /// Nodes of a cube of side 2, displaced by a field.
    fn nodes(of: impl Fn([f64; 3]) -> [f64; 3]) -> Vec<[f64; 3]> {
        (0..27)
            .map(|k| of([k % 3, k / 3 % 3, k / 9].map(|i| i as f64 - 1.0)))
            .collect()
    }

    fn sampled(u: &[[f64; 3]], at: [f64; 3]) -> f64 {
        let mut f = nalgebra::Matrix3::identity();
        for (u, q) in u.iter().zip(gradients_27(at)) {
            f += nalgebra::Vector3::from(*u) * q.transpose();
        }
        f.determinant()
    }

    #[test]
    fn known_determinants_are_bounded_closely() {
        let stretched = nodes(|[x, y, z]| [0.1 * x, -0.2 * y, 0.3 * z + 0.5 * x]);
        let found = least(&stretched, 2.0, 1e-3, 8);
        assert!((found.lower - 1.1 * 0.8 * 1.3).abs() < 1e-14 && (found.reached - found.lower).abs() < 1e-14);
        // 1 - 2 c x along x alone: least at the end, where Gauss' points of 0.775 do not see it.
        let bent = nodes(|[x, _, _]| [-0.6 * x * x, 0.0, 0.0]);
        let found = least(&bent, 2.0, 1e-3, 8);
        assert!(
            (found.lower + 0.2).abs() < 1e-14 && (found.reached + 0.2).abs() < 1e-14,
            "{found:?}"
        );
        assert!(sampled(&bent, [0.774_596_669_241_483_4, 0.0, 0.0]) > 0.05);
        // 0.05 + 0.9 y^2: least in the middle, where no corner is; coefficients of the whole cube are below zero.
        let dipped = nodes(|[x, y, _]| [x * (0.9 * y * y - 0.95), 0.0, 0.0]);
        let found = least(&dipped, 2.0, 1e-3, 8);
        assert!(smallest(determinant(&dipped, 2.0).into_iter()) < 0.0);
        let near = |x: f64| (x - 0.05).abs() < 1e-14;
        assert!(
            found.lower > 0.0 && found.lower < 0.05 + 1e-14 && near(found.reached),
            "{found:?}"
        );
    }

    #[test]
    fn no_sample_is_below_the_bound_and_some_are_near() {
        let mut state = 1_u64;
        let mut next = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        let (mut inverted, mut proved) = (0, 0);
        for case in 0..60 {
            let size = 0.1 + 0.02 * f64::from(case);
            let u: Vec<[f64; 3]> = (0..27).map(|_| [size * next(), size * next(), size * next()]).collect();
            let found = least(&u, 2.0, 1e-3, 8);
            let place = |k: usize| [k % 21, k / 21 % 21, k / 441].map(|i| i as f64 / 10.0 - 1.0);
            let sample = (0..9261).map(|k| sampled(&u, place(k))).fold(f64::INFINITY, f64::min);
            assert!(
                found.lower <= sample + 1e-12 && found.lower <= found.reached,
                "{case}: {found:?} {sample}"
            );
            // Where it is not above zero it is known within what was asked for.
            assert!(
                found.lower > 0.0 || found.reached - found.lower <= 1e-3 + 1e-12,
                "{case}: {found:?}"
            );
            // Neither way of proving says what samples refute.
            assert!(!is_positive(&u, 2.0, 1e-3, 8) || sample > 0.0, "{case}");
            let places = (0..9261).map(place);
            assert_eq!(is_positive_at(&u, 2.0, places), sample > 0.0, "{case}");
            let quick = is_near_one(&gradient(&u, 2.0));
            assert!(!quick || found.lower > 0.0 && sample > 0.0, "{case}");
            proved += usize::from(quick);
            inverted += usize::from(found.reached < 0.0);
        }
        assert!(inverted > 10 && inverted < 50, "{inverted}");
        assert!(proved > 0 && proved < 60 - inverted, "{proved}");
    }
}
