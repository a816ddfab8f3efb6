//! The elimination of dense columns, by halves: most of its work is in products (`product`).

use super::number::Number;
pub(super) use super::product::{Factor, Scratch, subtract};

/// Columns eliminated together before the rest is brought up to date.
const BLOCK_COLUMNS: usize = 4;
/// A pivot vanished: column, pivot, diagonal entry.
pub(super) type Vanished = (usize, f64, f64);

/// Eliminates the first columns of a dense matrix of `size` rows, of which `panel` holds them: `L` below the diagonal and
/// the pivots on it. `diagonal` holds the matrix's own diagonal entries. How many pivots are negative: at `most` of them it ends.
pub(super) fn eliminate<T: Number>(
    panel: &mut [T],
    size: usize,
    diagonal: &[T],
    most: usize,
    scratch: &mut Scratch<T>,
) -> Result<usize, Vanished> {
    halves(panel, size, diagonal, [0, diagonal.len()], most, scratch)
}

/// The columns from one to another: one half, what that takes from the other, the other half.
fn halves<T: Number>(
    panel: &mut [T],
    size: usize,
    diagonal: &[T],
    [from, to]: [usize; 2],
    most: usize,
    scratch: &mut Scratch<T>,
) -> Result<usize, Vanished> {
    // By halves, so that most of the work is in products with many terms, whatever the width.
    if to - from <= BLOCK_COLUMNS {
        let mut negative = 0;
        for (k, own) in diagonal.iter().enumerate().take(to).skip(from) {
            negative +=
                usize::from(column(panel, size, [k, to], *own).map_err(|pivot| (k, pivot.value(), own.value()))?);
            if negative >= most {
                break;
            }
        }
        return Ok(negative);
    }
    // A multiple of the block, so that only the last block is narrower.
    let middle = from + (to - from).div_ceil(2 * BLOCK_COLUMNS) * BLOCK_COLUMNS;
    let before = halves(panel, size, diagonal, [from, middle], most, scratch)?;
    // The caller asks only whether there are so many: what is left need not be eliminated.
    if before >= most {
        return Ok(before);
    }
    let (done, rest) = panel.split_at_mut(middle * size);
    let factor = Factor {
        columns: &done[from * size..],
        size,
        skip: middle,
    };
    // The rest of the panel begins at row 0; only what lies at and below its diagonal counts.
    subtract(&factor, &mut rest[middle..], size, to - middle, scratch);
    Ok(before + halves(panel, size, diagonal, [middle, to], most - before, scratch)?)
}

/// One column: divided by its pivot, and taken from the columns up to `to`. True where the pivot is negative.
fn column<T: Number>(panel: &mut [T], size: usize, [k, to]: [usize; 2], diagonal: T) -> Result<bool, T> {
    let (done, rest) = panel.split_at_mut((k + 1) * size);
    let own = &mut done[k * size + k..];
    let pivot = own[0];
    // A zero entry has a zero bound: equality counts as vanished too.
    let [value, diagonal] = [pivot, diagonal].map(Number::value);
    if value.is_nan() || value.abs() <= T::ZERO_PIVOT * diagonal.abs() {
        return Err(pivot);
    }
    let own = &mut own[1..];
    for (c, other) in rest.chunks_exact_mut(size).take(to - k - 1).enumerate() {
        // The column is not divided yet: its entries still are those of `L` times the pivot.
        let by = own[c] / pivot;
        let below = &mut other[k + 1 + c..];
        below.iter_mut().zip(&own[c..]).for_each(|(y, l)| *y -= by * *l);
    }
    own.iter_mut().for_each(|l| *l /= pivot);
    Ok(value < 0.0)
}
