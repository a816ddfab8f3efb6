//! The nearest point of a quadratic arc.

use nalgebra::Vector2;

use crate::q9::shape::{line, line_slope};

/// The nearest point of an arc.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Nearest {
    /// Where on the arc, from -1 to 1.
    pub u: f64,
    /// From the arc to the point.
    pub offset: Vector2<f64>,
    /// Its length.
    pub distance: f64,
    /// True where the foot lies inside the arc, so that `offset` is normal to it.
    pub inside: bool,
}

/// Steps of the search on either side of the best start: a quadratic arc has up to two near points.
const STARTS: u32 = 8;

pub(super) fn combine(arc: &[Vector2<f64>; 3], weights: [f64; 3]) -> Vector2<f64> {
    arc[0] * weights[0] + arc[1] * weights[1] + arc[2] * weights[2]
}

/// The point of the arc `(1, 2, 3)` of II 3.14 nearest to `point`.
pub fn nearest(arc: &[Vector2<f64>; 3], point: Vector2<f64>) -> Nearest {
    let offset = |u: f64| point - combine(arc, line(u));
    let places = (0..=STARTS).map(|k| f64::from(k) * 2.0 / f64::from(STARTS) - 1.0);
    let best = places.min_by(|a, b| offset(*a).norm_squared().total_cmp(&offset(*b).norm_squared()));
    let step = 2.0 / f64::from(STARTS);
    let best = best.unwrap_or(0.0);
    let u = root(arc, point, [(best - step).max(-1.0), (best + step).min(1.0)]);
    let to = offset(u);
    Nearest {
        u,
        offset: to,
        distance: to.norm(),
        inside: u.abs() < 1.0,
    }
}

/// The zero of `-<point - q, q'>` in a bracket, by Newton's method kept inside by bisection; an end where it has none.
fn root(arc: &[Vector2<f64>; 3], point: Vector2<f64>, [mut low, mut high]: [f64; 2]) -> f64 {
    let bend = arc[0] - arc[1] * 2.0 + arc[2];
    let slope = |u: f64| {
        let (q, dq) = (combine(arc, line(u)), combine(arc, line_slope(u)));
        ((q - point).dot(&dq), dq.norm_squared() + (q - point).dot(&bend))
    };
    if slope(low).0 >= 0.0 {
        return low;
    }
    if slope(high).0 <= 0.0 {
        return high;
    }
    let mut u = 0.5 * (low + high);
    for _ in 0..60 {
        let (value, derivative) = slope(u);
        if value > 0.0 {
            high = u
        } else {
            low = u
        }
        let newton = u - value / derivative;
        let next = if newton > low && newton < high {
            newton
        } else {
            0.5 * (low + high)
        };
        if (next - u).abs() <= f64::EPSILON {
            return next;
        }
        u = next;
    }
    u
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn agrees_with_trying_many_points() {
        let mut state = 5_u64;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        };
        for _ in 0..300 {
            let end = Vector2::new(2.0 + next(), next());
            let arc = [Vector2::zeros(), end * 0.5 + Vector2::new(next(), next()) * 0.3, end];
            let point = Vector2::new(1.0 + 2.0 * next(), 2.0 * next());
            let found = nearest(&arc, point);
            let tried = (0..=20_000).map(|k| {
                let q = combine(&arc, line(f64::from(k) * 1e-4 - 1.0));
                (point - q).norm()
            });
            let best = tried.fold(f64::INFINITY, f64::min);
            // The grid misses the foot by 5e-5 of the parameter at most: 1e-4 of length.
            assert!(
                found.distance <= best + 1e-12 && found.distance >= best - 2e-4,
                "{found:?} {best}"
            );
            if found.inside {
                let tangent = combine(&arc, line_slope(found.u));
                assert!(found.offset.dot(&tangent).abs() < 1e-12);
            }
        }
    }
}
