//! What a model of the whole grid leaves: whether single discs' own pixels agree with where it has them.
//!
//! Each disc's pixels alone say how far it is off, with a covariance. Were the model right, these offsets would be noise less
//! what the model itself follows: their squares would add up to chi squared, and so would the part of them that goes smoothly over
//! the grid. The smooth part is what a lens or a bent sheet leaves, and a tenth of what single discs tell is enough to see it.

use nalgebra::{DMatrix, DVector, Matrix2, Vector2};

use crate::grid::fit::lens_fit::Own;
use crate::grid::lattice::Cell;

/// Smaller offsets, pixels, are the pixels' own: the model takes a pixel's area for a Gaussian.
const PIXEL_MODEL_PX: f64 = 5e-4;
/// How many deviations of the normal distribution beyond doubt: one in four thousand.
const DOUBT_DEVIATIONS: f64 = 3.5;
/// Eigenvalues below this share of the greatest are none.
const LEAST_EIGENVALUE_SHARE: f64 = 1e-7;

/// What moves cells, a column for each number: its two rows at a cell.
pub(crate) type Columns<'a> = &'a dyn Fn(Cell) -> Vec<[f64; 2]>;

/// How far off the discs are, beside what noise does.
#[derive(Debug, Clone)]
pub(crate) struct Misfit {
    /// Chi squared of the smooth part, and its degrees of freedom.
    smooth: [f64; 2],
    /// Of what is left then.
    rest: [f64; 2],
    /// Of what the model itself could follow: that its own fit differs from the discs' own.
    own: [f64; 2],
    /// The smooth part by the numbers of what it is made of, and by the model's numbers what the model would follow of it.
    field: DVector<f64>,
    follows: DVector<f64>,
    /// How far the smooth part is taken to move a disc at most, pixels: twice its root mean square over those whose pixels tell.
    most: f64,
    /// The root mean square of the smooth part over the discs, pixels, beyond noise.
    pub(crate) px: f64,
}

/// Powers of column and row up to a degree, for either coordinate.
pub(crate) struct Powers {
    degree: i32,
    middle: [f64; 2],
    unit: f64,
}

impl Powers {
    /// Over discs.
    pub(crate) fn new(own: &[Own], degree: i32) -> Self {
        let (middle, unit) = frame(own);
        Self { degree, middle, unit }
    }

    /// What they are at a cell.
    pub(crate) fn at(&self, cell: Cell) -> Vec<[f64; 2]> {
        let [x, y] = [0, 1].map(|k| (f64::from(cell[k]) - self.middle[k]) / self.unit);
        let all = (0..=self.degree).flat_map(|d| (0..=d).map(move |b| (d - b, b)));
        let both = all
            .map(|(a, b)| x.powi(a) * y.powi(b))
            .flat_map(|p| [[p, 0.0], [0.0, p]]);
        both.collect()
    }
}

/// Solves a symmetric system in the directions in which it says something; how many those are.
fn solved(matrix: &DMatrix<f64>, right: &DMatrix<f64>) -> (DMatrix<f64>, usize) {
    // Scaled to a diagonal of 1, so that one threshold of the eigenvalues holds for numbers of any unit.
    let scale = matrix.diagonal().map(|d| if d > 0.0 { d.sqrt().recip() } else { 0.0 });
    let scaled = DMatrix::from_fn(matrix.nrows(), matrix.ncols(), |i, j| {
        matrix[(i, j)] * scale[i] * scale[j]
    });
    let eigen = scaled.symmetric_eigen();
    let most = eigen.eigenvalues.max();
    let by_scale = |m: DMatrix<f64>| DMatrix::from_fn(m.nrows(), m.ncols(), |i, j| m[(i, j)] * scale[i]);
    let (mut turned, mut rank) = (eigen.eigenvectors.transpose() * by_scale(right.clone()), 0);
    for (mut row, value) in turned.row_iter_mut().zip(&eigen.eigenvalues) {
        // The pseudo-inverse: a lens's numbers and polynomials overlap, and what they do alike must count once in the
        // rank.
        let says = *value > LEAST_EIGENVALUE_SHARE * most;
        rank += usize::from(says);
        row *= if says { value.recip() } else { 0.0 };
    }
    (by_scale(&eigen.eigenvectors * turned), rank)
}

/// Whether chi squared is beyond doubt too large (Wilson and Hilferty 1931).
fn is_beyond([squares, dims]: [f64; 2]) -> bool {
    // The cube root of chi squared over k is nearly normal, of mean 1 - 2 / 9 k and variance 2 / 9 k.
    let spread = 2.0 / (9.0 * dims);
    dims > 0.0 && squares > dims * (1.0 - spread + DOUBT_DEVIATIONS * spread.sqrt()).powi(3)
}

impl Misfit {
    /// Of discs, beside a model whose numbers move a cell as `tangent` says, by a smooth part that is made of `smooth`.
    pub(crate) fn of(own: &[Own], smooth: Columns, tangent: Columns) -> Option<Self> {
        let first = own.first()?.cell;
        let (numbers, count) = (tangent(first).len(), smooth(first).len());
        let columns = numbers + count;
        let (mut matrix, mut vector, mut all) = (DMatrix::zeros(columns, columns), DMatrix::zeros(columns, 1), 0.0);
        for o in own {
            // The pixels' own error adds to the variance, so that it goes in before the inverse.
            let noise = o.information.try_inverse()? + Matrix2::identity() * (PIXEL_MODEL_PX * PIXEL_MODEL_PX);
            let information = noise.try_inverse()?;
            let rows: Vec<Vector2<f64>> = tangent(o.cell)
                .into_iter()
                .chain(smooth(o.cell))
                .map(Vector2::from)
                .collect();
            let weighted: Vec<Vector2<f64>> = rows.iter().map(|r| information * r).collect();
            for (i, w) in weighted.iter().enumerate() {
                vector[i] += w.dot(&o.off);
                rows[..=i]
                    .iter()
                    .enumerate()
                    .for_each(|(j, r)| matrix[(i, j)] += w.dot(r));
            }
            all += (o.off.transpose() * information * o.off)[0];
        }
        matrix.fill_upper_triangle_with_lower_triangle();
        // First what the model's own numbers would take, then the smooth part in what that leaves: the Schur
        // complement.
        let inner = matrix.view((0, 0), (numbers, numbers)).into_owned();
        let (followed, held) = solved(&inner, &vector.rows(0, numbers).into_owned());
        let followed = followed.column(0).into_owned();
        let own_squares = followed.dot(&vector.rows(0, numbers));
        let across = matrix.view((0, numbers), (numbers, count)).into_owned();
        let taken = solved(&inner, &across).0;
        let outer = matrix.view((numbers, numbers), (count, count)) - across.transpose() * &taken;
        let left: DMatrix<f64> =
            vector.rows(numbers, count) - across.transpose() * DMatrix::from_columns(std::slice::from_ref(&followed));
        let (field, dims) = solved(&outer, &left);
        let (field, left) = (field.column(0).into_owned(), left.column(0).into_owned());
        let found = field.dot(&left).max(0.0);
        // Two coordinates a disc, less a degree of freedom for each direction that was fitted.
        let rest = (2 * own.len()) as f64 - (held + dims) as f64;
        let mut misfit = Self {
            smooth: [found, dims as f64],
            rest: [(all - own_squares - found).max(0.0), rest.max(0.0)],
            own: [own_squares, held as f64],
            follows: taken * &field,
            field,
            most: 0.0,
            px: 0.0,
        };
        let offs = own.iter().map(|o| misfit.at(o.cell, smooth, tangent).norm_squared());
        let squares: f64 = offs.sum();
        misfit.most = 2.0 * (squares / own.len() as f64).sqrt();
        // What is rough is noise of single discs, be it more than the pixels' own: so much counts as noise of what is smooth.
        let growth = misfit.growth();
        misfit.smooth[0] /= growth;
        misfit.own[0] /= growth;
        misfit.px = (squares / own.len() as f64).sqrt() * misfit.beyond_noise().sqrt();
        Some(misfit)
    }

    /// The smooth part at a cell, as it is seen.
    fn at(&self, cell: Cell, smooth: Columns, tangent: Columns) -> Vector2<f64> {
        let mut out = Vector2::zeros();
        for (k, t) in smooth(cell).iter().enumerate() {
            out += Vector2::from(*t) * self.field[k];
        }
        for (k, t) in tangent(cell).iter().enumerate() {
            // What the model would follow of the smooth part is no error of it.
            out -= Vector2::from(*t) * self.follows[k];
        }
        out
    }

    /// The share of the smooth part's square that is not noise: none where noise is this large once in twenty images.
    fn beyond_noise(&self) -> f64 {
        let [squares, dims] = self.smooth;
        // Chi squared has the mean k and the variance 2 k: two deviations beyond the mean.
        let usual = dims + 2.0 * (2.0 * dims).sqrt();
        if squares > usual { 1.0 - dims / squares } else { 0.0 }
    }

    /// Whether the model is wrong beyond doubt: in what goes smoothly over the grid, or in its own numbers.
    pub(crate) fn is_seen(&self) -> bool {
        is_beyond(self.smooth) || is_beyond(self.own)
    }

    /// Whether its own numbers are: single discs have the model itself elsewhere.
    pub(crate) fn is_off(&self) -> bool {
        is_beyond(self.own)
    }

    /// How much larger than by noise alone the squares of single discs' offsets are that are not smooth, at least 1.
    pub(crate) fn growth(&self) -> f64 {
        let [squares, dims] = self.rest;
        if dims > 0.0 { (squares / dims).max(1.0) } else { 1.0 }
    }

    /// What the model may leave at a cell. Beyond the discs that tell, polynomials grow without anything that holds them.
    pub(crate) fn left(&self, cell: Cell, smooth: Columns, tangent: Columns) -> Matrix2<f64> {
        let off = self.at(cell, smooth, tangent).cap_magnitude(self.most);
        off * off.transpose() * self.beyond_noise()
    }
}

/// The middle of the cells, and half of the longer side.
fn frame(own: &[Own]) -> ([f64; 2], f64) {
    let bounds = [0, 1].map(|k| {
        let all = own.iter().map(|o| f64::from(o.cell[k]));
        all.fold([f64::MAX, f64::MIN], |[a, b], v| [a.min(v), b.max(v)])
    });
    // At least one step: cells on a line, or one alone, have no extent to divide by.
    let unit = bounds.iter().map(|b| 0.5 * (b[1] - b[0])).fold(1.0, f64::max);
    (bounds.map(|b| 0.5 * (b[0] + b[1])), unit)
}
