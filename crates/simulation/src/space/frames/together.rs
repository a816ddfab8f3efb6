//! Several solids that know nothing of one another, pressed by one tube: each is followed by frames of its own, with steps, factors and a balance of its own.
//!
//! One that hardly resists may take many steps, or new factors, where another takes one; together each would have to wait for the other. Whether they
//! come into one another, whoever asks for frames must look.

use nalgebra::{Isometry3, Vector6};

use super::{Change, Frame, Frames, Refused, State};
use crate::space::bodies::Bodies;
use crate::space::system::System;
use crate::space::term::TubeForce;
use crate::space::tube::Tube;

/// Frames of several solids, at one tube.
#[derive(Debug)]
pub struct Together {
    /// All solids, whose unknowns lie one after the other.
    whole: System,
    each: Vec<Frames>,
    a: Vec<f64>,
}

impl Together {
    /// Frames of one solid each, in the order of the solids of `whole`; `None` where these are others, or there is none.
    pub fn new(whole: System, each: Vec<Frames>) -> Option<Self> {
        let fits = |(body, frames): (usize, &Frames)| {
            whole.bodies.part(body, &vec![0.0; whole.bodies.size()]).len() == frames.state().len()
        };
        let is_whole = !each.is_empty() && each.len() == whole.bodies.len() && each.iter().enumerate().all(fits);
        is_whole.then(|| {
            let mut together = Self {
                whole,
                each,
                a: Vec::new(),
            };
            together.gather();
            together
        })
    }

    /// All solids.
    pub fn bodies(&self) -> &Bodies {
        &self.whole.bodies
    }

    /// The state of the last frame, of all solids one after the other.
    pub fn state(&self) -> &[f64] {
        &self.a
    }

    /// The tube where the first solid's state has it: where all have it but on the way to a pose.
    pub fn tube(&self) -> &Tube {
        self.each[0].tube()
    }

    /// What no point of the tube goes farther than on the way to a pose, mm, from where any state has it.
    pub fn way_to(&self, pose: &Isometry3<f64>) -> f64 {
        self.each.iter().map(|one| one.way_to(pose)).fold(0.0, f64::max)
    }

    /// Which solids the tube presses.
    pub fn pressed(&self) -> Vec<bool> {
        self.each.iter().map(|one| !one.is_free()).collect()
    }

    /// Whether nothing presses on the tube.
    pub fn is_free(&self) -> bool {
        self.each.iter().all(Frames::is_free)
    }

    /// As [`Frames::is_clear`], of all.
    pub fn is_clear(&self, pose: &Isometry3<f64>) -> bool {
        self.each.iter().all(|one| one.is_clear(pose))
    }

    /// As [`Frames::is_clear_now`], of all.
    pub fn is_clear_now(&self, pose: &Isometry3<f64>) -> bool {
        self.each.iter().all(|one| one.is_clear_now(pose))
    }

    /// As [`Frames::force`], of all.
    pub fn force(&self) -> TubeForce {
        self.each.iter().map(Frames::force).fold(TubeForce::default(), sum)
    }

    /// As [`Frames::rest`], of all: `None`, and nothing is changed, where the tube would touch one.
    pub fn rest(&mut self, pose: &Isometry3<f64>) -> Option<Frame> {
        let tubes: Option<Vec<Tube>> = self.each.iter().map(|one| one.clear_at_start(pose)).collect();
        let each = self.each.iter_mut().zip(tubes?);
        let frames: Vec<Frame> = each.map(|(one, tube)| one.rest_with(tube, pose)).collect();
        self.gather();
        Some(all(&frames))
    }

    /// Moves the tube to a pose, and the solids with it: one that presses on nothing and that the tube would not touch at the start is there, to the bit. Refused as
    /// soon as one is, or as [`Refused::Denied`] where `allowed` denies the state of all; then all are where they were, as after any refusal.
    pub fn frame_where(&mut self, pose: &Isometry3<f64>, allowed: impl FnOnce(&Bodies, &[f64]) -> bool) -> Frame {
        // Kept by all: one that could follow goes back with one that could not.
        let starts: Vec<_> = self.each.iter().map(Frames::start).collect();
        let frames: Vec<Frame> = self.each.iter_mut().map(|one| one.rest_or_frame(pose)).collect();
        let found = all(&frames);
        self.gather();
        // Others are asked of what all came to together.
        let why = match found.state {
            State::Refused(why) => why,
            _ if allowed(&self.whole.bodies, &self.a) => return found,
            _ => Refused::Denied,
        };
        let each = self.each.iter_mut().zip(starts);
        let frames: Vec<Frame> = each.map(|(one, start)| one.give_up(start, why)).collect();
        self.gather();
        all(&frames)
    }

    /// What small forces on all unknowns, N, do to the state, each to first order: [`super::Yielding::to`]. `None` where that is not known of a solid that
    /// some of them push, nor where none pushes one that has moved: then nothing is said of what moved it.
    pub fn changes(&mut self, forces: &[Vec<f64>]) -> Option<Vec<Change>> {
        let none = || Change {
            unknowns: vec![0.0; self.a.len()],
            on_tube: Vector6::zeros(),
        };
        let mut changes: Vec<Change> = forces.iter().map(|_| none()).collect();
        for (body, one) in self.each.iter_mut().enumerate() {
            let bodies = &self.whole.bodies;
            let own = |all: &'_ [f64]| bodies.part(body, all).to_vec();
            let is_zero = |all: &[f64]| bodies.part(body, all).iter().all(|x| *x == 0.0);
            // A solid at rest is there whatever its numbers are: its second derivatives are not asked for.
            if is_zero(&self.a) {
                continue;
            }
            if forces.iter().all(|all| is_zero(all)) {
                return None;
            }
            // Made once for all numbers: its factor is what takes the time.
            let yielding = one.yielding()?;
            let first = bodies.offset(body);
            for (change, all) in changes.iter_mut().zip(forces) {
                let found = yielding.to(&own(all))?;
                change.unknowns[first..first + found.unknowns.len()].copy_from_slice(&found.unknowns);
                change.on_tube += found.on_tube;
            }
        }
        Some(changes)
    }

    fn gather(&mut self) {
        self.a.clear();
        self.each.iter().for_each(|one| self.a.extend_from_slice(one.state()));
    }
}

fn sum(one: TubeForce, other: TubeForce) -> TubeForce {
    TubeForce {
        force: one.force + other.force,
        moment: one.moment + other.moment,
        points: one.points + other.points,
        area: one.area + other.area,
        depth: one.depth.max(other.depth),
    }
}

/// Frames of several solids as one: as far as the worst came, with the forces and the work of all.
fn all(frames: &[Frame]) -> Frame {
    let first = frames[0];
    frames[1..].iter().fold(first, |one, other| Frame {
        state: worse(one.state, other.state),
        residual: one.residual.max(other.residual),
        unsettled: one.unsettled.max(other.unsettled),
        force: sum(one.force, other.force),
        energy: one.energy + other.energy,
        work: one.work + other.work,
        least_determinant: one.least_determinant.min(other.least_determinant),
        depth: one.depth.max(other.depth),
        inside: one.inside.max(other.inside),
        gap: one.gap.max(other.gap),
        steps: one.steps + other.steps,
        factor: one.factor + other.factor,
        contact_steps: one.contact_steps + other.contact_steps,
    })
}

/// Refused before on the way, on the way before what did not settle.
fn worse(one: State, other: State) -> State {
    let rank = |state: State| match state {
        State::Settled => 0,
        State::Approximate => 1,
        State::CatchingUp { .. } => 2,
        State::Refused(_) => 3,
    };
    match (one, other) {
        (State::CatchingUp { left: a }, State::CatchingUp { left: b }) => State::CatchingUp { left: a.max(b) },
        _ if rank(other) > rank(one) => other,
        _ => one,
    }
}
