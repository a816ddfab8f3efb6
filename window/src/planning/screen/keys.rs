//! The keys of the planning screen: those of 3D Slicer and ITK-SNAP where these have one.

use bus::message::PlanWish;
use egui::{Event, Key, Modifiers, Ui};
use geometry::{Ct, Point};
use guidance::plan::{Edit, MAX_NAME, MAX_WHO};

use super::super::camera::{Cut, PRESETS};
use super::super::desk::{Desk, Mode};
use super::super::typing::{For, Typed, Typing};
use super::{Known, Outcome};

/// What is said where a key needs the pointer on an image.
const POINT: &str = "point at an image first";

/// Takes what was pressed; `pointed` is what the pointer is on.
pub(super) fn take(
    ui: &Ui,
    known: &Known<'_>,
    desk: &mut Desk,
    pointed: Option<(Cut, Point<Ct>)>,
    outcome: &mut Outcome,
) {
    let events = ui.input(|input| input.events.clone());
    if desk.typing.is_some() {
        typed(desk, &events, outcome);
        return;
    }
    for event in events {
        if let Event::Key {
            key,
            pressed: true,
            modifiers,
            ..
        } = event
        {
            pressed(known, desk, (key, modifiers), pointed, outcome);
        }
    }
}

fn typed(desk: &mut Desk, events: &[Event], outcome: &mut Outcome) {
    let Some(mut typing) = desk.typing.take() else { return };
    let most = match typing.what {
        For::Name => MAX_NAME,
        For::Confirm => MAX_WHO,
    };
    match typing.take(events, most) {
        Typed::Goes => desk.typing = Some(typing),
        Typed::GivenUp => {}
        Typed::Done => match typing.what {
            For::Name => {
                let plan = outcome.plan.plan().clone();
                let wish = desk.change(&plan, |target| target.name = typing.text);
                wish.into_iter().for_each(|wish| outcome.wish(wish));
            }
            For::Confirm => outcome.wish(PlanWish::Confirm(typing.text)),
        },
    }
}

fn pressed(
    known: &Known<'_>,
    desk: &mut Desk,
    (key, modifiers): (Key, Modifiers),
    pointed: Option<(Cut, Point<Ct>)>,
    outcome: &mut Outcome,
) {
    let grid = known.grid;
    let plan = &outcome.plan.plan().clone();
    if modifiers.ctrl {
        match key {
            Key::Z => outcome.wish(PlanWish::Undo),
            Key::Y => outcome.wish(PlanWish::Redo),
            _ => {}
        }
        return;
    }
    match key {
        Key::Tab => desk.select_next(plan, !modifiers.shift),
        Key::PageDown => desk.select_next(plan, true),
        Key::PageUp => desk.select_next(plan, false),
        Key::W => {
            desk.mode = if desk.mode == Mode::Level {
                Mode::Point
            } else {
                Mode::Level
            }
        }
        Key::M => desk.mode = Mode::Measure(Vec::new(), 2),
        Key::A => desk.mode = Mode::Measure(Vec::new(), 3),
        Key::R => desk.camera.reset(grid),
        Key::J => {
            if let Some(target) = desk.target(plan).cloned() {
                desk.select(&target);
            }
        }
        Key::Escape => give_up(desk),
        Key::F9 => outcome.shot = true,
        Key::Num1 | Key::Num2 | Key::Num3 | Key::Num4 | Key::Num5 => {
            let place = key as usize - Key::Num1 as usize;
            desk.camera.window = PRESETS[place].1;
        }
        Key::B | Key::ArrowDown => slice(desk, pointed, -1.0, known),
        Key::F | Key::ArrowUp => slice(desk, pointed, 1.0, known),
        _ => edit(known, desk, key, pointed, outcome),
    }
}

fn give_up(desk: &mut Desk) {
    let begun = !matches!(desk.mode, Mode::Point) || desk.held.is_some();
    match begun {
        true => (desk.mode, desk.held) = (Mode::Point, None),
        false => desk.enlarged = None,
    }
}

fn slice(desk: &mut Desk, pointed: Option<(Cut, Point<Ct>)>, steps: f64, known: &Known<'_>) {
    match pointed.map(|(cut, _)| cut).or(desk.enlarged) {
        Some(cut) => desk.camera.turn_wheel(cut, steps, known.grid),
        None => POINT.clone_into(&mut desk.note),
    }
}

/// Keys that change the plan.
fn edit(known: &Known<'_>, desk: &mut Desk, key: Key, pointed: Option<(Cut, Point<Ct>)>, outcome: &mut Outcome) {
    let plan = &outcome.plan.plan().clone();
    let wish = match (key, pointed) {
        (Key::T | Key::E, None) => {
            POINT.clone_into(&mut desk.note);
            None
        }
        (Key::T, Some((_, p))) => Some(desk.add(plan, p)),
        (Key::E, Some((_, p))) => desk.change(plan, |target| target.entry = Some(p)).inspect(|wish| {
            if let PlanWish::Edit(Edit::Change(_, target)) = wish {
                desk.camera.fit(target);
            }
        }),
        (Key::Plus | Key::Equals, _) => desk.change(plan, |target| Desk::step_diameter(target, 1.0)),
        (Key::Minus, _) => desk.change(plan, |target| Desk::step_diameter(target, -1.0)),
        (Key::CloseBracket, _) => desk.change(plan, |target| Desk::step_stop(target, 1.0)),
        (Key::OpenBracket, _) => desk.change(plan, |target| Desk::step_stop(target, -1.0)),
        (Key::Delete, _) => desk
            .target(plan)
            .map(|target| PlanWish::Edit(Edit::Remove(target.name.clone()))),
        (Key::X, _) => plan
            .measures
            .len()
            .checked_sub(1)
            .map(|last| PlanWish::Edit(Edit::RemoveMeasure(last))),
        (Key::N, _) => {
            begin(desk, For::Name, known);
            None
        }
        (Key::C, _) => {
            begin(desk, For::Confirm, known);
            None
        }
        _ => None,
    };
    wish.into_iter().for_each(|wish| outcome.wish(wish));
}

/// Asks for words.
pub(super) fn begin(desk: &mut Desk, what: For, known: &Known<'_>) {
    let text = match (what, desk.target(known.plan)) {
        (For::Name, Some(target)) => target.name.clone(),
        (For::Name, None) => return,
        (For::Confirm, _) => String::new(),
    };
    desk.typing = Some(Typing { what, text });
}
