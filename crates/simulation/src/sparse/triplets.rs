//! A symmetric matrix as a sum of entries of its lower triangle.

/// Entries of the lower triangle of a symmetric matrix; entries of one place add up.
#[derive(Debug, Clone, Default)]
pub struct Triplets {
    size: usize,
    /// `(row, column)`, `row >= column`.
    pub(super) places: Vec<(u32, u32)>,
    pub(super) values: Vec<f64>,
    /// The unknowns of the last dense part, and where its entries begin.
    block: Vec<u32>,
    start: usize,
}

impl Triplets {
    /// A matrix of zeros.
    pub fn new(size: usize) -> Self {
        Self {
            size,
            ..Self::default()
        }
    }

    /// Rows, and columns.
    pub fn size(&self) -> usize {
        self.size
    }

    /// Makes it a matrix of zeros of this size, keeping its memory.
    pub fn reset(&mut self, size: usize) {
        self.size = size;
        self.places.clear();
        self.values.clear();
        self.block.clear();
    }

    /// Adds `value` at `(i, j)` and, where they differ, at `(j, i)`. Call it once for the two of them.
    #[inline]
    pub fn add(&mut self, i: usize, j: usize, value: f64) {
        let (row, column) = if i >= j { (i, j) } else { (j, i) };
        self.places.push((row as u32, column as u32));
        self.values.push(value);
    }

    /// Adds a dense matrix of some unknowns, each of them once: `values` row by row, from the diagonal down to the left. One that
    /// follows another of the same unknowns in the same order takes its places.
    pub fn add_block(&mut self, unknowns: impl ExactSizeIterator<Item = usize> + Clone, values: &[f64]) {
        let same = unknowns.len() == self.block.len();
        if same && unknowns.clone().zip(&self.block).all(|(new, old)| new as u32 == *old) {
            let old = &mut self.values[self.start..self.start + values.len()];
            old.iter_mut().zip(values).for_each(|(old, new)| *old += new);
            return;
        }
        self.block.clear();
        self.block.extend(unknowns.map(|u| u as u32));
        self.start = self.values.len();
        self.values.extend_from_slice(values);
        for (k, &i) in self.block.iter().enumerate() {
            let row = self.block[..=k].iter();
            self.places.extend(row.map(|&j| (i.max(j), i.min(j))));
        }
    }

    /// The product with a vector.
    pub fn product(&self, x: &[f64]) -> Vec<f64> {
        let mut y = vec![0.0; self.size];
        for (&(i, j), value) in self.places.iter().zip(&self.values) {
            let (i, j) = (i as usize, j as usize);
            y[i] += value * x[j];
            if i != j {
                y[j] += value * x[i];
            }
        }
        y
    }

    /// The product of absolute values with a vector's: times 2^-52 the rounding of [`Self::product`].
    pub fn absolute_product(&self, x: &[f64]) -> Vec<f64> {
        let mut y = vec![0.0; self.size];
        for (&(i, j), value) in self.places.iter().zip(&self.values) {
            let (i, j) = (i as usize, j as usize);
            y[i] += (value * x[j]).abs();
            if i != j {
                y[j] += (value * x[i]).abs();
            }
        }
        y
    }

    /// The diagonal.
    pub fn diagonal(&self) -> Vec<f64> {
        let mut diagonal = vec![0.0; self.size];
        for (&(i, j), value) in self.places.iter().zip(&self.values) {
            if i == j {
                diagonal[i as usize] += value;
            }
        }
        diagonal
    }

    /// Forgets the rows and columns marked in `fixed`, and puts `diagonal` on their diagonal.
    pub fn fix(&mut self, fixed: &[bool], diagonal: f64) {
        if !fixed.contains(&true) {
            return;
        }
        for (&(i, j), value) in self.places.iter().zip(&mut self.values) {
            if fixed[i as usize] || fixed[j as usize] {
                // The place stays, so that the pattern, and with it the elimination, is that of the last matrix.
                *value = 0.0;
            }
        }
        for (i, _) in fixed.iter().enumerate().filter(|(_, fixed)| **fixed) {
            self.add(i, i, diagonal);
        }
    }
}
