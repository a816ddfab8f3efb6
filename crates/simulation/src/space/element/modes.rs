//! The functions that the measure of volume is projected on.

use nalgebra::Vector3;

use super::Point;

/// The space that `theta` is projected on in each element, in the mean square by its own quadrature.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dilatation {
    /// No projection: locks near incompressibility.
    Plain,
    /// Constants: for 8 nodes.
    Constant,
    /// Linear functions of the reference position: for 27 nodes.
    Linear,
}

/// Functions at most.
pub(in crate::space) const MODES: usize = 4;

/// Below this part of the largest extent of the points, an extent is none.
const FLAT: f64 = 1e-10;
/// Below this part of their distance from the origin it is rounding.
const ROUNDING: f64 = 1e-14;

/// Functions orthonormal in the mean over the points: `sum_p w_p b_i(p) b_j(p) / sum_p w_p` is 1 for `i = j`, else 0; the
/// first is 1. They do not change with the unit of length, to the last bit where that is a power of two. Functions that the points
/// cannot tell from those before them are left out. For each point [`MODES`] numbers, of which
/// the first so many count as the second result says; the others are 0.
pub(super) fn orthonormal(points: &[Point], dilatation: Dilatation) -> (Vec<[f64; MODES]>, usize) {
    let mut kept: Vec<Vec<f64>> = Vec::new();
    if dilatation != Dilatation::Plain {
        // Of length 1 as it is, since the mean of 1 is 1 whatever the weights.
        kept.push(vec![1.0; points.len()]);
    }
    if dilatation == Dilatation::Linear {
        add_linear(points, &mut kept);
    }
    let mut modes = vec![[0.0; MODES]; points.len()];
    for (mode, values) in kept.iter().enumerate() {
        for (point, value) in values.iter().enumerate() {
            modes[point][mode] = *value;
        }
    }
    (modes, kept.len())
}

/// Gram-Schmidt of the three coordinates, the longest rest first.
fn add_linear(points: &[Point], kept: &mut Vec<Vec<f64>>) {
    let volume: f64 = points.iter().map(|p| p.weight).sum();
    // About the centre, so that coordinates far from the origin keep the digits of their differences.
    let centre = points.iter().map(|p| p.at * (p.weight / volume)).sum::<Vector3<f64>>();
    let farthest = points.iter().map(|p| p.at.amax()).fold(0.0, f64::max);
    let coordinate = |axis: usize| points.iter().map(|p| p.at[axis] - centre[axis]).collect::<Vec<f64>>();
    let mut rest: Vec<Vec<f64>> = (0..3).map(coordinate).collect();
    let inner = |x: &[f64], y: &[f64]| inner(points, x, y) / volume;
    let norm = |x: &[f64]| inner(x, x).sqrt();
    let largest = rest.iter().map(|x| norm(x)).fold(0.0, f64::max);
    // Two measures: a cloud is flat beside its own extent, and a tiny one far away is lost in rounding.
    let least = (FLAT * largest).max(ROUNDING * farthest);
    while !rest.is_empty() {
        // Twice: the second round takes off what rounding left in the first.
        for x in &mut rest {
            for other in kept.iter().chain(kept.iter()) {
                let part = inner(x, other);
                x.iter_mut().zip(other).for_each(|(x, other)| *x -= part * other);
            }
        }
        let lengths: Vec<f64> = rest.iter().map(|x| norm(x)).collect();
        let longest = (0..rest.len()).fold(0, |a, b| if lengths[b] > lengths[a] { b } else { a });
        let length = lengths[longest];
        // False where it is not a number.
        let told_apart = length > least;
        if !told_apart {
            break;
        }
        // The longest goes first, as divided by its length it has the least rounding to hand on.
        let mut next = rest.swap_remove(longest);
        next.iter_mut().for_each(|x| *x /= length);
        kept.push(next);
    }
}

/// `sum_p w_p x_p y_p`.
fn inner(points: &[Point], x: &[f64], y: &[f64]) -> f64 {
    points.iter().zip(x).zip(y).map(|((p, x), y)| p.weight * x * y).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(count: usize, at: impl Fn(usize) -> Vector3<f64>) -> Vec<Point> {
        let point = |k: usize| Point {
            weight: 0.3 + (k % 3) as f64,
            at: at(k),
            slopes: Vec::new(),
        };
        (0..count).map(point).collect()
    }

    fn scattered(k: usize) -> Vector3<f64> {
        let k = k as f64;
        Vector3::new((1.7 * k).sin(), (2.3 * k).cos(), (0.9 * k * k).sin())
    }

    #[test]
    fn functions_are_orthonormal_and_degenerate_ones_are_left_out() {
        let (a, b) = (Vector3::new(1.0, 0.3, -0.2), Vector3::new(0.1, -0.5, 0.7));
        let flat = move |k: usize| a * scattered(k).x + b * scattered(k).y;
        // Four points span no more than four functions, two a line.
        let clouds = [
            (points(20, scattered), 4),
            (points(20, move |k| flat(k) + Vector3::repeat(1e3)), 3),
            (points(20, move |k| a * scattered(k).z), 2),
            (points(20, move |_| a), 1),
            (points(1, scattered), 1),
            (points(2, scattered), 2),
            (points(3, scattered), 3),
            (points(20, |k| scattered(k) * 1e-6), 4),
            (
                points(20, |k| scattered(k).component_mul(&Vector3::new(1.0, 1e-8, 1.0))),
                4,
            ),
            (
                points(20, |k| scattered(k).component_mul(&Vector3::new(1.0, 1e-12, 1.0))),
                3,
            ),
        ];
        for (which, (cloud, expected)) in clouds.iter().enumerate() {
            let (modes, count) = orthonormal(cloud, Dilatation::Linear);
            assert_eq!(count, *expected, "cloud {which}");
            let column = |mode: usize| modes.iter().map(|m| m[mode]).collect::<Vec<f64>>();
            for i in 0..MODES {
                for j in 0..MODES {
                    let volume: f64 = cloud.iter().map(|p| p.weight).sum();
                    let product = inner(cloud, &column(i), &column(j)) / volume;
                    let exact = if i == j && i < count { 1.0 } else { 0.0 };
                    assert!((product - exact).abs() < 1e-13, "cloud {which}: {i} {j} {product}");
                }
            }
        }
        assert_eq!(orthonormal(&clouds[0].0, Dilatation::Plain).1, 0);
        assert_eq!(orthonormal(&clouds[0].0, Dilatation::Constant).1, 1);
    }
}
