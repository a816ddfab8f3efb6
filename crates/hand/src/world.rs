//! The tube in the hand, and what of it comes to the glass.

use chance::Chance;
use geometry::{Ct, Rigid, Tool};

use crate::conditions::Conditions;
use crate::errors::Errors;
use crate::reader::Shown;
use crate::sensor::{Measured, Sensor};
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
pub(crate) struct World<'a> {
    task: &'a Task,
    conditions: &'a Conditions,
    sensor: &'a dyn Sensor,
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

/// The sensor that errs by [`Errors`]: its draws are those of the task.
pub(crate) struct Drawn<'a> {
    task: &'a Task,
    errors: Errors,
    registration: Rigid<Ct, Ct>,
}

impl<'a> Drawn<'a> {
    pub(crate) fn new(task: &'a Task, errors: Errors) -> Self {
        let registration = errors.of_registration(task.aim.target, Chance::new(task.seed, REGISTRATION));
        Self {
            task,
            errors,
            registration,
        }
    }
}

impl Sensor for Drawn<'_> {
    fn measured(&self, frame: u64, t_s: f64, truly: &dyn Fn(f64) -> Option<Rigid<Ct, Tool>>) -> Option<Measured> {
        let pose = truly(t_s)?;
        let tip = pose * geometry::Point::<Tool>::new(0.0, 0.0, 0.0);
        let noise = self.errors.of_frame(tip, Chance::new(self.task.seed, FRAMES + frame));
        // The true pose is the measured one with both motions after it.
        let measured = (self.registration * noise).inverse() * pose;
        Some(Measured {
            pose: measured,
            covariance: self.errors.stated(measured, self.task.aim.target),
        })
    }
}

impl<'a> World<'a> {
    pub(crate) fn new(task: &'a Task, conditions: &'a Conditions, sensor: &'a dyn Sensor) -> Self {
        let human = &conditions.human;
        Self {
            task,
            conditions,
            sensor,
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

    /// What is on the glass in the frame of this number; `None` where nothing was measured, as of a tube that lies across
    /// its way.
    pub(crate) fn shown(&self, frame: u64) -> Option<Shown> {
        let Conditions { delay_s, lag_s, .. } = self.conditions;
        let truly = |t_s: f64| self.task.way.pose(&self.truly(t_s));
        let t_s = frame as f64 / RATE_HZ - delay_s - lag_s;
        let Measured { pose, covariance } = self.sensor.measured(frame, t_s, &truly)?;
        Some(Shown {
            pose,
            covariance,
            aim: self.task.aim,
            entry: self.task.way.entry(),
        })
    }

    /// Whether the tube lies across its way at a time, so that it has no pose.
    pub(crate) fn is_across(&self, t_s: f64) -> bool {
        self.task.way.pose(&self.truly(t_s)).is_none()
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
