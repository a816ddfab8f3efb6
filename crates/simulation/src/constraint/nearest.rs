//! The nearest point of a quadratic arc.

use nalgebra::Vector2;

use crate::q9::shape::line;

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
const STARTS_PER_ARC: u32 = 8;
/// Seven times its square is below the rounding of the parameter.
const SMALL_CHANGE: f64 = 3e-9;

pub(super) fn combine(arc: &[Vector2<f64>; 3], weights: [f64; 3]) -> Vector2<f64> {
    arc[0] * weights[0] + arc[1] * weights[1] + arc[2] * weights[2]
}

/// Half the squared distance of a point to the arc's point `u`: a polynomial of degree 4, by its derivative.
struct Polynomial {
    /// Coefficients of the derivative, `<q - p, q'>`.
    slope: [f64; 4],
}

impl Polynomial {
    fn new(arc: &[Vector2<f64>; 3], point: Vector2<f64>) -> Self {
        // q(u) - p = c0 + c1 u + c2 u^2.
        let c0 = arc[1] - point;
        let c1 = (arc[2] - arc[0]) * 0.5;
        let c2 = (arc[0] - arc[1] * 2.0 + arc[2]) * 0.5;
        Self {
            slope: [
                c0.dot(&c1),
                c1.norm_squared() + 2.0 * c0.dot(&c2),
                3.0 * c1.dot(&c2),
                2.0 * c2.norm_squared(),
            ],
        }
    }

    /// Less its value at 0.
    fn value(&self, u: f64) -> f64 {
        let [a, b, c, d] = self.slope;
        u * (a + u * (b / 2.0 + u * (c / 3.0 + u * (d / 4.0))))
    }

    /// First and second derivative.
    fn derivatives(&self, u: f64) -> (f64, f64) {
        let [a, b, c, d] = self.slope;
        (a + u * (b + u * (c + u * d)), b + u * (2.0 * c + u * (3.0 * d)))
    }

    /// True where the second derivative is positive all along the arc: there is one near point.
    fn convex(&self) -> bool {
        // The second derivative is `b + 2 c u + 3 d u^2` with `d >= 0`: at least `b - 2 |c|` on the arc.
        self.slope[1] > 2.0 * self.slope[2].abs()
    }

    /// A change of the parameter after which Newton's method has nothing left to change. Where the second derivative is at least
    /// half of its value in the middle and the third no more than six times that, the next change is below 7 times its square.
    fn close(&self) -> f64 {
        let [_, b, c, d] = self.slope;
        if b > 4.0 * c.abs() && b > d {
            SMALL_CHANGE
        } else {
            4.0 * f64::EPSILON
        }
    }

    /// A bracket round the nearest point.
    fn bracket(&self) -> [f64; 2] {
        if self.convex() {
            return [-1.0, 1.0];
        }
        // Two minima may lie on one arc: from the best of nine places Newton's method is kept next to the lower one.
        let step = 2.0 / f64::from(STARTS_PER_ARC);
        let places = (0..=STARTS_PER_ARC).map(|k| f64::from(k) * step - 1.0);
        let best = places.min_by(|a, b| self.value(*a).total_cmp(&self.value(*b)));
        let best = best.unwrap_or(0.0);
        [(best - step).max(-1.0), (best + step).min(1.0)]
    }
}

/// The point of the arc `(1, 2, 3)` of II 3.14 nearest to `point`.
pub fn nearest(arc: &[Vector2<f64>; 3], point: Vector2<f64>) -> Nearest {
    let polynomial = Polynomial::new(arc, point);
    let u = root(&polynomial);
    let offset = point - combine(arc, line(u));
    Nearest {
        u,
        offset,
        distance: offset.norm(),
        inside: u.abs() < 1.0,
    }
}

/// The zero of the slope in its bracket, by Newton's method kept inside by bisection; an end where it has none.
fn root(polynomial: &Polynomial) -> f64 {
    let [mut low, mut high] = polynomial.bracket();
    if polynomial.derivatives(low).0 >= 0.0 {
        return low;
    }
    if polynomial.derivatives(high).0 <= 0.0 {
        return high;
    }
    // Without its higher terms the slope has its zero here.
    let guess = -polynomial.slope[0] / polynomial.slope[1];
    let mut u = if guess > low && guess < high {
        guess
    } else {
        0.5 * (low + high)
    };
    let close = polynomial.close();
    for _ in 0..60 {
        let (value, derivative) = polynomial.derivatives(u);
        if value > 0.0 {
            high = u
        } else {
            low = u
        }
        let newton = u - value / derivative;
        let inside = newton > low && newton < high;
        let next = if inside { newton } else { 0.5 * (low + high) };
        // What the slope's own rounding leaves.
        if (next - u).abs() <= if inside { close } else { 4.0 * f64::EPSILON } {
            return next;
        }
        u = next;
    }
    u
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::q9::shape::line_slope;

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
