//! Integrals along a line, and where a function of one number vanishes.

use super::super::field::Bounds;

/// Points and weights on `[0, 1]`.
pub(in super::super) fn gauss(points: usize) -> &'static [(f64, f64)] {
    const ONE: [(f64, f64); 1] = [(0.5, 1.0)];
    const TWO: [(f64, f64); 2] = [(0.211_324_865_405_187_13, 0.5), (0.788_675_134_594_812_9, 0.5)];
    const THREE: [(f64, f64); 3] = [
        (0.112_701_665_379_258_31, 5.0 / 18.0),
        (0.5, 4.0 / 9.0),
        (0.887_298_334_620_741_7, 5.0 / 18.0),
    ];
    const FOUR: [(f64, f64); 4] = [
        (0.069_431_844_202_973_71, 0.173_927_422_568_726_93),
        (0.330_009_478_207_571_87, 0.326_072_577_431_273_07),
        (0.669_990_521_792_428_1, 0.326_072_577_431_273_07),
        (0.930_568_155_797_026_3, 0.173_927_422_568_726_93),
    ];
    const FIVE: [(f64, f64); 5] = [
        (0.046_910_077_030_668_02, 0.118_463_442_528_094_54),
        (0.230_765_344_947_158_46, 0.239_314_335_249_683_23),
        (0.5, 0.284_444_444_444_444_44),
        (0.769_234_655_052_841_6, 0.239_314_335_249_683_23),
        (0.953_089_922_969_332, 0.118_463_442_528_094_54),
    ];
    // Of `n` points the rule is exact to degree `2 n - 1`; more than five gain nothing beside the boxes' own size.
    match points {
        0 | 1 => &ONE,
        2 => &TWO,
        3 => &THREE,
        4 => &FOUR,
        _ => &FIVE,
    }
}

/// Gauss points of the parts between stops.
pub(super) fn pieces(stops: &mut [f64], gauss: &[(f64, f64)]) -> Vec<(f64, f64)> {
    stops.sort_unstable_by(f64::total_cmp);
    let mut points = Vec::new();
    for pair in stops.windows(2) {
        let length = pair[1] - pair[0];
        if length > 0.0 {
            points.extend(gauss.iter().map(|(x, w)| (pair[0] + length * x, length * w)));
        }
    }
    points
}

/// A place, and the function's value there.
type Valued = (f64, f64);

/// Halving needs 55 values at most; the worst function tried, one of the ninth order, takes fewer than 130.
const MOST_VALUES: u32 = 200;

/// Where a function changes its sign between two places at which its signs differ, to the last digits of the places: a parabola through the
/// last three places where it rises or falls between them, half of what is left elsewhere (Chandrupatla 1997, A new hybrid
/// quadratic/bisection algorithm for finding the zero of a nonlinear function without using derivatives, Advances in Engineering
/// Software 28). Smooth functions take six values, and the secant with forced halvings took 44.
pub(super) fn root(value: &mut impl FnMut(f64) -> f64, [low, high]: Bounds, [at_low, at_high]: Bounds) -> f64 {
    let small = 4.0 * f64::EPSILON * low.abs().max(high.abs()).max(high - low);
    if at_low == 0.0 {
        return low;
    }
    // The root lies between `a`, the newest place, and `b`.
    let (mut a, mut b) = ((low, at_low), (high, at_high));
    let mut part = 0.5;
    for _ in 0..MOST_VALUES {
        if b.1 == 0.0 || (b.0 - a.0).abs() <= small {
            break;
        }
        let x = a.0 + part * (b.0 - a.0);
        let new = (x, value(x));
        let before = if (new.1 < 0.0) == (a.1 < 0.0) {
            a
        } else {
            std::mem::replace(&mut b, a)
        };
        a = new;
        if a.1 == 0.0 {
            return a.0;
        }
        // A step beyond the root, however near it is, closes the other side.
        let least = (small / (b.0 - a.0).abs()).min(0.5);
        part = next(a, b, before).max(least).min(1.0 - least);
    }
    if b.1.abs() < a.1.abs() { b.0 } else { a.0 }
}

/// The part of the way from `a` to `b`, on either side of the root, at which to look next; `c` is the place before.
fn next(a: Valued, b: Valued, c: Valued) -> f64 {
    let along = (a.0 - b.0) / (c.0 - b.0);
    let risen = (a.1 - b.1) / (c.1 - b.1);
    // The parabola of the place by the value turns nowhere between them.
    let is_monotone = risen * risen < along && (1.0 - risen).powi(2) < 1.0 - along;
    if !is_monotone {
        return 0.5;
    }
    let towards_b = a.1 / (b.1 - a.1) * c.1 / (b.1 - c.1);
    let towards_c = (c.0 - a.0) / (b.0 - a.0) * a.1 / (c.1 - a.1) * b.1 / (c.1 - b.1);
    towards_b + towards_c
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The root, how many values it took, and whether all of them lay between the ends.
    fn found(f: impl Fn(f64) -> f64, ends: Bounds) -> (f64, u32) {
        let mut count = 0;
        let mut value = |x: f64| {
            assert!((ends[0]..=ends[1]).contains(&x), "{x} is not in {ends:?}");
            count += 1;
            f(x)
        };
        let root = root(&mut value, ends, ends.map(&f));
        assert!((ends[0]..=ends[1]).contains(&root));
        (root, count)
    }

    /// A function with its root at 0, and how many values it may take to find it.
    type Shape = (fn(f64) -> f64, u32);

    /// Planted roots, in the middle and as near to an end as can be, of functions that are straight, curved, flat about the root, steep or
    /// broken there, of any size.
    #[test]
    fn planted_roots_are_found_to_the_last_digits() {
        let shapes: [Shape; 8] = [
            (|x| x, 8),
            (|x| x * (1.0 + 0.3 * x + 0.2 * x * x), 14),
            (|x| x.exp_m1(), 16),
            (|x| 1e-150 * x, 8),
            (|x| x.atan() * 1e150, 20),
            (|x| x.cbrt(), 60),
            (|x| if x < 0.0 { -1.0 } else { 1.0 }, 60),
            (|x| if x < 0.0 { -1e-300 } else { 1e300 }, 60),
        ];
        let parts = [0.5, 0.3, 0.77, 1e-3, 1.0 - 1e-3, 1e-9, 1.0 - 1e-12];
        for (number, (shape, most)) in shapes.into_iter().enumerate() {
            for [low, high] in [[0.0, 3.0], [30.0, 33.0], [-1.0, 1e-3], [-500.0, -499.0]] {
                for part in parts {
                    let planted = low + part * (high - low);
                    let (x, count) = found(|x| shape(x - planted), [low, high]);
                    // Places are rounded to this, and the difference from the planted root once more.
                    let bound = 8.0 * f64::EPSILON * low.abs().max(high.abs());
                    assert!((x - planted).abs() <= bound, "shape {number}: {x} for {planted}");
                    assert!(count <= most, "shape {number}, {planted}: {count} values");
                }
            }
        }
    }

    /// A root at an end is that end; one of the ninth order is as sharp as its values are.
    #[test]
    fn roots_at_ends_and_flat_ones_are_found() {
        assert_eq!(found(|x| x - 2.0, [2.0, 3.0]), (2.0, 0));
        assert_eq!(found(|x| x - 3.0, [2.0, 3.0]), (3.0, 0));
        let (x, count) = found(|x| (x - 1.0).powi(9), [0.0, 2.5]);
        assert!((x - 1.0).abs() < 1e-15 && count < 130, "{x} after {count}");
    }
}
