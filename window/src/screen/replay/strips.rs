//! The two strips of the bar: which states there were, and how large the predicted errors.

use bus::message::TimelineColumn;
use egui::{Color32, Rect, Stroke, Ui, vec2};
use picture::palette;

use super::columns::runs;
use crate::colours;
use crate::sizes::Sizes;

/// Of anything else nothing is known: not read, no sample yet, or the run was being ended.
const KNOWN: u32 = TimelineColumn::LIVE | TimelineColumn::STALE | TimelineColumn::LOST | TimelineColumn::NOT_READABLE;

/// High: live throughout. Half: an old pose at some time. A gap with a tick below: none at some time. A line: nothing to be known.
pub(super) fn states(ui: &Ui, columns: &[Option<TimelineColumn>], room: Rect, sizes: &Sizes) {
    let painter = ui.painter();
    painter.rect_filled(room, 0.0, colours::CELL);
    let ink = colours::of(palette::QUIET);
    let upper = room.with_max_y(room.bottom() - 0.25 * room.height());
    for (from, to, column) in runs(columns, |column| column.map(|column| column.states)) {
        let wide = |rect: Rect| with_x(rect, room.left() + from as f32, room.left() + to as f32);
        let is_known = |column: &TimelineColumn| column.has(KNOWN);
        let Some(column) = column.filter(is_known) else {
            painter.rect_filled(wide(middle(upper, 1.0)), 0.0, colours::LINE);
            continue;
        };
        let height = match column {
            column if column.has(TimelineColumn::LOST | TimelineColumn::NOT_READABLE) => 0.0,
            column if column.has(TimelineColumn::STALE) => 0.5,
            _ => 1.0,
        };
        if height > 0.0 {
            let top = upper.bottom() - height * upper.height();
            painter.rect_filled(wide(upper.with_min_y(top)), 0.0, ink);
        }
        if column.has(TimelineColumn::LOST) {
            let least = wide(room).expand2(vec2(0.5 * (2.0 * sizes.line - (to - from) as f32).max(0.0), 0.0));
            painter.rect_filled(least.with_min_y(upper.bottom() + 1.0), 0.0, colours::of(palette::WORDS));
        }
        if column.has(TimelineColumn::NOT_READABLE) {
            // Wide enough to be seen, and with a gap on both sides.
            let least = wide(upper).expand2(vec2(0.5 * (7.0 * sizes.line - (to - from) as f32).max(0.0), 0.0));
            painter.rect_filled(least, 0.0, colours::CELL);
            hatched(ui, least.shrink2(vec2(3.0 * sizes.line, 0.0)), ink);
        }
    }
}

/// From the least to the largest 95 % error at the tip; what reaches beyond the top has a white end there.
pub(super) fn errors(ui: &Ui, columns: &[Option<TimelineColumn>], room: Rect, top_mm: f32, sizes: &Sizes) {
    let painter = ui.painter();
    let plot = room.with_min_y(room.top() + 2.0);
    let key = |column: Option<TimelineColumn>| {
        column.map(|column| {
            (
                column.has(TimelineColumn::ERROR_UNKNOWN),
                column.least_mm.to_bits(),
                column.most_mm.to_bits(),
            )
        })
    };
    for (from, to, column) in runs(columns, key) {
        let Some(column) = column else { continue };
        let wide = |rect: Rect| with_x(rect, plot.left() + from as f32, plot.left() + to as f32);
        if column.has(TimelineColumn::ERROR_UNKNOWN) {
            painter.rect_filled(wide(plot), 0.0, colours::CELL);
            hatched(ui, wide(plot), colours::LINE);
        }
        if column.most_mm.is_nan() {
            continue;
        }
        let y = |mm: f32| plot.bottom() - (mm / top_mm).min(1.0) * plot.height();
        let band = wide(Rect::from_x_y_ranges(
            plot.x_range(),
            y(column.most_mm)..=y(column.least_mm),
        ));
        let band = band.with_min_y(band.top().min(band.bottom() - sizes.line));
        painter.rect_filled(band, 0.0, colours::of(palette::TIP));
        if column.most_mm > top_mm {
            let end = wide(plot.with_max_y(plot.top() + 2.0 * sizes.line));
            painter.rect_filled(end, 0.0, colours::of(palette::WORDS));
        }
    }
}

fn with_x(rect: Rect, left: f32, right: f32) -> Rect {
    rect.with_min_x(left).with_max_x(right)
}

fn middle(rect: Rect, height: f32) -> Rect {
    Rect::from_center_size(rect.center(), vec2(rect.width(), height))
}

fn hatched(ui: &Ui, room: Rect, ink: Color32) {
    let mut x = room.left();
    while x < room.right() {
        ui.painter().vline(x, room.y_range(), Stroke::new(1.0, ink));
        x += 4.0;
    }
}
