//! Quantiles of numbers that are all at hand.

use std::cmp::Ordering;

/// The least of the values that the share `share` (0 to 1) of them does not exceed, by nearest rank; 0 where there is none.
/// NaN, of either sign, is larger than all numbers.
pub fn quantile(mut values: Vec<f64>, share: f64) -> f64 {
    let rank = (share * values.len() as f64).ceil() as usize;
    // A share beyond 0 to 1 means the ends; the upper bound is 1 where there is no value, as `clamp` panics below the
    // lower.
    let place = rank.clamp(1, values.len().max(1)) - 1;
    match values.get(place) {
        Some(_) => *values.select_nth_unstable_by(place, by_size).1,
        None => 0.0,
    }
}

/// The order of numbers, with every NaN at its end: 0 / 0 has its sign set on most processors, and `total_cmp` alone would
/// call that the least of all.
pub(crate) fn by_size(a: &f64, b: &f64) -> Ordering {
    a.is_nan().cmp(&b.is_nan()).then(a.total_cmp(b))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quantile_is_one_of_the_values() {
        let values = || (1..=20).rev().map(f64::from).collect::<Vec<_>>();
        for (share, found) in [
            (-1.0, 1.0),
            (0.0, 1.0),
            (0.05, 1.0),
            (0.0501, 2.0),
            (0.95, 19.0),
            (1.0, 20.0),
            (7.0, 20.0),
        ] {
            assert_eq!(quantile(values(), share), found, "{share}");
        }
        assert_eq!((quantile(Vec::new(), 0.5), quantile(vec![3.0], 0.01)), (0.0, 3.0));
        for nan in [f64::NAN, -f64::NAN] {
            assert_eq!(quantile(vec![nan, 1.0], 0.5), 1.0);
            assert_eq!(crate::median(vec![2.0, nan, 1.0]), 2.0);
        }
    }
}
