//! How noisy an image is.

use super::Image;

/// The noise's standard deviation in grey levels, from the median of the absolute response to the mask
/// `[1 -2 1; -2 4 -2; 1 -2 1] / 6` (Immerkaer 1996), which is blind to planes and to straight edges along the axes.
///
/// The median makes edges count little. At least the deviation of rounding, 1/sqrt(12). Images below 3 x 3 have that.
pub fn noise_deviation(image: &Image) -> f64 {
    let rounding = 1.0 / 12.0_f64.sqrt();
    if image.width() < 3 || image.height() < 3 {
        return rounding;
    }
    // Every second row and third column are enough for the median, and their responses nearly independent.
    let rows = (1..image.height() - 1).step_by(2);
    let mut responses: Vec<u32> = rows.flat_map(|y| responses(image, y)).collect();
    let middle = responses.len() / 2;
    let (_, median, _) = responses.select_nth_unstable(middle);
    // The mask's squares add up to 36: it makes noise six times as large; the median of a normal size is 0.67449
    // deviations.
    (f64::from(*median) / 6.0 / 0.674_49).max(rounding)
}

fn responses(image: &Image, y: usize) -> impl Iterator<Item = u32> {
    let rows = [image.row(y - 1), image.row(y), image.row(y + 1)];
    (1..image.width() - 1).step_by(3).map(move |x| {
        let second = |row: &[u16]| i32::from(row[x - 1]) - 2 * i32::from(row[x]) + i32::from(row[x + 1]);
        (second(rows[0]) - 2 * second(rows[1]) + second(rows[2])).unsigned_abs()
    })
}
