//! Grey values of an image whose size in mm is not known yet: it is what a calibration finds.

/// Grey values, row by row, and the part of them that is looked at. A pixel (u, v): whole numbers are centres of
/// pixels, u to the right, v down.
#[derive(Debug, Clone, Copy)]
pub struct Grey<'a> {
    values: &'a [u8],
    columns: usize,
    rows: usize,
    region: Region,
}

/// A rectangle of pixels: the first column and row, and the first ones beyond.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Region {
    /// First column and row.
    pub from: [usize; 2],
    /// The first column and row that no longer belong to it.
    pub to: [usize; 2],
}

/// Why grey values are no image.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum GreyError {
    /// No pixels, or more than any scanner shows.
    #[error("an image of {columns} x {rows} pixels; allowed are 16 x 16 to 4096 x 4096")]
    Size {
        /// As given.
        columns: usize,
        /// As given.
        rows: usize,
    },
    /// Another number of pixels than columns times rows.
    #[error("{found} pixels for an image of {expected}")]
    Pixels {
        /// How many there are.
        found: usize,
        /// Columns times rows.
        expected: usize,
    },
    /// A region that is empty, thinner than 16 pixels, or reaches beyond the image.
    #[error(
        "a region from column {}, row {} to {}, {}, which an image of {columns} x {rows} does not hold, or thinner than \
         16 pixels",
        .region.from[0], .region.from[1], .region.to[0], .region.to[1]
    )]
    Region {
        /// As given.
        region: Region,
        /// Of the image.
        columns: usize,
        /// Of the image.
        rows: usize,
    },
}

const SIDES: std::ops::RangeInclusive<usize> = 16..=4096;

impl<'a> Grey<'a> {
    /// A whole image.
    ///
    /// # Errors
    /// [`GreyError::Size`], [`GreyError::Pixels`].
    pub fn new(columns: usize, rows: usize, values: &'a [u8]) -> Result<Self, GreyError> {
        if !SIDES.contains(&columns) || !SIDES.contains(&rows) {
            return Err(GreyError::Size { columns, rows });
        }
        let expected = columns * rows;
        if values.len() != expected {
            let found = values.len();
            return Err(GreyError::Pixels { found, expected });
        }
        let region = Region {
            from: [0, 0],
            to: [columns, rows],
        };
        Ok(Self {
            values,
            columns,
            rows,
            region,
        })
    }

    /// The same image, looked at in a region only.
    ///
    /// # Errors
    /// [`GreyError::Region`].
    pub fn within(self, region: Region) -> Result<Self, GreyError> {
        let size = [self.columns, self.rows];
        let holds = |a: usize| region.to[a] <= size[a] && region.from[a].saturating_add(16) <= region.to[a];
        match holds(0) && holds(1) {
            true => Ok(Self { region, ..self }),
            false => Err(GreyError::Region {
                region,
                columns: self.columns,
                rows: self.rows,
            }),
        }
    }

    /// The region that is looked at.
    #[must_use]
    pub fn region(&self) -> Region {
        self.region
    }

    /// Columns and rows of the region.
    pub(crate) fn size(&self) -> [usize; 2] {
        [
            self.region.to[0] - self.region.from[0],
            self.region.to[1] - self.region.from[1],
        ]
    }

    /// The region's values, row by row.
    pub(crate) fn values(&self) -> Vec<f32> {
        let Region { from, to } = self.region;
        let rows = (from[1]..to[1]).map(|row| &self.values[row * self.columns + from[0]..row * self.columns + to[0]]);
        rows.flatten().map(|value| f32::from(*value)).collect()
    }
}

/// The values blurred by a normal curve of these deviations (pixels, along rows and along columns); beyond its border
/// the image goes on as at it.
pub(crate) fn blurred(values: &[f32], [columns, rows]: [usize; 2], sigma: [f64; 2]) -> Vec<f32> {
    let along_rows = kernel(sigma[0]);
    let mut across = vec![0.0; values.len()];
    for (out, row) in across.chunks_mut(columns).zip(values.chunks(columns)) {
        for (u, value) in out.iter_mut().enumerate() {
            let at = |k: isize| row[(u as isize + k).clamp(0, columns as isize - 1) as usize];
            *value = weighted(&along_rows, at);
        }
    }
    let along_columns = kernel(sigma[1]);
    let reach = along_columns.len() as isize / 2;
    let mut result = vec![0.0; values.len()];
    for v in 0..rows {
        let out = &mut result[v * columns..(v + 1) * columns];
        // Whole rows at a time: columns one by one would leave the cache at each step.
        for (k, weight) in (-reach..).zip(&along_columns) {
            let from = (v as isize + k).clamp(0, rows as isize - 1) as usize * columns;
            for (value, other) in out.iter_mut().zip(&across[from..from + columns]) {
                *value += weight * other;
            }
        }
    }
    result
}

fn weighted(kernel: &[f32], at: impl Fn(isize) -> f32) -> f32 {
    let reach = kernel.len() as isize / 2;
    (-reach..).zip(kernel).map(|(k, weight)| weight * at(k)).sum()
}

/// A normal curve to three deviations, with the sum 1.
fn kernel(sigma: f64) -> Vec<f32> {
    let reach = (3.0 * sigma).ceil() as i32;
    let curve = (-reach..=reach).map(|k| (-0.5 * (f64::from(k) / sigma.max(1e-9)).powi(2)).exp());
    let curve: Vec<f64> = curve.collect();
    let sum: f64 = curve.iter().sum();
    curve.iter().map(|value| (value / sum) as f32).collect()
}

/// The median, and the deviation by the median distance from it (0 in an image that is mostly black).
pub(crate) fn background(soft: &[f32]) -> (f32, f64) {
    let mut sorted: Vec<f32> = soft.iter().step_by(3).copied().collect();
    let half = sorted.len() / 2;
    let (_, median, _) = sorted.select_nth_unstable_by(half, f32::total_cmp);
    let median = *median;
    let mut off: Vec<f32> = sorted.iter().map(|value| (value - median).abs()).collect();
    let (_, distance, _) = off.select_nth_unstable_by(half, f32::total_cmp);
    (median, 1.4826 * f64::from(*distance))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_image_is_refused_with_its_numbers() {
        let grey = vec![0; 20 * 30];
        let said = |columns, rows| Grey::new(columns, rows, &grey).unwrap_err().to_string();
        assert!(said(4, 30).contains("4 x 30"));
        assert!(said(20, 31).contains("600 pixels for an image of 620"));
        let region = |from, to| Grey::new(20, 30, &grey).unwrap().within(Region { from, to });
        for (from, to) in [
            ([0, 0], [21, 30]),
            ([5, 0], [20, 30]),
            ([0, 20], [20, 10]),
            ([usize::MAX, 0], [20, 30]),
        ] {
            assert!(
                region(from, to).unwrap_err().to_string().contains("20 x 30"),
                "{from:?}"
            );
        }
        assert!(region([0, 3], [20, 30]).is_ok());
    }

    #[test]
    fn a_blur_keeps_what_is_even_and_the_sum_of_a_point() {
        let even = blurred(&[7.0; 40 * 30], [40, 30], [3.0, 1.5]);
        assert!(even.iter().all(|value| (value - 7.0).abs() < 1e-4));
        let mut point = vec![0.0; 40 * 30];
        point[15 * 40 + 20] = 100.0;
        let soft = blurred(&point, [40, 30], [3.0, 1.5]);
        // Single precision, 1200 terms: 1e-6 of the sum each.
        assert!((soft.iter().sum::<f32>() - 100.0).abs() < 0.1);
        assert_eq!(soft[15 * 40 + 23], soft[15 * 40 + 17]);
    }
}
