//! The buttons at the bottom, each with its key; a pedal sends the same keys.

use bus::message::ReplayState;
use egui::{Align2, Id, Key, Rect, Sense, Stroke, StrokeKind, Ui, pos2, vec2};

use super::button::{Button, button};
use super::words::{Type, Words, colour};
use super::{ImagesKey, Look, Outcome, Wish, step_buttons, tree};
use crate::colours;
use crate::model::{Model, ReplayModel, Tone};
use crate::sizes::Sizes;

/// The buttons of this screen.
fn buttons(model: &Model, look: &Look) -> Vec<Button> {
    if let Some(steps) = model.steps.as_ref().filter(|_| look.steps && !look.only_sight) {
        return step_buttons::all(steps);
    }
    let hold = if model.state.is_held { "Follow" } else { "Hold" };
    let mut all = match model.state.is_replay {
        true => of_a_replay(model),
        false => of_a_run(hold),
    };
    all.push(button("Screenshot", "F9", Key::F9, Wish::Shot));
    if look.enlarged.is_some() {
        all.push(button("All views", "Esc", Key::Escape, Wish::Enlarge(None)));
    } else if let (Some(next), false) = (look.views.next(&model.cells), look.only_sight) {
        all.push(button("Views", "V", Key::V, Wish::Views(next)));
    }
    if model.steps.is_some() && !look.only_sight {
        all.push(button("Steps", "F2", Key::F2, Wish::Steps(true)));
    }
    if model.may_restart_localizer {
        all.push(button("Restart localizer", "L", Key::L, Wish::RestartLocalizer));
    }
    // The way back is there where there is one.
    if model.are_images_changed && !model.state.is_replay {
        all.push(button("Scene's images", "0", Key::Num0, Wish::Images(ImagesKey::Scene)));
    }
    all
}

/// Those of a run that navigates.
fn of_a_run(hold: &str) -> Vec<Button> {
    vec![
        button(
            "Target before",
            "Page up",
            Key::PageUp,
            Wish::NextTarget { is_forward: false },
        ),
        button(
            "Next target",
            "Page down",
            Key::PageDown,
            Wish::NextTarget { is_forward: true },
        ),
        button("Mark", "Space", Key::Space, Wish::Mark),
        button(hold, "F6", Key::F6, Wish::Hold),
    ]
}

/// What a replay is steered by. What is chosen, marked and held is the recording's there.
fn of_a_replay(model: &Model) -> Vec<Button> {
    let is_going = |replay: &ReplayModel| replay.state == ReplayState::Playing;
    let pause = match model.replay.as_ref().is_none_or(is_going) {
        true => "Pause",
        false => "Play",
    };
    let mark = |is_forward| Wish::NextMark { is_forward };
    let speed = |is_faster| Wish::Speed { is_faster };
    vec![
        button("Mark before", "Page up", Key::PageUp, mark(false)),
        button("Next mark", "Page down", Key::PageDown, mark(true)),
        button("Back 5 s", "Left", Key::ArrowLeft, Wish::Skip(-5)),
        button("Pose before", "A", Key::A, Wish::PoseBefore),
        button(pause, "P", Key::P, Wish::Pause),
        button("Step", "S", Key::S, Wish::OnePose),
        button("On 5 s", "Right", Key::ArrowRight, Wish::Skip(5)),
        button("Slower", "Comma", Key::Comma, speed(false)),
        button("Faster", "Full stop", Key::Period, speed(true)),
        button("Moment", "M", Key::M, Wish::Moment),
    ]
}

pub(super) fn show(ui: &Ui, model: &Model, sizes: &Sizes, look: &Look, outcome: &mut Outcome) {
    let all = buttons(model, look);
    let width = sizes.foot.width() / all.len() as f32;
    for (k, button) in all.iter().enumerate() {
        let left = sizes.foot.left() + width * k as f32;
        let rect = Rect::from_min_size(pos2(left, sizes.foot.top()), vec2(width, sizes.foot.height()));
        if is_pressed(ui, button, rect.shrink(2.0), sizes, outcome) {
            outcome.wishes.push(button.wish.clone());
        }
    }
}

fn is_pressed(ui: &Ui, button: &Button, rect: Rect, sizes: &Sizes, outcome: &mut Outcome) -> bool {
    if !button.is_enabled {
        disabled(ui, (&button.word, button.key), rect, sizes, &mut outcome.words);
        return false;
    }
    let is_touched = touched(ui, (&button.word, button.key), rect, sizes, &mut outcome.words);
    is_touched || ui.input(|input| input.key_pressed(button.pressed))
}

/// A button that does nothing now: without a ground of its own. Why stands on the screen.
fn disabled(ui: &Ui, (word, key): (&str, &str), rect: Rect, sizes: &Sizes, words: &mut Words) {
    let response = ui.interact(rect, Id::unique(("button", key)), Sense::hover());
    tree::disabled(&response, word, key);
    ui.painter()
        .rect_stroke(rect, 4.0, Stroke::new(sizes.line, colours::LINE), StrokeKind::Inside);
    let how = Type {
        size: sizes.plain,
        colour: colour(Tone::Quiet),
        ground: colours::GROUND,
        align: Align2::CENTER_CENTER,
    };
    let (upper, lower) = rect.shrink2(vec2(sizes.gap, 2.0)).split_top_bottom_at_fraction(0.5);
    words.paint(ui, upper, &format!("({word})"), how);
    words.paint(ui, lower, key, how);
}

/// A button with its word, and its key as it is printed on the keyboard; whether it was touched.
pub(crate) fn touched(ui: &Ui, (word, key): (&str, &str), rect: Rect, sizes: &Sizes, words: &mut Words) -> bool {
    let response = ui.interact(rect, Id::unique(("button", key)), Sense::click());
    tree::button(&response, word, key);
    let ground = match response.is_pointer_button_down_on() {
        true => colours::LINE,
        false => colours::BUTTON,
    };
    ui.painter().rect_filled(rect, 4.0, ground);
    let how = Type {
        size: sizes.plain,
        colour: colour(Tone::Quiet),
        ground,
        align: Align2::CENTER_CENTER,
    };
    let (upper, lower) = rect.shrink2(vec2(sizes.gap, 2.0)).split_top_bottom_at_fraction(0.5);
    words.paint(ui, upper, word, how);
    words.paint(ui, lower, key, how);
    response.clicked()
}
