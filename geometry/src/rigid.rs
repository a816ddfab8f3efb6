//! Rigid transforms between two named frames.

use std::fmt;
use std::marker::PhantomData;
use std::ops::Mul;

use nalgebra::{Isometry3, Matrix3, Quaternion, Translation3, UnitQuaternion, Vector3};

use crate::{Direction, Frame, Point, Vector};

/// The rigid transform `to_from_from`: maps coordinates in `From` to coordinates in `To`. Millimetres.
pub struct Rigid<To, From>(Isometry3<f64>, PhantomData<fn() -> (To, From)>);

impl<To, From> Clone for Rigid<To, From> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<To, From> Copy for Rigid<To, From> {}
impl<To, From> PartialEq for Rigid<To, From> {
    fn eq(&self, other: &Self) -> bool {
        self.0 == other.0
    }
}
impl<To: Frame, From: Frame> fmt::Debug for Rigid<To, From> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (q, t) = (self.quaternion(), self.translation_mm());
        write!(f, "Rigid<{} from {}>(q {q:?}, t {t:?} mm)", To::NAME, From::NAME)
    }
}

impl<To, From> Rigid<To, From> {
    pub(crate) const fn wrap(iso: Isometry3<f64>) -> Self {
        Self(iso, PhantomData)
    }

    /// The transform whose frames coincide.
    pub fn identity() -> Self {
        Self::wrap(Isometry3::identity())
    }

    /// The transform with rotation vector `rotation` (axis times angle, radians) and translation `translation_mm`, both in `To`.
    pub fn from_rotation_vector(rotation: Vector<To>, translation_mm: Vector<To>) -> Self {
        let q = unit_quaternion_from_rotation_vector(rotation.0);
        Self::wrap(Isometry3::from_parts(Translation3::from(translation_mm.0), q))
    }

    /// The frame whose third axis is `z` and whose second axis is as near to `y` as it can be, with its origin at `origin`.
    ///
    /// `None` where `z` and `y` are parallel to 1e-12.
    pub fn from_axes(origin: Point<To>, z: Direction<To>, y: Direction<To>) -> Option<Self> {
        let x = Vector::<To>::wrap(y.0.cross(&z.0));
        if x.norm() < 1e-12 {
            return None;
        }
        let x = x.direction()?.0;
        let matrix = Matrix3::from_columns(&[x, z.0.cross(&x), z.0]);
        let rotation = nalgebra::Rotation3::from_matrix_unchecked(matrix);
        let q = UnitQuaternion::from_rotation_matrix(&rotation);
        Some(Self::wrap(Isometry3::from_parts(Translation3::from(origin.0), q)))
    }

    /// The unit quaternion (w, x, y, z) of the rotation.
    pub fn quaternion(&self) -> [f64; 4] {
        let q = self.0.rotation.quaternion();
        [q.w, q.i, q.j, q.k]
    }

    /// The translation, in `To`, mm.
    pub fn translation_mm(&self) -> [f64; 3] {
        self.0.translation.vector.into()
    }

    /// `from_from_to`: the other way.
    pub fn inverse(&self) -> Rigid<From, To> {
        Rigid::wrap(self.0.inverse())
    }

    /// The angle of the rotation in radians, 0 to pi.
    pub fn angle(&self) -> f64 {
        self.0.rotation.angle()
    }
}

impl<A, B, C> Mul<Rigid<B, C>> for Rigid<A, B> {
    type Output = Rigid<A, C>;
    fn mul(self, other: Rigid<B, C>) -> Rigid<A, C> {
        Rigid::wrap(self.0 * other.0)
    }
}

impl<To, From> Mul<Point<From>> for Rigid<To, From> {
    type Output = Point<To>;
    fn mul(self, p: Point<From>) -> Point<To> {
        Point::wrap(self.0.rotation * p.0 + self.0.translation.vector)
    }
}

impl<To, From> Mul<Vector<From>> for Rigid<To, From> {
    type Output = Vector<To>;
    fn mul(self, v: Vector<From>) -> Vector<To> {
        Vector::wrap(self.0.rotation * v.0)
    }
}

impl<To, From> Mul<Direction<From>> for Rigid<To, From> {
    type Output = Direction<To>;
    fn mul(self, d: Direction<From>) -> Direction<To> {
        Direction::wrap(self.0.rotation * d.0)
    }
}

/// exp of a rotation vector, without the flush to identity that nalgebra's own constructor makes near zero.
///
/// q = (cos(a/2), sin(a/2)/a * v), a = |v| (thesis, section 2.5.3); sin(a/2)/a -> 1/2 for tiny a.
fn unit_quaternion_from_rotation_vector(v: Vector3<f64>) -> UnitQuaternion<f64> {
    let angle = v.norm();
    let half = angle / 2.0;
    let scale = if angle < 1e-8 { 0.5 } else { half.sin() / angle };
    let q = Quaternion::from_parts(half.cos(), v * scale);
    UnitQuaternion::new_normalize(q)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Ct, Tool, Tracker};
    use proptest::prelude::*;

    fn rigid<A, B>(r: [f64; 3], t: [f64; 3]) -> Rigid<A, B> {
        Rigid::from_rotation_vector(Vector::new(r[0], r[1], r[2]), Vector::new(t[0], t[1], t[2]))
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
