//! How the force on the tube changes with its pose: for forces between frames, at the rate of a device that is held.

use nalgebra::{Matrix6, Vector3, Vector6};

use super::present::{Pressing, Response, Yielding};

/// A small motion of the tube: its origin's way, and a turn about that.
type Motion = (Vector3<f64>, Vector3<f64>);

impl Pressing {
    /// How a point of the tube, or of bone, at this place moves.
    fn carried(&self, (way, turn): &Motion) -> Vector3<f64> {
        match self.at_bone {
            true => Vector3::zeros(),
            false => way + turn.cross(&self.arm),
        }
    }

    /// What the normal becomes where the point itself is moved too.
    fn turned(&self, motion: &Motion, moved: &Vector3<f64>) -> Vector3<f64> {
        let bent = self.distance.hessian * (moved - self.carried(motion));
        match self.at_bone {
            true => bent,
            false => motion.1.cross(&self.distance.gradient) + bent,
        }
    }
}

impl Yielding<'_> {
    /// The derivative of force and moment on the tube (as [`super::Frames::force`] has them: the moment about the tube's own origin, world's axes) by its
    /// pose: rows force then moment, columns ways then turns about the origin. Points that press go on pressing. Zero without contact; `None` where
    /// rounding has eaten it.
    pub fn stiffness(&self) -> Option<Matrix6<f64>> {
        let mut stiffness = Matrix6::zeros();
        if self.pressing.iter().all(|p| p.at_bone) {
            return Some(stiffness);
        }
        for (k, mut column) in stiffness.column_iter_mut().enumerate() {
            // One column for each motion of the tube.
            let unit = Vector6::from_fn(|i, _| f64::from(u8::from(i == k)));
            let motion = (
                unit.fixed_rows::<3>(0).into_owned(),
                unit.fixed_rows::<3>(3).into_owned(),
            );
            let found = self.under(&motion)?;
            column.copy_from(&change(&self.pressing, &motion, &found));
        }
        Some(stiffness)
    }

    /// The change of force and moment on a tube that stays where it is.
    pub(super) fn on_tube(&self, found: &Response) -> Vector6<f64> {
        change(&self.pressing, &(Vector3::zeros(), Vector3::zeros()), found)
    }

    /// What a motion of the tube does: points that press keep no distance.
    fn under(&self, motion: &Motion) -> Option<Response> {
        let touches = &self.frames.contact.touches;
        let mut own = vec![0.0; touches.unknowns()];
        for p in &self.pressing {
            // With the point at rest; what its own way adds is in the springs.
            let force = p.turned(motion, &Vector3::zeros()) * (p.pressure * p.area);
            touches.push(p.point, &force, &mut own);
        }
        let mut forces = vec![0.0; self.frames.now.a.len()];
        touches.add(&own, &mut forces);
        let kept: Vec<f64> = self
            .pressing
            .iter()
            .map(|p| p.distance.gradient.dot(&p.carried(motion)))
            .collect();
        self.response(&forces, &kept)
    }
}

/// The change of force and moment on the tube.
fn change(pressing: &[Pressing], motion: &Motion, found: &Response) -> Vector6<f64> {
    let mut sum = Vector6::zeros();
    let each = pressing.iter().zip(&found.moved).zip(&found.more);
    for ((p, moved), more) in each.filter(|((p, _), _)| !p.at_bone) {
        let normal = p.distance.gradient;
        let force = normal * (-p.pressure * p.area);
        let change = (normal * *more + p.turned(motion, moved) * p.pressure) * -p.area;
        let moment = (moved - motion.0).cross(&force) + p.arm.cross(&change);
        sum += Vector6::new(change.x, change.y, change.z, moment.x, moment.y, moment.z);
    }
    sum
}
