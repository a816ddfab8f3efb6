//! Small motions of rigid transforms: the unknowns of every fit of a pose, in the two conventions that fits use.
//!
//! A motion is a rotation vector `w` and a translation `v`, both in the axes a transform leads to, `To`. After the transform
//! `(R, t)` it makes
//!
//! ```text
//! moved by         p -> exp(w) (R p + t) + v          turning about the origin of `To`                          (1)
//! moved in place   p -> exp(w) R p + t + v'           turning about the image `t` of the origin of `From`       (2)
//! ```
//!
//! The first is the convention of every covariance ([`crate::uncertain`]) and of messages and files. The second is better
//! conditioned where `t` is long beside what was measured, and is used inside fits; what leaves a fit is told apart by its
//! name. Both are the same motion where
//!
//! ```text
//! v' = v + (exp(w) - 1) t = v + w x t + O(w^2)                                                                  (3)
//! ```
//!
//! so a covariance of `(w, v')` is [`crate::Uncertain::from_covariance_about`] the point `t`.

use nalgebra::{Matrix3, Vector3};

use crate::rotation::{Rotation, RotationVector};
use crate::{Rigid, Vector};

/// A small motion: a turn and a shift.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motion {
    /// `w`: rotation vector, rad.
    pub turn: Vector3<f64>,
    /// `v` of (1) or `v'` of (2), mm.
    pub shift: Vector3<f64>,
}

/// A rigid transform without frames: inside a fit, whose axes are of its own making.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// The rotation `R`.
    pub turn: Rotation,
    /// The image `t` of the origin, mm.
    pub shift: Vector3<f64>,
}

impl Motion {
    /// The turn `exp(w)`; `None` where `w` is not finite.
    fn rotation(&self) -> Option<Rotation> {
        Some(Rotation::from_vector(RotationVector::new(self.turn.into()).ok()?))
    }
}

impl Pose {
    /// `R` as a matrix.
    pub fn matrix(&self) -> Matrix3<f64> {
        self.turn.matrix().into()
    }

    /// The motion (1) after this pose; `None` where its turn is not finite.
    pub fn moved_by(&self, motion: &Motion) -> Option<Self> {
        let turn = motion.rotation()?;
        Some(Self {
            turn: turn * self.turn,
            shift: Vector3::from(turn.apply(self.shift.into())) + motion.shift,
        })
    }

    /// The motion (2) after this pose; `None` where its turn is not finite.
    pub fn moved_in_place(&self, motion: &Motion) -> Option<Self> {
        Some(Self {
            turn: motion.rotation()? * self.turn,
            // The image t of the origin is what the turn is about, so that only the shift moves it.
            shift: self.shift + motion.shift,
        })
    }
}

impl<To, From> Rigid<To, From> {
    /// The motion (1) after this transform; `None` where its turn is not finite.
    pub fn moved_by(&self, motion: &Motion) -> Option<Self> {
        let pose = Pose {
            turn: self.rotation(),
            shift: self.translation_mm().into(),
        };
        let Pose { turn, shift } = pose.moved_by(motion)?;
        Some(Self::from_parts(turn, Vector::new(shift.x, shift.y, shift.z)))
    }

    /// The motion (1) that makes this transform `other`: the turn of at most pi.
    pub fn motion_to(&self, other: &Self) -> Motion {
        let turn = other.rotation() * self.rotation().inverse();
        // (1) with `turn` is R' p + t' = turn (R p + t) + v, hence v = t' - turn t.
        let carried = Vector3::from(turn.apply(self.translation_mm()));
        Motion {
            turn: turn.vector().radians().into(),
            shift: Vector3::from(other.translation_mm()) - carried,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::uncertain::Uncertain;
    use crate::{Marker, Point, Tracker};
    use nalgebra::{Matrix6, Vector6};

    const POSES: [([f64; 3], [f64; 3]); 4] = [
        ([0.0, 0.0, 0.0], [0.0, 0.0, 0.0]),
        ([0.7, -1.9, 0.4], [30.0, -120.0, 55.0]),
        ([0.0, std::f64::consts::PI, 0.0], [-2000.0, 900.0, 1400.0]),
        ([1e-9, 0.0, 1e-9], [1e-6, 0.0, 0.0]),
    ];

    fn pose((w, t): ([f64; 3], [f64; 3])) -> Pose {
        Pose {
            turn: Rotation::from_vector(RotationVector::new(w).unwrap()),
            shift: t.into(),
        }
    }

    /// (3) to first order: what is left is w^2 t / 2, and rounding of t.
    #[test]
    fn both_conventions_agree_at_first_order() {
        let v = Vector3::new(0.3, -0.2, 0.5);
        for parts in POSES {
            let pose = pose(parts);
            for size in [1e-2, 1e-4, 1e-6] {
                let turn = Vector3::new(0.6, -0.48, 0.64) * size;
                let by = pose.moved_by(&Motion { turn, shift: v }).unwrap();
                let shift = v + turn.cross(&pose.shift);
                let in_place = pose.moved_in_place(&Motion { turn, shift }).unwrap();
                let bound = pose.shift.norm() * (0.5 * size * size + 8.0 * f64::EPSILON) + 1e-15;
                assert_eq!(by.turn, in_place.turn);
                assert!((by.shift - in_place.shift).norm() <= bound, "{parts:?} {size}");
            }
        }
    }

    /// The same motion by the shift of (3) in full, to rounding, and one is not the other.
    #[test]
    fn one_convention_is_not_the_other() {
        let pose = pose(POSES[1]);
        let turn = Vector3::new(0.3, 0.2, -0.7);
        let motion = Motion {
            turn,
            shift: Vector3::zeros(),
        };
        let by = pose.moved_by(&motion).unwrap();
        assert!((by.shift - pose.shift).norm() > 50.0);
        assert_eq!(pose.moved_in_place(&motion).unwrap().shift, pose.shift);
    }

    /// By matrices alone: the exponential as its power series.
    #[test]
    fn the_motion_is_the_matrix_exponential_of_the_turn_about_the_origin() {
        let turn = Vector3::new(0.02, -0.05, 0.03);
        let (mut series, mut term) = (Matrix3::<f64>::identity(), Matrix3::<f64>::identity());
        for k in 1..20 {
            term = term * turn.cross_matrix() / f64::from(k);
            series += term;
        }
        for parts in POSES {
            let (pose, shift) = (pose(parts), Vector3::new(1.0, 2.0, -3.0));
            let moved = pose.moved_by(&Motion { turn, shift }).unwrap();
            assert!((moved.matrix() - series * pose.matrix()).amax() < 1e-15);
            assert!((moved.shift - (series * pose.shift + shift)).amax() < 1e-15 * (10.0 + pose.shift.norm()));
        }
    }

    #[test]
    fn the_motion_to_another_transform_leads_there() {
        for (a, b) in [(0, 1), (1, 2), (2, 1), (3, 0), (1, 1)] {
            let rigid = |k: usize| {
                let Pose { turn, shift } = pose(POSES[k]);
                Rigid::<Tracker, Marker>::from_parts(turn, Vector::new(shift.x, shift.y, shift.z))
            };
            let (from, to) = (rigid(a), rigid(b));
            let reached = from.moved_by(&from.motion_to(&to)).unwrap();
            assert!(reached.rotation().distance(to.rotation()) < 1e-15);
            let off = Vector3::from(reached.translation_mm()) - Vector3::from(to.translation_mm());
            assert!(off.amax() < 1e-12, "{a} {b}: {off}");
        }
    }

    /// A covariance of the second convention about `t` is one of the first, seen by what points move by.
    #[test]
    fn a_covariance_in_place_is_one_about_the_image_of_the_origin() {
        let pose = pose(POSES[1]);
        let rigid = Rigid::<Tracker, Marker>::from_parts(pose.turn, Vector::new(30.0, -120.0, 55.0));
        let factor =
            Matrix6::from_fn(|i, j| 1e-3 * f64::from((i * 7 + j * 3) as u8 % 11) + if i == j { 0.01 } else { 0.0 });
        let about = Point::new(30.0, -120.0, 55.0);
        let uncertain = Uncertain::from_covariance_about(about, rigid, factor * factor.transpose()).unwrap();
        let p = Point::<Marker>::new(4.0, -25.0, 60.0);
        let predicted = (uncertain * p).covariance();
        // The columns of the factor are motions whose squares add up to the covariance; differences of h.
        let h = 1e-6;
        let mut counted = Matrix3::<f64>::zeros();
        for column in 0..6 {
            let motion: Vector6<f64> = factor.column(column) * h;
            let step = |sign: f64| {
                let (turn, shift) = (motion.fixed_rows::<3>(0) * sign, motion.fixed_rows::<3>(3) * sign);
                let moved = pose.moved_in_place(&Motion { turn, shift }).unwrap();
                moved.matrix() * Vector3::from(p.mm()) + moved.shift
            };
            let slope = (step(1.0) - step(-1.0)) / (2.0 * h);
            counted += slope * slope.transpose();
        }
        // A difference of points 200 mm away is rounded by eps x 200 mm / 2 h = 2.2e-8; times twice a slope, below 2.3 mm, and six
        // columns: 6.1e-7.
        assert!((counted - predicted).amax() < 1e-6, "{counted} {predicted}");
    }
}
