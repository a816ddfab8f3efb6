//! What is compared: displays, noise, lag, and one thing at a time about the operator.

use std::fmt::Write as _;

use hand::{Approach, Conditions, Errors, Human, Outcome, Reader, SightReader, Task, perform};

use crate::pixels::{PixelReader, SCREEN, dial};
use crate::slices::SliceReader;

/// The seed of all that is drawn.
const SEED: u64 = 1;
/// Noise of the measured tip, mm along each axis.
pub const NOISES_MM: [f64; 3] = [0.1, 0.3, 0.5];
/// Added lag, ms.
pub const LAGS_MS: [f64; 4] = [0.0, 50.0, 105.0, 200.0];
/// The noise in which all else is compared, mm.
pub const NOISE_MM: f64 = 0.3;
/// How far off she puts up with, at most, beside what the display says, mm.
pub const CONTENT_MM: [f64; 3] = [1.0, 0.75, 0.5];

/// Slices on which a target off the plane is not drawn.
const CUT_ALONE: &str = "no dashed rings";

/// What is looked at.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Display {
    /// The numbers of the sight, rounded as they are drawn.
    Sight,
    /// The local images alone.
    Slices,
    /// The window's pixels.
    Pixels,
}

impl Display {
    /// In tables.
    pub const fn word(self) -> &'static str {
        match self {
            Self::Sight => "sight",
            Self::Slices => "slices",
            Self::Pixels => "pixels",
        }
    }
}

/// One row of the tables: a display and what it is used under.
#[derive(Debug, Clone, PartialEq)]
pub struct Case {
    /// What is looked at.
    pub display: Display,
    /// What is other than in the main table; empty there.
    pub variant: String,
    /// Noise of the tip, mm.
    pub noise_mm: f64,
    /// Added lag, ms.
    pub lag_ms: f64,
    /// Which ways are gone.
    pub approach: Approach,
    /// All else.
    pub conditions: Conditions,
}

/// A case with what came of it, task by task.
#[derive(Debug, Clone)]
pub struct Done {
    /// The case.
    pub case: Case,
    /// In the order of the tasks.
    pub outcomes: Vec<Outcome>,
}

impl Case {
    fn new(display: Display, noise_mm: f64, lag_ms: f64) -> Self {
        Self {
            display,
            variant: String::new(),
            noise_mm,
            lag_ms,
            approach: Approach::InPlane,
            conditions: Conditions {
                errors: Errors::noisy(noise_mm),
                lag_s: lag_ms / 1e3,
                ..Conditions::default()
            },
        }
    }

    /// The case of the main table with this word and another operator.
    fn with(display: Display, lag_ms: f64, variant: &str, change: impl FnOnce(&mut Human)) -> Self {
        let mut case = Self::new(display, NOISE_MM, lag_ms);
        case.variant = variant.to_owned();
        change(&mut case.conditions.human);
        case
    }

    /// Does this many tasks.
    pub fn run(self, tasks: u64) -> Done {
        let outcomes = match self.display {
            Display::Sight => all(&self, tasks, &mut SightReader::new(dial(SCREEN))),
            Display::Slices => all(&self, tasks, &mut SliceReader::new(self.variant == CUT_ALONE)),
            Display::Pixels => all(&self, tasks, &mut PixelReader::new()),
        };
        Done { case: self, outcomes }
    }
}

fn all(case: &Case, tasks: u64, reader: &mut impl Reader) -> Vec<Outcome> {
    let tasks = (0..tasks).map(|number| Task::draw(SEED, number, case.approach));
    tasks.map(|task| perform(&task, reader, &case.conditions)).collect()
}

/// The main table: displays by noise by lag.
pub fn main_cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for display in [Display::Sight, Display::Slices] {
        for noise_mm in NOISES_MM {
            cases.extend(LAGS_MS.map(|lag_ms| Case::new(display, noise_mm, lag_ms)));
        }
    }
    cases
}

/// One thing at a time.
pub fn other_cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for display in [Display::Sight, Display::Slices] {
        let with = |variant: &str, change: fn(&mut Human)| Case::with(display, 0.0, variant, change);
        if display == Display::Slices {
            cases.push(with("glance 0.2 s", |human| human.glance_s = 0.2));
            cases.push(with("glance 0.5 s", |human| human.glance_s = 0.5));
            cases.push(with("glance 1 s", |human| human.glance_s = 1.0));
            cases.push(with("glance 2 s", |human| human.glance_s = 2.0));
            cases.push(with(CUT_ALONE, |_| {}));
        }
        for mm in CONTENT_MM {
            let variant = format!("on until shown within {mm} mm");
            cases.push(Case::with(display, 0.0, &variant, |human| human.content_mm = mm));
        }
        cases.push(with("pushes at 10 mm/s", |human| human.advance_mm_s = 10.0));
        cases.push(with("pushes at 40 mm/s", |human| human.advance_mm_s = 40.0));
        cases.push(with("pushes as fast as she aims", |human| {
            human.advance_mm_s = f64::INFINITY
        }));
        cases.push(with("scatter 0.04", |human| human.scatter = 0.04));
        cases.push(with("scatter 0.10", |human| human.scatter = 0.10));
        cases.push(with("reaction 0.3 s", |human| human.reaction_s = 0.3));
        cases.push(with("no tremor", |human| human.tremor_mm = 0.0));
        for lag_ms in [105.0, 200.0] {
            let unknowing = Case::with(display, lag_ms, "does not wait for the lag", |human| {
                human.knows_lag = false
            });
            cases.push(unknowing);
        }
        let mut oblique = with("oblique ways", |_| {});
        oblique.approach = Approach::Oblique;
        cases.push(oblique);
        let mut understated = with("error understated by 2", |_| {});
        understated.conditions.errors.understated = 2.0;
        cases.push(understated);
    }
    cases
}

/// The same by the numbers and by the pixels.
pub fn compared() -> [Case; 2] {
    [Display::Sight, Display::Pixels].map(|display| {
        let mut case = Case::new(display, NOISE_MM, 0.0);
        case.variant = "compared".to_owned();
        case
    })
}

/// The head of the file of tasks.
pub const CSV_HEAD: &str = "display,variant,noise_mm,lag_ms,task,arrived,time_s,miss_mm,shown_mm,error_mm,predicted_mm,\
    within_predicted,as_predicted,strokes,glances\n";

/// One line a task.
pub fn csv(done: &[Done]) -> String {
    let mut text = CSV_HEAD.to_owned();
    for Done { case, outcomes } in done {
        for (task, o) in outcomes.iter().enumerate() {
            let _ = writeln!(
                text,
                "{},{},{},{},{task},{},{:.4},{:.4},{:.4},{:.4},{:.4},{},{},{},{}",
                case.display.word(),
                case.variant,
                case.noise_mm,
                case.lag_ms,
                o.is_arrived,
                o.time_s,
                o.miss_mm,
                o.shown_mm,
                o.error_mm,
                o.predicted_mm,
                o.is_within(),
                o.is_as_predicted(),
                o.strokes,
                o.glances,
            );
        }
    }
    text
}
