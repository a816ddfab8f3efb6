//! Normal equations of one disc: its outline and blur first, then its contrast and the plane of grey about it.

use nalgebra::{SMatrix, SVector};

use super::chi::ROUNDING;

/// Centre 2, shape 3, blur, contrast, background 3.
pub(crate) const N: usize = 10;
pub(crate) type Params = SVector<f64, N>;
pub(crate) type Information = SMatrix<f64, N, N>;

/// Normal equations at one set of parameters.
pub(crate) struct Equations {
    pub(crate) matrix: Information,
    pub(crate) vector: Params,
    pub(crate) squares: f64,
    pub(crate) pixels: usize,
}

impl Equations {
    /// The residuals' variance. Samples are whole: below the variance of rounding, residuals say nothing.
    pub(crate) fn variance(&self) -> f64 {
        (self.squares / (self.pixels - N) as f64).max(ROUNDING * ROUNDING)
    }
}

/// Parameters in whole groups of four.
pub(crate) const ROOM: usize = 12;

/// Normal equations as they are summed up; the lower triangle, row by row.
#[derive(Default)]
pub(crate) struct Sums {
    matrix: [[f64; ROOM]; ROOM],
    vector: [f64; ROOM],
    squares: f64,
    pixels: usize,
}

impl Sums {
    /// A pixel. Far from the edge it says nothing of the outline.
    pub(crate) fn add(&mut self, slope: &[f64; ROOM], residual: f64) {
        if slope[..4].iter().any(|s| *s != 0.0) {
            self.rows::<0, 4>(slope);
        }
        self.rows::<4, 8>(slope);
        self.rows::<8, 12>(slope);
        let vector = self.vector.iter_mut().zip(slope);
        vector.for_each(|(to, s)| *to += s * residual);
        self.squares += residual * residual;
        self.pixels += 1;
    }

    /// Four rows up to the diagonal, in whole groups of four: sizes that are known make one straight run of it.
    #[inline]
    fn rows<const FIRST: usize, const END: usize>(&mut self, slope: &[f64; ROOM]) {
        for i in FIRST..END {
            for j in 0..END {
                self.matrix[i][j] += slope[i] * slope[j];
            }
        }
    }

    pub(crate) fn equations(&self) -> Equations {
        let mut matrix = Information::from_fn(|i, j| self.matrix[i][j]);
        matrix.fill_upper_triangle_with_lower_triangle();
        Equations {
            matrix,
            vector: Params::from_fn(|i, _| self.vector[i]),
            squares: self.squares,
            pixels: self.pixels,
        }
    }
}
