//! The bar that a replay is steered by: what the recording holds over its time, and where the replay stands.
//!
//! Each column of pixels shows all that the recording has in its time: a moment without a pose is there however short it was. A state is
//! told by its shape, as the colours of alarms are those of the present.

mod columns;
mod strips;

use egui::{Align2, Color32, CursorIcon, Id, Pos2, Rect, Sense, Shape, Stroke, Ui, WidgetInfo, pos2, vec2};
use picture::palette;

use super::words::{Type, Words, colour};
use super::{Outcome, Wish};
use crate::colours;
use crate::model::{Model, ReplayModel, Tone};
use crate::sizes::Sizes;

/// Of the bar's width: what stands in words.
const WORDS: f32 = 0.24;
/// Of its height: the marks with their words, the states, the errors.
const ROWS: [f32; 3] = [0.3, 0.26, 0.44];
/// Shows it, and takes what a person points at.
pub(super) fn show(ui: &Ui, model: &Model, sizes: &Sizes, outcome: &mut Outcome) {
    let (Some(replay), Some(bar)) = (&model.replay, sizes.bar) else {
        return;
    };
    let (left, right) = bar.split_left_right_at_x(bar.left() + WORDS * bar.width());
    let track = right.shrink2(vec2(sizes.gap, 2.0));
    let [marks, states, errors] = rows(track);
    let columns = columns::of(replay, track.width() as usize);
    let top_mm = columns::top_mm(&columns);
    said(
        ui,
        replay,
        top_mm,
        left.shrink2(vec2(sizes.gap, 0.0)),
        (sizes, &mut outcome.words),
    );
    strips::states(ui, &columns, states, sizes);
    strips::errors(ui, &columns, errors, top_mm.unwrap_or(1.0), sizes);
    marked(ui, replay, [marks, track], sizes, &mut outcome.words);
    head(ui, track, replay.part(replay.at_ns), sizes);
    outcome.wishes.extend(pointed(ui, replay, track));
}

fn rows(track: Rect) -> [Rect; 3] {
    let mut top = track.top();
    ROWS.map(|part| {
        let rect = Rect::from_min_size(pos2(track.left(), top), vec2(track.width(), part * track.height()));
        top = rect.bottom();
        rect
    })
}

fn how(size: f32, align: Align2) -> Type {
    Type {
        size,
        colour: colour(Tone::Quiet),
        ground: colours::GROUND,
        align,
    }
}

/// Minutes and seconds.
fn time(seconds: f64) -> String {
    let hundredths = (seconds * 100.0).round() as i64;
    let sign = if hundredths < 0 { "-" } else { "" };
    let all = hundredths.abs();
    format!("{sign}{}:{:02}.{:02}", all / 6000, all / 100 % 60, all % 100)
}

fn said(ui: &Ui, replay: &ReplayModel, top_mm: Option<f32>, room: Rect, (sizes, words): (&Sizes, &mut Words)) {
    let [_, last] = replay.span_ns;
    let place = [replay.at_ns, last].map(|t_ns| time(replay.seconds(t_ns)));
    let lines = [
        format!("{} of {}  {}", place[0], place[1], replay.doing()),
        replay.lacking(),
        top_mm.map_or(String::new(), |mm| format!("band: tip 95 %, 0 to {mm} mm")),
    ];
    let height = room.height() / lines.len() as f32;
    for (k, line) in lines.iter().enumerate() {
        let at = pos2(room.left(), room.top() + k as f32 * height);
        let row = Rect::from_min_size(at, vec2(room.width(), height));
        words.put(ui, row, line, how(sizes.plain, Align2::LEFT_CENTER));
    }
}

/// Marks as ticks over all, and the words of the one that was reached last.
fn marked(ui: &Ui, replay: &ReplayModel, [room, track]: [Rect; 2], sizes: &Sizes, words: &mut Words) {
    let ink = colours::of(palette::TARGET);
    let marks = replay.marks();
    for mark in &marks {
        let x = track.left() + replay.part(mark.t_ns) as f32 * track.width();
        ui.painter()
            .vline(x, room.bottom()..=track.bottom(), Stroke::new(sizes.line, ink));
        let side = 0.2 * sizes.plain;
        let tip = pos2(x, room.bottom());
        ui.painter().add(Shape::convex_polygon(
            vec![tip, tip + vec2(-side, -side), tip + vec2(side, -side)],
            ink,
            Stroke::NONE,
        ));
    }
    let text = match (replay.reached(), marks.len()) {
        (_, 0) => String::new(),
        (None, count) => format!("{count} marks"),
        (Some((number, mark)), count) => format!("mark {number} of {count}: {}", mark.words()),
    };
    let room = room.with_max_y(room.bottom() - 0.2 * sizes.plain);
    words.put(ui, room, &text, how(0.8 * sizes.plain, Align2::LEFT_CENTER));
}

/// Where the replay stands.
fn head(ui: &Ui, track: Rect, part: f64, sizes: &Sizes) {
    let x = track.left() + part as f32 * track.width();
    let violet = colours::of(palette::REPLAY);
    let painter = ui.painter();
    painter.vline(x, track.y_range(), Stroke::new(4.0 * sizes.line, Color32::BLACK));
    painter.vline(x, track.y_range(), Stroke::new(2.0 * sizes.line, violet));
    painter.circle_filled(pos2(x, track.top() + 0.3 * sizes.plain), 0.3 * sizes.plain, violet);
}

/// A press on the bar, or a pointer that is drawn along it.
fn pointed(ui: &Ui, replay: &ReplayModel, track: Rect) -> Option<Wish> {
    let response = ui.interact(track, Id::unique("replay bar"), Sense::click_and_drag());
    response.widget_info(|| WidgetInfo::slider(true, replay.seconds(replay.at_ns), "place in the recording"));
    let response = response.on_hover_cursor(CursorIcon::PointingHand);
    let is_asked =
        response.clicked() || response.drag_started() || (response.dragged() && response.drag_delta().x != 0.0);
    let at: Pos2 = response.interact_pointer_pos().filter(|_| is_asked)?;
    let part = f64::from((at.x - track.left()) / track.width());
    Some(Wish::Seek(replay.moment_ns(part)))
}

#[cfg(test)]
mod tests;
