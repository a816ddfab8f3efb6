//! The sight in numbers and words: how far there is to go, how far off, and the verdict.

use egui::{Align2, Color32, Rect, Role, Shape, Stroke, Ui, pos2, vec2};
use guidance::sight::{Shape as VerdictShape, Verdict};
use picture::palette;

use super::Rooms;
use crate::colours;
use crate::model::{Aimed, Organs, Tone};
use crate::screen::words::{Type, Words, colour, on_band};
use crate::sizes::{ADVANCE, Sizes};

/// What the depth bar shows, mm to go.
const DEPTH_MM: [f64; 2] = [-10.0, 50.0];
/// Which part of the bar that is up to zero.
pub(super) const BELOW_ZERO: f64 = -DEPTH_MM[0] / (DEPTH_MM[1] - DEPTH_MM[0]);

/// How far there is to go: a bar of its own, zero where the tool is to stop.
pub(super) fn depth(ui: &Ui, aimed: &Aimed, rooms: &Rooms, words: &mut Words, sizes: &Sizes) {
    let bar = rooms.bar;
    let painter = ui.painter();
    painter.rect_stroke(
        bar,
        0.0,
        Stroke::new(sizes.line, colours::LINE),
        egui::StrokeKind::Inside,
    );
    let y = |mm: f64| {
        let part = (mm - DEPTH_MM[0]) / (DEPTH_MM[1] - DEPTH_MM[0]);
        bar.bottom() - part.clamp(0.0, 1.0) as f32 * bar.height()
    };
    let zero = y(0.0);
    let to_go = aimed.sight.to_go_mm;
    let ink = if to_go < 0.0 {
        colour(Tone::Warning)
    } else {
        colours::of(palette::TUBE)
    };
    let filled = Rect::from_two_pos(pos2(bar.left(), zero), pos2(bar.right(), y(to_go)));
    painter.rect_filled(filled, 0.0, ink);
    painter.line_segment(
        [pos2(bar.left() - 4.0, zero), pos2(bar.right() + 4.0, zero)],
        Stroke::new(3.0 * sizes.line, Color32::WHITE),
    );
    let how = Type {
        size: 0.8 * sizes.plain,
        colour: colour(Tone::Quiet),
        ground: colours::CELL,
        align: Align2::RIGHT_CENTER,
    };
    let room = Rect::from_min_size(
        pos2(bar.left() - 5.0 * sizes.plain - 4.0, zero - sizes.plain / 2.0),
        vec2(5.0 * sizes.plain, sizes.plain),
    );
    words.put(ui, room, "stop", how);
}

/// A distance, mm, with a decimal up to 99.9: never more than five characters.
pub(in crate::screen) fn millimetres(mm: f64) -> String {
    match mm {
        mm if mm.abs() < 99.95 => {
            let rounded = (10.0 * mm).round() / 10.0;
            // A negative zero would say that it is past.
            format!("{:.1}", if rounded == 0.0 { 0.0 } else { rounded })
        }
        mm if mm.abs() < 9999.5 => format!("{mm:.0}"),
        mm if mm > 0.0 => ">9999".to_owned(),
        _ => "<-999".to_owned(),
    }
}

pub(super) fn numbers(ui: &Ui, aimed: &Aimed, rooms: &Rooms, sizes: &Sizes, words: &mut Words) {
    let sight = &aimed.sight;
    let large = Type {
        size: sizes.critical,
        colour: colour(Tone::Quiet),
        ground: colours::CELL,
        align: Align2::CENTER_CENTER,
    };
    let small = Type {
        size: sizes.plain,
        ..large
    };
    let to_go = match aimed.target.stop_mm {
        0.0 => "mm to go".to_owned(),
        stop => format!("mm to {stop:.1} before"),
    };
    let off = match &sight.line {
        Some(line) => format!("mm off  {:.1}\u{b0}", line.angle_rad.to_degrees()),
        None => "mm off".to_owned(),
    };
    // Each number before what it is of: so they are read aloud.
    words.put(ui, rooms.left, &millimetres(sight.to_go_mm), large);
    words.put(ui, rooms.left_caption, &to_go, small);
    words.put(ui, rooms.right, &millimetres(sight.miss_length_mm), large);
    words.put(ui, rooms.right_caption, &off, small);
}

/// What a model of organs says of the tube, in the lower left corner of the sight: its state, and the force with what is uncertain of it.
pub(super) fn organs(ui: &Ui, organs: &Organs, sight: Rect, sizes: &Sizes, words: &mut Words) {
    let on_tube = match organs.force.is_empty() {
        true => String::new(),
        false => format!("tube {}", organs.force),
    };
    let height = 1.1 * sizes.plain;
    let lines = [(organs.word, organs.tone), (on_tube.as_str(), Tone::Quiet)];
    for (k, (text, tone)) in lines.into_iter().enumerate() {
        let letters = text.chars().count() as f32;
        let size = vec2((letters * ADVANCE * sizes.plain + 4.0).min(sight.width()), height);
        let room = Rect::from_min_size(pos2(sight.left(), sight.bottom() - (2 - k) as f32 * height), size);
        ui.painter().rect_filled(room, 0.0, colours::CELL);
        let how = Type {
            size: sizes.plain,
            colour: colour(tone),
            ground: colours::CELL,
            align: Align2::LEFT_CENTER,
        };
        words.put(ui, room, text, how);
    }
}

/// The verdict in words and by its shape.
pub(super) fn verdict(ui: &Ui, verdict: Verdict, room: Rect, sizes: &Sizes, words: &mut Words) {
    let (ground, ink) = match verdict {
        Verdict::OnTarget => (colour(Tone::Live), on_band(Tone::Live)),
        Verdict::PastTarget | Verdict::ErrorUnknown => (colour(Tone::Warning), on_band(Tone::Warning)),
        Verdict::OnCourse | Verdict::WithinError | Verdict::Steer => (colours::CELL, colour(Tone::Quiet)),
    };
    ui.painter().rect_filled(room, 4.0, ground);
    let how = Type {
        size: sizes.critical,
        colour: ink,
        ground,
        align: Align2::CENTER_CENTER,
    };
    words.put_as(ui, room, verdict.word(), how, Role::Status);
    // Thin enough to leave the word its room.
    let line = (sizes.critical / 40.0).max(0.5);
    let frame = Stroke::new(3.0 * line, ink);
    let inset = room.shrink(2.0 * line);
    // The frame's shape says the same again: whole for what may be done, broken for what is not sure.
    match verdict.shape() {
        VerdictShape::Disc | VerdictShape::Bar | VerdictShape::QuestionMark => {}
        VerdictShape::Ring => {
            ui.painter().rect_stroke(inset, 4.0, frame, egui::StrokeKind::Inside);
        }
        VerdictShape::DashedRing => {
            let corners = [
                inset.left_top(),
                inset.right_top(),
                inset.right_bottom(),
                inset.left_bottom(),
                inset.left_top(),
            ];
            ui.painter()
                .extend(Shape::dashed_line(&corners, frame, 12.0 * line, 10.0 * line));
        }
        VerdictShape::Arrow => {
            for y in [inset.top(), inset.bottom()] {
                ui.painter()
                    .line_segment([pos2(inset.left(), y), pos2(inset.right(), y)], Stroke::new(line, ink));
            }
        }
    }
}
