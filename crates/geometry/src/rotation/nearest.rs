//! The rotation nearest to a matrix that is off by measurement or rounding.

use super::error::finite;
use super::matrix::quaternion;
use super::{RotationError, RotationMatrix, exact};

type Rows = [[f64; 3]; 3];

/// The nearest rotation and how far it was.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Nearest {
    /// The rotation.
    pub matrix: RotationMatrix,
    /// Frobenius norm of the difference, of no unit: about 5e-4 for matrices in trackers' files.
    pub distance: f64,
}

/// Orthonormal to this in every scalar product of columns: the matrix is a rotation to 2 ulp and keeps its bits.
const KEPT_DEFECT: f64 = 2.0 * f64::EPSILON;

/// A determinant this small beside the entries' products is rounding: six products of three factors.
const SINGULAR_DETERMINANT: f64 = 16.0 * f64::EPSILON;

impl RotationMatrix {
    /// From nine numbers by rows that are a rotation to within `tolerance`; what is off is repaired by
    /// [`RotationMatrix::nearest`], and a matrix that is orthonormal to 2 ulp keeps its bits.
    ///
    /// `tolerance` bounds the Frobenius distance to the nearest rotation. Trackers' files need about 1e-3.
    ///
    /// # Errors
    /// Those of [`RotationMatrix::nearest`], and [`RotationError::NotOrthonormal`].
    pub fn new(rows: [[f64; 3]; 3], tolerance: f64) -> Result<Self, RotationError> {
        let Nearest { matrix, distance } = Self::nearest(rows)?;
        if distance <= tolerance {
            return Ok(matrix);
        }
        Err(RotationError::NotOrthonormal { distance, tolerance })
    }

    /// The rotation nearest to a matrix in the Frobenius norm: the orthogonal factor of its polar decomposition, by
    /// Newton's iteration (Higham 1986), and the distance to it.
    ///
    /// Domain: finite matrices of positive determinant, of any scale. Error: 3 ulp where the matrix is within 0.1 of a
    /// rotation; else that times its condition number. A matrix orthonormal to 2 ulp is returned bit for bit.
    ///
    /// # Errors
    /// [`RotationError::Nan`], [`RotationError::Infinite`]; [`RotationError::Reflection`] where the determinant is
    /// negative; [`RotationError::Singular`] where it is zero to rounding.
    pub fn nearest(rows: Rows) -> Result<Nearest, RotationError> {
        finite("matrix", rows.as_flattened())?;
        let scaled = scaled(rows);
        // Before the bits are kept: a reflection is orthonormal too.
        check_determinant(scaled)?;
        let defect = defect(rows);
        if defect <= KEPT_DEFECT {
            // To first order the distance to the rotation is half the distance of MT M from 1, of nine entries.
            return Ok(Nearest {
                matrix: Self::wrap(rows),
                distance: 1.5 * defect,
            });
        }
        let polar = polar(scaled);
        // Newton's iteration leaves some ulp; through the quaternion the matrix is orthonormal to 2 ulp.
        let matrix = quaternion(polar).matrix();
        Ok(Nearest {
            matrix,
            distance: distance(rows, matrix.rows()),
        })
    }
}

/// The largest entry of abs(MT M - 1), exact to 2^-100; infinite where entries are above 2.
fn defect(m: Rows) -> f64 {
    if exact::largest(flat(m)) > 2.0 {
        return f64::INFINITY;
    }
    let column = |j: usize| [m[0][j], m[1][j], m[2][j]];
    let pairs = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];
    pairs.iter().fold(0.0, |worst, &(i, j)| {
        let (high, low) = exact::dot(column(i), column(j));
        let want = if i == j { 1.0 } else { 0.0 };
        ((high - want) + low).abs().max(worst)
    })
}

/// The matrix times the power of two that brings its largest entry to between 1 and 2; zero stays.
fn scaled(m: Rows) -> Rows {
    let most = exact::largest(flat(m));
    if most == 0.0 {
        return m;
    }
    // In two steps, since one alone may be beyond the numbers: denormals first become normal.
    let lift = if most < 1e-300 { 2f64.powi(200) } else { 1.0 };
    // The exponent field of a normal number, without its bias.
    let exponent = ((most * lift).to_bits() >> 52) as i32 - 1023;
    let (half, rest) = (-exponent / 2, -exponent - (-exponent / 2));
    let (half, rest) = (power_of_two(half), power_of_two(rest));
    m.map(|row| row.map(|x| x * lift * half * rest))
}

/// 2^exponent, of exponents from -1022 to 1023.
fn power_of_two(exponent: i32) -> f64 {
    f64::from_bits(((exponent + 1023) as u64) << 52)
}

fn flat(m: Rows) -> [f64; 9] {
    let [[a, b, c], [d, e, f], [g, h, i]] = m;
    [a, b, c, d, e, f, g, h, i]
}

/// The matrix of cofactors: the determinant times the inverse transposed.
fn cofactors([a, b, c]: Rows) -> Rows {
    use super::quaternion::cross;
    [cross(b, c), cross(c, a), cross(a, b)]
}

fn determinant(m: Rows, cofactors: Rows) -> f64 {
    m[0].iter().zip(cofactors[0]).map(|(x, c)| x * c).sum()
}

/// Refuses determinants that are negative, or zero to rounding; the largest entry is between 1 and 2.
fn check_determinant(m: Rows) -> Result<(), RotationError> {
    let c = cofactors(m);
    let determinant = determinant(m, c);
    // Hadamard's bound on the determinant; scaled, the rows' squares cannot overflow.
    let [x, y, z] = m.map(|[a, b, c]| (a * a + b * b + c * c).sqrt());
    if determinant.abs() <= SINGULAR_DETERMINANT * x * y * z {
        Err(RotationError::Singular { determinant })
    } else if determinant < 0.0 {
        Err(RotationError::Reflection { determinant })
    } else {
        Ok(())
    }
}

/// The orthogonal polar factor: X becomes the mean of X and its inverse transposed until nothing moves.
///
/// Each step halves the logarithm of every singular value while it is large, squares its distance to 1 once it is small:
/// 64 are enough for every condition number below 2^50, 4 for a tracker's matrix.
fn polar(m: Rows) -> Rows {
    let mut x = m;
    for _ in 0..64 {
        let c = cofactors(x);
        let determinant = determinant(x, c);
        // C / det is the inverse transposed; the determinant is positive and stays so, as singular values stay
        // positive.
        let next = [0, 1, 2].map(|i| [0, 1, 2].map(|j| 0.5 * (x[i][j] + c[i][j] / determinant)));
        let moved = flat(next)
            .iter()
            .zip(flat(x))
            .fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()));
        x = next;
        // The square of this is the next step's move.
        if moved < 1e-9 {
            break;
        }
    }
    x
}

/// Frobenius norm of the difference.
fn distance(a: Rows, b: Rows) -> f64 {
    let (a, b) = (flat(a), flat(b));
    exact::length([0, 1, 2, 3, 4, 5, 6, 7, 8].map(|i| a[i] - b[i]))
}
