//! Rigid transforms between two named frames.

use std::fmt;
use std::marker::PhantomData;
use std::ops::Mul;

use nalgebra::Vector3;

use crate::rotation::{Rotation, RotationError, RotationVector, finite, nearly_orthonormal};
use crate::{Direction, Frame, Point, Vector};

/// The rigid transform `to_from_from`: maps coordinates in `From` to coordinates in `To`, p -> R p + t. Millimetres.
///
/// The rotation is a [`Rotation`], so NaN and quaternions that are not unit cannot get in, and what goes in comes out bit
/// for bit. Every composition puts the quaternion's norm back to 1: abs(q)^2 stays within 3.5 ulp of 1 however many are
/// multiplied, see [`Rotation`]'s product.
pub struct Rigid<To, From> {
    rotation: Rotation,
    translation: Vector3<f64>,
    frames: PhantomData<fn() -> (To, From)>,
}

impl<To, From> Clone for Rigid<To, From> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<To, From> Copy for Rigid<To, From> {}
impl<To, From> PartialEq for Rigid<To, From> {
    fn eq(&self, other: &Self) -> bool {
        self.rotation == other.rotation && self.translation == other.translation
    }
}
impl<To: Frame, From: Frame> fmt::Debug for Rigid<To, From> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (q, t) = (self.quaternion(), self.translation_mm());
        write!(f, "Rigid<{} from {}>(q {q:?}, t {t:?} mm)", To::NAME, From::NAME)
    }
}

impl<To, From> Rigid<To, From> {
    /// The transform whose frames coincide.
    pub const fn identity() -> Self {
        Self::wrap(Rotation::IDENTITY, Vector3::new(0.0, 0.0, 0.0))
    }

    const fn wrap(rotation: Rotation, translation: Vector3<f64>) -> Self {
        Self {
            rotation,
            translation,
            frames: PhantomData,
        }
    }

    /// p -> R p + t from the rotation R and the translation t in `To`, mm. Exact.
    pub const fn from_parts(rotation: Rotation, translation_mm: Vector<To>) -> Self {
        Self::wrap(rotation, translation_mm.0)
    }

    /// The transform with rotation vector `rotation` (axis times angle, radians) and translation `translation_mm`, both in
    /// `To`. Error of the rotation as [`Rotation::from_vector`].
    ///
    /// # Errors
    /// [`RotationError::Nan`] and [`RotationError::Infinite`], for either vector.
    pub fn from_rotation_vector(rotation: Vector<To>, translation_mm: Vector<To>) -> Result<Self, RotationError> {
        let vector = RotationVector::new(rotation.0.into())?;
        finite("translation", translation_mm.0.as_slice())?;
        Ok(Self::from_parts(Rotation::from_vector(vector), translation_mm))
    }

    /// The frame whose third axis is `z` and whose second axis is as near to `y` as it can be, with its origin at `origin`.
    ///
    /// `None` where `z` and `y` are parallel to 1e-12. Error: 4 ulp of 1 in the third axis, that divided by the sine of the
    /// angle between `z` and `y` in the others.
    pub fn from_axes(origin: Point<To>, z: Direction<To>, y: Direction<To>) -> Option<Self> {
        let x = Vector::<To>::wrap(y.0.cross(&z.0));
        if x.norm() < 1e-12 {
            return None;
        }
        let x = x.direction()?.0;
        // x is normal to both, so that y = z x x lies in the plane of z and the y given: as near to it as can be.
        let (y, z) = (z.0.cross(&x), z.0);
        let rows = [0, 1, 2].map(|i| [x[i], y[i], z[i]]);
        Some(Self::wrap(nearly_orthonormal(rows), origin.0))
    }

    /// The rotation, which turns coordinates in `From` to the axes of `To`.
    #[inline]
    pub const fn rotation(&self) -> Rotation {
        self.rotation
    }

    /// The unit quaternion (w, x, y, z) of the rotation.
    pub const fn quaternion(&self) -> [f64; 4] {
        self.rotation.quaternion()
    }

    /// The translation: the place of `From`'s origin in `To`, mm.
    #[inline]
    pub const fn translation(&self) -> Vector<To> {
        Vector::wrap(self.translation)
    }

    /// The translation, in `To`, mm.
    pub fn translation_mm(&self) -> [f64; 3] {
        self.translation.into()
    }

    /// `from_from_to`: the other way. The rotation exact, the translation as [`Rotation::apply`].
    pub fn inverse(&self) -> Rigid<From, To> {
        let back = self.rotation.inverse();
        // p = R^T (q - t) = R^T q - R^T t.
        Rigid::wrap(back, -turned(back, self.translation))
    }

    /// R v + t of components in `From`, mm.
    #[inline]
    fn moved(&self, v: Vector3<f64>) -> Vector3<f64> {
        turned(self.rotation, v) + self.translation
    }

    /// The angle of the rotation in radians, 0 to pi, to 3 ulp of itself.
    pub fn angle(&self) -> f64 {
        self.rotation.angle()
    }
}

/// The rotation applied to components.
#[inline]
fn turned(rotation: Rotation, v: Vector3<f64>) -> Vector3<f64> {
    Vector3::from(rotation.apply(v.into()))
}

impl<A, B, C> Mul<Rigid<B, C>> for Rigid<A, B> {
    type Output = Rigid<A, C>;
    #[inline]
    fn mul(self, other: Rigid<B, C>) -> Rigid<A, C> {
        Rigid::wrap(self.rotation * other.rotation, self.moved(other.translation))
    }
}

impl<To, From> Mul<Point<From>> for Rigid<To, From> {
    type Output = Point<To>;
    #[inline]
    fn mul(self, p: Point<From>) -> Point<To> {
        Point::wrap(self.moved(p.0))
    }
}

impl<To, From> Mul<Vector<From>> for Rigid<To, From> {
    type Output = Vector<To>;
    #[inline]
    fn mul(self, v: Vector<From>) -> Vector<To> {
        Vector::wrap(turned(self.rotation, v.0))
    }
}

impl<To, From> Mul<Direction<From>> for Rigid<To, From> {
    type Output = Direction<To>;
    #[inline]
    fn mul(self, d: Direction<From>) -> Direction<To> {
        Direction::wrap(turned(self.rotation, d.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Ct, Tool, Tracker};
    use proptest::prelude::*;

    fn rigid<A, B>(r: [f64; 3], t: [f64; 3]) -> Rigid<A, B> {
        Rigid::from_rotation_vector(Vector::new(r[0], r[1], r[2]), Vector::new(t[0], t[1], t[2])).unwrap()
    }

    proptest! {
        #[test]
        fn inverse_undoes(r in prop::array::uniform3(-3.0..3.0), t in prop::array::uniform3(-500.0..500.0),
                          p in prop::array::uniform3(-500.0..500.0)) {
            let ct_from_tool: Rigid<Ct, Tool> = rigid(r, t);
            let p = Point::<Tool>::new(p[0], p[1], p[2]);
            let back = ct_from_tool.inverse() * (ct_from_tool * p);
            // About twenty roundings of numbers below 2000 mm.
            prop_assert!(back.distance(p) < 20.0 * 2000.0 * f64::EPSILON);
        }

        #[test]
        fn composition_is_application(r in prop::array::uniform3(-3.0..3.0), s in prop::array::uniform3(-3.0..3.0),
                                      p in prop::array::uniform3(-500.0..500.0)) {
            let ct_from_tracker: Rigid<Ct, Tracker> = rigid(r, [1.0, -2.0, 3.0]);
            let tracker_from_tool: Rigid<Tracker, Tool> = rigid(s, [-4.0, 5.0, 60.0]);
            let p = Point::<Tool>::new(p[0], p[1], p[2]);
            let once = (ct_from_tracker * tracker_from_tool) * p;
            let twice = ct_from_tracker * (tracker_from_tool * p);
            prop_assert!(once.distance(twice) < 40.0 * 1000.0 * f64::EPSILON);
        }
    }

    #[test]
    fn tiny_rotations_are_kept() {
        let r: Rigid<Ct, Tool> = rigid([1e-300, 0.0, 0.0], [0.0; 3]);
        assert_eq!(r.quaternion()[1], 0.5e-300);
        let back = r.inverse() * r;
        assert_eq!(back.rotation(), Rotation::IDENTITY);
    }

    #[test]
    fn what_is_not_finite_is_refused() {
        for bad in [f64::NAN, f64::INFINITY] {
            let (good, bad) = (Vector::<Ct>::new(0.0, 1.0, 0.0), Vector::new(0.0, 1.0, bad));
            assert!(Rigid::<Ct, Tool>::from_rotation_vector(bad, good).is_err());
            assert!(Rigid::<Ct, Tool>::from_rotation_vector(good, bad).is_err());
        }
    }

    /// A million transforms of every angle: the norm stays within the bound of one product, and no factor is lost.
    #[test]
    fn the_norm_does_not_drift() {
        let step: Rigid<Ct, Ct> = rigid([0.7, -1.1, 2.3], [1.0, -2.0, 3.0]);
        let mut product = Rigid::<Ct, Ct>::identity();
        let mut worst = 0.0f64;
        for _ in 0..1_000_000 {
            product = product * step;
            worst = worst.max(product.rotation().excess().abs());
        }
        assert!(worst <= 3.5 * f64::EPSILON, "{worst:e}");
        // Each product adds at most 4 ulp to the angle, and the power of the one step is known.
        let turns = 1e6 * step.angle();
        let angle = RotationVector::new(step.rotation().axis_angle().axis().map(|c| c * turns)).unwrap();
        let drift = Rotation::from_vector(angle).distance(product.rotation());
        assert!(drift < 8.0 * 1e6 * f64::EPSILON, "{drift:e}");
    }

    #[test]
    fn axes_give_a_proper_rotation() {
        let z = Vector::<Ct>::new(1.0, 1.0, 0.2).direction().unwrap();
        let r: Rigid<Ct, Tool> = Rigid::from_axes(Point::new(1.0, 2.0, 3.0), z, Direction::Z).unwrap();
        let got = r * Direction::<Tool>::Z;
        assert!((got.vector() - z.vector()).norm() < 8.0 * f64::EPSILON);
        assert!((r * Direction::<Tool>::Y).dot(Direction::Z) > 0.9);
        assert!(Rigid::<Ct, Tool>::from_axes(Point::new(0.0, 0.0, 0.0), z, z).is_none());
    }
}
