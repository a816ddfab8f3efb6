//! Medians.

use crate::quantile::by_size;

/// The middle value in order, the upper of two; 0 where there is none. NaN, of either sign, is larger than all numbers.
pub fn median(mut values: Vec<f64>) -> f64 {
    let middle = values.len() / 2;
    match values.get(middle) {
        // Selection takes linear time; the order of all others is of no interest.
        Some(_) => *values.select_nth_unstable_by(middle, by_size).1,
        None => 0.0,
    }
}
