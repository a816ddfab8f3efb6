//! One task, from the first look until the operator lets go.

use geometry::{Ct, Point};

use crate::conditions::Conditions;
use crate::decide::{Act, Percept, decide};
use crate::reader::Reader;
use crate::sensor::Sensor;
use crate::sight;
use crate::task::Task;
use crate::world::{Drawn, World, between, newest};

/// How it ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outcome {
    /// The display said that the tip had arrived, and she let go; else the task was given up.
    pub is_arrived: bool,
    /// From the first look until then, s.
    pub time_s: f64,
    /// Where the tip truly stands then.
    pub tip: Point<Ct>,
    /// From there to the target of the task, mm.
    pub miss_mm: f64,
    /// What the last picture showed of that, mm.
    pub shown_mm: f64,
    /// How far the true aim is from where the last picture had it, mm.
    pub error_mm: f64,
    /// The error predicted at the target, the ball that holds 95 of 100, with what that leaves out, mm.
    pub predicted_mm: f64,
    /// Strokes of the hand.
    pub strokes: usize,
    /// Times that she turned to another picture.
    pub glances: usize,
}

impl Outcome {
    /// Whether the true aim is where the display had it, to within the predicted error: what that error claims.
    pub fn is_as_predicted(&self) -> bool {
        self.error_mm <= self.predicted_mm
    }

    /// Whether the true miss is within the predicted error: what that error does not claim, as the display also showed
    /// a miss.
    pub fn is_within(&self) -> bool {
        self.miss_mm <= self.predicted_mm
    }
}

/// Does one task by what `reader` reads. The same for the same task, reader and conditions, always.
pub fn perform(task: &Task, reader: &mut impl Reader, conditions: &Conditions) -> Outcome {
    perform_with(task, reader, conditions, &Drawn::new(task, conditions.errors))
}

/// The same where `sensor` measures the tube: the errors of the conditions are then not used. Where it has nothing to show
/// she waits.
pub fn perform_with(task: &Task, reader: &mut impl Reader, conditions: &Conditions, sensor: &impl Sensor) -> Outcome {
    let mut trial = Trial {
        task,
        conditions,
        world: World::new(task, conditions, sensor),
        attention: Attention::default(),
        glances: 0,
        now_s: 0.0,
    };
    let is_arrived = trial.run(reader);
    trial.outcome(is_arrived)
}

struct Trial<'a> {
    task: &'a Task,
    conditions: &'a Conditions,
    world: World<'a>,
    attention: Attention,
    glances: usize,
    now_s: f64,
}

/// What she knows of the pictures.
#[derive(Default)]
struct Attention {
    /// The picture that she looks at.
    current: Option<usize>,
    /// Those looked at since the last stroke that asked for nothing.
    settled: Vec<usize>,
    /// Of those, what said that the tip has arrived.
    inside: Vec<usize>,
    /// Of each picture: the tube pointed at the target when it was looked at last.
    aligned: [bool; 8],
}

impl Attention {
    /// The tube has moved, or looking at all pictures once was not enough: each may ask for something again.
    fn begin_again(&mut self) {
        self.settled.clear();
        self.inside.clear();
    }

    /// Of these pictures the one that she looks at next: if she can, that before her. `None` where none asks for
    /// anything.
    fn next(&self, pictures: &[usize]) -> Option<usize> {
        let is_open = |picture: &usize| !self.settled.contains(picture);
        let here = self
            .current
            .filter(|picture| pictures.contains(picture) && is_open(picture));
        here.or_else(|| pictures.iter().copied().find(is_open))
    }

    /// Whether the tube may be pushed as far as the other pictures tell: it pointed at the target on each.
    fn may_push(&self, picture: usize, pictures: &[usize]) -> bool {
        let mut others = pictures.iter().filter(|other| **other != picture);
        others.all(|other| self.aligned[other % 8])
    }
}

impl Trial<'_> {
    /// Whether the display said that the tip had arrived before the task was given up.
    fn run(&mut self, reader: &mut impl Reader) -> bool {
        while self.now_s < self.conditions.limit_s {
            let Some(shown) = self.world.shown(newest(self.now_s)) else {
                if self.world.is_across(self.now_s) {
                    return false;
                }
                self.now_s += self.conditions.human.look_s;
                continue;
            };
            let pictures = reader.pictures(&shown);
            if pictures.is_empty() {
                self.now_s += self.conditions.human.look_s;
                let tilt = self.world.meant(self.now_s).tilt;
                self.stroke(tilt, reader.unseen_mm(&shown));
            } else if self.one_look(reader, &pictures) {
                return true;
            }
        }
        false
    }

    /// Looks at one of the pictures and does what it asks for; whether the tip has arrived.
    fn one_look(&mut self, reader: &mut impl Reader, pictures: &[usize]) -> bool {
        let (human, radius_mm) = (self.conditions.human, self.task.aim.radius_mm);
        let Some(picture) = self.attention.next(pictures) else {
            // All of them ask for nothing, and not all say that it has arrived.
            self.attention.begin_again();
            return false;
        };
        self.turn_to(picture);
        let Some(seen) = self.look(reader, picture, human.look_s) else {
            self.attention.settled.push(picture);
            return false;
        };
        self.attention.aligned[picture % 8] = seen.is_aligned(&human, radius_mm);
        let may_push = self.attention.may_push(picture, pictures);
        match decide(&seen, &human, radius_mm, may_push) {
            Act::Stroke {
                beside_mm,
                ahead_mm,
                push_mm,
            } => {
                let tilt = self.tilt(reader, picture, beside_mm, ahead_mm);
                self.stroke(tilt, push_mm);
                return false;
            }
            Act::Leave => self.attention.settled.push(picture),
        }
        if seen.is_arrived(&human) {
            self.attention.inside.push(picture);
        }
        if !pictures.iter().all(|picture| self.attention.inside.contains(picture)) {
            return false;
        }
        // She goes on looking for a while: it might have been noise.
        let stays = self.look(reader, picture, human.dwell_s);
        self.attention.begin_again();
        stays.is_some_and(|seen| seen.is_inside)
    }

    fn turn_to(&mut self, picture: usize) {
        if self.attention.current.is_some_and(|current| current != picture) {
            self.now_s += self.conditions.human.glance_s;
            self.glances += 1;
        }
        self.attention.current = Some(picture);
    }

    /// Looks at one picture for a while.
    fn look(&mut self, reader: &mut impl Reader, picture: usize, for_s: f64) -> Option<Percept> {
        let frames = between(self.now_s, self.now_s + for_s);
        self.now_s += for_s;
        let shown = frames.filter_map(|frame| self.world.shown(frame));
        let readings: Vec<_> = shown.filter_map(|shown| reader.read(picture, &shown)).collect();
        Percept::of(&readings)
    }

    /// The tilt of a tube that is turned until its axis lies `beside_mm` (right, up of the picture) further at the
    /// target.
    fn tilt(&self, reader: &impl Reader, picture: usize, beside_mm: [f64; 2], ahead_mm: Option<f64>) -> [f64; 2] {
        let from = self.world.meant(self.now_s);
        let lever_mm = from.depth_mm + ahead_mm.unwrap_or(0.0).max(0.0);
        let Some(pose) = self.task.way.pose(&from) else {
            return from.tilt;
        };
        let [right, up] = reader.axes(picture, pose);
        self.task
            .way
            .turned(&from, right * beside_mm[0] + up * beside_mm[1], lever_mm)
    }

    /// One stroke after the reaction, and the wait until the picture stands still.
    fn stroke(&mut self, tilt: [f64; 2], push_mm: f64) {
        let Conditions {
            human, delay_s, lag_s, ..
        } = self.conditions;
        let wait_s = if human.knows_lag { delay_s + lag_s } else { *delay_s };
        self.now_s = self.world.stroke(self.now_s + human.reaction_s, tilt, push_mm) + wait_s;
        self.attention.begin_again();
    }

    fn outcome(&self, is_arrived: bool) -> Outcome {
        let shown = self.world.shown(newest(self.now_s));
        let last = shown.and_then(|shown| sight::exact(&shown).ok());
        let tip = self.task.way.tip(&self.world.truly(self.now_s));
        let predicted = last.and_then(|sight| sight.predicted.ok());
        Outcome {
            is_arrived,
            time_s: self.now_s,
            tip,
            // The tip is to stand at the target itself.
            miss_mm: tip.distance(self.task.aim.target),
            shown_mm: last.map_or(f64::NAN, |sight| sight.miss_length_mm.hypot(sight.to_go_mm)),
            error_mm: last.map_or(f64::NAN, |sight| tip.distance(sight.tip)),
            predicted_mm: predicted.map_or(f64::NAN, |error| error.ball_95_mm + error.remainder_mm),
            strokes: self.world.strokes(),
            glances: self.glances,
        }
    }
}
