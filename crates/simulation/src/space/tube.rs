//! A rigid tube: a chain of round cones along a bent axis, with its signed distance in closed form.
//!
//! The axis is a polyline; each of its points has a radius. A segment with its two radii is the union of the spheres between
//! them, centre and radius linear along it: the convex hull of the two spheres at its ends, a capsule where the radii agree.
//! The tube is the union of its segments, so its ends and bends are round. One point alone is a sphere.
//!
//! * [`Tube::signed_distance`]: value, normal and second derivatives at a point, for contact.
//! * [`Tube::first_touch`]: how far along a straight way a point may go until it touches the tube.
//! * [`Sweep`]: the same while the tube turns and slides from one pose to another.
//!
//! # Where the distance is exact
//!
//! Outside and at the surface the value is the distance to the tube. Inside it is the least of the segments' own signed
//! distances. That is the exact depth where one segment alone is left; where segments overlap it never overstates
//! the way out. It is continuous, and no two places differ by more than the way between them.
//!
//! # Where derivatives jump
//!
//! First derivatives are continuous outside except where two segments are equally near (beside the inside of a bend): there
//! the first of the two in the order of the axis answers. Second derivatives also jump where the foot reaches the end of
//! a segment (a side curves once, a sphere twice): the end itself answers as the sphere. On the axis a normal does not
//! exist, and [`Distance`] says which is given.
//!
//! Lengths are in any consistent unit; no tolerance is absolute. Lengths, offsets included, between 1e-70 and 1e70 neither vanish nor overflow.

mod cone;
mod distance;
mod hit;
mod screw;
mod sweep;
#[cfg(test)]
mod tests;

use nalgebra::{Isometry3, Point3, Vector3};

use cone::Cone;
pub use distance::Distance;
pub use sweep::{Sweep, SweepError};

/// Quaternions of single precision have unit length to 1e-7.
const UNIT_TO: f64 = 1e-6;

/// Why a tube was refused.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum TubeError {
    /// The axis has no point.
    #[error("the axis has no points: a tube needs at least one")]
    NoPoints,
    /// Points and radii are not as many.
    #[error("the axis has {points} points but {radii} radii")]
    Count {
        /// The number of points.
        points: usize,
        /// The number of radii.
        radii: usize,
    },
    /// A coordinate of the axis is NaN or infinite.
    #[error("point {index} of the axis is not finite")]
    Point {
        /// Which point, from 0.
        index: usize,
    },
    /// A radius is NaN, infinite, zero or negative.
    #[error("radius {index} is {radius}: a radius is finite and above zero")]
    Radius {
        /// Which radius, from 0.
        index: usize,
        /// The radius given.
        radius: f64,
    },
    /// The pose has a number that is NaN or infinite, or its quaternion not unit length.
    #[error("the pose is not finite, or its quaternion not of unit length")]
    Pose,
}

/// A rigid tube at a pose.
#[derive(Debug, Clone, PartialEq)]
pub struct Tube {
    /// Takes the tube's frame to the world's.
    pose: Isometry3<f64>,
    /// In the tube's frame, in the order of the axis; never empty.
    cones: Vec<Cone>,
}

impl Tube {
    /// The tube along `axis`, points of its own frame, with a radius at each; `pose` takes that frame to the world.
    ///
    /// Points may coincide: such a segment is the larger of its two spheres, as is one whose spheres contain one another.
    ///
    /// # Errors
    ///
    /// A [`TubeError`]: no points, counts that differ, a number that is not finite, a radius that is not above zero.
    pub fn new(pose: Isometry3<f64>, axis: &[Point3<f64>], radii: &[f64]) -> Result<Self, TubeError> {
        check(axis, radii)?;
        check_pose(&pose)?;
        let ends: Vec<_> = axis.iter().map(|p| p.coords).zip(radii.iter().copied()).collect();
        let cones = match ends.as_slice() {
            [one] => vec![Cone::new(*one, *one)],
            many => many.windows(2).map(|w| Cone::new(w[0], w[1])).collect(),
        };
        Ok(Self { pose, cones })
    }

    /// A tube of one radius with round ends, from the centre of its tip's sphere `origin` along `direction`, `length` from
    /// centre to centre.
    ///
    /// # Errors
    ///
    /// As [`Self::new`]; a direction without length is [`TubeError::Point`] 1, as is a length below zero.
    pub fn straight(origin: Point3<f64>, direction: Vector3<f64>, length: f64, radius: f64) -> Result<Self, TubeError> {
        // A length that is NaN fails the comparison, and is refused with those below zero.
        let along = direction
            .try_normalize(0.0)
            .filter(|_| length >= 0.0)
            .ok_or(TubeError::Point { index: 1 })?;
        // The tip is the origin of the tube's own frame: only the pose says where it is.
        let axis = [Point3::origin(), Point3::from(along * length)];
        let pose = Isometry3::translation(origin.x, origin.y, origin.z);
        Self::new(pose, &axis, &[radius; 2])
    }

    /// The same tube elsewhere.
    ///
    /// # Errors
    ///
    /// [`TubeError::Pose`] where a number of the pose is not finite, or its quaternion not of unit length to 1e-6.
    pub fn at(&self, pose: Isometry3<f64>) -> Result<Self, TubeError> {
        check_pose(&pose)?;
        Ok(Self { pose, ..self.clone() })
    }

    /// The least radius at any point of the axis.
    #[must_use]
    pub fn least_radius(&self) -> f64 {
        let each = self.cones.iter().map(|cone| cone.first.radius.min(cone.last.radius));
        each.fold(f64::INFINITY, f64::min)
    }

    /// What no point of the tube goes farther than, mm, where the tube goes to another pose as [`Self::toward`] has it. Above zero unless the
    /// poses are one.
    #[must_use]
    pub fn way_to(&self, pose: &Isometry3<f64>) -> f64 {
        let angle = self.pose.rotation.angle_to(&pose.rotation);
        let along = (pose.translation.vector - self.pose.translation.vector).norm();
        let ends = self.cones.iter().flat_map(|cone| [cone.first, cone.last]);
        let ways = ends.map(|end| {
            let (axis, arm) = (Point3::from(end.centre), end.centre.norm());
            let chord = (pose * axis - self.pose * axis).norm();
            // Velocities on the way differ from their mean, the chord, by half the angle times the arm at most, times the angle.
            (along + angle * arm).min(chord + 0.5 * angle * angle * arm) + angle * end.radius
        });
        ways.fold(0.0, f64::max)
    }

    /// The same tube a part of the way to another pose: the origin along a line, turned about one axis.
    #[must_use]
    pub fn toward(&self, pose: &Isometry3<f64>, part: f64) -> Self {
        let turn = self.pose.rotation.rotation_to(&pose.rotation).powf(part);
        let origin = self.pose.translation.vector.lerp(&pose.translation.vector, part);
        let pose = Isometry3::from_parts(origin.into(), turn * self.pose.rotation);
        Self { pose, ..self.clone() }
    }

    /// The pose: takes the tube's frame to the world's.
    #[must_use]
    pub fn pose(&self) -> &Isometry3<f64> {
        &self.pose
    }

    /// Signed distance of the place `x` (world) to the tube, above zero outside, with two derivatives in the world's frame.
    ///
    /// Exact outside and at the surface; see the [module](self) for the inside and for the places where derivatives jump.
    /// Rounding: a few units in the last place of the largest coordinate of `x` and pose. A place that is not finite gives NaN.
    #[must_use]
    pub fn signed_distance(&self, x: &Vector3<f64>) -> Distance {
        let local = self.pose.inverse_transform_point(&Point3::from(*x)).coords;
        let mut nearest = &self.cones[0];
        let mut least = nearest.value(&local);
        for cone in &self.cones[1..] {
            let value = cone.value(&local);
            // Strictly: of two equally near the first answers.
            if value < least {
                (nearest, least) = (cone, value);
            }
        }
        nearest.distance(&local).turned(&self.pose.rotation)
    }

    /// The value alone of [`Self::signed_distance`], by the same formula and without derivatives.
    #[must_use]
    pub fn distance(&self, x: &Vector3<f64>) -> f64 {
        let local = self.pose.inverse_transform_point(&Point3::from(*x)).coords;
        let values = self.cones[1..].iter().map(|cone| cone.value(&local));
        let first = self.cones[0].value(&local);
        values.fold(first, |least, value| if value < least { value } else { least })
    }

    /// The least `t` in `[0, 1]` at which `x + t d` (world) lies in the closed tube; 0 where `x` already does; none where the
    /// whole way is free.
    ///
    /// Closed form (roots of quadratic equations, discriminants as products that do not cancel): a way that misses or
    /// grazes the tube by 1e-12 of its radius is told apart while `x` is within some hundred radii of it.
    #[must_use]
    pub fn first_touch(&self, x: &Vector3<f64>, d: &Vector3<f64>) -> Option<f64> {
        let local = self.pose.inverse_transform_point(&Point3::from(*x)).coords;
        let way = self.pose.inverse_transform_vector(d);
        self.first_touch_grown(&local, &way, 0.0)
    }

    /// True where the way from `x` to `x + d` (world) leads through what lies deeper than `depth` in the tube; less than the least radius.
    #[must_use]
    pub fn is_crossed(&self, x: &Vector3<f64>, d: &Vector3<f64>, depth: f64) -> bool {
        let local = self.pose.inverse_transform_point(&Point3::from(*x)).coords;
        let way = self.pose.inverse_transform_vector(d);
        self.first_touch_grown(&local, &way, -depth).is_some()
    }

    /// [`Self::first_touch`] in the tube's frame, of the tube with all radii larger by `growth`.
    fn first_touch_grown(&self, x: &Vector3<f64>, d: &Vector3<f64>, growth: f64) -> Option<f64> {
        let touches = self.cones.iter().filter_map(|cone| hit::first(cone, x, d, growth));
        touches.reduce(f64::min)
    }
}

fn check(axis: &[Point3<f64>], radii: &[f64]) -> Result<(), TubeError> {
    if axis.is_empty() {
        return Err(TubeError::NoPoints);
    }
    if axis.len() != radii.len() {
        return Err(TubeError::Count {
            points: axis.len(),
            radii: radii.len(),
        });
    }
    if let Some(index) = axis.iter().position(|p| !p.iter().all(|c| c.is_finite())) {
        return Err(TubeError::Point { index });
    }
    match radii.iter().position(|r| !(r.is_finite() && *r > 0.0)) {
        Some(index) => Err(TubeError::Radius {
            index,
            radius: radii[index],
        }),
        None => Ok(()),
    }
}

fn check_pose(pose: &Isometry3<f64>) -> Result<(), TubeError> {
    let parts = pose.translation.vector.iter().chain(pose.rotation.coords.iter());
    // With another length it would be no rotation: distances would be those of a tube out of shape.
    let unit = (pose.rotation.quaternion().norm() - 1.0).abs() < UNIT_TO;
    if unit && parts.copied().all(f64::is_finite) {
        Ok(())
    } else {
        Err(TubeError::Pose)
    }
}
