//! How steep a region's function is, by blocks of its grid.

/// Steps of the grid along an axis of a block.
const BLOCK: usize = 4;

/// Bounds of the slope near the places of each block.
#[derive(Debug, Clone, Default)]
pub(super) struct Slopes {
    dims: [usize; 3],
    /// Mm within which a bound holds about each place of its block.
    reach_mm: f64,
    /// By block: mm in which the function changes by 1 at least.
    lazy: Vec<f32>,
}

impl Slopes {
    /// Of a grid of `dims` values.
    pub(super) fn of(dims: [u32; 3], step_mm: f64, values: &[f32]) -> Self {
        let count = dims.map(|n| n as usize);
        let cells = count.map(|n| n - 1);
        let dims = cells.map(|n| n.div_ceil(BLOCK));
        let mut most = vec![0.0_f64; dims.iter().product()];
        for z in 0..cells[2] {
            for y in 0..cells[1] {
                for x in 0..cells[0] {
                    let block = [x / BLOCK, y / BLOCK, z / BLOCK];
                    let own = &mut most[block[0] + dims[0] * (block[1] + dims[1] * block[2])];
                    *own = own.max(steepest(values, count, [x, y, z]));
                }
            }
        }
        for axis in 0..3 {
            most = spread(&most, dims, axis);
        }
        // Single precision is rounded: the places are a thousandth nearer than the bound says.
        let lazy = |square: &f64| (step_mm / square.sqrt().max(1e-30)).min(1e30) as f32;
        Self {
            dims,
            reach_mm: BLOCK as f64 * step_mm,
            lazy: most.iter().map(lazy).collect(),
        }
    }

    /// The distance within which the bound near a place of the grid holds, mm, and mm in which the function changes by 1 at least.
    #[inline(always)]
    pub(super) fn near(&self, index: [f64; 3]) -> [f64; 2] {
        let block = |a: usize| (index[a] as usize / BLOCK).min(self.dims[a] - 1);
        let at = block(0) + self.dims[0] * (block(1) + self.dims[1] * block(2));
        [self.reach_mm, f64::from(self.lazy[at])]
    }
}

/// The square of a bound of the slope in a cell, of a step: along an axis it is a mean of the four differences of neighbours.
fn steepest(values: &[f32], [nx, ny, _]: [usize; 3], [x, y, z]: [usize; 3]) -> f64 {
    let first = x + nx * (y + ny * z);
    let steps = [1, nx, nx * ny];
    let along = |a: usize| {
        let (p, q) = (steps[(a + 1) % 3], steps[(a + 2) % 3]);
        let off = |at: usize| (f64::from(values[at + steps[a]]) - f64::from(values[at])).abs();
        [first, first + p, first + q, first + p + q]
            .into_iter()
            .map(off)
            .fold(0.0, f64::max)
    };
    (0..3).map(|a| along(a).powi(2)).sum()
}

/// The largest of each block and its two neighbours along an axis.
fn spread(values: &[f64], dims: [usize; 3], axis: usize) -> Vec<f64> {
    let step: usize = dims[..axis].iter().product();
    let of = |k: usize| {
        let at = k / step % dims[axis];
        let before = if at > 0 { values[k - step] } else { 0.0 };
        let after = if at + 1 < dims[axis] { values[k + step] } else { 0.0 };
        values[k].max(before).max(after)
    };
    (0..values.len()).map(of).collect()
}
