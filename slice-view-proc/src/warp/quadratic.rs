//! Functions on a cube that are quadratic along each axis, by their 27 values or by Bernstein's coefficients.
//!
//! Values run fastest along x, then y, then z, at -1, 0 and 1 of each axis.

/// Bernstein's coefficients from values: the function lies between the least and the largest of them everywhere in the cube.
#[inline]
pub(super) fn bernstein(values: &[f64; 27]) -> [f64; 27] {
    let mut b = *values;
    for (step, first) in LINES {
        for at in first {
            let [low, middle, high] = [b[at], b[at + step], b[at + 2 * step]];
            b[at + step] = 2.0 * middle - 0.5 * (low + high);
        }
    }
    b
}

/// The steps along each axis, and where its nine lines begin.
pub(super) const LINES: [(usize, [usize; 9]); 3] = [
    (1, [0, 3, 6, 9, 12, 15, 18, 21, 24]),
    (3, [0, 1, 2, 9, 10, 11, 18, 19, 20]),
    (9, [0, 1, 2, 3, 4, 5, 6, 7, 8]),
];

/// The coefficients on the lower and the upper half along an axis (de Casteljau).
#[inline]
pub(super) fn halves(b: &[f64; 27], axis: usize) -> [[f64; 27]; 2] {
    let (mut lower, mut upper) = (*b, *b);
    let (step, first) = LINES[axis];
    for at in first {
        let [low, middle, high] = [b[at], b[at + step], b[at + 2 * step]];
        let (left, right) = (0.5 * (low + middle), 0.5 * (middle + high));
        let centre = 0.5 * (left + right);
        (lower[at + step], lower[at + 2 * step]) = (left, centre);
        (upper[at], upper[at + step]) = (centre, right);
    }
    [lower, upper]
}

/// The three polynomials of an axis at `t` in [0, 1]: exactly 1 and 0 at the nodes, so that cubes that share a face share its values.
#[inline]
pub(super) fn weights(t: f64) -> [f64; 3] {
    [(1.0 - t) * (1.0 - 2.0 * t), 4.0 * t * (1.0 - t), t * (2.0 * t - 1.0)]
}

/// The value of three functions at once.
#[inline]
pub(super) fn at(values: &[[f64; 3]; 27], [x, y, z]: &[[f64; 3]; 3]) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for (k, z) in z.iter().enumerate() {
        for (j, y) in y.iter().enumerate() {
            let weight = z * y;
            for (i, x) in x.iter().enumerate() {
                let (value, weight) = (&values[9 * k + 3 * j + i], weight * x);
                for axis in 0..3 {
                    sum[axis] += weight * value[axis];
                }
            }
        }
    }
    sum
}

/// A bound of the second derivative along any direction over a cube of side 1: the root of the sum of squares of all of them.
pub(super) fn bend(values: &[[f64; 3]; 27]) -> f64 {
    let mut square = 0.0;
    for axis in 0..3 {
        let b = bernstein(&values.map(|value| value[axis]));
        for (p, (step, first)) in LINES.into_iter().enumerate() {
            let own = first.map(|at| 2.0 * (b[at] - 2.0 * b[at + step] + b[at + 2 * step]));
            square += largest(&own).powi(2);
            for (other, _) in &LINES[p + 1..] {
                square += 2.0 * mixed(&b, step, *other).powi(2);
            }
        }
    }
    square.sqrt()
}

/// The largest mixed derivative along two axes, by their steps.
fn mixed(b: &[f64; 27], one: usize, other: usize) -> f64 {
    let digit = |at: usize, step: usize| at / step % 3;
    let cells = (0..27).filter(|at| digit(*at, one) < 2 && digit(*at, other) < 2);
    let slopes = cells.map(|at| 4.0 * (b[at] - b[at + one] - b[at + other] + b[at + one + other]));
    slopes.fold(0.0, |most: f64, slope| most.max(slope.abs()))
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |most: f64, value| most.max(value.abs()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// x^2 y - 3 y z + z^2 with its second derivatives.
    fn sample([x, y, z]: [f64; 3]) -> f64 {
        x * x * y - 3.0 * y * z + z * z
    }

    fn nodes() -> [[f64; 3]; 27] {
        std::array::from_fn(|k| [k % 3, k / 3 % 3, k / 9].map(|i| i as f64 / 2.0))
    }

    #[test]
    fn values_coefficients_and_halves_are_of_one_function() {
        let values = nodes().map(|node| [sample(node), 1.0, node[2]]);
        let place = [0.3, 0.85, 0.6];
        let found = at(&values, &place.map(weights));
        assert!((found[0] - sample(place)).abs() < 1e-14);
        assert!((found[1] - 1.0).abs() < 1e-15 && (found[2] - 0.6).abs() < 1e-15);
        // Corners of Bernstein's coefficients are values: the upper half along x, then the lower along z.
        let b = bernstein(&values.map(|value| value[0]));
        let [_, upper] = halves(&b, 0);
        let [lower, _] = halves(&upper, 2);
        for (corner, place) in [
            (0, [0.5, 0.0, 0.0]),
            (2, [1.0, 0.0, 0.0]),
            (26, [1.0, 1.0, 0.5]),
            (24, [0.5, 1.0, 0.5]),
        ] {
            assert!((lower[corner] - sample(place)).abs() < 1e-15, "{corner}");
        }
        let least = b.iter().copied().fold(f64::INFINITY, f64::min);
        assert!((0..1000).all(|k| sample([k % 10, k / 10 % 10, k / 100].map(|i| i as f64 / 9.0)) >= least));
    }

    #[test]
    fn the_bend_bounds_all_second_derivatives_and_is_reached_where_they_are_constant() {
        // d2/dz2 = 2, d2/dydz = -3; x^2 y has 2 y (up to 2) and 2 x (up to 2).
        let values = nodes().map(|node| [sample(node), 0.0, 0.0]);
        let exact = (2.0_f64.powi(2) + 2.0_f64.powi(2) + 2.0 * (2.0_f64.powi(2) + 3.0_f64.powi(2))).sqrt();
        assert!((bend(&values) - exact).abs() < 1e-13, "{}", bend(&values));
        assert!(bend(&nodes()) < 1e-14);
    }

    #[test]
    fn a_face_has_the_same_bits_in_both_cubes() {
        let mut values = nodes().map(|[x, y, z]| [x.sin(), (y * z).exp(), x - y]);
        let face: Vec<[f64; 3]> = (0..9).map(|k| values[2 + 3 * k]).collect();
        let there = at(&values, &[1.0, 0.375, 0.8125].map(weights));
        values = nodes().map(|[x, y, z]| [y + 7.0, z - x, x * 1e3]);
        for k in 0..9 {
            values[3 * k] = face[k];
        }
        assert_eq!(there, at(&values, &[0.0, 0.375, 0.8125].map(weights)));
    }
}
