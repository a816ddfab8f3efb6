//! Medians.

/// The middle value in order, the upper of two; 0 where there is none.
pub fn median(mut values: Vec<f64>) -> f64 {
    let middle = values.len() / 2;
    match values.get(middle) {
        Some(_) => *values.select_nth_unstable_by(middle, f64::total_cmp).1,
        None => 0.0,
    }
}
