//! Quantiles of numbers that are all at hand.

/// The least of the values that the share `share` (0 to 1) of them does not exceed, by nearest rank; 0 where there is none.
/// NaN is larger than all numbers.
pub fn quantile(mut values: Vec<f64>, share: f64) -> f64 {
    let rank = (share * values.len() as f64).ceil() as usize;
    let place = rank.clamp(1, values.len().max(1)) - 1;
    match values.get(place) {
        Some(_) => *values.select_nth_unstable_by(place, f64::total_cmp).1,
        None => 0.0,
    }
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
        assert_eq!(quantile(vec![f64::NAN, 1.0], 0.5), 1.0);
    }
}
