//! The sight: the target about the tool's axis, the error that is predicted there, the depth, and the verdict.
//!
//! It looks along the tube, with the right and the up of the image across the tube. The cross in the middle is the tool's axis at the
//! target's depth; the target moves, and the tool is steered towards it. Distances from the middle are drawn by `asinh`, linear near the
//! middle and ever more compressed outwards, so that the target is seen at 1 mm and at 100 mm without a change of scale in between.

mod dial;
pub(super) mod readout;

use std::f32::consts::TAU;

use bus::message::TargetShown;
use egui::{Align2, Color32, Id, Pos2, Rect, Role, Shape, Stroke, Ui, pos2, vec2};
use guidance::sight::{Ellipse, Sight};
use picture::palette;

use super::tree;
use super::words::{Type, UNREADABLE, Words, colour, has_letters};
use crate::colours;
use crate::model::{Aimed, Model, Tone};
use crate::sizes::{ADVANCE, Sizes};
pub use dial::Dial;

/// Up to this distance the sight is about linear, mm.
const LINEAR_MM: f64 = 5.0;
/// What the rim shows, mm; what is further off is at the rim.
const REACH_MM: f64 = 100.0;
/// The rings, mm.
const RINGS_MM: [f64; 4] = [2.0, 5.0, 20.0, 50.0];
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

pub(super) fn show(ui: &mut Ui, model: &Model, rect: Rect, sizes: &Sizes, words: &mut Words) {
    let name = || match &model.sight {
        Ok(aimed) => format!("the sight: {}", drawing(&aimed.sight)),
        Err(_) => "the sight".to_owned(),
    };
    tree::group(ui, Id::unique("sight"), name, |ui| draw(ui, model, rect, sizes, words));
}

/// What the drawing says, in words, for those who do not see it.
fn drawing(sight: &Sight) -> String {
    let [right, up] = sight.miss_mm;
    let across = format!(
        "{:.1} mm to the {}",
        right.abs(),
        if right < 0.0 { "left" } else { "right" }
    );
    let upright = format!("{:.1} mm {}", up.abs(), if up < 0.0 { "down" } else { "up" });
    let error = match &sight.predicted {
        Ok(predicted) => {
            let [long, short] = predicted.ellipse.half_axes_mm.map(|mm| format!("{mm:.1}"));
            format!("error in 95 of 100 cases {long} by {short} mm")
        }
        Err(_) => "error not known".to_owned(),
    };
    format!("target {across}, {upright}; {error}")
}

fn draw(ui: &Ui, model: &Model, rect: Rect, sizes: &Sizes, words: &mut Words) {
    ui.painter().rect_filled(rect, 0.0, colours::CELL);
    let rooms = rooms(rect, sizes);
    draw_aimed(ui, model, &rooms, sizes, words);
    // On top: rings go through the corner where the sight is small.
    if let Some(organs) = &model.organs {
        readout::organs(ui, organs, rooms.sight, sizes, words);
    }
}

fn draw_aimed(ui: &Ui, model: &Model, rooms: &Rooms, sizes: &Sizes, words: &mut Words) {
    let line = thin(rooms.sight, sizes);
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
            let large = Type {
                size: sizes.critical,
                ..how
            };
            words.put_as(ui, rooms.verdict, "NO SIGHT", large, Role::Status);
            words.put(ui, rooms.sight, why, how);
            return;
        }
    };
    let name = match has_letters(ui, &aimed.target.name, sizes.plain) {
        true => &aimed.target.name,
        false => UNREADABLE,
    };
    // Whose place it is comes before a name that may be long.
    let title = [aimed.sight.phase.word(), aimed.whereabouts.words(), name];
    let title: Vec<&str> = title.into_iter().filter(|word| !word.is_empty()).collect();
    let ink = match aimed.whereabouts {
        TargetShown::NotSettled | TargetShown::AtRest => colour(Tone::Warning),
        _ => colours::of(palette::TARGET),
    };
    words.put(ui, rooms.title, &title.join("  "), plain(ink, Align2::LEFT_CENTER));
    readout::verdict(ui, aimed.sight.verdict, rooms.verdict, sizes, words);
    rings(ui, rooms, sizes, words);
    aim(ui, aimed, rooms.sight, line);
    readout::depth(ui, aimed, rooms, words, sizes);
    readout::numbers(ui, aimed, rooms, sizes, words);
}

fn rooms(cell: Rect, sizes: &Sizes) -> Rooms {
    let inner = cell.shrink(sizes.gap);
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
        // The longest takes the whole width.
        verdict: verdict.with_min_x(cell.left() + 2.0).with_max_x(cell.right() - 2.0),
        sight: Rect::from_min_max(middle.min, pos2(middle.right() - bar_width, middle.bottom())),
        bar: Rect::from_min_max(pos2(middle.right() - bar_width, middle.top()), middle.max).shrink(sizes.gap),
        left: half(numbers, true),
        right: half(numbers, false),
        left_caption: half(captions, true),
        right_caption: half(captions, false),
    }
}

/// The width of a thin line on the sight: as everywhere, and thinner where the sight is so small that lines would hide one another.
fn thin(room: Rect, sizes: &Sizes) -> f32 {
    let side = room.width().min(room.height());
    sizes.line.min(side / 200.0).max(0.5)
}

/// How far from the middle a distance is drawn, parts of the rim's.
pub(super) fn drawn(mm: f64) -> f64 {
    (mm / LINEAR_MM).asinh() / (REACH_MM / LINEAR_MM).asinh()
}

/// Where a point of the sight, (right, up) mm, is drawn. What is beyond the rim is drawn on it.
fn at(room: Rect, [right, up]: [f64; 2]) -> Pos2 {
    let radius = rim(room);
    let mm = right.hypot(up);
    if mm == 0.0 {
        return room.center();
    }
    let part = drawn(mm).min(1.0) * radius / mm;
    // Up on the screen is towards smaller rows.
    room.center() + vec2((right * part) as f32, (-up * part) as f32)
}

/// From the middle to the rim, pixels.
fn rim(room: Rect) -> f64 {
    f64::from(0.96 * room.width().min(room.height()) / 2.0)
}

fn rings(ui: &Ui, rooms: &Rooms, sizes: &Sizes, words: &mut Words) {
    for mm in RINGS_MM.into_iter().chain([REACH_MM]) {
        let ring: Vec<Pos2> = circle([0.0, 0.0], mm).map(|p| at(rooms.sight, p)).collect();
        ui.painter()
            .add(Shape::closed_line(ring, Stroke::new(sizes.line, colours::LINE)));
    }
    let how = Type {
        size: 0.8 * sizes.plain,
        colour: colours::of(palette::QUIET),
        ground: colours::CELL,
        align: Align2::LEFT_CENTER,
    };
    // One number says what the rings are; the others follow.
    let place = at(rooms.sight, [0.0, -20.0]) + vec2(2.0, 1.0) * sizes.line;
    let text = "20 mm";
    let size = vec2(text.len() as f32 * ADVANCE * how.size + 2.0, sizes.plain);
    let room = Rect::from_min_size(place, size);
    // Where the sight is small, other rings cross the word.
    ui.painter().rect_filled(room, 0.0, colours::CELL);
    words.put(ui, room, text, how);
}

fn circle([x, y]: [f64; 2], radius: f64) -> impl Iterator<Item = [f64; 2]> {
    (0..SIDES).map(move |k| {
        let (sin, cos) = (f64::from(TAU) * k as f64 / SIDES as f64).sin_cos();
        [x + radius * cos, y + radius * sin]
    })
}

/// The tool's axis, its error, the target, and the entry.
fn aim(ui: &Ui, aimed: &Aimed, room: Rect, line: f32) {
    let (painter, sight) = (ui.painter(), &aimed.sight);
    if let Ok(predicted) = &sight.predicted {
        let ring: Vec<Pos2> = ellipse(&predicted.ellipse).map(|p| at(room, p)).collect();
        rimmed(ui, ring, 2.0 * line, line, colours::of(palette::TIP));
    }
    let arm = 0.06 * room.width().min(room.height());
    for direction in [vec2(1.0, 0.0), vec2(-1.0, 0.0), vec2(0.0, 1.0), vec2(0.0, -1.0)] {
        let ends = [room.center() + 0.3 * arm * direction, room.center() + arm * direction];
        painter.line_segment(ends, Stroke::new(5.0 * line, Color32::BLACK));
        painter.line_segment(ends, Stroke::new(2.5 * line, colours::of(palette::TUBE)));
    }
    let target: Vec<Pos2> = circle(sight.miss_mm, aimed.target.radius_mm)
        .map(|p| at(room, p))
        .collect();
    rimmed(ui, target, 3.0 * line, line, colours::of(palette::TARGET));
    painter.circle_filled(at(room, sight.miss_mm), 3.0 * line, colours::of(palette::TARGET));
    if let Some(planned) = &sight.line {
        let entry = at(room, planned.entry_mm);
        let square = Rect::from_center_size(entry, egui::Vec2::splat(12.0 * line));
        let stroke = Stroke::new(2.0 * line, colours::of(palette::TARGET));
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

/// A closed line with a dark rim on each side, so that it is seen on whatever it crosses.
fn rimmed(ui: &Ui, points: Vec<Pos2>, width: f32, rim: f32, ink: Color32) {
    ui.painter().add(Shape::closed_line(
        points.clone(),
        Stroke::new(width + 3.0 * rim, Color32::BLACK),
    ));
    ui.painter().add(Shape::closed_line(points, Stroke::new(width, ink)));
}
