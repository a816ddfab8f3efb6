//! States of tissue from frame to frame, as a tube moves: a few steps each, with factors that are a little old.
//!
//! [`crate::space::equilibrium::settle`] finds one state with new factors at every step, and stands for the truth here. From one frame
//! to the next little changes but the contact, so:
//!
//! 1. Unknowns of the surface that the tube may press ([`Frames::new`]'s `wanted`) are eliminated last. What the elimination
//!    of all others leaves on them is their stiffness against contact; contact is exact in that small dense problem (`reduced`).
//! 2. The factor is of elasticity alone, at an earlier state: contacts come and go without another. The next one is made by a second
//!    thread and taken up a fixed number of frames after it was asked for (`factors`): by way and rate, never by a clock.
//! 3. Steps are mixed (`mix`), and made no longer than the energy falls.
//!
//! The same poses give the same bits, whatever the machine's load.

mod contact;
mod factors;
mod mix;
mod reduced;
mod report;
mod search;
mod settings;
mod stiffness;
mod touch;
mod watch;

pub use report::{Frame, Refused, State};
pub use settings::{NoFrames, Settings};

use std::sync::Arc;

use nalgebra::{Isometry3, Vector3};

use super::system::System;
use super::tube::Tube;
use crate::control::Potential;
use crate::sparse::Dissection;
use contact::Contact;
use factors::Factors;
use mix::Mix;
use search::Found;
use touch::Touches;
use watch::Others;

/// Ways between poses are made in parts of this part of the tube's least radius: points may be half a radius deep, not more.
const PART_OF_RADIUS: f64 = 0.4;
/// Steps in a part of a way that does not end there: it only has to lead on.
const STEPS_ON_THE_WAY: usize = 4;
/// A residual that falls by less than this a step asks for new factors.
const SLOW_RATE: f64 = 0.25;

/// Poses so many parts of a way off are errors of a tracker.
const MOST_PARTS: f64 = 1e6;
/// A residual that is better not left: a frame that ends with it is tried again in halves.
const FAR_OFF: f64 = 0.05;

/// A state of tissue and tube.
#[derive(Debug, Clone)]
struct Now {
    a: Vec<f64>,
    at: Evaluated,
    /// Of the points that the tube may reach.
    pressures: Vec<f64>,
    tube: Tube,
    found: Found,
}

/// A system, its state, and the tube in it.
#[derive(Debug)]
pub struct Frames {
    system: Arc<System>,
    settings: Settings,
    now: Now,
    /// The state of the frame before, where the last one was settled.
    last: Option<Now>,
    contact: Contact,
    others: Others,
    factors: Factors,
    mix: Mix,
    least_force: f64,
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
    /// Frames of a system without tubes of its own, from its state `a` on, for a tube that presses points of the surface of solid `body` for
    /// which `wanted(reference place, normal)` holds. Wherever else it comes to lie in a surface the frame is refused, so
    /// name all that it may reach; every node there costs time.
    ///
    /// # Errors
    /// [`NoFrames`].
    pub fn new(
        system: System,
        a: Vec<f64>,
        body: usize,
        tube: Tube,
        settings: Settings,
        wanted: impl Fn(&Vector3<f64>, &Vector3<f64>) -> bool,
    ) -> Result<Self, NoFrames> {
        settings.check(tube.least_radius())?;
        let (solids, expected) = (system.bodies.len(), system.bodies.size());
        if body >= solids {
            return Err(NoFrames::NoBody { body, solids });
        }
        if a.len() != expected {
            return Err(NoFrames::Size {
                found: a.len(),
                expected,
            });
        }
        if !system.tubes.is_empty() {
            return Err(NoFrames::Tubes {
                found: system.tubes.len(),
            });
        }
        let found = system.obstacles.len() + system.organs.len();
        if found > 0 {
            return Err(NoFrames::Contacts { found });
        }
        if let Some(term) = system.others.iter().position(|term| term.changes()) {
            return Err(NoFrames::Changing { term });
        }
        let others = Others::new(&system, body, &wanted);
        let touches = Touches::new(&system, body, wanted)?;
        let order = Dissection::by_places(&system.places(), &touches.unknowns())?;
        let at = Evaluated::of(&system, &a).ok_or(NoFrames::NoEnergy)?;
        let system = Arc::new(system);
        let factors = Factors::new(&system, order, settings.precision, &a).ok_or(NoFrames::NoFactor)?;
        let solid = system.bodies.solid(body);
        let hundredth = 1e-2 * solid.extent();
        let usual = solid.shear_scale() * hundredth * hundredth;
        let least_force = settings.least_force.unwrap_or(usual);
        let used = Settings {
            least_force: Some(least_force),
            ..settings
        };
        used.check(tube.least_radius())?;
        let frames = Self {
            now: Now {
                a,
                at,
                pressures: vec![0.0; touches.len()],
                tube,
                found: Found::default(),
            },
            last: None,
            contact: Contact::new(touches),
            mix: Mix::default(),
            system,
            settings,
            others,
            factors,
            least_force,
            scale: least_force,
            frame: 0,
            ways: [0.0; 2],
            slow: false,
            stale: false,
        };
        let mut v = Vec::new();
        frames.contact.touches.take(&frames.now.a, &mut v);
        match frames.watch(&frames.now.tube, &frames.now.a, &v) {
            Err(Refused::TooDeep { depth, most }) => Err(NoFrames::TooDeep { depth, most }),
            // Anything else may be left behind by the first way.
            _ => Ok(frames),
        }
    }

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

    /// Unknowns that are eliminated last.
    pub fn root_size(&self) -> usize {
        3 * self.contact.touches.nodes()
    }

    /// Moves the tube to a pose, and the tissue with it. What is inside the tissue is not seen: a tube that begins wholly within it presses nothing.
    pub fn frame(&mut self, pose: &Isometry3<f64>) -> Frame {
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
        match self.go(pose, parts, &start) {
            Ok(found) => {
                self.now.found = found;
                let state = self.judge(pose, &found);
                let work = self.work(&start.tube, &before);
                self.last = (state == State::Settled && parts == 1).then_some(start);
                Frame {
                    work,
                    ..self.report(state, &found)
                }
            }
            Err(refused) => {
                self.restore(start);
                self.last = None;
                self.refuse(refused)
            }
        }
    }

    /// Back to a state: factors may be of any other by now.
    fn restore(&mut self, start: Now) {
        (self.now, self.ways, self.stale) = (start, [f64::INFINITY; 2], true);
    }

    fn refuse(&self, refused: Refused) -> Frame {
        let found = Found {
            steps: 0,
            contact_steps: 0,
            ..self.now.found
        };
        self.report(State::Refused(refused), &found)
    }

    /// Goes to a pose, and once more in halves where that leads nowhere: each half with factors of its own.
    fn go(&mut self, pose: &Isometry3<f64>, parts: usize, start: &Now) -> Result<Found, Refused> {
        let first = self.walk(pose, parts, parts > 1);
        let good = first.as_ref().is_ok_and(|found| found.residual <= FAR_OFF);
        if good || parts > 1 || self.settings.most_parts < 2 {
            return first;
        }
        // The first way's end is kept: the halves may lead to a worse one.
        let reached = self.now.clone();
        self.restore(start.clone());
        match (first, self.walk(pose, 2, true)) {
            (Ok(first), Ok(second)) if second.residual < first.residual => Ok(first.and(&second)),
            (Ok(first), _) => {
                self.restore(reached);
                Ok(first)
            }
            (Err(_), second) => second,
        }
    }

    /// Goes to a pose in so many parts, of which so many are made as a frame may have; where `at_once`, with new factors in each.
    fn walk(&mut self, pose: &Isometry3<f64>, parts: usize, at_once: bool) -> Result<Found, Refused> {
        let mut found = Found::default();
        for part in 0..parts.min(self.settings.most_parts) {
            let left = parts - part;
            // A part of one is the pose itself, to the bit.
            let next = match left {
                1 => self.now.tube.at(*pose).map_err(|_| Refused::Pose)?,
                _ => self.now.tube.toward(pose, 1.0 / left as f64),
            };
            let most = if left == 1 {
                self.settings.most_steps
            } else {
                STEPS_ON_THE_WAY
            };
            self.refresh(at_once);
            let moved = self.now.tube.way_to(next.pose());
            self.ways.iter_mut().for_each(|way| *way += moved);
            if parts == 1 {
                self.foresee(&next);
            }
            found = found.and(&self.search(&next, most)?);
        }
        Ok(found)
    }

    /// Goes on as the last frame did, where that lowers energy and depths at the tube's new place: what is left is of second order then.
    fn foresee(&mut self, next: &Tube) {
        let Some(last) = &self.last else {
            return;
        };
        let (from, now, to) = (last.tube.pose(), self.now.tube.pose(), next.pose());
        let old = now.translation.vector - from.translation.vector;
        let part = (to.translation.vector - now.translation.vector).dot(&old) / old.norm_squared();
        let turn = from.rotation.rotation_to(&now.rotation).powf(part) * now.rotation;
        let foreseen = Isometry3::from_parts((now.translation.vector + old * part).into(), turn);
        // Back and forth along one way are foreseen, up to twice as fast, turns with it.
        if !(part.abs() <= 2.0 && next.way_to(&foreseen) <= 0.5 * next.way_to(now)) {
            return;
        }
        let a: Vec<f64> = self
            .now
            .a
            .iter()
            .zip(&last.a)
            .map(|(a, b)| a + part * (a - b))
            .collect();
        let Some(at) = Evaluated::of(&self.system, &a) else {
            return;
        };
        let (mut v, mut moved) = (Vec::new(), Vec::new());
        self.contact.touches.take(&self.now.a, &mut v);
        self.contact.touches.take(&a, &mut moved);
        let cost = |v: &[f64]| self.contact.cost(&self.now.pressures, v, next);
        let way: Vec<f64> = moved.iter().zip(&v).map(|(moved, v)| moved - v).collect();
        // A guess is taken only where it is better than to begin where the last frame ended.
        let lower = at.energy + cost(&moved) < self.now.at.energy + cost(&v);
        if lower && !self.contact.passes(&v, &way, next) {
            (self.now.a, self.now.at, self.stale) = (a, at, true);
        }
    }

    /// New factors where the old ones are too old: at once on a long way, else by the other thread.
    fn refresh(&mut self, at_once: bool) {
        // By way, not by frames: a tube at rest needs no new factors.
        let old = self.ways[0] > self.settings.refresh;
        if (at_once || self.settings.delay == 0) && old {
            self.renew();
        } else if (old || self.slow) && !self.factors.is_waiting() {
            self.factors.ask(
                &self.system,
                &self.now.a,
                self.frame.saturating_add(self.settings.delay.max(1) as u64),
            );
            self.ways[1] = 0.0;
        }
    }

    /// Factors of the state as it is, at once; false where there are none.
    fn renew(&mut self) -> bool {
        // What the other thread makes is older than what is made now, but its memory is needed.
        self.factors.take_up(u64::MAX);
        // Where none can be made, as tissue is about to slip, the old one is all there is.
        let made = self.factors.make_now(&self.system, &self.now.a);
        if made {
            (self.ways, self.stale) = ([0.0; 2], false);
        }
        made
    }

    fn judge(&mut self, pose: &Isometry3<f64>, found: &Found) -> State {
        self.slow = found.rate > SLOW_RATE && found.steps > 1;
        // The last part of a way is the pose itself, to the bit.
        if self.now.tube.pose() != pose {
            let left = self.now.tube.way_to(pose);
            return State::CatchingUp { left };
        }
        let settled = found.residual <= self.settings.tolerance && found.depth <= self.settings.depth;
        if settled { State::Settled } else { State::Approximate }
    }

    fn report(&self, state: State, found: &Found) -> Frame {
        let force = self.force();
        Frame {
            state,
            residual: found.residual,
            unsettled: found.unsettled(),
            force,
            energy: self.now.at.energy,
            work: 0.0,
            least_determinant: self.system.least_determinant(&self.now.a),
            steps: found.steps,
            factor: self.factors.number,
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
