//! Points, vectors and directions that know their frame.

use std::fmt;
use std::marker::PhantomData;
use std::ops::{Add, Mul, Neg, Sub};

use nalgebra::Vector3;

use crate::{Ct, Frame};

/// A position in frame `F`; mm in every frame but `Voxel` and `Image`.
pub struct Point<F>(pub(crate) Vector3<f64>, PhantomData<fn() -> F>);

/// A displacement in frame `F`; same unit as [`Point`].
pub struct Vector<F>(pub(crate) Vector3<f64>, PhantomData<fn() -> F>);

/// A unit vector in frame `F`; its norm is 1 to 2 ulp.
pub struct Direction<F>(pub(crate) Vector3<f64>, PhantomData<fn() -> F>);

macro_rules! value_type {
    ($name:ident) => {
        impl<F> Clone for $name<F> {
            fn clone(&self) -> Self {
                *self
            }
        }
        impl<F> Copy for $name<F> {}
        impl<F> PartialEq for $name<F> {
            fn eq(&self, other: &Self) -> bool {
                self.0 == other.0
            }
        }
        impl<F: Frame> fmt::Debug for $name<F> {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                let [x, y, z] = self.0.into();
                write!(f, "{}<{}>({x}, {y}, {z})", stringify!($name), F::NAME)
            }
        }
        impl<F> $name<F> {
            /// Wraps coordinates that the caller has computed in this frame.
            pub(crate) const fn wrap(v: Vector3<f64>) -> Self {
                Self(v, PhantomData)
            }
        }
    };
}
value_type!(Point);
value_type!(Vector);
value_type!(Direction);

impl<F> Point<F> {
    /// A point from coordinates known to be in `F`. Numbers from outside come through [`crate::checked::point`].
    pub const fn new(x: f64, y: f64, z: f64) -> Self {
        Self::wrap(Vector3::new(x, y, z))
    }

    /// The coordinates, in the frame's unit.
    pub fn mm(self) -> [f64; 3] {
        self.0.into()
    }

    /// Euclidean distance to `other`, in the frame's unit.
    pub fn distance(self, other: Self) -> f64 {
        (self.0 - other.0).norm()
    }

    /// The point at fraction `s` of the way to `other`; `s` outside 0..1 extrapolates.
    pub fn lerp(self, other: Self, s: f64) -> Self {
        Self::wrap(self.0 + (other.0 - self.0) * s)
    }
}

impl<F> Vector<F> {
    /// A vector from components known to be in `F`.
    pub const fn new(x: f64, y: f64, z: f64) -> Self {
        Self::wrap(Vector3::new(x, y, z))
    }

    /// The components, in the frame's unit.
    pub fn mm(self) -> [f64; 3] {
        self.0.into()
    }

    /// Euclidean norm.
    pub fn norm(self) -> f64 {
        self.0.norm()
    }

    /// The scalar product.
    pub fn dot(self, other: Self) -> f64 {
        self.0.dot(&other.0)
    }

    /// The vector product.
    pub fn cross(self, other: Self) -> Self {
        Self::wrap(self.0.cross(&other.0))
    }

    /// The direction of this vector, or `None` where it is zero or not finite.
    pub fn direction(self) -> Option<Direction<F>> {
        // Scaled by the largest component first, so that neither tiny nor huge vectors lose their direction; amax alone
        // would skip a NaN.
        let largest = self.0.amax();
        if !self.0.iter().all(|x| x.is_finite()) || largest == 0.0 {
            return None;
        }
        (self.0 / largest).try_normalize(0.0).map(Direction::wrap)
    }
}

impl<F> Direction<F> {
    /// The frame's first axis.
    pub const X: Self = Self::wrap(Vector3::new(1.0, 0.0, 0.0));
    /// The frame's second axis.
    pub const Y: Self = Self::wrap(Vector3::new(0.0, 1.0, 0.0));
    /// The frame's third axis.
    pub const Z: Self = Self::wrap(Vector3::new(0.0, 0.0, 1.0));

    /// The components, without unit.
    pub fn components(self) -> [f64; 3] {
        self.0.into()
    }

    /// The vector of norm 1 along this direction.
    pub const fn vector(self) -> Vector<F> {
        Vector::wrap(self.0)
    }

    /// The cosine of the angle to `other`.
    pub fn dot(self, other: Self) -> f64 {
        self.0.dot(&other.0)
    }

    /// The vector product; its norm is the sine of the angle.
    pub fn cross(self, other: Self) -> Vector<F> {
        Vector::wrap(self.0.cross(&other.0))
    }
}

impl<F> Sub for Point<F> {
    type Output = Vector<F>;
    fn sub(self, other: Self) -> Vector<F> {
        Vector::wrap(self.0 - other.0)
    }
}

impl<F> Add<Vector<F>> for Point<F> {
    type Output = Self;
    fn add(self, v: Vector<F>) -> Self {
        Self::wrap(self.0 + v.0)
    }
}

impl<F> Sub<Vector<F>> for Point<F> {
    type Output = Self;
    fn sub(self, v: Vector<F>) -> Self {
        Self::wrap(self.0 - v.0)
    }
}

impl<F> Add for Vector<F> {
    type Output = Self;
    fn add(self, v: Self) -> Self {
        Self::wrap(self.0 + v.0)
    }
}

impl<F> Sub for Vector<F> {
    type Output = Self;
    fn sub(self, v: Self) -> Self {
        Self::wrap(self.0 - v.0)
    }
}

impl<F> Mul<f64> for Vector<F> {
    type Output = Self;
    fn mul(self, s: f64) -> Self {
        Self::wrap(self.0 * s)
    }
}

impl<F> Mul<f64> for Direction<F> {
    type Output = Vector<F>;
    fn mul(self, s: f64) -> Vector<F> {
        Vector::wrap(self.0 * s)
    }
}

impl<F> Neg for Direction<F> {
    type Output = Self;
    fn neg(self) -> Self {
        Self::wrap(-self.0)
    }
}

impl Point<Ct> {
    /// The place as people read it: `L 12.0  A 158.9  S 3.1 mm`, each coordinate by the side it is on, without a sign and with so
    /// many decimals.
    pub fn in_words(self, decimals: usize) -> String {
        let sides = [["L", "R"], ["P", "A"], ["S", "I"]];
        let words: Vec<String> = sides
            .iter()
            .zip(self.mm())
            .map(|(side, mm)| {
                let digits = format!("{:.decimals$}", mm.abs());
                // What is shown as 0 is on no side: the first letter then.
                let is_other = mm < 0.0 && digits.bytes().any(|c| (b'1'..=b'9').contains(&c));
                format!("{} {digits}", side[usize::from(is_other)])
            })
            .collect();
        format!("{} mm", words.join("  "))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn direction_survives_extreme_lengths() {
        for scale in [1e-308, 1e-160, 1.0, 1e160, 1e307] {
            let d = Vector::<Ct>::new(3.0 * scale, 0.0, 4.0 * scale).direction().unwrap();
            // Two roundings in the scaling, two in the normalisation.
            assert!((d.components()[0] - 0.6).abs() < 4.0 * f64::EPSILON, "{scale}");
            assert!((d.components()[2] - 0.8).abs() < 4.0 * f64::EPSILON, "{scale}");
        }
    }

    #[test]
    fn no_direction_without_length() {
        assert!(Vector::<Ct>::new(0.0, 0.0, 0.0).direction().is_none());
        assert!(Vector::<Ct>::new(f64::NAN, 0.0, 1.0).direction().is_none());
        assert!(Vector::<Ct>::new(f64::INFINITY, 0.0, 1.0).direction().is_none());
    }

    /// `P -158.9` was read as posterior.
    #[test]
    fn a_place_in_words_has_sides_and_no_signs() {
        assert_eq!(
            Point::<Ct>::new(12.0, -158.94, 3.06).in_words(1),
            "L 12.0  A 158.9  S 3.1 mm"
        );
        assert_eq!(
            Point::<Ct>::new(-0.04, -0.06, -1e-9).in_words(1),
            "L 0.0  A 0.1  S 0.0 mm"
        );
        assert_eq!(
            Point::<Ct>::new(-7.25, 0.0, -2.0).in_words(2),
            "R 7.25  P 0.00  I 2.00 mm"
        );
    }
}
