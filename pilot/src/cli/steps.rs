//! `pilot steps`: calibration, registration and check, step by step, without a window.

use std::fmt::Write;
use std::process::ExitCode;
use std::time::Duration;

use bus::Bus;
use bus::clock::{self, monotonic_ns};
use bus::message::{StepPoint, StepTask, StepWish, Steps};
use bus::port::Subscriber;
use bus::run::{RunContext, RunError as FolderError, RunLock, run_dir};
use bus::topic::STEPS;
use clap::{Args, ValueEnum};
use serde_json::{Value, json};

use super::ask::ask_process;
use super::error::CliError;
use crate::plan::CALIBRATOR;
use crate::resolve::ResolveError;

pub(crate) const STEPS_HELP: &str = "\
What a run's window shows on its screens Calibrate, Register and Check, and what can be done there. Nothing is used before it is \
accepted; a check counts as soon as every point was touched, or one of them is off.

Examples:
  pilot steps                          what is to be done now, and how good it is so far
  pilot steps register                 begins the registration of the patient, from its first point
  pilot steps begin --wait             touches the next point, and says what came of it
  pilot steps point 2                  the next touch is of the second point
  pilot steps back                     forgets the last touch
  pilot steps accept                   the tracker uses what was found
  pilot steps --json                   all of it for a program

Exit codes: 0 done; 1 refused, or what was listened to gave nothing.";

/// How long the newest message may take to come.
const MESSAGE: Duration = Duration::from_secs(2);
/// The longest that a step is waited for.
const STEP: Duration = Duration::from_secs(150);
const LOOK: Duration = Duration::from_millis(20);

/// What is wished.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Wish {
    /// Begin the calibration of the tool.
    Calibrate,
    /// Begin the registration of the patient.
    Register,
    /// Begin the check of the registration.
    Check,
    /// Listen: to the motion of this step, or to the next touch.
    Begin,
    /// Give up what is listened to.
    Cancel,
    /// Forget the last touch, or the step before.
    Back,
    /// The next touch is of this point.
    Point,
    /// Use what was found.
    Accept,
}

#[derive(Debug, Args)]
pub(crate) struct StepsArgs {
    /// What is to be done; without it, where things stand is said
    #[arg(value_enum)]
    wish: Option<Wish>,
    /// With `point`: which, from 1
    #[arg(value_name = "NUMBER", value_parser = clap::value_parser!(u32).range(1..))]
    number: Option<u32>,
    /// Wait until the step has ended, and say what came of it
    #[arg(long)]
    wait: bool,
    /// As JSON
    #[arg(long)]
    json: bool,
    /// The run
    #[arg(long, default_value = "default")]
    run: String,
}

impl StepsArgs {
    /// Asks the run, and says what it answered and where things stand.
    pub(crate) fn carry_out(&self) -> Result<(String, ExitCode), CliError> {
        let mut text = String::new();
        let listener = Listener::open(&self.run)?;
        if let Some(wish) = self.wish()? {
            let said = ask_process(&self.run, CALIBRATOR, wish.command(), |_| Ok(()))?;
            if !self.wait {
                return Ok((said, ExitCode::SUCCESS));
            }
        }
        // Where something was wished, the newest message is of after that: it is told before the answer.
        let steps = listener.settled(self.wait)?;
        let refused = Steps::text(&steps.refused);
        text += match self.json {
            true => json(&steps).to_string(),
            false => words(&steps),
        }
        .trim_end();
        let code = match self.wait && !refused.is_empty() {
            true => ExitCode::FAILURE,
            false => ExitCode::SUCCESS,
        };
        Ok((text, code))
    }

    fn wish(&self) -> Result<Option<StepWish>, CliError> {
        Ok(Some(match (self.wish, self.number) {
            (Some(Wish::Point), Some(number)) => StepWish::Point(number - 1),
            (Some(Wish::Point), None) => return Err(CliError::NoPoint),
            (_, Some(number)) => return Err(CliError::Number(number)),
            (None, None) => return Ok(None),
            (Some(Wish::Calibrate), None) => StepWish::Open(StepTask::Calibrate),
            (Some(Wish::Register), None) => StepWish::Open(StepTask::Register),
            (Some(Wish::Check), None) => StepWish::Open(StepTask::Check),
            (Some(Wish::Begin), None) => StepWish::Begin,
            (Some(Wish::Cancel), None) => StepWish::Cancel,
            (Some(Wish::Back), None) => StepWish::Back,
            (Some(Wish::Accept), None) => StepWish::Accept,
        }))
    }
}

/// Hears where things stand.
struct Listener {
    run: String,
    steps: Subscriber<Steps>,
    /// Kept for as long as it is listened.
    _bus: Bus,
}

impl Listener {
    fn open(run: &str) -> Result<Self, CliError> {
        let dir = run_dir(run)?;
        if !RunLock::is_held(&dir) {
            return Err(FolderError::NotRunning { name: run.to_owned() }.into());
        }
        let context = RunContext::load(&dir)?;
        let scene = scene::Scene::load(&context.scene_path()).map_err(ResolveError::from)?;
        if scene.steps.is_none() || context.replay.is_some() || context.simulated_time {
            return Err(CliError::NoSteps(run.to_owned()));
        }
        let bus = Bus::operate(&context)?;
        Ok(Self {
            run: run.to_owned(),
            steps: Subscriber::open(&bus, &STEPS, "", 1)?,
            _bus: bus,
        })
    }

    /// The newest message, with `wait` the newest of nothing that goes on.
    fn settled(&self, wait: bool) -> Result<Steps, CliError> {
        let (mut newest, began_ns) = (None, monotonic_ns());
        let patience = if wait { STEP } else { MESSAGE };
        while monotonic_ns() - began_ns < clock::ns(patience) {
            newest = self.steps.newest()?.or(newest);
            let is_settled = |steps: &Steps| !wait || !steps.phase().is_some_and(|phase| phase.is_busy());
            if let Some(steps) = newest.filter(is_settled) {
                return Ok(steps);
            }
            std::thread::sleep(LOOK);
        }
        newest.ok_or_else(|| CliError::NoSteps(self.run.clone()))
    }
}

/// For people.
fn words(steps: &Steps) -> String {
    let mut text = String::new();
    let text_of = |field: &[u8]| Steps::text(field);
    let Some(task) = steps.task() else {
        let has = StepTask::ALL
            .into_iter()
            .filter(|task| steps.has(*task))
            .map(StepTask::word);
        return format!(
            "nothing is begun; begin with one of: {}",
            has.collect::<Vec<_>>().join(", ")
        );
    };
    let phase = steps.phase().map_or("unknown", |phase| phase.word());
    // Writing to a string does not fail.
    let _ = writeln!(
        text,
        "{}  {}, step {} of {}: {phase}",
        task.word(),
        text_of(&steps.title),
        (steps.step + 1).min(steps.steps),
        steps.steps
    );
    for (name, field) in [
        ("to do", &steps.what[..]),
        ("still lacks", &steps.advice[..]),
        ("REFUSED", &steps.refused[..]),
    ] {
        if !text_of(field).is_empty() {
            let _ = writeln!(text, "{name:<17}{}", text_of(field));
        }
    }
    for (i, point) in steps.points().iter().enumerate() {
        let _ = writeln!(text, "point {:<11}{}", i + 1, point_words(point));
    }
    for gate in steps.gates() {
        let kept = if gate.kept == 1 { "kept" } else { "NOT KEPT" };
        let _ = writeln!(
            text,
            "gate             {} {}: found {:.3}, {kept}",
            gate.name(),
            gate.limit,
            gate.found
        );
    }
    for figure in steps.figures() {
        let _ = writeln!(text, "                 {}", figure.words());
    }
    match steps.is(Steps::CAN_ACCEPT) {
        true => text += "can be accepted: pilot steps accept\n",
        false if !text_of(&steps.why_not).is_empty() => {
            let _ = writeln!(text, "not accepted     {}", text_of(&steps.why_not));
        }
        false => {}
    }
    if steps.is(Steps::CAN_BEGIN) {
        let _ = writeln!(
            text,
            "next             pilot steps begin --wait; the same as: {}",
            text_of(&steps.command)
        );
    }
    text
}

fn point_words(point: &StepPoint) -> String {
    let name = point.name();
    if !point.is_touched() {
        return format!("{name}: not touched");
    }
    let mut words = name;
    for (what, mm) in [
        ("residual", point.residual_mm),
        ("left out", point.left_out_mm),
        ("95 % within", point.expected_mm),
    ] {
        if mm.is_finite() {
            let _ = write!(words, ", {what} {mm:.2} mm");
        }
    }
    words + if point.is_off() { ", OFF" } else { "" }
}

/// For programs.
fn json(steps: &Steps) -> Value {
    let text = |field: &[u8]| Steps::text(field);
    let point = |point: &StepPoint| {
        json!({
            "name": point.name(), "touched": point.is_touched(), "touches": point.touches, "off": point.is_off(),
            "residual_mm": point.residual_mm, "left_out_mm": point.left_out_mm, "expected_95_mm": point.expected_mm,
        })
    };
    let gate = |gate: &bus::message::StepGate| json!({ "name": gate.name(), "limit": gate.limit, "found": gate.found, "kept": gate.kept == 1 });
    json!({
        "task": steps.task().map(StepTask::word),
        "phase": steps.phase().map(|phase| phase.word()),
        "step": steps.step, "steps": steps.steps,
        "title": text(&steps.title), "what": text(&steps.what), "advice": text(&steps.advice),
        "refused": text(&steps.refused), "why_not_accepted": text(&steps.why_not),
        "can_begin": steps.is(Steps::CAN_BEGIN), "can_accept": steps.is(Steps::CAN_ACCEPT),
        "command": text(&steps.command),
        "points": steps.points().iter().map(point).collect::<Vec<_>>(),
        "gates": steps.gates().iter().map(gate).collect::<Vec<_>>(),
        "figures": steps.figures().iter().map(|figure| figure.words()).collect::<Vec<_>>(),
        "target": { "name": text(&steps.target), "covariance_upper_mm2": steps.covariance, "radius_95_mm": steps.target_95_mm },
    })
}
