//! Where a person is on her way through calibration, registration and check, and what came of it so far.

use iceoryx2::prelude::ZeroCopySend;

use super::{Command, CommandKind, StepMotion, field_text, text_field};

/// Most bytes of a point's name.
const NAME: usize = 40;

/// Published by the calibrator whenever something changes. Lengths are mm, times of the session's clock ns; what is not known is NaN.
#[derive(Debug, Clone, Copy, PartialEq, ZeroCopySend)]
#[repr(C)]
#[type_name("trocar/Steps/2")]
pub struct Steps {
    /// When it was said.
    pub t_ns: i64,
    /// Code of a [`StepTask`]; 0: none was begun.
    pub task: u32,
    /// Bits of the tasks that the scene has: `1 << code`.
    pub tasks: u32,
    /// Code of a [`StepPhase`].
    pub phase: u32,
    /// Bits: [`Steps::CAN_BEGIN`] and those after it.
    pub flags: u32,
    /// Which step of the task, from 0.
    pub step: u32,
    /// How many steps the task has.
    pub steps: u32,
    /// While it is listened: s passed.
    pub passed_s: f64,
    /// And s asked for.
    pub asked_s: f64,
    /// While it is listened: frames that came.
    pub frames: u32,
    /// And those that show the marker.
    pub poses: u32,
    /// How many of `points`, `gates` and `figures` there are.
    pub counts: [u32; 3],
    /// Which of the points is to be touched next, from 0; beyond the last: none, or any.
    pub next: u32,
    /// Upper triangle by rows of the covariance of the place of `target` under the proposed registration, CT axes, mm^2.
    pub covariance: [f64; 6],
    /// Radius that holds 95 % of the errors at `target`, mm.
    pub target_95_mm: f64,
    /// What the step is called.
    pub title: [u8; Self::TITLE],
    /// What the person is to do.
    pub what: [u8; Self::WORDS],
    /// While it is listened: what the motion still lacks.
    pub advice: [u8; Self::WORDS],
    /// What it covers: while it is listened, and of the result that came of it.
    pub motion: StepMotion,
    /// Why the last try gave nothing; empty where it gave something.
    pub refused: [u8; Self::LONG],
    /// Why what is proposed cannot be accepted; of no meaning with [`Steps::CAN_ACCEPT`].
    pub why_not: [u8; Self::LONG],
    /// The command that does the same.
    pub command: [u8; Self::LONG],
    /// Where `covariance` is of.
    pub target: [u8; StepPoint::NAME],
    /// The points to be touched, in order.
    pub points: [StepPoint; Self::POINTS],
    /// The bounds that the result is held against.
    pub gates: [StepGate; Self::GATES],
    /// What else is known of the result, in words.
    pub figures: [StepFigure; Self::FIGURES],
}

/// A point that is touched.
#[derive(Debug, Clone, Copy, PartialEq, ZeroCopySend)]
#[repr(C)]
pub struct StepPoint {
    /// Its distance after the registration, or of the touched place from the known one, mm.
    pub residual_mm: f64,
    /// Its distance under the registration of all other points, mm.
    pub left_out_mm: f64,
    /// Up to where 95 % of such distances are expected, mm.
    pub expected_mm: f64,
    /// Bits: 1 it was touched, 2 its distance is beyond what is allowed.
    pub flags: u32,
    /// How often it was touched.
    pub touches: u32,
    /// Its name.
    pub name: [u8; NAME],
}

/// A bound on the result.
#[derive(Debug, Clone, Copy, PartialEq, ZeroCopySend)]
#[repr(C)]
pub struct StepGate {
    /// The bound.
    pub limit: f64,
    /// What was found; NaN: it was not measured.
    pub found: f64,
    /// 1: kept.
    pub kept: u32,
    /// 1: found must not be below the limit; else not above.
    pub at_least: u32,
    /// As the scene calls it.
    pub name: [u8; 32],
}

/// A line about the result.
#[derive(Debug, Clone, Copy, PartialEq, ZeroCopySend)]
#[repr(C)]
pub struct StepFigure {
    /// The words.
    pub words: [u8; 112],
}

const _: () = assert!(size_of::<StepPoint>() == 32 + StepPoint::NAME && size_of::<StepGate>() == 56);
const _: () = assert!(
    size_of::<Steps>()
        == 128
            + size_of::<StepMotion>()
            + Steps::TITLE
            + 2 * Steps::WORDS
            + 3 * Steps::LONG
            + StepPoint::NAME
            + Steps::POINTS * size_of::<StepPoint>()
            + Steps::GATES * size_of::<StepGate>()
            + Steps::FIGURES * size_of::<StepFigure>()
);

/// What is made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum StepTask {
    /// The tool.
    Calibrate,
    /// The patient.
    Register,
    /// Known points are touched.
    Check,
}

/// What goes on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StepPhase {
    /// Nothing was begun.
    Waiting,
    /// The simulated hand is on its way.
    Going,
    /// The instrument is followed.
    Listening,
    /// It is computed what came of that.
    Working,
    /// Everything of the task was accepted.
    Done,
}

/// What a person wishes of the calibrator.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StepWish {
    /// Begin a task, from its first step; what was not accepted is forgotten.
    Open(StepTask),
    /// Listen now: to the motion of this step, or to the next touch.
    Begin,
    /// Stop listening, and forget what was heard.
    Cancel,
    /// Forget the last touch, or the step before.
    Back,
    /// The next touch is of this point, from 0.
    Point(u32),
    /// Use what is proposed.
    Accept,
}

impl StepTask {
    /// Every task, in order.
    pub const ALL: [Self; 3] = [Self::Calibrate, Self::Register, Self::Check];

    /// Its code on the wire, from 1.
    pub const fn code(self) -> u32 {
        self as u32 + 1
    }

    /// As on a command line.
    pub const fn word(self) -> &'static str {
        match self {
            Self::Calibrate => "calibrate",
            Self::Register => "register",
            Self::Check => "check",
        }
    }
}

impl StepPhase {
    const ALL: [Self; 5] = [Self::Waiting, Self::Going, Self::Listening, Self::Working, Self::Done];

    /// Its code on the wire.
    pub const fn code(self) -> u32 {
        self as u32
    }

    /// As a person reads it.
    pub const fn word(self) -> &'static str {
        match self {
            Self::Waiting => "waiting",
            Self::Going => "the hand is on its way",
            Self::Listening => "listening",
            Self::Working => "computing",
            Self::Done => "accepted",
        }
    }

    /// Whether something goes on that ends by itself.
    pub const fn is_busy(self) -> bool {
        matches!(self, Self::Going | Self::Listening | Self::Working)
    }
}

impl StepWish {
    /// The request.
    pub fn command(self) -> Command {
        let words = match self {
            Self::Open(task) => task.word(),
            Self::Begin => "begin",
            Self::Cancel => "cancel",
            Self::Back => "back",
            Self::Point(_) => "point",
            Self::Accept => "accept",
        };
        let number = match self {
            Self::Point(place) => f64::from(place),
            _ => 0.0,
        };
        Command {
            number,
            ..Command::with_text(CommandKind::Steps, words)
        }
    }

    /// What a request asks for; `None` for words that are none.
    pub fn of(command: &Command) -> Option<Self> {
        let words = command.words();
        Some(match words.as_str() {
            "begin" => Self::Begin,
            "cancel" => Self::Cancel,
            "back" => Self::Back,
            "accept" => Self::Accept,
            "point" if (0.0..f64::from(u32::MAX)).contains(&command.number) => Self::Point(command.number as u32),
            word => Self::Open(StepTask::ALL.into_iter().find(|task| task.word() == word)?),
        })
    }
}

impl StepPoint {
    /// Most bytes of a point's name.
    pub const NAME: usize = NAME;
    /// It was touched.
    pub const TOUCHED: u32 = 1;
    /// Its distance is beyond what is allowed.
    pub const OFF: u32 = 2;
    const NONE: Self = Self {
        residual_mm: f64::NAN,
        left_out_mm: f64::NAN,
        expected_mm: f64::NAN,
        flags: 0,
        touches: 0,
        name: [0; NAME],
    };

    /// One that was not touched yet.
    pub fn named(name: &str) -> Self {
        Self {
            name: text_field(name),
            ..Self::NONE
        }
    }

    /// Its name.
    pub fn name(&self) -> String {
        field_text(&self.name)
    }

    /// Whether it was touched.
    pub const fn is_touched(&self) -> bool {
        self.flags & Self::TOUCHED != 0
    }

    /// Whether its distance is beyond what is allowed.
    pub const fn is_off(&self) -> bool {
        self.flags & Self::OFF != 0
    }
}

impl StepGate {
    const NONE: Self = Self {
        limit: f64::NAN,
        found: f64::NAN,
        kept: 0,
        at_least: 0,
        name: [0; 32],
    };

    /// A bound, and what was found.
    pub fn new(name: &str, limit: f64, found: f64, kept: bool) -> Self {
        Self {
            limit,
            found,
            kept: kept.into(),
            at_least: name.starts_with("min").into(),
            name: text_field(name),
        }
    }

    /// As the scene calls it.
    pub fn name(&self) -> String {
        field_text(&self.name)
    }
}

impl StepFigure {
    /// A line.
    pub fn new(words: &str) -> Self {
        Self {
            words: text_field(words),
        }
    }

    /// The line.
    pub fn words(&self) -> String {
        field_text(&self.words)
    }
}

impl Steps {
    /// Most bytes of a title.
    pub const TITLE: usize = 64;
    /// Most bytes of a sentence.
    pub const WORDS: usize = 192;
    /// Most bytes of a reason, and of a command.
    pub const LONG: usize = 320;
    /// Most points of a task.
    pub const POINTS: usize = 32;
    /// Most gates of a result.
    pub const GATES: usize = 12;
    /// Most lines about a result.
    pub const FIGURES: usize = 10;
    /// It can be begun to listen.
    pub const CAN_BEGIN: u32 = 1;
    /// What is proposed can be accepted.
    pub const CAN_ACCEPT: u32 = 2;
    /// There is something to take back.
    pub const CAN_GO_BACK: u32 = 4;
    /// The hand is a simulated one, which does what a step asks for.
    pub const PRACTICE: u32 = 8;

    /// Nothing was begun; the scene has these tasks.
    pub fn none(tasks: &[StepTask]) -> Self {
        Self {
            t_ns: 0,
            task: 0,
            tasks: tasks.iter().fold(0, |bits, task| bits | 1 << task.code()),
            phase: StepPhase::Waiting.code(),
            flags: 0,
            step: 0,
            steps: 0,
            passed_s: 0.0,
            asked_s: 0.0,
            frames: 0,
            poses: 0,
            counts: [0; 3],
            next: u32::MAX,
            covariance: [f64::NAN; 6],
            target_95_mm: f64::NAN,
            title: [0; Self::TITLE],
            what: [0; Self::WORDS],
            advice: [0; Self::WORDS],
            motion: StepMotion::NONE,
            refused: [0; Self::LONG],
            why_not: [0; Self::LONG],
            command: [0; Self::LONG],
            target: [0; StepPoint::NAME],
            points: [StepPoint::NONE; Self::POINTS],
            gates: [StepGate::NONE; Self::GATES],
            figures: [StepFigure { words: [0; 112] }; Self::FIGURES],
        }
    }

    /// The task, or `None` where none was begun.
    pub fn task(&self) -> Option<StepTask> {
        StepTask::ALL.into_iter().find(|task| task.code() == self.task)
    }

    /// Whether the scene has a task.
    pub const fn has(&self, task: StepTask) -> bool {
        self.tasks & (1 << task.code()) != 0
    }

    /// What goes on; `None` for an unknown code.
    pub fn phase(&self) -> Option<StepPhase> {
        StepPhase::ALL.into_iter().find(|phase| phase.code() == self.phase)
    }

    /// Whether all of these bits are set.
    pub const fn is(&self, flags: u32) -> bool {
        self.flags & flags == flags
    }

    /// The points there are.
    pub fn points(&self) -> &[StepPoint] {
        &self.points[..(self.counts[0] as usize).min(Self::POINTS)]
    }

    /// The gates there are.
    pub fn gates(&self) -> &[StepGate] {
        &self.gates[..(self.counts[1] as usize).min(Self::GATES)]
    }

    /// The lines there are.
    pub fn figures(&self) -> &[StepFigure] {
        &self.figures[..(self.counts[2] as usize).min(Self::FIGURES)]
    }

    /// With these points, gates and lines; those that have no room are left out.
    #[must_use]
    pub fn with(mut self, points: &[StepPoint], gates: &[StepGate], figures: &[StepFigure]) -> Self {
        self.points = filled(points, StepPoint::NONE);
        self.gates = filled(gates, StepGate::NONE);
        self.figures = filled(figures, StepFigure { words: [0; 112] });
        self.counts = [
            points.len().min(Self::POINTS),
            gates.len().min(Self::GATES),
            figures.len().min(Self::FIGURES),
        ]
        .map(|n| n as u32);
        self
    }

    /// A text of it, such as `&steps.title`.
    pub fn text(field: &[u8]) -> String {
        field_text(field)
    }

    /// A text for it, cut at a character where it is too long.
    pub fn field<const N: usize>(text: &str) -> [u8; N] {
        text_field(text)
    }
}

fn filled<T: Copy, const N: usize>(from: &[T], none: T) -> [T; N] {
    let mut all = [none; N];
    all.iter_mut().zip(from).for_each(|(to, from)| *to = *from);
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_wish_comes_back() {
        let open = StepTask::ALL.map(StepWish::Open);
        let others = [
            StepWish::Begin,
            StepWish::Cancel,
            StepWish::Back,
            StepWish::Point(7),
            StepWish::Accept,
        ];
        for wish in open.into_iter().chain(others) {
            assert_eq!(StepWish::of(&wish.command()), Some(wish));
        }
        let other = Command::with_text(CommandKind::Steps, "dance");
        assert_eq!(StepWish::of(&other), None);
        for number in [f64::NAN, -1.0, 1e12] {
            let point = Command {
                number,
                ..Command::with_text(CommandKind::Steps, "point")
            };
            assert_eq!(StepWish::of(&point), None);
        }
    }

    #[test]
    fn what_has_no_room_is_left_out_and_counts_from_the_bus_reach_no_further() {
        let many = vec![StepPoint::named("é"); 99];
        let mut steps = Steps::none(&[StepTask::Register]).with(&many, &[], &[StepFigure::new("rms 0.1 mm")]);
        assert_eq!((steps.points().len(), steps.gates().len()), (Steps::POINTS, 0));
        assert_eq!(
            (steps.points()[3].name(), steps.figures()[0].words()),
            ("é".into(), "rms 0.1 mm".into())
        );
        assert!(steps.has(StepTask::Register) && !steps.has(StepTask::Check) && steps.task().is_none());
        steps.counts = [u32::MAX; 3];
        steps.phase = 77;
        assert_eq!(
            (steps.points().len(), steps.gates().len(), steps.phase()),
            (Steps::POINTS, Steps::GATES, None)
        );
    }
}
