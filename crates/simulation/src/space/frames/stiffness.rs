//! How the force on the tube changes with its pose: for forces between frames, at the rate of a device that is held.

use nalgebra::{Matrix6, Vector3, Vector6};

use super::Frames;
use super::near::{Active, Near};
use super::pressed::Pressed;
use crate::space::tube::Distance;

/// Stiffness of contact times the mean compliance of a point: what it leaves goes with its inverse, round by round.
const STIFFNESS_PART: f64 = 1e5;
/// Rounds, and the gap beside the tube's own way at which they end.
const MOST_ROUNDS: usize = 30;
const ENOUGH: f64 = 1e-8;

/// A point that presses, for small motions of the tube.
#[derive(Debug)]
pub(super) struct Pressing {
    /// Among those near.
    pub(super) point: usize,
    /// From the tube's origin.
    arm: Vector3<f64>,
    pub(super) distance: Distance,
    pub(super) area: f64,
    pub(super) pressure: f64,
    /// What it presses does not move.
    at_bone: bool,
}

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

/// What moves points that press: forces by their area, ways besides what forces do, and ways that they must go along their normals.
pub(super) struct Driven {
    pub(super) forces: Vec<Vector3<f64>>,
    pub(super) free: Vec<Vector3<f64>>,
    pub(super) kept: Vec<f64>,
    /// The length of all this, mm: what gaps are small beside.
    pub(super) length: f64,
}

/// What that comes to: ways of the points, changes of their pressures, and forces on them.
pub(super) struct Response {
    moved: Vec<Vector3<f64>>,
    pub(super) more: Vec<f64>,
    pub(super) forces: Vec<Vector3<f64>>,
}

/// Points that press, held at what they press.
#[derive(Debug)]
pub(super) struct Held {
    pub(super) pressing: Vec<Pressing>,
    active: Active,
    springs: Pressed,
    /// Stress by length.
    stiff: f64,
}

impl Frames {
    /// The derivative of force and moment on the tube (as [`Frames::force`] has them: the moment about the tube's own origin, world's axes) by its
    /// pose: rows force then moment, columns ways then turns about the origin, by the stiffness of tissue that the last factor has, which
    /// may be [`super::Settings::refresh`] and what goes on meanwhile old. Points that press go on pressing. `None` where it is not to be had: outside
    /// [`super::State::Settled`], where that factor is of a convex matrix in the place of second derivatives that are not positive definite, or where a small
    /// motion changes the state by much; zero without contact.
    pub fn stiffness(&self) -> Option<Matrix6<f64>> {
        if !self.now.settled || self.factors.now.convex {
            return None;
        }
        let near = &self.factors.now.near;
        // After a refusal the points at the tube may still be those of the pose that was refused.
        let pressing = self.pressing(near)?;
        let mut stiffness = Matrix6::zeros();
        if pressing.iter().all(|p| p.at_bone) {
            return Some(stiffness);
        }
        let held = Held::new(pressing, near)?;
        for (k, mut column) in stiffness.column_iter_mut().enumerate() {
            // One column for each motion of the tube.
            let unit = Vector6::from_fn(|i, _| f64::from(u8::from(i == k)));
            let motion = (
                unit.fixed_rows::<3>(0).into_owned(),
                unit.fixed_rows::<3>(3).into_owned(),
            );
            let found = held.response(&held.driven(&motion))?;
            column.copy_from(&change(&held.pressing, &motion, &found));
        }
        Some(stiffness)
    }

    /// The points that press; `None` where one is not among those near.
    pub(super) fn pressing(&self, near: &Near) -> Option<Vec<Pressing>> {
        let (mut v, touches) = (Vec::new(), &self.contact.touches);
        touches.take(&self.now.a, &mut v);
        let (around, origin) = (self.around(&self.now.tube), self.now.tube.pose().translation.vector);
        let each = self.now.pressures.iter().enumerate().filter(|(_, p)| **p > 0.0);
        let pressing = each.map(|(k, pressure)| {
            Some(Pressing {
                point: near.index(k)?,
                arm: touches.at(k, &v) - origin,
                distance: touches.distance(k, &v, &around),
                area: touches.area(k),
                pressure: *pressure,
                at_bone: touches.with(k) > 0,
            })
        });
        pressing.collect()
    }
}

impl Held {
    /// Far stiffer than in a search: a derivative takes one linear solution, and what is left falls by this ratio each round. `None` where that is not
    /// positive definite.
    pub(super) fn new(pressing: Vec<Pressing>, near: &Near) -> Option<Self> {
        let mut active = Active::default();
        // As many numbers as points press, in their order.
        let numbers: Vec<usize> = pressing.iter().map(|p| active.take(near, p.point)).collect();
        let mean_area = pressing.iter().map(|p| p.area).sum::<f64>() / pressing.len() as f64;
        let stiff = STIFFNESS_PART / (near.mean() * mean_area);
        let each = pressing
            .iter()
            .zip(numbers)
            .map(|(p, number)| (number, p.distance, stiff * p.area, p.pressure * p.area));
        let mut springs = Pressed::default();
        springs.take(each, true, &active).then_some(Self {
            pressing,
            active,
            springs,
            stiff,
        })
    }

    /// What a motion of the tube does: points that press keep no distance.
    fn driven(&self, motion: &Motion) -> Driven {
        let each = || self.pressing.iter();
        Driven {
            // With the point at rest; what its own way adds is in the springs.
            forces: each()
                .map(|p| p.turned(motion, &Vector3::zeros()) * p.pressure)
                .collect(),
            free: vec![Vector3::zeros(); self.pressing.len()],
            kept: each().map(|p| p.distance.gradient.dot(&p.carried(motion))).collect(),
            length: each().map(|p| p.carried(motion).norm()).fold(0.0, f64::max),
        }
    }

    /// Where points go and what their pressures become.
    pub(super) fn response(&self, driven: &Driven) -> Option<Response> {
        let mut more = vec![0.0; self.pressing.len()];
        let with_free = |mut moved: Vec<Vector3<f64>>| {
            moved
                .iter_mut()
                .zip(&driven.free)
                .for_each(|(moved, free)| *moved += free);
            moved
        };
        for _ in 0..MOST_ROUNDS {
            let each = self
                .pressing
                .iter()
                .zip(&driven.forces)
                .zip(driven.kept.iter().zip(&more));
            let pushed =
                each.map(|((p, own), (kept, more))| (own + p.distance.gradient * (more + self.stiff * kept)) * p.area);
            let mut forces: Vec<Vector3<f64>> = pushed.collect();
            // Points follow by a spring each, as stiff as that, and by what pressures have gained.
            for (number, held) in self.springs.holding(&with_free(self.active.moved(&forces))) {
                forces[number] -= held;
            }
            let moved = with_free(self.active.moved(&forces));
            let mut left = 0.0_f64;
            let each = self.pressing.iter().zip(&mut more).zip(moved.iter().zip(&driven.kept));
            for ((p, more), (moved, kept)) in each {
                let gap = p.distance.gradient.dot(moved) - kept;
                *more -= self.stiff * gap;
                left = left.max(gap.abs());
            }
            if left <= ENOUGH * driven.length {
                return Some(Response { moved, more, forces });
            }
        }
        None
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
