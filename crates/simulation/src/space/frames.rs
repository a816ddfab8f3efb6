//! States of tissue from frame to frame, as a tube moves: a few steps each, with factors that are a little old.
//!
//! [`crate::space::equilibrium::settle`] finds one state with new factors at every step, and stands for the truth here. From one frame
//! to the next little changes but the contact, so:
//!
//! 1. All that contact does to a step is forces on the points at the tube and at bones. What these move of one another is their compliance, by the factor (`near`);
//!    contact is exact in that small dense problem (`reduced`, `pressed`).
//! 2. The factor is of elasticity alone, at an earlier state: contacts come and go without another. The next one is made by a second
//!    thread and taken up a fixed number of frames after it was asked for (`factors`): by way and rate, never by a clock.
//! 3. Steps are mixed (`mix`), and made no longer than energy and depths together fall, or the free forces halve (`search`).
//!
//! The same poses give the same bits, whatever the machine's load.

mod around;
mod begin;
mod contact;
mod factors;
mod mix;
mod near;
mod present;
mod pressed;
mod reduced;
mod report;
mod rest;
mod search;
mod settings;
mod stiffness;
mod together;
mod touch;
mod walk;
mod watch;

pub use present::{Change, Yielding};
pub use report::{Frame, Refused, State};
pub use settings::{NoFrames, Settings};
pub use together::Together;

use std::sync::Arc;

use nalgebra::Isometry3;

use super::bodies::Bodies;
use super::system::System;
use super::term::ObstacleContact;
use super::tube::Tube;
use crate::control::Potential;
use around::Around;
use contact::Contact;
use factors::Factors;
use mix::Mix;
use present::Present;
use search::Found;
use watch::Others;

/// Ways between poses are made in parts of this part of the tube's least radius: points may be half a radius deep, not more.
const PART_OF_RADIUS: f64 = 0.4;
/// A residual that falls by less than this a step asks for new factors.
const SLOW_RATE: f64 = 0.25;

/// Poses so many parts of a way off are errors of a tracker.
const MOST_PARTS: f64 = 1e6;

/// A state of tissue and tube.
#[derive(Debug, Clone)]
struct Now {
    a: Vec<f64>,
    at: Evaluated,
    /// Of the points that the tube may reach.
    pressures: Vec<f64>,
    tube: Tube,
    found: Found,
    settled: bool,
}

/// A system, its state, and the tube in it.
#[derive(Debug)]
pub struct Frames {
    system: Arc<System>,
    /// Bones behind the tissue.
    bones: Vec<ObstacleContact>,
    settings: Settings,
    now: Now,
    /// The state at the start, without a tube.
    begun: Now,
    /// The state of the frame before, where the last one was settled.
    last: Option<Now>,
    contact: Contact,
    others: Others,
    factors: Factors,
    /// `None` until somebody asks for it.
    present: Option<Box<Present>>,
    mix: Mix,
    /// Of each solid.
    least_forces: Vec<f64>,
    /// The forces of contact of the last step, as a length.
    scale: f64,
    frame: u64,
    /// How far the tube has gone since the state of the factor in use, and of the one asked for, mm.
    ways: [f64; 2],
    slow: bool,
    /// The factor in use is of another state.
    stale: bool,
}

/// Energy without contact, and the forces that it leaves on free unknowns: downhill.
#[derive(Debug, Clone)]
struct Evaluated {
    energy: f64,
    forces: Vec<f64>,
}

impl Frames {
    /// The system.
    pub fn system(&self) -> &System {
        &self.system
    }

    /// The state of the last frame.
    pub fn state(&self) -> &[f64] {
        &self.now.a
    }

    /// The tube where the state has it.
    pub fn tube(&self) -> &Tube {
        &self.now.tube
    }

    /// What the tissue may touch, with the tube there.
    fn around<'a>(&'a self, tube: &'a Tube) -> Around<'a> {
        Around {
            tube,
            bones: &self.bones,
        }
    }

    /// Moves the tube to a pose, and the tissue with it.
    pub fn frame(&mut self, pose: &Isometry3<f64>) -> Frame {
        self.frame_where(pose, |_, _| true)
    }

    /// The same, refused as [`Refused::Denied`] where `allowed` denies the state that was found: then the state before it stands, as after any
    /// refusal, and what comes goes on from that. For what the model does not know of, as solids that come into one another.
    pub fn frame_where(&mut self, pose: &Isometry3<f64>, allowed: impl FnOnce(&Bodies, &[f64]) -> bool) -> Frame {
        self.frame += 1;
        let parts = self.tube().way_to(pose) / (PART_OF_RADIUS * self.tube().least_radius());
        if self.now.tube.at(*pose).is_err() || parts > MOST_PARTS {
            return self.refuse(Refused::Pose);
        }
        // First of all, so that all of this frame is by one factor, whatever becomes of its steps.
        if self.factors.take_up(self.frame) {
            (self.ways[0], self.stale) = (self.ways[1], true);
        }
        let parts = (parts.ceil() as usize).max(1);
        // What a refusal goes back to, and what the work is reckoned from.
        let (start, before) = (self.now.clone(), self.force());
        let gone = self.go(pose, parts, &start);
        let allowed = |found| {
            allowed(&self.system.bodies, &self.now.a)
                .then_some(found)
                .ok_or(Refused::Denied)
        };
        match gone.and_then(allowed) {
            Ok(found) => {
                let unsettled = self.unsettled();
                let found = Found { unsettled, ..found };
                self.now.found = found;
                let state = self.judge(pose, &found);
                let work = self.work(&start.tube, &before);
                self.last = (state == State::Settled && parts == 1).then_some(start);
                Frame {
                    work,
                    ..self.report(state, &found)
                }
            }
            Err(refused) => self.give_up(start, refused),
        }
    }

    /// The least of the least forces, by which free forces are measured where nothing presses yet.
    fn least_force(&self) -> f64 {
        self.least_forces.iter().copied().fold(f64::INFINITY, f64::min)
    }

    /// What a frame goes back to where others deny it.
    fn start(&self) -> Now {
        self.now.clone()
    }

    /// Back to that.
    fn give_up(&mut self, start: Now, why: Refused) -> Frame {
        self.restore(start);
        self.last = None;
        self.refuse(why)
    }

    fn refuse(&self, refused: Refused) -> Frame {
        let found = Found {
            steps: 0,
            contact_steps: 0,
            ..self.now.found
        };
        self.report(State::Refused(refused), &found)
    }

    fn judge(&mut self, pose: &Isometry3<f64>, found: &Found) -> State {
        self.slow = found.rate > SLOW_RATE && found.steps > 1;
        self.now.settled = false;
        // The last part of a way is the pose itself, to the bit.
        if self.now.tube.pose() != pose {
            let left = self.now.tube.way_to(pose);
            return State::CatchingUp { left };
        }
        // Laws that forbid no inversion have a balance inside out, and all may be inside out between the points of elements.
        self.now.settled = self.is_balanced(found) && found.determinant > 0.0 && self.is_upright();
        if self.now.settled {
            State::Settled
        } else {
            State::Approximate
        }
    }

    fn report(&self, state: State, found: &Found) -> Frame {
        let force = self.force();
        Frame {
            state,
            residual: found.residual,
            unsettled: found.unsettled,
            force,
            energy: self.now.at.energy,
            work: 0.0,
            least_determinant: found.determinant,
            steps: found.steps,
            factor: self.factors.number,
            depth: found.depth,
            inside: found.inside,
            gap: found.gap,
            contact_steps: found.contact_steps,
        }
    }
}

/// The length of a vector.
fn norm(x: &[f64]) -> f64 {
    x.iter().map(|x| x * x).sum::<f64>().sqrt()
}

impl Evaluated {
    fn of(system: &System, a: &[f64]) -> Option<Self> {
        let mut forces = vec![0.0; a.len()];
        let energy = system.gradient(a, &mut forces).filter(|e| e.is_finite())?;
        for (force, fixed) in forces.iter_mut().zip(&system.fixed) {
            *force = if *fixed { 0.0 } else { -*force };
        }
        Some(Self { energy, forces })
    }
}
