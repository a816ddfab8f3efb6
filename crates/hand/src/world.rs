//! The tube in the hand, and what of it comes to the glass.

use chance::Chance;
use geometry::{Ct, Rigid};

use crate::conditions::Conditions;
use crate::reader::Shown;
use crate::stroke::Stroke;
use crate::task::Task;
use crate::tremor::Tremor;
use crate::tube::Posture;

/// Frames a second on the glass.
const RATE_HZ: f64 = 60.0;
/// Numbers of what is drawn in a task: the task itself has 0.
const REGISTRATION: u64 = 1;
const TREMOR: u64 = 2;
const STROKES: u64 = 1 << 20;
const FRAMES: u64 = 1 << 32;

/// All that happens in a task, at every moment of it.
#[derive(Debug)]
pub(crate) struct World<'a> {
    task: &'a Task,
    conditions: &'a Conditions,
    registration: Rigid<Ct, Ct>,
    tremor: Tremor,
    /// In the order of time; none begins before the one before it has ended.
    strokes: Vec<Stroke>,
}

/// The frame that is on the glass at a time, s.
pub(crate) fn newest(t_s: f64) -> u64 {
    (t_s * RATE_HZ).floor() as u64
}

/// The frames that come between two times, s; the one that is there where none comes.
pub(crate) fn between(from_s: f64, to_s: f64) -> std::ops::RangeInclusive<u64> {
    let first = (from_s * RATE_HZ).ceil() as u64;
    first..=newest(to_s).max(first)
}

impl<'a> World<'a> {
    pub(crate) fn new(task: &'a Task, conditions: &'a Conditions) -> Self {
        let Conditions { human, errors, .. } = conditions;
        Self {
            task,
            conditions,
            registration: errors.of_registration(task.aim.target, Chance::new(task.seed, REGISTRATION)),
            tremor: Tremor::new(human.tremor_mm, human.tremor_hz, Chance::new(task.seed, TREMOR)),
            strokes: Vec::new(),
        }
    }

    /// How many strokes were made.
    pub(crate) fn strokes(&self) -> usize {
        self.strokes.len()
    }

    /// Where the hand means to be.
    pub(crate) fn meant(&self, t_s: f64) -> Posture {
        let begun = self.strokes.iter().rev().find(|stroke| stroke.begin_s <= t_s);
        begun.map_or(self.task.start, |stroke| stroke.at(t_s))
    }

    /// Where the tube is.
    pub(crate) fn truly(&self, t_s: f64) -> Posture {
        self.task.way.moved(&self.meant(t_s), self.tremor.at(t_s))
    }

    /// What is on the glass in the frame of this number; `None` for a tube that lies across its way.
    pub(crate) fn shown(&self, frame: u64) -> Option<Shown> {
        let Conditions {
            errors, delay_s, lag_s, ..
        } = self.conditions;
        let captured = self.truly(frame as f64 / RATE_HZ - delay_s - lag_s);
        let pose = self.task.way.pose(&captured)?;
        let noise = errors.of_frame(
            self.task.way.tip(&captured),
            Chance::new(self.task.seed, FRAMES + frame),
        );
        // The true pose is the measured one with both motions after it.
        let measured = (self.registration * noise).inverse() * pose;
        Some(Shown {
            pose: measured,
            covariance: errors.stated(measured, self.task.aim.target),
            aim: self.task.aim,
            entry: self.task.way.entry(),
        })
    }

    /// One stroke that begins at a time, s, and is meant to end at this tilt, `push_mm` deeper; when it has ended, s.
    pub(crate) fn stroke(&mut self, begin_s: f64, tilt: [f64; 2], push_mm: f64) -> f64 {
        let from = self.meant(begin_s);
        let to = Posture {
            tilt,
            depth_mm: from.depth_mm + push_mm,
        };
        let stroke = Stroke {
            begin_s,
            duration_s: self.conditions.human.stroke_s(push_mm),
            from,
            to: self.scattered(&from, &to),
        };
        self.strokes.push(stroke);
        stroke.end_s()
    }

    /// Where a stroke ends that is meant to end at `to`: it errs by a part of the hand's way, along it and half as much
    /// across it.
    fn scattered(&self, from: &Posture, to: &Posture) -> Posture {
        let chance = Chance::new(self.task.seed, STROKES + self.strokes.len() as u64);
        let scatter = self.conditions.human.scatter;
        let way = self.task.way.of_hand(from, to);
        let length = way.iter().map(|x| x * x).sum::<f64>().sqrt();
        if length == 0.0 {
            return *to;
        }
        let draws = [0, 1, 2].map(|k| chance.normal(k));
        let along: f64 = (0..3).map(|k| draws[k] * way[k] / length).sum();
        // Half of it alike in all directions, and what is missing along the way.
        let error = |k: usize| scatter * length * (0.5 * draws[k] + 0.5 * along * way[k] / length);
        let hand = [0, 1, 2].map(|k| way[k] + error(k));
        self.task.way.moved(from, hand)
    }
}
