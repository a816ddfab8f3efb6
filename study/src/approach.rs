//! One approach: the scripted hand steers the tube to a target by what the sight, or the window's pixels, show of poses that the chain
//! makes.

use std::cell::{Cell, RefCell};
use std::f64::consts::{PI, TAU};

use bus::message::Lost;
use chance::Chance;
use geometry::{Ct, Direction, Point, Rigid, Tool, Uncertain, Vector};
use guidance::sight::{Aim, Covariance};
use hand::{Conditions, Dial, Measured, Outcome, Posture, Sensor, SightReader, Task, Way, perform_with};
use tracker_proc::chain::{Chain, Found, Reason};
use tracker_proc::operating_room::{Frame, OperatingRoom};

use crate::Words;
use crate::pixels::PixelReader;
use crate::plan::{Dials, Display};
use crate::record::Reasons;
use crate::room::LENGTH_MM;
use crate::truth::understated;

/// From the entry to the target, and how deep the tube is at the beginning, mm: as in the study of the hand.
const WAY_MM: f64 = 90.0;
const START_MM: f64 = 10.0;
/// How far the tube points beside the target at the beginning, at least and at most, rad.
const TILT_RAD: [f64; 2] = [4.0 * PI / 180.0, 8.0 * PI / 180.0];
/// How far ways may be from straight backwards, rad.
const OBLIQUE_RAD: f64 = PI / 6.0;
/// Rolls of the tube that are tried before it is taken: she holds the marker towards the localizer.
const ROLLS: u32 = 12;
/// When she gives up, s.
const LIMIT_S: f64 = 60.0;
/// Frames before the first look: pictures are older than what they show.
const BEFORE: u64 = 200;

/// What the chain made of the frame that was shown last.
#[derive(Debug, Clone)]
pub(crate) struct Last {
    pub(crate) frame: Frame,
    pub(crate) pose: Uncertain<Ct, Tool>,
}

/// A frame of the localizer, and what the chain made of it.
#[derive(Debug, Clone)]
pub(crate) struct Shot {
    pub(crate) frame: Frame,
    pub(crate) found: Result<Found, Reason>,
}

/// All frames of an approach in order, for a recording: also those that nobody looked at.
#[derive(Debug, Default)]
pub(crate) struct Tape {
    /// By how many frames after the first look the next one is, once there is one.
    next: Option<i64>,
    pub(crate) shots: Vec<Shot>,
}

/// How an approach went.
pub(crate) struct Approached {
    pub(crate) outcome: Outcome,
    /// `None` where no picture showed a pose.
    pub(crate) last: Option<Last>,
    /// When it ended, s of the room's time.
    pub(crate) ended_s: f64,
    /// Pictures looked at.
    pub(crate) pictures: u64,
    /// Those of them without a pose, by reason.
    pub(crate) reasons: Reasons,
}

/// The chain as what measures the tube.
struct Chained<'a> {
    localizer: &'a OperatingRoom,
    chain: &'a Chain,
    dials: &'a Dials,
    first: u64,
    last: RefCell<Option<Last>>,
    pictures: Cell<u64>,
    reasons: Cell<Reasons>,
    tape: Option<&'a RefCell<Tape>>,
}

impl Chained<'_> {
    /// Counts a picture, and why it has no pose.
    fn count(&self, found: Result<&Found, &Reason>) {
        self.pictures.set(self.pictures.get() + 1);
        let Err(reason) = found else { return };
        let mut reasons = self.reasons.get();
        let each = Lost::ALL.into_iter().zip(&mut reasons);
        each.filter(|(lost, _)| *lost == reason.lost())
            .for_each(|(_, count)| *count += 1);
        self.reasons.set(reasons);
    }

    /// Keeps the frames up to this one. What is before the present does not change any more.
    fn keep(&self, number: i64, truly: &dyn Fn(f64) -> Option<Rigid<Ct, Tool>>) {
        let Some(tape) = self.tape else { return };
        let mut tape = tape.borrow_mut();
        for at in tape.next.unwrap_or(number)..=number {
            // A tube across its way has no pose, and its frame is left out.
            let Some(pose) = truly(at as f64 / self.dials.localizer.rate_hz) else {
                continue;
            };
            let frame = self.localizer.frame_at(self.first.saturating_add_signed(at), pose);
            let found = self.chain.solve(&frame.tool, &frame.reference);
            tape.shots.push(Shot { frame, found });
        }
        tape.next = tape.next.max(Some(number.saturating_add(1)));
    }
}

impl Sensor for Chained<'_> {
    fn measured(&self, _: u64, t_s: f64, truly: &dyn Fn(f64) -> Option<Rigid<Ct, Tool>>) -> Option<Measured> {
        // The localizer's newest frame, by a whole number of them before or after the first look.
        let number = (t_s * self.dials.localizer.rate_hz).floor();
        self.keep(number as i64, truly);
        let pose = truly(number / self.dials.localizer.rate_hz)?;
        let seq = self.first.saturating_add_signed(number as i64);
        let frame = self.localizer.frame_at(seq, pose);
        let found = self.chain.solve(&frame.tool, &frame.reference);
        self.count(found.as_ref());
        let pose = found.ok()?.ct_from_tool;
        *self.last.borrow_mut() = Some(Last { frame, pose });
        Some(Measured {
            pose: pose.transform(),
            covariance: Covariance::Upper(understated(&pose, self.dials.understated)),
        })
    }
}

/// The task of an operation at one of its targets, held so that the localizer sees most of the marker; where the tube enters is drawn where it is
/// not told.
pub(crate) fn task(
    seed: u64,
    (target, entry): (Point<Ct>, Option<Point<Ct>>),
    radius_mm: f64,
    (quiet, seq): (&OperatingRoom, u64),
) -> Option<Task> {
    let chance = Chance::new(seed, 0);
    let evenly = |draw: u64, [low, high]: [f64; 2]| low + (high - low) * chance.uniform(draw);
    let (sin, cos) = evenly(0, [0.0, OBLIQUE_RAD]).sin_cos();
    let (up, right) = evenly(1, [0.0, TAU]).sin_cos();
    let drawn = target + Vector::new(sin * right, cos, sin * up) * -WAY_MM;
    let entry = entry.unwrap_or(drawn);
    let tilt = evenly(2, TILT_RAD).tan();
    let (b, a) = evenly(3, [0.0, TAU]).sin_cos();
    let start = Posture {
        tilt: [tilt * a, tilt * b],
        depth_mm: START_MM,
    };
    let straight = Posture {
        tilt: [0.0; 2],
        depth_mm: target.distance(entry),
    };
    let ways = (0..ROLLS).filter_map(|k| Way::new(entry, target, LENGTH_MM, TAU * f64::from(k) / f64::from(ROLLS)));
    let seen = |way: &Way| {
        let both = [start, straight].map(|posture| way.pose(&posture).map(|pose| quiet.frame_at(seq, pose).tool.len()));
        both.map(|seen| seen.unwrap_or(0)).into_iter().min()
    };
    // The first of those that are seen best.
    let way = ways.reduce(|best, way| if seen(&way) > seen(&best) { way } else { best })?;
    Some(Task {
        seed,
        way,
        aim: Aim {
            target,
            radius_mm,
            entry: None,
            stop_mm: 0.0,
        },
        start,
    })
}

/// Does one task; frames of the localizer count from `from` on, and are kept on the tape, where there is one.
///
/// # Errors
/// Where the machine failed: the window was not painted.
pub(crate) fn approach(
    task: &Task,
    (localizer, chain): (&OperatingRoom, &Chain),
    dials: &Dials,
    from: u64,
    tape: Option<&RefCell<Tape>>,
) -> Result<Approached, Words> {
    let sensor = Chained {
        localizer,
        chain,
        dials,
        first: from + BEFORE,
        last: RefCell::new(None),
        pictures: Cell::new(0),
        reasons: Cell::new(Reasons::default()),
        tape,
    };
    let conditions = Conditions {
        lag_s: dials.localizer.latency_s,
        limit_s: LIMIT_S,
        ..Conditions::default()
    };
    let outcome = match dials.display {
        Display::Sight => perform_with(task, &mut SightReader::new(Dial::FULL_HD), &conditions, &sensor),
        Display::Pixels => {
            // A screen of its own for each approach: what is painted does not depend on what was painted before.
            let mut reader = PixelReader::new()?;
            let outcome = perform_with(task, &mut reader, &conditions, &sensor);
            reader.painted()?;
            outcome
        }
    };
    Ok(Approached {
        outcome,
        ended_s: sensor.first as f64 / dials.localizer.rate_hz + outcome.time_s,
        last: sensor.last.take(),
        pictures: sensor.pictures.get(),
        reasons: sensor.reasons.get(),
    })
}

/// The pose of a tube that stands where it is to end: for what is told of an operation that was refused.
pub(crate) fn at_target(task: &Task) -> Option<Rigid<Ct, Tool>> {
    let straight = |depth_mm: f64| {
        task.way.pose(&Posture {
            tilt: [0.0; 2],
            depth_mm,
        })
    };
    let tip = straight(0.0)? * Point::new(0.0, 0.0, 0.0);
    straight(tip.distance(task.aim.target))
}

/// How long an approach may take, s: the room's time goes on by as much.
pub(crate) const fn longest_s(rate_hz: f64) -> f64 {
    LIMIT_S + 30.0 + 2.0 * BEFORE as f64 / rate_hz
}

/// A direction of its own, and a turn about another: how a marker is pushed.
pub(crate) fn push<F: geometry::Frame>(chance: Chance, mm: f64, deg: f64) -> Rigid<F, F> {
    let way = |first: u64| {
        let [x, y, z] = [0, 1, 2].map(|k| chance.normal(first + k));
        Vector::<F>::new(x, y, z).direction().unwrap_or(Direction::X)
    };
    let turn = way(0).vector() * deg.to_radians();
    Rigid::from_rotation_vector(turn, way(3).vector() * mm).unwrap_or(Rigid::identity())
}
