//! The filters along one axis: weights of the voxels about a point, in f64. In three dimensions their product is taken.
//!
//! For a point at fraction t (0 <= t < 1) behind voxel i, weight k belongs to voxel i + k + [`first_tap`]. All of them sum
//! to 1. Sources: Catmull-Rom: Keys 1981 (cubic convolution, a = -1/2); B-spline: Unser, Aldroubi and Eden 1993; Lanczos
//! window: Duchon 1979.

use scene::Filter;

/// The most taps along one axis.
pub(super) const MAX_TAPS: usize = 10;

/// The voxel of the first weight, relative to the one before the point.
pub(super) fn first_tap(filter: Filter) -> i64 {
    // The nearest voxel has one tap, whose half would put it one voxel on.
    1 - (filter.taps() as i64 / 2).max(1)
}

/// The weights of `filter` at fraction `t`; those after its last tap are zero.
pub(super) fn weights(filter: Filter, t: f64) -> [f64; MAX_TAPS] {
    let mut w = [0.0; MAX_TAPS];
    match filter {
        Filter::Nearest => w[0] = 1.0,
        Filter::Linear => w[..2].copy_from_slice(&[1.0 - t, t]),
        Filter::Cubic => w[..4].copy_from_slice(&cubic(t)),
        Filter::BSpline => w[..4].copy_from_slice(&b_spline(t)),
        Filter::Sinc3 => lanczos(3, t, &mut w),
        Filter::Sinc5 => lanczos(5, t, &mut w),
    }
    w
}

/// Along one axis, in a volume of values up to one: the largest sum of a filter's absolute weights (its Lebesgue
/// constant; for the B-spline the 3 of its prefilter) and the largest sum of their absolute slopes, per voxel.
const fn largest_sums(filter: Filter) -> [f64; 2] {
    match filter {
        Filter::Nearest => [1.0, 0.0],
        Filter::Linear => [1.0, 2.0],
        // At 1/2: -1/16, 9/16, 9/16, -1/16.
        Filter::Cubic => [1.25, 3.0],
        // The inverse of (1, 4, 1) / 6 has the norm 6 / (4 - 2); the weights themselves are positive and sum to 1.
        Filter::BSpline => [3.0, 3.0 * 1.5],
        Filter::Sinc3 => [1.5435, 3.164],
        Filter::Sinc5 => [1.8636, 3.439],
    }
}

/// The largest result in a volume of values up to one in magnitude.
pub(super) fn gain(filter: Filter) -> f64 {
    largest_sums(filter)[0].powi(3)
}

/// How much a result changes at most in such a volume, per voxel of index error on all three axes together.
pub(super) fn steepness(filter: Filter) -> f64 {
    let [sum, slope] = largest_sums(filter);
    3.0 * slope * sum * sum
}

fn cubic(t: f64) -> [f64; 4] {
    let s = 1.0 - t;
    [
        -0.5 * t * s * s,
        1.0 + t * t * (1.5 * t - 2.5),
        1.0 + s * s * (1.5 * s - 2.5),
        -0.5 * s * t * t,
    ]
}

fn b_spline(t: f64) -> [f64; 4] {
    let s = 1.0 - t;
    [
        s * s * s / 6.0,
        2.0 / 3.0 - t * t * (2.0 - t) / 2.0,
        2.0 / 3.0 - s * s * (2.0 - s) / 2.0,
        t * t * t / 6.0,
    ]
}

/// `sinc(x) sinc(x / a)` at the 2 a voxels about the point, divided by their sum so that a constant stays one.
fn lanczos(a: i32, t: f64, w: &mut [f64; MAX_TAPS]) {
    let mut sum = 0.0;
    for (k, weight) in (1 - a..=a).zip(w.iter_mut()) {
        let x = t - f64::from(k);
        *weight = sinc(x) * sinc(x / f64::from(a));
        sum += *weight;
    }
    w.iter_mut().for_each(|weight| *weight /= sum);
}

/// `sin(pi x) / (pi x)`, exactly 0 at whole numbers other than 0.
fn sinc(x: f64) -> f64 {
    if x == 0.0 {
        return 1.0;
    }
    // The sine of a rounded multiple of pi is some 1e-16, but a voxel's centre must give that voxel alone.
    if x == x.round() {
        return 0.0;
    }
    let angle = std::f64::consts::PI * x;
    angle.sin() / angle
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn sums_are_one_and_mirror_images_agree(t in 0.0..1.0_f64) {
            for filter in Filter::ALL {
                let (w, mirrored) = (weights(filter, t), weights(filter, 1.0 - t));
                let taps = filter.taps();
                // Ten terms, each good to a few ulp of at most 1.
                prop_assert!((w.iter().sum::<f64>() - 1.0).abs() < 20.0 * f64::EPSILON, "{filter:?}");
                for k in 0..taps {
                    let off = (w[k] - mirrored[taps - 1 - k]).abs();
                    // 1 - t rounds by half an ulp, which sine at pi makes 16 at most.
                    prop_assert!(off < 32.0 * f64::EPSILON, "{filter:?} {k} {off}");
                }
            }
        }

        #[test]
        fn polynomials_of_the_filters_degree_come_back(t in 0.0..1.0_f64) {
            let moment = |filter: Filter, power: i32| -> f64 {
                let at = |k: usize| (k as i64 + first_tap(filter)) as f64;
                (0..filter.taps()).map(|k| weights(filter, t)[k] * at(k).powi(power)).sum()
            };
            // Lines for linear and B-spline, parabolas for Catmull-Rom.
            for (filter, degree) in [(Filter::Linear, 1), (Filter::BSpline, 1), (Filter::Cubic, 2)] {
                for power in 0..=degree {
                    prop_assert!((moment(filter, power) - t.powi(power)).abs() < 40.0 * f64::EPSILON, "{filter:?} {power}");
                }
            }
        }
    }

    /// The constants of the error bounds, swept: no phase is above them, and some come within a thousandth.
    #[test]
    fn sums_of_weights_and_slopes_are_the_largest() {
        const PHASES: u32 = 20_000;
        const STEP: f64 = 1e-6;
        for filter in Filter::ALL {
            let prefilter = if filter == Filter::BSpline { 3.0 } else { 1.0 };
            let (mut sum, mut slope) = (0.0_f64, 0.0_f64);
            for i in 0..PHASES {
                let t = f64::from(i) / f64::from(PHASES) * (1.0 - STEP);
                let (a, b) = (weights(filter, t), weights(filter, t + STEP));
                sum = sum.max(prefilter * a.iter().map(|w| w.abs()).sum::<f64>());
                let changes = a.iter().zip(b).map(|(a, b)| (b - a).abs());
                slope = slope.max(prefilter * changes.sum::<f64>() / STEP);
            }
            for (found, stated) in [sum, slope].into_iter().zip(largest_sums(filter)) {
                // Differences over 1e-6 of weights good to 1e-15 are good to 1e-8.
                assert!(
                    found <= stated + 1e-8 && found >= 0.999 * stated,
                    "{filter:?}: {found}, {stated}"
                );
            }
        }
    }

    #[test]
    fn interpolators_give_the_voxel_at_a_voxel() {
        for filter in [Filter::Linear, Filter::Cubic, Filter::Sinc3, Filter::Sinc5] {
            let mut expected = [0.0; MAX_TAPS];
            expected[(-first_tap(filter)) as usize] = 1.0;
            assert_eq!(weights(filter, 0.0), expected, "{filter:?}");
        }
    }
}
