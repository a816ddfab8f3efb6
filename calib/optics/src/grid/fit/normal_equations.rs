//! Normal equations of the fit of a whole grid: outlines first, then planes of grey.

use nalgebra::{SMatrix, SVector};

/// The homography's entries, the first parameters.
pub(crate) const HOMOGRAPHY: usize = 8;
/// The radius's index: it stands behind the homography.
pub(crate) const RADIUS: usize = HOMOGRAPHY;
/// The blur's index: what is before it moves outlines.
pub(crate) const BLUR: usize = RADIUS + 1;
/// How many parameters shape the discs' coverage: homography, radius, blur.
pub(crate) const SHAPES: usize = BLUR + 1;
/// The first index of the plane of grey of discs less paper, and of that of the paper.
pub(crate) const DISC: usize = SHAPES;
pub(crate) const PAPER: usize = DISC + 3;
/// The least blur, pixels: that of a pixel's own area.
pub(crate) const LEAST_BLUR: f64 = 0.29;
/// All parameters.
pub(crate) const N: usize = PAPER + 3;
pub(crate) type Params = SVector<f64, N>;

/// Normal equations at one set of parameters.
pub(crate) struct Equations {
    pub(crate) matrix: SMatrix<f64, N, N>,
    pub(crate) vector: Params,
    pub(crate) squares: f64,
    pub(crate) pixels: usize,
}

/// Normal equations as they are summed up; the lower triangle, row by row.
pub(crate) struct Sums {
    matrix: [[f64; N]; N],
    vector: [f64; N],
    squares: f64,
}

impl Default for Sums {
    fn default() -> Self {
        Self {
            matrix: [[0.0; N]; N],
            vector: [0.0; N],
            squares: 0.0,
        }
    }
}

impl Sums {
    /// A pixel. Most lie far from every edge: they say nothing of outlines.
    pub(crate) fn add(&mut self, shapes: &[f64], disc: f64, greys: &[f64; 6], residual: f64) {
        let mut slope = [0.0; N];
        slope[SHAPES..].copy_from_slice(greys);
        let mut first = SHAPES;
        if shapes.iter().any(|s| *s != 0.0) {
            slope.iter_mut().zip(shapes).for_each(|(to, s)| *to = s * disc);
            first = 0;
        }
        if first == 0 {
            self.rows::<0, 4>(&slope);
            self.rows::<4, 8>(&slope);
        }
        self.rows::<8, 12>(&slope);
        self.rows::<12, 16>(&slope);
        for (to, s) in self.vector.iter_mut().zip(&slope).skip(first) {
            *to += s * residual;
        }
        self.squares += residual * residual;
    }

    /// Four rows up to the diagonal, in whole groups of four: sizes that are known make one straight run of it.
    #[inline]
    fn rows<const FIRST: usize, const END: usize>(&mut self, slope: &[f64; N]) {
        for i in FIRST..END {
            for j in 0..END {
                self.matrix[i][j] += slope[i] * slope[j];
            }
        }
    }

    pub(crate) fn equations(&self, pixels: usize) -> Equations {
        let mut matrix = SMatrix::<f64, N, N>::from_fn(|i, j| self.matrix[i][j]);
        // Rows of outlines were left out where they vanish: the lower triangle is whole.
        matrix.fill_upper_triangle_with_lower_triangle();
        Equations {
            matrix,
            vector: Params::from(self.vector),
            squares: self.squares,
            pixels,
        }
    }
}

impl Equations {
    /// The planes of grey by least squares for the outlines given: they are linear.
    pub(crate) fn greys(&self) -> Option<SVector<f64, 6>> {
        let linear = self.matrix.fixed_view::<6, 6>(SHAPES, SHAPES).into_owned().cholesky()?;
        Some(linear.solve(&self.vector.fixed_rows::<6>(SHAPES).into_owned()))
    }
}

/// The inverse through the correlation matrix: parameters differ in size by 1e5.
pub(crate) fn inverse(matrix: &SMatrix<f64, N, N>) -> Option<SMatrix<f64, N, N>> {
    // What no pixel tells has the diagonal 0: its scale stays finite, and Cholesky's zero pivot refuses the matrix.
    let scale = matrix.diagonal().map(|d| 1.0 / d.max(1e-300).sqrt());
    let scaled = SMatrix::<f64, N, N>::from_fn(|i, j| matrix[(i, j)] * scale[i] * scale[j]);
    let inverse = scaled.cholesky()?.inverse();
    Some(SMatrix::from_fn(|i, j| inverse[(i, j)] * scale[i] * scale[j]))
}

/// A step, which leaves the blur as it is where that is held, and by how much the squares fall with it were the model linear.
pub(crate) fn step(equations: &Equations, damping: f64, blur_held: bool) -> Option<(Params, f64)> {
    let held = equations.matrix.diagonal() * damping;
    // Damped by the diagonal (Marquardt), as the parameters have different units.
    let mut damped = equations.matrix + SMatrix::from_diagonal(&held);
    let mut vector = equations.vector;
    if blur_held {
        damped.row_mut(BLUR).fill(0.0);
        damped.column_mut(BLUR).fill(0.0);
        // A row of its own that says 0: the matrix keeps its size, and the other parameters no longer see the blur.
        (damped[(BLUR, BLUR)], vector[BLUR]) = (1.0, 0.0);
    }
    let step = inverse(&damped)? * vector;
    // With (A + D) s = v the squares fall by 2 s.v - s^T A s = s.(v + D s).
    let expected = step.dot(&(vector + held.component_mul(&step)));
    Some((step, expected))
}
