//! The foot of a place on a surface, by Newton's method.

use nalgebra::{Matrix2, Matrix3, Matrix3x2, Vector3};

use crate::space::cells::Curved;
use crate::space::tube::Distance;

/// Steps at most; from a start within the surface's curvature four or five are made.
const MOST_STEPS: usize = 50;
/// A step of so many units in the last place is the last.
const LAST_STEP: f64 = 8.0 * f64::EPSILON;

/// A point of the surface near a place, down and up the field's slope. `None` where the slope leads to none.
pub(super) fn descend(field: &dyn Curved, start: Vector3<f64>) -> Option<Vector3<f64>> {
    let mut at = start;
    for _ in 0..MOST_STEPS {
        let slope = field.slope(&at);
        let step = slope * (field.value(&at) / slope.norm_squared());
        if !step.iter().all(|s| s.is_finite()) {
            return None;
        }
        at -= step;
        if step.norm() <= LAST_STEP * (at.norm() + (at - start).norm()) {
            return Some(at);
        }
    }
    // What still walks to and fro by its rounding is there as well.
    let slope = field.slope(&at).norm();
    ((field.value(&at) / slope).abs() <= 1e-12 * (at.norm() + (at - start).norm())).then_some(at)
}

/// Signed distance of `x`, its foot sought from a point of the surface on, by steps of `most` at most.
pub(super) fn signed_distance(field: &dyn Curved, x: &Vector3<f64>, start: &Vector3<f64>, most: f64) -> Distance {
    let foot = foot(field, x, start, most);
    let slope = field.slope(&foot);
    let (normal, length) = (unit(&slope), slope.norm());
    let value = (x - foot).dot(&normal);
    let across = Matrix3::identity() - normal * normal.transpose();
    let shape = across * (field.curvature(&foot) / length) * across;
    // Where the place is as far outside a hollow as that is wide no second derivative exists.
    let carried = (Matrix3::identity() + shape * value).try_inverse();
    let hessian = carried.map_or_else(Matrix3::zeros, |inverse| shape * inverse);
    Distance {
        value,
        gradient: normal,
        hessian: (hessian + hessian.transpose()) * 0.5,
    }
}

/// The point of the surface at which `x` lies on the normal.
fn foot(field: &dyn Curved, x: &Vector3<f64>, start: &Vector3<f64>, most: f64) -> Vector3<f64> {
    let (mut at, mut last) = (*start, f64::INFINITY);
    for _ in 0..MOST_STEPS {
        let Some(step) = step(field, x, &at) else {
            return *start;
        };
        let length = step.norm();
        at += step * (most / length).min(1.0);
        // As near as rounding allows: steps become no smaller any more.
        let rounding = LAST_STEP * (x.norm() + at.norm());
        if length <= rounding || (length >= last && length <= 1e6 * rounding) {
            return at;
        }
        last = length;
    }
    at
}

/// A step of Newton's method to the stationary state of `1/2 |x - y|^2` on the surface.
fn step(field: &dyn Curved, x: &Vector3<f64>, at: &Vector3<f64>) -> Option<Vector3<f64>> {
    let slope = field.slope(at);
    let normal = slope.try_normalize(0.0)?;
    let along = -normal * (field.value(at) / slope.norm());
    let tangents = tangents(&normal);
    // The multiplier of the constraint is what of the way lies along the normal.
    let multiplier = (x - at).dot(&normal) / slope.norm();
    let matrix = Matrix3::identity() + field.curvature(at) * multiplier;
    let within: Matrix2<f64> = tangents.transpose() * matrix * tangents;
    let force = tangents.transpose() * ((x - at) - matrix * along);
    // Beyond the centre of curvature the distance has no minimum here: down its slope instead.
    let chosen = within.cholesky().map_or(force, |factor| factor.solve(&force));
    let step = along + tangents * chosen;
    step.iter().all(|s| s.is_finite()).then_some(step)
}

/// The direction of a slope; not a number where a field has none.
pub(super) fn unit(slope: &Vector3<f64>) -> Vector3<f64> {
    slope.try_normalize(0.0).unwrap_or_else(|| Vector3::repeat(f64::NAN))
}

/// Two unit vectors square to a normal and to one another.
fn tangents(normal: &Vector3<f64>) -> Matrix3x2<f64> {
    // Across the axis that it points along least.
    let one = unit(&normal.cross(&Vector3::ith(normal.iamin(), 1.0)));
    Matrix3x2::from_columns(&[one, normal.cross(&one)])
}
