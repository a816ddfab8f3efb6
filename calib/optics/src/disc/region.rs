//! Regions around a pixel as a few rectangles, so that their sums cost the same at every radius.

use crate::image::Sums;

/// The most different widths of rows in a region. A disc of radius up to 5 px is exact; beyond, its area is off by at
/// most 4 % and its outline by a twelfth of the radius.
const MAX_ROW_WIDTHS: usize = 5;

/// A set of pixels relative to a middle, as rectangles that do not overlap.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Region {
    /// Columns and rows relative to the middle, the last behind the end.
    boxes: Vec<[[isize; 2]; 2]>,
    pixels: usize,
}

impl Region {
    /// The pixels within `radius` of the middle (the thesis's I, 5.2), in at most 9 rectangles.
    pub fn disc(radius: f64) -> Self {
        let reach = radius.floor() as isize;
        let half = |y: isize| (radius * radius - (y * y) as f64).max(0.0).sqrt().floor() as isize;
        let mut rows: Vec<(isize, isize)> = (0..=reach).map(|y| (y, half(y))).collect();
        flatten(&mut rows);
        let mut boxes: Vec<[[isize; 2]; 2]> = Vec::new();
        let (mut start, mut width) = (0, rows.first().map_or(0, |r| r.1));
        for (y, w) in rows.iter().copied().chain([(reach + 1, -1)]) {
            if w == width {
                continue;
            }
            let columns = [-width, width + 1];
            if start == 0 {
                boxes.push([columns, [1 - y, y]]);
            } else {
                boxes.push([columns, [start, y]]);
                boxes.push([columns, [1 - y, 1 - start]]);
            }
            (start, width) = (y, w);
        }
        let area = |[x, y]: &[[isize; 2]; 2]| ((x[1] - x[0]) * (y[1] - y[0])) as usize;
        let pixels = boxes.iter().map(area).sum();
        Self { boxes, pixels }
    }

    /// The number of pixels.
    pub fn pixels(&self) -> usize {
        self.pixels
    }

    /// The number of rectangles.
    pub fn boxes(&self) -> usize {
        self.boxes.len()
    }

    /// Count, sum and sum of squares over the region about a pixel, clipped to the image.
    #[inline]
    pub fn over(&self, sums: &Sums, x: usize, y: usize) -> [u64; 3] {
        let (x, y) = (x as isize, y as isize);
        self.boxes.iter().fold([0; 3], |total, [columns, rows]| {
            let part = sums.over(columns.map(|c| c + x), rows.map(|r| r + y));
            [total[0] + part[0], total[1] + part[1], total[2] + part[2]]
        })
    }
}

/// Makes the widths of rows few: rows that follow each other are given the mean of their widths.
fn flatten(rows: &mut [(isize, isize)]) {
    let mut widths: Vec<isize> = rows.iter().map(|row| row.1).collect();
    widths.dedup();
    if widths.len() <= MAX_ROW_WIDTHS {
        return;
    }
    // Equal steps of the angle from the middle row to the last share the outline's error evenly.
    let n = rows.len() as f64;
    let level = |y: isize| {
        let sine = (y as f64 + 0.5) / n;
        ((sine.min(1.0).asin() / std::f64::consts::FRAC_PI_2 * MAX_ROW_WIDTHS as f64) as usize).min(MAX_ROW_WIDTHS - 1)
    };
    for k in 0..MAX_ROW_WIDTHS {
        let members: Vec<usize> = (0..rows.len()).filter(|i| level(rows[*i].0) == k).collect();
        let total: isize = members.iter().map(|i| rows[*i].1).sum();
        let count = members.len().max(1) as isize;
        members
            .into_iter()
            .for_each(|i| rows[i].1 = (total + count / 2) / count);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Image;

    #[test]
    fn small_discs_are_exact_and_large_ones_cost_no_more() {
        for radius in [1.0_f64, 2.0, 3.0, 4.5, 5.0] {
            let mut count = 0;
            for y in -6..=6_i32 {
                count += (-6..=6_i32)
                    .filter(|x| f64::from(x * x + y * y) <= radius * radius)
                    .count();
            }
            assert_eq!(Region::disc(radius).pixels(), count, "{radius}");
        }
        for radius in [9.0, 20.0, 73.5, 200.0] {
            let region = Region::disc(radius);
            let area = std::f64::consts::PI * radius * radius;
            assert!(region.boxes() < 2 * MAX_ROW_WIDTHS, "{radius}: {}", region.boxes());
            assert!((region.pixels() as f64 / area - 1.0).abs() < 0.04, "{radius}");
        }
    }

    #[test]
    fn sums_at_the_border_are_of_what_is_there() {
        let image = Image::new(5, 4, (0..20).collect()).unwrap();
        let sums = Sums::new(&image);
        // 5.1 extended: about the corner only its own quarter is left.
        assert_eq!(Region::disc(1.0).over(&sums, 0, 0), [3, 6, 26]);
        assert_eq!(Region::disc(30.0).over(&sums, 2, 2)[0], 20);
    }
}
