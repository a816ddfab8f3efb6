//! Whether two short arcs are apart, together, or still to be cut.
//!
//! In the frame of the second one's chord its points have a height `g(x)` that bends little, and the first one's point at `s`
//! stands `h(s) = y(s) - g(x(s))` over it. For any polynomial `t(s)` near the parameter of the point of the second below the
//! first's, with `m` the largest slope of `g`,
//!
//! `|h(s) - (y(s) - y_2(t(s)))| <= m |x_2(t(s)) - x(s)|`,
//!
//! and both brackets are polynomials of degree 4 in `s`, which lie between their least and largest Bernstein coefficient. With
//! `t` the parabola through the parameters at both ends and in the middle the right side falls with the fourth power of the
//! length: arcs that run along one another are told apart where neither is cut short. Of two that are the same it is zero.

use nalgebra::Vector2;

use super::bezier::Bezier;

/// The largest slope of the second over its chord that is looked at.
const MAX_SLOPE: f64 = 0.5;
/// Its parameter runs no slower along the chord than this part of the mean.
const MIN_SPEED: f64 = 0.25;
/// Parameters are looked at so much beyond those below the first arc, in their own range.
const BEYOND_PARAMETER: f64 = 0.1;

/// How two arcs lie.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Lie {
    /// Farther apart than about the tolerance.
    Apart,
    /// All of the first within twice the tolerance of the second, between these parameters of it.
    Together([f64; 2]),
    /// All of the first within twice the tolerance of the second, did it not go beyond an end of it.
    Beside,
    /// Neither is proved.
    Open,
}

/// The first arc in the frame of the second's chord, and what the second needs of it.
struct Frame {
    x: [f64; 3],
    y: [f64; 3],
    /// Where the second ends, and its control point.
    length: f64,
    control: [f64; 2],
}

fn least(values: &[f64]) -> f64 {
    values.iter().copied().fold(f64::INFINITY, f64::min)
}

fn most(values: &[f64]) -> f64 {
    values.iter().copied().fold(f64::NEG_INFINITY, f64::max)
}

/// True where two intervals are farther apart than the tolerance.
fn away(one: [f64; 2], other: [f64; 2], tolerance: f64) -> bool {
    one[0] - other[1] > tolerance || other[0] - one[1] > tolerance
}

impl Frame {
    /// `None` where the second has no chord.
    fn of(first: &Bezier, second: &Bezier) -> Option<Self> {
        let [start, control, end] = second.0;
        let length = (end - start).norm();
        // A NaN is not `<= 0` and would give a frame of NaN.
        if length.is_nan() || length <= 0.0 {
            return None;
        }
        let along = (end - start) / length;
        let across = Vector2::new(-along.y, along.x);
        let local = |p: Vector2<f64>| [along.dot(&(p - start)), across.dot(&(p - start))];
        let at = first.0.map(local);
        Some(Self {
            x: at.map(|p| p[0]),
            y: at.map(|p| p[1]),
            length,
            control: local(control),
        })
    }

    /// Told by the boxes of both in this frame.
    fn apart(&self, tolerance: f64) -> bool {
        let [x, y] = self.control;
        // The curve is half as high as its control point.
        let heights = [0.5 * y.min(0.0), 0.5 * y.max(0.0)];
        let along = [x.min(0.0), x.max(self.length)];
        away([least(&self.y), most(&self.y)], heights, tolerance)
            || away([least(&self.x), most(&self.x)], along, tolerance)
    }

    /// The parameter of the second where it passes `x`, on the side where it runs forwards.
    fn parameter(&self, x: f64) -> Option<f64> {
        let control = self.control[0];
        let root = (control * control + (self.length - 2.0 * control) * x).sqrt();
        // `x = 2 c t + (L - 2 c) t^2` by the form without cancellation, which also holds where `L = 2 c`. A negative
        // radicand becomes NaN: no such point.
        let t = x / (control + root);
        t.is_finite().then_some(t)
    }

    /// The lie by the heights of the first over the second.
    fn heights(&self, tolerance: f64) -> Option<Lie> {
        let ([control, rise], length) = (self.control, self.length);
        // Then the second runs backwards along its chord somewhere, and has no height there.
        if control <= 0.0 || control >= length {
            return None;
        }
        let middle = |v: &[f64; 3]| 0.25 * (v[0] + v[2]) + 0.5 * v[1];
        let [begin, half, end] = [self.x[0], middle(&self.x), self.x[2]].map(|x| self.parameter(x));
        let (begin, half, end) = (begin?, half?, end?);
        // A quadratic through the parameters at the ends and the middle: off by little where arcs are short, and by how much is
        // bounded below.
        let t = [begin, 2.0 * half - 0.5 * (begin + end), end];
        let room = BEYOND_PARAMETER * (most(&t) - least(&t)) + 16.0 * tolerance / length;
        let range = [least(&t) - room, most(&t) + room];
        // The derivative of `x_2` is linear in `t`, as is that of `y_2`: both are bounded by the ends of the range.
        let speed = 2.0 * least(&range.map(|t| control + (length - 2.0 * control) * t));
        let steep = 2.0 * most(&range.map(|t| (rise * (1.0 - 2.0 * t)).abs())) / speed;
        if speed < MIN_SPEED * length || steep.is_nan() || steep > MAX_SLOPE {
            return None;
        }
        let (once, twice) = (raised(&t), square(&t));
        let along = |k: usize| 2.0 * control * once[k] + (length - 2.0 * control) * twice[k];
        let height = |k: usize| 2.0 * rise * (once[k] - twice[k]);
        let (x, y) = (raised(&self.x), raised(&self.y));
        // What that parameter misses along the chord, times the slope, is what heights may be off by.
        let missed = (0..5).map(|k| (along(k) - x[k]).abs()).fold(0.0, f64::max);
        // The point below must lie within the range that slope and speed were bounded for.
        if missed > room * speed {
            return None;
        }
        let over: [f64; 5] = std::array::from_fn(|k| y[k] - height(k));
        let bound = [least(&over) - steep * missed, most(&over) + steep * missed];
        self.told(bound, tolerance)
    }

    fn told(&self, [low, high]: [f64; 2], tolerance: f64) -> Option<Lie> {
        if low > tolerance || high < -tolerance {
            return Some(Lie::Apart);
        }
        if low.abs().max(high.abs()) > 1.5 * tolerance {
            return None;
        }
        let ends = [least(&self.x), most(&self.x)];
        if ends[0] < -tolerance || ends[1] > self.length + tolerance {
            return Some(Lie::Beside);
        }
        let parameter = |x: f64| self.parameter(x.clamp(0.0, self.length));
        let (from, to) = (
            parameter(ends[0] - 2.0 * tolerance)?,
            parameter(ends[1] + 2.0 * tolerance)?,
        );
        Some(Lie::Together([from.clamp(0.0, 1.0), to.clamp(0.0, 1.0)]))
    }
}

/// Bernstein coefficients of degree 4 of a polynomial of degree 2.
fn raised([a, b, c]: &[f64; 3]) -> [f64; 5] {
    [*a, 0.5 * (a + b), (a + 4.0 * b + c) / 6.0, 0.5 * (b + c), *c]
}

/// And of its square.
fn square([a, b, c]: &[f64; 3]) -> [f64; 5] {
    [a * a, a * b, (2.0 * b * b + a * c) / 3.0, b * c, c * c]
}

/// How two arcs lie. Apart means by more than the tolerance over 1.12 (the slope of the second over its chord is at most 1/2).
pub(super) fn lie(first: &Bezier, second: &Bezier, tolerance: f64) -> Lie {
    let ([low, high], [from, to]) = (first.bounds(), second.bounds());
    if (low - to).sup(&(from - high)).max() > tolerance {
        return Lie::Apart;
    }
    // The box along the first's own chord tells of slanted ones.
    if Frame::of(second, first).is_some_and(|frame| frame.apart(tolerance)) {
        return Lie::Apart;
    }
    let Some(frame) = Frame::of(first, second) else {
        return Lie::Open;
    };
    if frame.apart(tolerance) {
        return Lie::Apart;
    }
    frame.heights(tolerance).unwrap_or(Lie::Open)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn numbers(mut state: u64) -> impl FnMut() -> f64 {
        move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        }
    }

    /// The least distance of a point of the first to the second, and the largest, among many.
    fn tried(first: &Bezier, second: &Bezier) -> [f64; 2] {
        let mut found = [f64::INFINITY, 0.0_f64];
        for k in 0..=200 {
            let p = first.at(f64::from(k) / 200.0);
            let each = (0..=400).map(|j| (second.at(f64::from(j) / 400.0) - p).norm());
            let distance = each.fold(f64::INFINITY, f64::min);
            found = [found[0].min(distance), found[1].max(distance)];
        }
        found
    }

    #[test]
    fn what_is_told_is_so_among_points_of_both() {
        let (mut next, mut apart, mut together) = (numbers(5), 0, 0);
        for _ in 0..4000 {
            let tolerance = 10.0_f64.powf(-1.5 + next());
            let mut place = |size: f64| Vector2::new(next(), next()) * size;
            let second = Bezier([place(1.0), place(1.0), place(1.0)]);
            let (mut first, about) = (Bezier([place(1.0), place(1.0), place(1.0)]), place(0.1));
            if next() > 0.0 {
                first = second.part([0.3 + 0.2 * next(), 0.7 + 0.2 * next()]);
                first.0.iter_mut().for_each(|p| *p += about * (0.5 * (1.0 + next())));
            }
            let [near, far] = tried(&first, &second);
            match lie(&first, &second, tolerance) {
                Lie::Apart => {
                    apart += 1;
                    assert!(near > tolerance / 1.12, "{first:?} {second:?} {tolerance}: {near}");
                }
                Lie::Together([from, to]) => {
                    together += 1;
                    // The second's points are tried 1/400 of up to 6 apart.
                    assert!(far < 2.0 * tolerance + 0.01, "{first:?} {second:?} {tolerance}: {far}");
                    let held = tried(&second.part([from, to]), &first);
                    assert!(from < to && held[0] < 2.0 * tolerance + 0.01);
                }
                Lie::Beside | Lie::Open => {}
            }
        }
        assert!(apart > 500 && together > 30, "{apart} {together}");
    }

    #[test]
    fn arcs_that_run_along_one_another_are_told_apart_whole() {
        // The same circle by arcs of 1/16, one a little larger and out of phase.
        let arc = |radius: f64, from: f64| {
            let [p, m, q] = [0.0, 0.1, 0.2].map(|by| Vector2::new(f64::cos(from + by), f64::sin(from + by)) * radius);
            Bezier([p, m * 2.0 - (p + q) * 0.5, q])
        };
        let (inner, outer) = (arc(1.0, 0.05), arc(1.0 + 1e-5, 0.0));
        assert_eq!(lie(&inner, &outer, 1e-12), Lie::Open);
        assert_eq!(lie(&inner.part([0.0, 0.7]), &outer, 1e-12), Lie::Apart);
        // One on itself, in parts that do not match: 1e-16 of its size apart.
        let one = arc(1.0, 0.0);
        let found = lie(&one.part([0.21, 0.33]), &one.part([0.1, 0.4]), 1e-15);
        assert!(
            matches!(found, Lie::Together([a, b]) if (a - 0.11 / 0.3).abs() < 1e-9 && (b - 0.23 / 0.3).abs() < 1e-9),
            "{found:?}"
        );
    }
}
