//! How the force on the tube changes with its pose: for forces between frames, at the rate of a device that is held.

use nalgebra::{DMatrix, Matrix3, Matrix6, Vector3, Vector6};

use super::Frames;
use super::contact::Contact;
use crate::space::tube::Tube;
use crate::sparse::Dense;

/// Stiffness of contact by the mean stiffness of an unknown: what it leaves goes with its inverse, round by round.
const STIFFNESS_PART: f64 = 1e4;
/// Rounds, and the gap beside the tube's own way at which they end.
const MOST_ROUNDS: usize = 30;
const ENOUGH: f64 = 1e-8;

/// A point that presses, for small motions of the tube.
struct Pressing {
    point: usize,
    /// From the tube's origin.
    arm: Vector3<f64>,
    normal: Vector3<f64>,
    bend: Matrix3<f64>,
    area: f64,
    pressure: f64,
}

/// A small motion of the tube: its origin's way, and a turn about that.
type Motion = (Vector3<f64>, Vector3<f64>);

impl Pressing {
    /// How a point of the tube at this place moves.
    fn carried(&self, (way, turn): &Motion) -> Vector3<f64> {
        way + turn.cross(&self.arm)
    }

    /// What the normal becomes where the point itself is moved too.
    fn turned(&self, motion: &Motion, moved: &Vector3<f64>) -> Vector3<f64> {
        motion.1.cross(&self.normal) + self.bend * (moved - self.carried(motion))
    }
}

impl Frames {
    /// The derivative of force and moment on the tube (as [`Frames::force`] has them: the moment about the tube's own origin, world's axes) by its
    /// pose: rows force then moment, columns ways then turns about the origin, by the stiffness of tissue that the last factor has, which
    /// may be [`super::Settings::refresh`] and what goes on meanwhile old. Points that press go on pressing. `None` where it is not to be had: after a refusal,
    /// or where a small motion changes the state by much; zero without contact.
    pub fn stiffness(&self) -> Option<Matrix6<f64>> {
        self.contact
            .tube_stiffness(&self.now.pressures, &self.now.a, &self.now.tube)
    }
}

impl Contact {
    fn tube_stiffness(&self, pressures: &[f64], a: &[f64], tube: &Tube) -> Option<Matrix6<f64>> {
        let mut v = Vec::new();
        self.touches.take(a, &mut v);
        let pressing = self.pressing(pressures, &v, tube);
        // After a refusal the points at the tube may still be those of the pose that was refused.
        if pressing.len() < pressures.iter().filter(|p| **p > 0.0).count() {
            return None;
        }
        let mut stiffness = Matrix6::zeros();
        if pressing.is_empty() {
            return Some(stiffness);
        }
        let (local, model) = self.local();
        // Far stiffer than in a search: a derivative takes one linear solution, and what is left falls by this ratio each round.
        let mean_area = pressing.iter().map(|p| p.area).sum::<f64>() / pressing.len() as f64;
        let stiff = STIFFNESS_PART * model.trace() / model.nrows() as f64 / mean_area;
        let mut matrix: DMatrix<f64> = model.clone();
        for p in &pressing {
            let own = (p.normal * p.normal.transpose() * stiff - p.bend * p.pressure) * p.area;
            local.stiffen(p.point, &own, &mut matrix);
        }
        let mut dense = Dense::default();
        if !dense.factor(&matrix) {
            return None;
        }
        for (k, mut column) in stiffness.column_iter_mut().enumerate() {
            // One column for each motion of the tube.
            let unit = Vector6::from_fn(|i, _| f64::from(u8::from(i == k)));
            let motion = (
                unit.fixed_rows::<3>(0).into_owned(),
                unit.fixed_rows::<3>(3).into_owned(),
            );
            let (moved, more) = self.response(&pressing, &dense, stiff, &motion)?;
            column.copy_from(&change(&pressing, &motion, &moved, &more));
        }
        Some(stiffness)
    }

    fn pressing(&self, pressures: &[f64], v: &[f64], tube: &Tube) -> Vec<Pressing> {
        let origin = tube.pose().translation.vector;
        let each = self.points().iter().enumerate().filter(|(_, k)| pressures[**k] > 0.0);
        let pressing = each.map(|(point, k)| {
            let at = self.touches.at(*k, v);
            let distance = tube.signed_distance(&at);
            Pressing {
                point,
                arm: at - origin,
                normal: distance.gradient,
                bend: distance.hessian,
                area: self.touches.area(*k),
                pressure: pressures[*k],
            }
        });
        pressing.collect()
    }

    /// Where points go and what their pressures become when the tube moves: points that press keep no distance.
    fn response(
        &self,
        pressing: &[Pressing],
        dense: &Dense,
        stiff: f64,
        motion: &Motion,
    ) -> Option<(Vec<Vector3<f64>>, Vec<f64>)> {
        let (local, size) = (self.local().0, self.local().1.nrows());
        let mut more = vec![0.0; pressing.len()];
        let most = pressing.iter().map(|p| p.carried(motion).norm()).fold(0.0, f64::max);
        for _ in 0..MOST_ROUNDS {
            let mut y = vec![0.0; size];
            for (p, more) in pressing.iter().zip(&more) {
                // With the point at rest; what its own way adds is in the matrix.
                let pushed = p.turned(motion, &Vector3::zeros()) * p.pressure
                    + p.normal * (more + stiff * p.normal.dot(&p.carried(motion)));
                local.push(p.point, &(pushed * p.area), &mut y);
            }
            // Points follow the tube by a spring each, as stiff as that, and by what pressures have gained.
            dense.solve(&mut y);
            let moved: Vec<Vector3<f64>> = pressing.iter().map(|p| local.displacement(p.point, &y)).collect();
            let mut left = 0.0_f64;
            for ((p, more), moved) in pressing.iter().zip(&mut more).zip(&moved) {
                let gap = p.normal.dot(&(moved - p.carried(motion)));
                *more -= stiff * gap;
                left = left.max(gap.abs());
            }
            if left <= ENOUGH * most {
                return Some((moved, more));
            }
        }
        None
    }
}

/// The change of force and moment on the tube.
fn change(pressing: &[Pressing], motion: &Motion, moved: &[Vector3<f64>], more: &[f64]) -> Vector6<f64> {
    let mut sum = Vector6::zeros();
    for ((p, moved), more) in pressing.iter().zip(moved).zip(more) {
        let force = p.normal * (-p.pressure * p.area);
        let change = (p.normal * *more + p.turned(motion, moved) * p.pressure) * -p.area;
        let moment = (moved - motion.0).cross(&force) + p.arm.cross(&change);
        sum += Vector6::new(change.x, change.y, change.z, moment.x, moment.y, moment.z);
    }
    sum
}
