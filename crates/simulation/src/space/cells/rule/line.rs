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

/// Where a function changes its sign between two places at which its signs differ: the secant, in turns with halving
/// (Illinois), to the last digits of the places.
pub(super) fn root(
    value: &mut impl FnMut(f64) -> f64,
    [mut low, mut high]: Bounds,
    [mut at_low, mut at_high]: Bounds,
) -> f64 {
    let small = 4.0 * f64::EPSILON * low.abs().max(high.abs()).max(high - low);
    // A halving at least every third step: 3 x 53 of them leave nothing.
    for step in 0..160 {
        // A zero at an end is the root: the secant would never leave it, and the middle is somewhere else.
        if at_low == 0.0 {
            return low;
        }
        if at_high == 0.0 {
            return high;
        }
        if high - low <= small {
            break;
        }
        let secant = low - at_low * (high - low) / (at_high - at_low);
        let halved = step % 3 == 2 || !(secant > low && secant < high);
        let x = if halved { 0.5 * (low + high) } else { secant };
        let y = value(x);
        if y == 0.0 {
            return x;
        }
        if (y < 0.0) == (at_low < 0.0) {
            (low, at_low) = (x, y);
            // The end that stays counts for less, so that the secant moves it too.
            at_high *= 0.5;
        } else {
            (high, at_high) = (x, y);
            at_low *= 0.5;
        }
    }
    0.5 * (low + high)
}
