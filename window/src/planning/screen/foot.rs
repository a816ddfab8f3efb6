//! The buttons at the bottom, each with its key.

use bus::message::PlanWish;
use egui::{Rect, Ui, pos2, vec2};
use guidance::plan::Edit;

use super::super::desk::{Desk, Mode};
use super::super::typing::For;
use super::{Known, Outcome, keys};
use crate::screen::touched;
use crate::sizes::Sizes;

/// A button: its word and its key as it is printed on the keyboard.
const BUTTONS: [(&str, &str); 11] = [
    ("Undo", "Ctrl Z"),
    ("Redo", "Ctrl Y"),
    ("Next target", "Tab"),
    ("Name", "N"),
    ("Remove", "Del"),
    ("Distance", "M"),
    ("Angle", "A"),
    ("Window", "W"),
    ("Reset", "R"),
    ("Screenshot", "F9"),
    ("Confirm", "C"),
];

pub(super) fn show(ui: &Ui, known: &Known<'_>, desk: &mut Desk, sizes: &Sizes, outcome: &mut Outcome) {
    let width = sizes.foot.width() / BUTTONS.len() as f32;
    for (k, (word, key)) in BUTTONS.into_iter().enumerate() {
        let corner = pos2(sizes.foot.left() + width * k as f32, sizes.foot.top());
        let rect = Rect::from_min_size(corner, vec2(width, sizes.foot.height())).shrink(2.0);
        if touched(ui, (word, key), rect, sizes, &mut outcome.words) {
            carry_out(word, known, desk, outcome);
        }
    }
}

fn carry_out(word: &str, known: &Known<'_>, desk: &mut Desk, outcome: &mut Outcome) {
    let removed = || desk.target(known.plan).map(|target| target.name.clone());
    match word {
        "Undo" => outcome.wish(PlanWish::Undo),
        "Redo" => outcome.wish(PlanWish::Redo),
        "Next target" => desk.select_next(known.plan, true),
        "Name" => keys::begin(desk, For::Name, known),
        "Remove" => {
            let name = removed();
            let wish = name.map(|name| PlanWish::Edit(Edit::Remove(name)));
            wish.into_iter().for_each(|wish| outcome.wish(wish));
        }
        "Distance" => desk.mode = Mode::Measure(Vec::new(), 2),
        "Angle" => desk.mode = Mode::Measure(Vec::new(), 3),
        "Window" => {
            desk.mode = if desk.mode == Mode::Level {
                Mode::Point
            } else {
                Mode::Level
            }
        }
        "Reset" => desk.camera.reset(known.grid),
        "Screenshot" => outcome.shot = true,
        "Confirm" => keys::begin(desk, For::Confirm, known),
        _ => {}
    }
}
