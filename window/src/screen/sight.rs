//! The sight: the target about the tool's axis, the error that is predicted there, the depth, and the verdict.
//!
//! It looks along the tube, with the right and the up of the image across the tube. The cross in the middle is the tool's axis at the
//! target's depth; the target moves, and the tool is steered towards it. Distances from the middle are drawn by `asinh`, linear near the
//! middle and ever more compressed outwards, so that the target is seen at 1 mm and at 100 mm without a change of scale in between.

use std::f32::consts::TAU;

use egui::{Align2, Color32, Pos2, Rect, Shape, Stroke, Ui, pos2, vec2};
use guidance::sight::{Ellipse, Shape as VerdictShape, Verdict};
use picture::palette;

use super::words::{Type, Words, colour};
use crate::colours;
use crate::model::{Aimed, Model, Tone};
use crate::sizes::Sizes;

/// Up to this distance the sight is about linear, mm.
const LINEAR_MM: f64 = 5.0;
/// What the rim shows, mm; what is further off is at the rim.
const REACH_MM: f64 = 100.0;
/// The rings, mm.
const RINGS_MM: [f64; 4] = [2.0, 5.0, 20.0, 50.0];
/// What the depth bar shows, mm to go.
const DEPTH_MM: [f64; 2] = [-10.0, 50.0];
const SIDES: usize = 64;

/// The rooms of the sight's cell.
struct Rooms {
    title: Rect,
    verdict: Rect,
    sight: Rect,
    bar: Rect,
    left: Rect,
    right: Rect,
    left_caption: Rect,
    right_caption: Rect,
}

pub(super) fn show(ui: &Ui, model: &Model, rect: Rect, sizes: &Sizes, words: &mut Words) {
    ui.painter().rect_filled(rect, 0.0, colours::CELL);
    let mut rooms = rooms(rect.shrink(sizes.gap), sizes);
    // The longest verdict takes the whole width.
    rooms.verdict = rooms
        .verdict
        .with_min_x(rect.left() + 2.0)
        .with_max_x(rect.right() - 2.0);
    let plain = |colour, align| Type {
        size: sizes.plain,
        colour,
        ground: colours::CELL,
        align,
    };
    let aimed = match &model.sight {
        Ok(aimed) => aimed,
        Err(why) => {
            let quiet = plain(colour(Tone::Quiet), Align2::LEFT_CENTER);
            words.put(ui, rooms.title, "SIGHT", quiet);
            let how = plain(colour(Tone::Warning), Align2::CENTER_CENTER);
            words.put(
                ui,
                rooms.verdict,
                "NO SIGHT",
                Type {
                    size: sizes.critical,
                    ..how
                },
            );
            words.put(ui, rooms.sight, why, how);
            return;
        }
    };
    let title = format!("{}  {}", aimed.sight.phase.word(), aimed.target.name);
    words.put(
        ui,
        rooms.title,
        &title,
        plain(colours::of(palette::TARGET), Align2::LEFT_CENTER),
    );
    verdict(ui, aimed.sight.verdict, rooms.verdict, sizes, words);
    rings(ui, &rooms, sizes, words);
    aim(ui, aimed, rooms.sight);
    depth(ui, aimed, &rooms, words, sizes);
    numbers(ui, aimed, &rooms, sizes, words);
}

fn rooms(inner: Rect, sizes: &Sizes) -> Rooms {
    let row = 1.2 * sizes.plain;
    let large = 1.12 * sizes.critical;
    let band = |top: f32, height: f32| Rect::from_min_size(pos2(inner.left(), top), vec2(inner.width(), height));
    let title = band(inner.top(), row);
    let verdict = band(title.bottom(), large);
    let captions = band(inner.bottom() - row, row);
    let numbers = band(captions.top() - large, large);
    let middle = Rect::from_min_max(verdict.left_bottom(), numbers.right_top());
    let bar_width = 2.6 * sizes.plain;
    let half = |rect: Rect, is_left: bool| {
        let width = rect.width() / 2.0;
        let left = if is_left { rect.left() } else { rect.left() + width };
        Rect::from_min_size(pos2(left, rect.top()), vec2(width, rect.height()))
    };
    Rooms {
        title,
        verdict,
        sight: Rect::from_min_max(middle.min, pos2(middle.right() - bar_width, middle.bottom())),
        bar: Rect::from_min_max(pos2(middle.right() - bar_width, middle.top()), middle.max).shrink(sizes.gap),
        left: half(numbers, true),
        right: half(numbers, false),
        left_caption: half(captions, true),
        right_caption: half(captions, false),
    }
}

/// How far from the middle a distance is drawn, parts of the rim's.
pub(super) fn drawn(mm: f64) -> f64 {
    (mm / LINEAR_MM).asinh() / (REACH_MM / LINEAR_MM).asinh()
}

/// Where a point of the sight, (right, up) mm, is drawn. What is beyond the rim is drawn on it.
fn at(room: Rect, [right, up]: [f64; 2]) -> Pos2 {
    let radius = f64::from(0.96 * room.width().min(room.height()) / 2.0);
    let mm = right.hypot(up);
    if mm == 0.0 {
        return room.center();
    }
    let part = drawn(mm).min(1.0) * radius / mm;
    // Up on the screen is towards smaller rows.
    room.center() + vec2((right * part) as f32, (-up * part) as f32)
}

fn rings(ui: &Ui, rooms: &Rooms, sizes: &Sizes, words: &mut Words) {
    for mm in RINGS_MM.into_iter().chain([REACH_MM]) {
        let ring: Vec<Pos2> = circle([0.0, 0.0], mm).map(|p| at(rooms.sight, p)).collect();
        ui.painter()
            .add(Shape::closed_line(ring, Stroke::new(1.0, colours::LINE)));
    }
    let how = Type {
        size: 0.8 * sizes.plain,
        colour: colours::of(palette::QUIET),
        ground: colours::CELL,
        align: Align2::LEFT_CENTER,
    };
    // One number says what the rings are; the others follow.
    let place = at(rooms.sight, [0.0, -20.0]);
    let room = Rect::from_min_size(place + vec2(2.0, 1.0), vec2(5.0 * sizes.plain, sizes.plain));
    words.put(ui, room, "20 mm", how);
}

fn circle([x, y]: [f64; 2], radius: f64) -> impl Iterator<Item = [f64; 2]> {
    (0..SIDES).map(move |k| {
        let (sin, cos) = (f64::from(TAU) * k as f64 / SIDES as f64).sin_cos();
        [x + radius * cos, y + radius * sin]
    })
}

/// The tool's axis, its error, the target, and the entry.
fn aim(ui: &Ui, aimed: &Aimed, room: Rect) {
    let (painter, sight) = (ui.painter(), &aimed.sight);
    if let Ok(predicted) = &sight.predicted {
        let ring: Vec<Pos2> = ellipse(&predicted.ellipse).map(|p| at(room, p)).collect();
        rimmed(ui, ring, 2.0, colours::of(palette::TIP));
    }
    let arm = 0.06 * room.width().min(room.height());
    for direction in [vec2(1.0, 0.0), vec2(-1.0, 0.0), vec2(0.0, 1.0), vec2(0.0, -1.0)] {
        let line = [room.center() + 0.3 * arm * direction, room.center() + arm * direction];
        painter.line_segment(line, Stroke::new(5.0, Color32::BLACK));
        painter.line_segment(line, Stroke::new(2.5, colours::of(palette::TUBE)));
    }
    let target: Vec<Pos2> = circle(sight.miss_mm, aimed.target.radius_mm)
        .map(|p| at(room, p))
        .collect();
    rimmed(ui, target, 3.0, colours::of(palette::TARGET));
    painter.circle_filled(at(room, sight.miss_mm), 3.0, colours::of(palette::TARGET));
    if let Some(line) = &sight.line {
        let entry = at(room, line.entry_mm);
        let square = Rect::from_center_size(entry, vec2(12.0, 12.0));
        let stroke = Stroke::new(2.0, colours::of(palette::TARGET));
        painter.rect_stroke(square, 0.0, stroke, egui::StrokeKind::Middle);
    }
}

fn ellipse(ellipse: &Ellipse) -> impl Iterator<Item = [f64; 2]> {
    let ([long, short], (sin, cos)) = (ellipse.half_axes_mm, ellipse.turn_rad.sin_cos());
    circle([0.0, 0.0], 1.0).map(move |[x, y]| {
        let (x, y) = (long * x, short * y);
        [x * cos - y * sin, x * sin + y * cos]
    })
}

/// A closed line with a dark rim, so that it is seen on whatever it crosses.
fn rimmed(ui: &Ui, points: Vec<Pos2>, width: f32, ink: Color32) {
    ui.painter().add(Shape::closed_line(
        points.clone(),
        Stroke::new(width + 3.0, Color32::BLACK),
    ));
    ui.painter().add(Shape::closed_line(points, Stroke::new(width, ink)));
}

/// How far there is to go: a bar of its own, zero where the tool is to stop.
fn depth(ui: &Ui, aimed: &Aimed, rooms: &Rooms, words: &mut Words, sizes: &Sizes) {
    let bar = rooms.bar;
    let painter = ui.painter();
    painter.rect_stroke(bar, 0.0, Stroke::new(1.0, colours::LINE), egui::StrokeKind::Inside);
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
        Stroke::new(3.0, Color32::WHITE),
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
pub(super) fn millimetres(mm: f64) -> String {
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

fn numbers(ui: &Ui, aimed: &Aimed, rooms: &Rooms, sizes: &Sizes, words: &mut Words) {
    let sight = &aimed.sight;
    let large = Type {
        size: sizes.critical,
        colour: colour(Tone::Quiet),
        ground: colours::CELL,
        align: Align2::CENTER_CENTER,
    };
    words.put(ui, rooms.left, &millimetres(sight.to_go_mm), large);
    words.put(ui, rooms.right, &millimetres(sight.miss_length_mm), large);
    let small = Type {
        size: sizes.plain,
        ..large
    };
    let to_go = match aimed.target.stop_mm {
        0.0 => "mm to go".to_owned(),
        stop => format!("mm to {stop:.1} before"),
    };
    words.put(ui, rooms.left_caption, &to_go, small);
    words.put(ui, rooms.right_caption, "mm off", small);
}

/// The verdict in words and by its shape.
fn verdict(ui: &Ui, verdict: Verdict, room: Rect, sizes: &Sizes, words: &mut Words) {
    let (ground, ink) = match verdict {
        Verdict::OnTarget => (colours::of(palette::TARGET), colours::ON_BAND),
        Verdict::PastTarget | Verdict::ErrorUnknown => (colour(Tone::Warning), colours::ON_BAND),
        Verdict::OnCourse | Verdict::WithinError | Verdict::Steer => (colours::CELL, colour(Tone::Quiet)),
    };
    ui.painter().rect_filled(room, 4.0, ground);
    let how = Type {
        size: sizes.critical,
        colour: ink,
        ground,
        align: Align2::CENTER_CENTER,
    };
    words.put(ui, room, verdict.word(), how);
    let frame = Stroke::new(3.0, ink);
    let inset = room.shrink(2.0);
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
            ui.painter().extend(Shape::dashed_line(&corners, frame, 12.0, 10.0));
        }
        VerdictShape::Arrow => {
            for y in [inset.top(), inset.bottom()] {
                ui.painter()
                    .line_segment([pos2(inset.left(), y), pos2(inset.right(), y)], Stroke::new(1.0, ink));
            }
        }
    }
}
