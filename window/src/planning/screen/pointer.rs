//! What the pointer does on an image: the wheel goes through slices, drags move, enlarge and change the window, clicks point.

use egui::{Event, Id, PointerButton, Pos2, Sense, Ui};
use geometry::{Ct, Point};
use guidance::plan::{Plan, Target};

use super::super::camera::Cut;
use super::super::desk::{Desk, Held, Mode};
use super::super::placed::Placed;
use super::image::Cell;
use super::{Known, Outcome};
use crate::screen::{HU_PX, tree};

/// A drag of so many pixels doubles what is seen, or halves it.
const DOUBLING_PX: f32 = 150.0;
/// A point is taken hold of within so many thin lines.
const REACH: f32 = 12.0;

pub(super) fn take(ui: &Ui, known: &Known<'_>, desk: &mut Desk, cell: &Cell, outcome: &mut Outcome) {
    let response = ui.interact(
        cell.image,
        Id::unique(("cut", cell.cut.place())),
        Sense::click_and_drag(),
    );
    tree::cut(&response, cell.cut.title());
    if response.double_clicked() && desk.is_same_place {
        desk.enlarged = match desk.enlarged {
            None => Some(cell.cut),
            Some(_) => None,
        };
    }
    let at = ui.input(|input| input.pointer.latest_pos());
    let is_over = at.is_some_and(|at| cell.image.contains(at));
    if is_over {
        wheel(ui, known, desk, cell.cut);
    }
    let (Some(placed), Some(at)) = (&cell.placed, at) else {
        return;
    };
    if is_over && ui.input(|input| input.modifiers.shift && !input.pointer.any_down()) {
        // The other slices follow the pointer.
        desk.camera.cursor = placed.in_patient(at);
    }
    buttons(ui, known, desk, (cell, placed, at), outcome);
}

fn wheel(ui: &Ui, known: &Known<'_>, desk: &mut Desk, cut: Cut) {
    // The wheel itself: what egui makes smooth of it would go on after it has stopped.
    let turned = |event: &Event| match event {
        Event::MouseWheel { delta, modifiers, .. } => Some((f64::from(delta.y), modifiers.ctrl)),
        _ => None,
    };
    for (lines, is_zoom) in ui.input(|input| input.events.iter().filter_map(turned).collect::<Vec<_>>()) {
        match is_zoom {
            true => desk.camera.zoom(cut, 2.0_f64.powf(-lines / 4.0)),
            false => desk.camera.turn_wheel(cut, lines, known.grid),
        }
    }
}

/// Presses, drags and releases, in their order. Several may come with one frame, and a drag goes on wherever the pointer is.
fn buttons(
    ui: &Ui,
    known: &Known<'_>,
    desk: &mut Desk,
    (cell, placed, at): (&Cell, &Placed, Pos2),
    outcome: &mut Outcome,
) {
    let (pressed, released, down, moved, [shift, ctrl]) = ui.input(|input| {
        let pointer = &input.pointer;
        (
            [PointerButton::Primary, PointerButton::Middle, PointerButton::Secondary]
                .map(|b| pointer.button_pressed(b)),
            pointer.any_released(),
            [PointerButton::Primary, PointerButton::Middle, PointerButton::Secondary].map(|b| pointer.button_down(b)),
            pointer.delta(),
            [input.modifiers.shift, input.modifiers.ctrl],
        )
    });
    if pressed.contains(&true) && cell.image.contains(at) {
        desk.dragged = Some(cell.cut);
        // Two clicks in two places measure, and enlarge nothing.
        desk.is_same_place = desk.pressed.is_some_and(|before| (before - at).length() < REACH);
        desk.pressed = Some(at);
        // What begins with Ctrl changes the window, and moves no point.
        desk.is_leveled = ctrl && pressed[0] && !shift;
        if pressed[0] && !shift && !ctrl {
            press(known, desk, (placed, at), outcome);
        }
    }
    if desk.dragged != Some(cell.cut) {
        return;
    }
    match down {
        [_, true, _] | [true, _, _] if down[1] || shift => {
            let by = placed.in_patient(at - moved) - placed.in_patient(at);
            desk.camera.pan(cell.cut, by);
        }
        [_, _, true] => desk.camera.zoom(cell.cut, f64::from((moved.y / DOUBLING_PX).exp2())),
        [true, _, _] if desk.is_leveled => level(desk, moved),
        [true, _, _] => drag(desk, placed, at, moved),
        _ => {}
    }
    if released {
        (desk.dragged, desk.is_leveled) = (None, false);
        desk.release(known.plan).into_iter().for_each(|wish| outcome.wish(wish));
    }
}

/// Takes hold of a point of the plan that is near, or points.
fn press(known: &Known<'_>, desk: &mut Desk, (placed, at): (&Placed, Pos2), outcome: &mut Outcome) {
    match desk.mode {
        Mode::Measure(..) => desk
            .measure(placed.in_patient(at))
            .into_iter()
            .for_each(|wish| outcome.wish(wish)),
        Mode::Level => {}
        Mode::Point => match near(known.plan, placed, at) {
            Some(held) if known.plan.confirmed.is_none() => {
                desk.selected = Some(held.name.clone());
                desk.held = Some(held);
            }
            Some(held) => desk.selected = Some(held.name),
            None => desk.camera.cursor = placed.in_patient(at),
        },
    }
}

fn level(desk: &mut Desk, moved: egui::Vec2) {
    desk.camera
        .level(f64::from(moved.x * HU_PX), f64::from(-moved.y * HU_PX));
}

fn drag(desk: &mut Desk, placed: &Placed, at: Pos2, moved: egui::Vec2) {
    // Beside the image there is nothing to be seen of where a point would come to lie.
    let at = at.clamp(placed.rect.min, placed.rect.max);
    match (&desk.mode, &mut desk.held) {
        (Mode::Level, _) => level(desk, moved),
        // In its own depth: what is dragged stays as far from the plane as it was.
        (_, Some(held)) if moved != egui::Vec2::ZERO => {
            let normal = placed.plane.into_screen();
            let depth_mm = placed.plane.project(held.at).depth_mm;
            held.at = placed.in_patient(at) + normal * depth_mm;
        }
        (Mode::Point, None) => desk.camera.cursor = placed.in_patient(at),
        _ => {}
    }
}

/// The centre or the entry that is nearest to a place on the screen, within reach of it and of the plane.
fn near(plan: &Plan, placed: &Placed, at: Pos2) -> Option<Held> {
    let points = plan.targets.iter().flat_map(|target: &Target| {
        let held = |at, is_entry| Held {
            name: target.name.clone(),
            is_entry,
            at,
        };
        [
            Some(held(target.centre, false)),
            target.entry.map(|entry| held(entry, true)),
        ]
    });
    let distance = |held: &Held| {
        let (there, depth_mm) = placed.on_screen(held.at);
        (depth_mm.abs() <= super::marks::NEAR_MM).then(|| (there - at).length())
    };
    let reached = points.flatten().filter_map(|held| Some((distance(&held)?, held)));
    let near = reached.filter(|(distance, _)| *distance <= REACH);
    near.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, held)| held)
}

/// Where the pointer is in the patient: under it lies this point of that image.
pub(super) fn pointed(ui: &Ui, cells: &[Cell]) -> Option<(Cut, Point<Ct>)> {
    let at = ui.input(|input| input.pointer.latest_pos())?;
    let under = cells.iter().find(|cell| cell.image.contains(at))?;
    Some((under.cut, under.placed.as_ref()?.in_patient(at)))
}
