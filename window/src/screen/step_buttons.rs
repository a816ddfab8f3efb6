//! The buttons of the screen of steps.

use bus::message::{StepPhase, StepTask, StepWish, Steps};
use egui::Key;

use super::Wish;
use super::button::{Button, button};
use crate::model::StepsModel;

/// A task, its word, its key as it is printed and the key.
const TASKS: [(StepTask, &str, &str, Key); 3] = [
    (StepTask::Calibrate, "Calibrate", "F2", Key::F2),
    (StepTask::Register, "Register", "F3", Key::F3),
    (StepTask::Check, "Check", "F4", Key::F4),
];

pub(super) fn all(steps: &StepsModel) -> Vec<Button> {
    let told = steps.steps.as_deref();
    let is_busy = told.and_then(Steps::phase).is_some_and(StepPhase::is_busy);
    let step = |wish| Wish::Step(wish);
    let mut all: Vec<Button> = TASKS
        .into_iter()
        .filter(|(task, ..)| steps.has(*task))
        .map(|(task, word, key, pressed)| button(word, key, pressed, step(StepWish::Open(task))))
        .collect();
    if let Some(told) = told.filter(|told| told.task().is_some()) {
        all.push(match is_busy {
            true => button("Give up", "Esc", Key::Escape, step(StepWish::Cancel)),
            false => button("Begin", "Space", Key::Space, step(StepWish::Begin)).enabled(told.is(Steps::CAN_BEGIN)),
        });
        all.extend(of_the_points(told, is_busy));
        if told.task() != Some(StepTask::Check) {
            let can = |flag| told.is(flag) && !is_busy;
            let back = button("Take back", "Backspace", Key::Backspace, step(StepWish::Back));
            all.push(back.enabled(can(Steps::CAN_GO_BACK)));
            let accept = button("Accept", "A", Key::A, step(StepWish::Accept));
            all.push(accept.enabled(can(Steps::CAN_ACCEPT)));
        }
    }
    all.extend(of_the_run(steps));
    all.push(button("Screenshot", "F9", Key::F9, Wish::Shot));
    all.push(button("Images", "F5", Key::F5, Wish::Steps(false)));
    all
}

/// The point to be touched next is a person's choice.
fn of_the_points(told: &Steps, is_busy: bool) -> Vec<Button> {
    if told.points().len() < 2 {
        return Vec::new();
    }
    let has_choice = told.next != u32::MAX;
    let point = |word, key, pressed, is_forward| {
        button(word, key, pressed, Wish::NextPoint { is_forward }).enabled(has_choice && !is_busy)
    };
    vec![
        point("Point before", "Up", Key::ArrowUp, false),
        point("Next point", "Down", Key::ArrowDown, true),
    ]
}

/// What a person says of the run.
fn of_the_run(steps: &StepsModel) -> Vec<Button> {
    let mut all = Vec::new();
    if steps.asks_whose {
        all.push(button("Confirm", "C", Key::C, Wish::Confirm));
        all.push(button("Reject", "X", Key::X, Wish::Reject));
    }
    if steps.is_registered {
        all.push(button("Marker moved", "B", Key::B, Wish::Moved));
    }
    if let Some(word) = steps.navigates {
        all.push(button(word, "N", Key::N, Wish::Navigate));
    }
    all
}
