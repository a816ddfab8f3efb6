//! Corners on a grid of 1/256 of a pixel, and the edges between them.

use std::ops::Range;

/// Parts of a pixel.
const PARTS: i32 = 256;
/// A corner, in parts of a pixel.
pub(super) type Corner = [i32; 2];

/// The nearest corner of the grid.
#[inline]
pub(super) fn corner(at: [f64; 2]) -> Corner {
    // Added to 1.5 x 2^52, a number below 2^51 leaves its nearest whole number in the lower bits: no call for rounding.
    const ROUNDER: f64 = 6_755_399_441_055_744.0;
    let nearest = |x: f64| {
        (x * f64::from(PARTS) + ROUNDER)
            .to_bits()
            .wrapping_sub(ROUNDER.to_bits()) as i32
    };
    [nearest(at[0]), nearest(at[1])]
}

/// Where an edge passes through the plane: from its lower to its higher corner, so that all pieces about it find the same bits.
#[inline(always)]
pub(super) fn crossing(from: &[f64; 3], to: &[f64; 3]) -> Corner {
    let part = from[2] / (from[2] - to[2]);
    corner([from[0] + part * (to[0] - from[0]), from[1] + part * (to[1] - from[1])])
}

/// An edge, row by row: the first column whose centre is not left of it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Edge {
    /// Rows that are left.
    pub(super) rows: usize,
    /// The column is a quotient, rounded up, that stays whole from row to row: the remainder is kept.
    column: i32,
    left: i64,
    step: i32,
    more: i64,
    by: i64,
}

impl Edge {
    /// The first row, and the edge from there on; none where no row's centre from `start` to `end` lies on it.
    #[inline(always)]
    pub(super) fn new(from: Corner, to: Corner, start: usize, end: usize) -> Option<(usize, Self)> {
        // Downwards, so that both sides of an edge compute the same.
        let ([x, y], [x_end, y_end]) = if from[1] < to[1] { (from, to) } else { (to, from) };
        let own = rows(y, y_end, end);
        let first = own.start.max(start);
        if own.end <= first {
            return None;
        }
        // The quotient of (x tall + (256 row - y) wide) by 256 tall. All are below 2^53.
        let (wide, tall) = (i64::from(x_end - x), i64::from(y_end - y));
        let parts = i64::from(PARTS);
        let (step, more) = quotient(wide, tall);
        let by = parts * tall;
        let over = i64::from(x) * tall + (parts * first as i64 - i64::from(y)) * wide + by - 1;
        let (column, left) = quotient(over, by);
        let edge = Self {
            rows: own.end - first,
            column,
            left,
            step,
            more: parts * more,
            by,
        };
        Some((first, edge))
    }
}

impl Iterator for Edge {
    type Item = i32;

    #[inline(always)]
    fn next(&mut self) -> Option<i32> {
        let column = self.column;
        self.rows = self.rows.checked_sub(1)?;
        (self.column, self.left) = (self.column + self.step, self.left + self.more);
        if self.left >= self.by {
            (self.column, self.left) = (self.column + 1, self.left - self.by);
        }
        Some(column)
    }
}

/// Quotient, rounded down, and remainder of numbers below 2^53: what a division in double precision gives is off by 1 at most.
#[inline(always)]
fn quotient(a: i64, b: i64) -> (i32, i64) {
    let near = (a as f64 / b as f64) as i64;
    let left = a - near * b;
    let (less, more) = (i64::from(left < 0), i64::from(left >= b));
    ((near - less + more) as i32, left + (less - more) * b)
}

/// The rows whose centres lie from the one to the other, the last not included.
pub(super) fn rows(least: i32, most: i32, end: usize) -> Range<usize> {
    let whole = |y: i32| (y + PARTS - 1).div_euclid(PARTS).clamp(0, end as i32) as usize;
    whole(least)..whole(most)
}
