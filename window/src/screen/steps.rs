//! The screen of steps: the ladder from an examination to a navigation, and calibration, registration and check, step by step.
//!
//! ```text
//! +------------------------------------+------------------------+
//! | what is to be done, large          | the ladder             |
//! | how far it is: time, poses         | gates, kept or not     |
//! | points as bars, or the motion      | figures, the command   |
//! |                                    | the error at the target|
//! +------------------------------------+------------------------+
//! ```

mod bars;
mod ellipse;
mod motion;

use bus::message::{StepPhase, StepTask, Steps};
use egui::{Align2, Rect, Ui, vec2};
use picture::palette;

use super::lines::{self, Lines};
use super::words::{Type, Words, colour, on_band};
use super::{Outcome, tree};
use crate::colours;
use crate::model::{StepsModel, Tone};
use crate::sizes::Sizes;

/// Of the width, what the step takes; the rest is the ladder's and what is known of the result.
const STEP: f32 = 0.56;
/// What is to be done stands so much larger than other words.
const LARGE: f32 = 1.5;
/// Of the height at the right, the picture of the error.
const ELLIPSE: f32 = 0.34;

pub(super) fn show(ui: &Ui, steps: &StepsModel, sizes: &Sizes, outcome: &mut Outcome) {
    let room = Rect::from_min_max(sizes.top.left_bottom(), sizes.foot.right_top()).shrink(sizes.gap);
    let (left, right) = room.split_left_right_at_fraction(STEP);
    let words = &mut outcome.words;
    let (left, right) = (left.with_max_x(left.right() - sizes.gap), right);
    match (&steps.steps, steps.task()) {
        (Some(told), Some(_)) => step(ui, told, left, (sizes, words)),
        (told, _) => begin(ui, told.as_deref(), left, (sizes, words)),
    }
    result(ui, steps, right, (sizes, words));
}

fn large(sizes: &Sizes, tone: Tone) -> Type {
    Type {
        size: LARGE * sizes.plain,
        colour: colour(tone),
        ground: colours::GROUND,
        align: Align2::LEFT_CENTER,
    }
}

/// Nothing was begun: what can be.
fn begin(ui: &Ui, told: Option<&Steps>, room: Rect, (sizes, words): (&Sizes, &mut Words)) {
    let mut lines = Lines::new(ui, room, (sizes, words));
    match told {
        Some(_) => lines.put_now("Choose what is to be done: Calibrate, Register or Check.", Tone::Quiet),
        None => lines.put_now(
            "nothing came from the process `calib`: `pilot status` says how it is",
            Tone::Warning,
        ),
    }
}

/// The step that a person stands at.
fn step(ui: &Ui, told: &Steps, room: Rect, (sizes, words): (&Sizes, &mut Words)) {
    let tall = 1.3 * LARGE * sizes.plain;
    let (head, below) = room.split_top_bottom_at_y(room.top() + tall);
    let number = (told.step + 1).min(told.steps.max(1));
    let title = format!("{}    {number} of {}", Steps::text(&told.title), told.steps);
    words.put(ui, head, &title, large(sizes, Tone::Live));
    let (what, below) = below.split_top_bottom_at_y(below.top() + 2.0 * tall);
    wrapped(ui, what, &Steps::text(&told.what), large(sizes, Tone::Quiet), words);
    let (progress, below) = below.split_top_bottom_at_y(below.top() + 2.6 * sizes.plain);
    goes_on(ui, told, progress, (sizes, words));
    let mut lines = Lines::new(ui, below, (sizes, words));
    let advice = Steps::text(&told.advice);
    match told.phase() {
        Some(StepPhase::Listening) => lines.put_now(&advice, Tone::Quiet),
        _ => lines.put_wrapped(&Steps::text(&told.refused), Tone::Warning),
    }
    let rest = lines.rest();
    if !motion::show(ui, told, rest, (sizes, words)) {
        bars::show(ui, told, rest, (sizes, words));
    }
}

/// Words over two lines as long as one another.
fn wrapped(ui: &Ui, room: Rect, text: &str, how: Type, words: &mut Words) {
    let columns = (room.width() / (crate::sizes::ADVANCE * how.size)) as usize;
    let (upper, lower) = room.split_top_bottom_at_fraction(0.5);
    let letters = text.chars().count();
    let columns = if letters <= columns {
        letters
    } else {
        letters.div_ceil(2) + 6
    };
    let lines = lines::wrapped(text, columns.max(1));
    for (room, line) in [upper, lower].into_iter().zip(lines) {
        words.put(ui, room, line, how);
    }
}

/// How far the step is: a bar of the time, and how many frames show the marker.
fn goes_on(ui: &Ui, told: &Steps, room: Rect, (sizes, words): (&Sizes, &mut Words)) {
    let Some(phase) = told.phase() else { return };
    let (bar, below) = room.split_top_bottom_at_fraction(0.5);
    let bar = bar.shrink2(vec2(0.0, 2.0));
    let text = match phase {
        StepPhase::Listening => {
            let share = (told.passed_s / told.asked_s.max(0.1)).clamp(0.0, 1.0) as f32;
            ui.painter().rect_filled(bar, 2.0, colours::BUTTON);
            let full = Rect::from_min_size(bar.min, vec2(share * bar.width(), bar.height()));
            ui.painter().rect_filled(full, 2.0, colours::of(palette::TARGET));
            format!(
                "{:.1} of {:.1} s, the marker seen in {} of {} frames",
                told.passed_s, told.asked_s, told.poses, told.frames
            )
        }
        StepPhase::Going => "the simulated hand is on its way".to_owned(),
        StepPhase::Working => "computing".to_owned(),
        StepPhase::Done => "ACCEPTED and written; the ladder says when the tracker uses it".to_owned(),
        StepPhase::Waiting => String::new(),
    };
    let how = Type {
        size: sizes.plain,
        colour: colour(Tone::Quiet),
        ground: colours::GROUND,
        align: Align2::LEFT_CENTER,
    };
    words.put_as(ui, below, &text, how, tree::role(Tone::Quiet));
}

/// At the right: the ladder, and what is known of the result.
fn result(ui: &Ui, steps: &StepsModel, room: Rect, (sizes, words): (&Sizes, &mut Words)) {
    let told = steps.steps.as_deref();
    let has_ellipse = told.is_some_and(|told| told.target_95_mm.is_finite());
    let (upper, lower) = match has_ellipse {
        true => room.split_top_bottom_at_fraction(1.0 - ELLIPSE),
        false => (room, room.with_min_y(room.bottom())),
    };
    let mut lines = Lines::new(ui, upper, (sizes, words)).or_by("`pilot steps` says them");
    for rung in &steps.ladder {
        let mark = if rung.is_done { "[x] " } else { "[ ] " };
        lines.put_now(&format!("{mark}{}", rung.words), rung.tone);
    }
    lines.next();
    if let Some(told) = told.filter(|told| told.task().is_some()) {
        verdict(told, &mut lines);
        gates(told, &mut lines);
        for figure in told.figures() {
            lines.put_all(&figure.words(), Tone::Quiet);
        }
        let command = Steps::text(&told.command);
        if !command.is_empty() {
            lines.put_all(&format!("the same: {command}"), Tone::Quiet);
        }
    }
    lines.put_waiting();
    if let Some(told) = told.filter(|_| has_ellipse) {
        ellipse::show(ui, told, steps.target_radius_mm, lower, (sizes, words));
    }
}

/// Whether the result can be accepted, and why not.
fn verdict(told: &Steps, lines: &mut Lines<'_, '_>) {
    if told.task() == Some(StepTask::Check) || told.phase().is_some_and(|phase| phase.is_busy()) {
        return;
    }
    match told.is(Steps::CAN_ACCEPT) {
        true => lines.put_now("CAN BE ACCEPTED: A", Tone::Live),
        false => lines.put_wrapped(&format!("NOT YET: {}", Steps::text(&told.why_not)), Tone::Quiet),
    }
}

fn gates(told: &Steps, lines: &mut Lines<'_, '_>) {
    for gate in told.gates() {
        let (kept, tone) = match gate.kept {
            1 => ("kept", Tone::Quiet),
            _ => ("NOT KEPT", Tone::Warning),
        };
        let (what, unit) = in_words(&gate.name());
        let found = match gate.found.is_finite() {
            true => format!("{:.2}{unit}", gate.found),
            false => "not measured".to_owned(),
        };
        let bound = if gate.at_least == 1 { "at least" } else { "at most" };
        lines.put_all(&format!("{what} {found}, {bound} {}: {kept}", gate.limit), tone);
    }
}

/// A gate of the scene as a person says it, and its unit.
fn in_words(gate: &str) -> (String, &'static str) {
    let known = [
        ("max_rms_mm", "poses agree to", " mm"),
        ("max_tip_error_mm", "error of the tip", " mm"),
        ("max_condition", "condition", ""),
        ("min_cone_deg", "cone", "\u{b0}"),
        ("max_fre_mm", "points agree to", " mm"),
        ("max_tre_mm", "error at the target (95 %)", " mm"),
    ];
    let found = known.iter().find(|(name, ..)| *name == gate);
    found.map_or((gate.to_owned(), ""), |(_, words, unit)| ((*words).to_owned(), unit))
}

/// Words of a tone in a table.
fn cell(sizes: &Sizes, tone: Tone, align: Align2) -> Type {
    let has_band = matches!(tone, Tone::Warning | Tone::Alarm);
    Type {
        size: sizes.plain,
        colour: if has_band { on_band(tone) } else { colour(Tone::Quiet) },
        ground: if has_band { colour(tone) } else { colours::GROUND },
        align,
    }
}
