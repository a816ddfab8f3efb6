//! Rotations of 4-space as pairs of unit quaternions.

use std::ops::Mul;

use super::error::finite;
use super::quaternion::product;
use super::{Rotation, RotationError, exact, nearest4};

/// A rotation of 4-space x -> p * x * conj(q), the pair of unit quaternions held (2.59 to 2.64): its matrix is
/// Qg(p) Qd(q). (p, q) and (-p, -q) are the same rotation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rotation4 {
    left: Rotation,
    right: Rotation,
}

/// Up to this distance from a rotation what is of second order is below 2^-53.
const FIRST_ORDER: f64 = 1e-8;

/// A plane that a rotation of 4-space turns in itself: x goes to cos(angle) x + sin(angle) y (2.73).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InvariantPlane {
    /// Two orthonormal vectors, x and y.
    pub basis: [[f64; 4]; 2],
    /// The angle from x to y, radians; 0 to 2 pi in the first plane, of either sign in the second.
    pub angle: f64,
}

impl Rotation4 {
    /// The rotation that leaves everything in place.
    pub const IDENTITY: Self = Self {
        left: Rotation::IDENTITY,
        right: Rotation::IDENTITY,
    };

    /// From the quaternions p and q of x -> p * x * conj(q). Exact.
    pub const fn from_pair(left: Rotation, right: Rotation) -> Self {
        Self { left, right }
    }

    /// The quaternions p and q.
    pub const fn pair(self) -> (Rotation, Rotation) {
        (self.left, self.right)
    }

    /// The matrix Qg(p) Qd(q) by rows. Error: 1 ulp of 1 in each entry; orthonormal to 2 ulp.
    pub fn matrix(self) -> [[f64; 4]; 4] {
        let [p, q] = [self.left, self.right].map(|r| r.quaternion().map(exact::fixed));
        let off = 0.5 * (self.left.excess() + self.right.excess());
        [0, 1, 2, 3].map(|i| [0, 1, 2, 3].map(|j| entry(p, q, i, j, off)))
    }

    /// The rotation nearest to a matrix by rows in the Frobenius norm, and the distance to it.
    ///
    /// Domain: matrices of positive determinant within `tolerance`. Error: 3 ulp within 1e-8 of a rotation, where the
    /// products of the two quaternions' components are read off at once; else 8 eps times the condition number, through the
    /// polar decomposition.
    ///
    /// # Errors
    /// [`RotationError::Nan`], [`RotationError::Infinite`]; [`RotationError::Reflection`] where the determinant is negative,
    /// [`RotationError::Singular`] where it is zero to rounding; [`RotationError::NotOrthonormal`] above `tolerance`.
    pub fn from_matrix(rows: [[f64; 4]; 4], tolerance: f64) -> Result<(Self, f64), RotationError> {
        finite("matrix", rows.as_flattened())?;
        let near = Self::factored(rows).map(|r| (r, r.frobenius(rows)));
        let (nearest, distance) = match near {
            // What the factors are wrong by is of second order in the distance.
            Some((rotation, distance)) if distance < FIRST_ORDER => (rotation, distance),
            _ => {
                let polar = nearest4::polar(rows)?;
                let rotation = Self::factored(polar).ok_or(RotationError::Singular { determinant: 0.0 })?;
                (rotation, rotation.frobenius(rows))
            }
        };
        if distance <= tolerance {
            return Ok((nearest, distance));
        }
        Err(RotationError::NotOrthonormal { distance, tolerance })
    }

    /// The quaternions of a matrix that is a rotation to rounding, from the rank-one matrix of their components' products.
    fn factored(rows: [[f64; 4]; 4]) -> Option<Self> {
        let a = products(rows);
        let best = (1..4).fold(0, |best, l| if column(a, l) > column(a, best) { l } else { best });
        // Two steps of the power method: the second vector is right to first order whatever the first one's error.
        // The largest column of a rank-one matrix is its left vector, and the one farthest from zero.
        let start = exact::unit([0, 1, 2, 3].map(|k| a[k][best]))?;
        let right = exact::unit([0, 1, 2, 3].map(|l| (0..4).map(|k| a[k][l] * start[k]).sum()))?;
        let left = exact::unit(a.map(|row| (0..4).map(|l| row[l] * right[l]).sum()))?;
        Some(Self {
            left: Rotation::wrap(left),
            right: Rotation::wrap(right),
        })
    }

    fn frobenius(self, rows: [[f64; 4]; 4]) -> f64 {
        let m = self.matrix();
        exact::length([0, 1, 2, 3].map(|i| exact::length([0, 1, 2, 3].map(|j| m[i][j] - rows[i][j]))))
    }

    /// The inverse: both conjugates. Exact.
    pub fn inverse(self) -> Self {
        Self {
            left: self.left.inverse(),
            right: self.right.inverse(),
        }
    }

    /// The image p * x * conj(q) of a vector, in its unit; error below 6 ulp of its norm.
    pub fn apply(self, x: [f64; 4]) -> [f64; 4] {
        product(product(self.left.quaternion(), x), self.right.inverse().quaternion())
    }

    /// Two orthogonal planes that the rotation turns in themselves, the larger angle first (2.72).
    ///
    /// Singular set: isoclinic rotations (both angles equal), which turn infinitely many planes in themselves; one pair
    /// of them is returned. Error: the angles 4 ulp of the larger; a basis 8 ulp divided by the smaller of abs(g), abs(h)
    /// as a share of the larger, but always orthonormal to 8 ulp.
    pub fn invariant_planes(self) -> [InvariantPlane; 2] {
        let (g, h) = self.log().factors();
        let [ng, nh] = [g, h].map(exact::length::<3>);
        let [g, h] = [g, h].map(|v| exact::unit(v).unwrap_or([1.0, 0.0, 0.0]));
        // On the plane where Hg = Hd of the unit vectors the angles add up, on the other one they are subtracted.
        [plane(g, h, 1.0, ng + nh), plane(g, h, -1.0, ng - nh)]
    }
}

/// The composition: turns by `other` first (2.61, 2.64). Error: 6 ulp.
impl Mul for Rotation4 {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        Self {
            left: self.left * other.left,
            right: self.right * other.right,
        }
    }
}

/// The sign of the product of the units e_a and e_b of the quaternions (2.7), which is plus or minus e_(a xor b).
const SIGN: [[f64; 4]; 4] = [
    [1.0, 1.0, 1.0, 1.0],
    [1.0, -1.0, 1.0, -1.0],
    [1.0, -1.0, -1.0, 1.0],
    [1.0, 1.0, -1.0, -1.0],
];

/// e_k * e_j * conj(e_l) = sign e_(k xor j xor l): the sign.
#[inline]
fn sign(k: usize, j: usize, l: usize) -> f64 {
    let conjugate = if l == 0 { 1.0 } else { -1.0 };
    SIGN[k][j] * SIGN[k ^ j][l] * conjugate
}

/// Entry i, j of Qg(p) Qd(q) / (1 + off): the coefficient of e_i in p * e_j * conj(q), rounded once.
#[inline]
fn entry(p: [(f64, f64); 4], q: [(f64, f64); 4], i: usize, j: usize, off: f64) -> f64 {
    let (mut high, mut low) = (0.0, 0.0);
    for (k, factor) in p.into_iter().enumerate() {
        // e_k e_j conj(e_l) is plus or minus e_(k xor j xor l): one l for each k.
        let l = k ^ i ^ j;
        let (product, rest) = exact::fixed_product(factor, q[l]);
        high += sign(k, j, l) * product;
        low += sign(k, j, l) * rest;
    }
    // Divided by 1 + off to first order, as off is a few ulp.
    high + (low - (high + low) * off)
}

/// The products p_k q_l from the matrix that is linear in them: the 16 matrices of the products of units are orthogonal.
fn products(m: [[f64; 4]; 4]) -> [[f64; 4]; 4] {
    let of = |k: usize, l: usize| 0.25 * (0..4).map(|j| sign(k, j, l) * m[k ^ j ^ l][j]).sum::<f64>();
    [0, 1, 2, 3].map(|k| [0, 1, 2, 3].map(|l| of(k, l)))
}

fn column(a: [[f64; 4]; 4], l: usize) -> f64 {
    exact::largest([0, 1, 2, 3].map(|k| a[k][l]))
}

/// The plane on which Hg(g) x = side Hd(h) x for unit g and h, its basis x and Hg(g) x.
fn plane(g: [f64; 3], h: [f64; 3], side: f64, angle: f64) -> InvariantPlane {
    let [g, h] = [g, h].map(|[x, y, z]| [0.0, x, y, z]);
    let minus_h = h.map(|c| -c);
    // Hg Hd is -side on the plane: project the unit vectors, and take the longest projection.
    let candidates = [0, 1, 2, 3].map(|n| {
        let mut e = [0.0; 4];
        e[n] = 1.0;
        let image = product(product(g, e), minus_h);
        [0, 1, 2, 3].map(|i| 0.5 * (e[i] - side * image[i]))
    });
    let longest = candidates
        .into_iter()
        .max_by(|a, b| exact::length(*a).total_cmp(&exact::length(*b)));
    let x = longest.and_then(exact::unit).unwrap_or([1.0, 0.0, 0.0, 0.0]);
    InvariantPlane {
        basis: [x, product(g, x)],
        angle,
    }
}
