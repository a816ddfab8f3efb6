//! The pivot: a rotation of space as a unit quaternion.

use std::ops::Mul;

use super::error::finite;
use super::{RotationError, exact};

/// A rotation of space, held as a unit quaternion (s, u1, u2, u3) (2.27), its norm 1 to 2.5 ulp.
///
/// q and -q are the same rotation (2.30); equality is of the numbers, so that q != -q here. Use [`Rotation::distance`]
/// to compare rotations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rotation([f64; 4]);

/// A quaternion whose squared norm is this near to 1 keeps its bits, so that poses go through files unchanged: what the
/// norm of a [`Rotation`] may be off by, however it came about.
const KEPT_NORM_DEFECT: f64 = 5.0 * f64::EPSILON;

impl Rotation {
    /// The rotation that leaves everything in place.
    pub const IDENTITY: Self = Self([1.0, 0.0, 0.0, 0.0]);

    /// From a quaternion (s, u1, u2, u3) of any length above zero, which is divided by its norm unless that is 1 to 2.5 ulp.
    ///
    /// Domain: any finite quaternion but zero, from the smallest to the largest numbers. Error: 1 ulp.
    ///
    /// # Errors
    /// [`RotationError::Nan`], [`RotationError::Infinite`], [`RotationError::Zero`].
    pub fn from_quaternion(q: [f64; 4]) -> Result<Self, RotationError> {
        finite("quaternion", &q)?;
        Self::normalised(q).ok_or(RotationError::Zero { what: "quaternion" })
    }

    /// q / abs(q), or q itself where it is unit already; `None` for zero. The components are finite.
    pub(crate) fn normalised(q: [f64; 4]) -> Option<Self> {
        // `excess` splits numbers up to 2 only.
        if exact::largest(q) <= 2.0 && excess(q).abs() <= KEPT_NORM_DEFECT {
            return Some(Self(q));
        }
        exact::unit(q).map(Self)
    }

    /// A quaternion divided by its norm in plain arithmetic, its largest component between 2^-100 and 2^100.
    ///
    /// 1 ulp in each component; what its norm is off by goes unseen into no conversion, since each divides it out.
    #[inline]
    pub(crate) fn nearly(q: [f64; 4]) -> Self {
        let scale = 1.0 / q.iter().map(|x| x * x).sum::<f64>().sqrt();
        Self(q.map(|x| x * scale))
    }

    /// Wraps a quaternion whose norm the caller knows to be 1 to 2.5 ulp.
    #[inline]
    pub(crate) const fn wrap(q: [f64; 4]) -> Self {
        Self(q)
    }

    /// The quaternion (s, u1, u2, u3).
    #[inline]
    pub const fn quaternion(self) -> [f64; 4] {
        self.0
    }

    /// abs(q)^2 - 1, to 2^-78: what is left of rounding.
    #[inline]
    pub(crate) fn excess(self) -> f64 {
        excess(self.0)
    }

    /// The inverse: the conjugate (2.4). Exact.
    #[inline]
    pub fn inverse(self) -> Self {
        let [s, x, y, z] = self.0;
        Self([s, -x, -y, -z])
    }

    /// The image q * v * conj(q) of a vector, in the vector's unit (2.27); error below 19 eps of abs(v).
    ///
    /// v + 2 s (u x v) + 2 u x (u x v): tiny rotations move by an amount exact to their own size. The bound adds, in half
    /// eps, 3.5 for the second term, 10 for the third, 3 for the sums and 20 for what the norm's square is off by, 5 eps at
    /// most of a displacement of at most 2 abs(v).
    #[inline]
    pub fn apply(self, v: [f64; 3]) -> [f64; 3] {
        let [s, x, y, z] = self.0;
        let u = [x, y, z];
        let t = cross(u, v).map(|c| 2.0 * c);
        let w = cross(u, t);
        [0, 1, 2].map(|i| v[i] + (s * t[i] + w[i]))
    }
}

/// abs(q)^2 - 1, to 2^-78 for quaternions that are nearly unit, to a few ulp for components up to 2.
#[inline]
fn excess(q: [f64; 4]) -> f64 {
    let [a, b, c, d] = q.map(|x| exact::fixed_product(exact::fixed(x), exact::fixed(x)));
    // The 1 is taken off while the parts are exact multiples of 2^-52; the rests are of the size of the result.
    ((a.0 - 1.0) + b.0 + c.0 + d.0) + (a.1 + b.1 + c.1 + d.1)
}

/// The vector product.
#[inline]
pub(crate) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// Hamilton's product (2.3) of any two quaternions.
#[inline]
pub(crate) fn product(a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
    let [s, x, y, z] = a;
    let [t, i, j, k] = b;
    [
        s * t - (x * i + y * j + z * k),
        (s * i + t * x) + (y * k - z * j),
        (s * j + t * y) + (z * i - x * k),
        (s * k + t * z) + (x * j - y * i),
    ]
}

/// The composition: `a * b` turns by `b` first, then by `a` (2.30). Error below 4 ulp.
///
/// The norm is put back to 1 each time, so that it does not drift however many are multiplied: abs(q)^2 is within 3.5 ulp
/// of 1 after every product. The square's own rounding is 1.5 ulp (products, two sums and a last one, half an ulp of 1
/// each), the correction's is 1 ulp and those of the components 1 ulp; what Newton leaves out is of second order.
impl Mul for Rotation {
    type Output = Self;
    #[inline]
    fn mul(self, other: Self) -> Self {
        Self(repaired(product(self.0, other.0)))
    }
}

/// A quaternion whose norm is 1 to a few ulp, divided by it: one step of Newton for 1 / sqrt.
#[inline]
pub(crate) fn repaired(q: [f64; 4]) -> [f64; 4] {
    let [s, x, y, z] = q;
    // 1 / sqrt(n) = 1 - (n - 1) / 2 + O((n - 1)^2), and n - 1 is a few ulp.
    let repair = 1.5 - 0.5 * ((s * s + x * x) + (y * y + z * z));
    q.map(|c| c * repair)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rotation::RotationVector;

    /// However a rotation came about, its numbers go through files and back bit for bit.
    #[test]
    fn what_comes_out_goes_in_again() {
        let mut worst = 0.0f64;
        for i in 0..100_000 {
            let angle = |k: f64| 3.6 * (f64::from(i) * k).sin();
            let turn = Rotation::from_vector(RotationVector::wrap([angle(0.7), angle(1.3), angle(2.9)]));
            for q in [
                turn,
                turn.matrix().rotation(),
                turn * turn,
                turn.slerp(turn * turn, 0.3),
            ] {
                worst = worst.max(q.excess().abs());
                assert_eq!(Rotation::from_quaternion(q.quaternion()), Ok(q));
            }
        }
        assert!(worst <= KEPT_NORM_DEFECT, "{worst:e}");
    }
}
