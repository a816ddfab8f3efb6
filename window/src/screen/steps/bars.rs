//! The points of a task with their distances as bars: filled under the registration of all, in outline under that of all others.

use bus::message::{StepPoint, Steps};
use egui::{Align2, Rect, Stroke, StrokeKind, Ui, pos2, vec2};
use picture::palette;

use super::cell;
use crate::colours;
use crate::model::Tone;
use crate::screen::words::Words;
use crate::sizes::Sizes;

/// Parts of a row: the name, the bars, the numbers.
const NAME: f32 = 0.34;
const BARS: f32 = 0.36;
/// The bars end at so many times what 95 % of distances are below.
const REACH: f64 = 2.0;

pub(super) fn show(ui: &Ui, told: &Steps, room: Rect, (sizes, words): (&Sizes, &mut Words)) {
    let points = told.points();
    if points.is_empty() {
        return;
    }
    let height = 1.4 * sizes.plain;
    let fit = (room.height() / height) as usize;
    let row = |k: usize| {
        Rect::from_min_size(
            pos2(room.left(), room.top() + k as f32 * height),
            vec2(room.width(), height),
        )
    };
    let Some(fit) = fit.checked_sub(1).filter(|fit| *fit > 0) else {
        return;
    };
    if points.iter().any(|point| point.residual_mm.is_finite()) {
        head(ui, row(0), sizes, words);
    }
    let shown = visible(points.len(), told.next as usize, fit);
    for (k, place) in shown.clone().enumerate() {
        let is_next = told.next as usize == place;
        one(
            ui,
            (&points[place], is_next),
            row(k + 1).shrink2(vec2(0.0, 1.0)),
            sizes,
            words,
        );
    }
    let more = points.len() - shown.len();
    if more > 0 {
        let text = format!("{more} more of {} points", points.len());
        words.put(ui, row(fit), &text, cell(sizes, Tone::Quiet, Align2::LEFT_CENTER));
    }
}

/// Which of so many points are shown where there is room for `fit` lines: with the next one among them, and a line left to say that
/// there are more.
fn visible(count: usize, next: usize, fit: usize) -> std::ops::Range<usize> {
    if count <= fit {
        return 0..count;
    }
    let room = fit - 1;
    let first = next.min(count - 1).saturating_sub(room / 2).min(count - room);
    first..first + room
}

fn parts(row: Rect) -> [Rect; 3] {
    let (name, rest) = row.split_left_right_at_fraction(NAME);
    let (bars, numbers) = rest.split_left_right_at_fraction(BARS / (1.0 - NAME));
    [name, bars, numbers]
}

fn head(ui: &Ui, row: Rect, sizes: &Sizes, words: &mut Words) {
    let [_, bars, numbers] = parts(row);
    let how = |align| cell(sizes, Tone::Quiet, align);
    words.put(
        ui,
        bars.shrink2(vec2(sizes.gap, 0.0)),
        "line: 95 % of touches",
        how(Align2::LEFT_CENTER),
    );
    words.put(ui, numbers, "off, left out: mm", how(Align2::RIGHT_CENTER));
}

fn one(ui: &Ui, (point, is_next): (&StepPoint, bool), row: Rect, sizes: &Sizes, words: &mut Words) {
    let [name, bars, numbers] = parts(row);
    let tone = if point.is_off() { Tone::Warning } else { Tone::Quiet };
    if is_next {
        ui.painter().rect_stroke(
            row,
            2.0,
            Stroke::new(2.0 * sizes.line, colours::of(palette::TARGET)),
            StrokeKind::Inside,
        );
    }
    if point.is_off() {
        ui.painter()
            .rect_filled(numbers, 2.0, cell(sizes, tone, Align2::LEFT_CENTER).ground);
    }
    let mark = if point.is_touched() { "[x] " } else { "[ ] " };
    let name = name.shrink2(vec2(sizes.gap, 0.0));
    words.put(
        ui,
        name,
        &format!("{mark}{}", point.name()),
        cell(sizes, Tone::Quiet, Align2::LEFT_CENTER),
    );
    if !point.residual_mm.is_finite() {
        let text = if point.is_off() { "OFF" } else { "" };
        words.put(ui, numbers, text, cell(sizes, tone, Align2::RIGHT_CENTER));
        return;
    }
    drawn(ui, point, bars.shrink2(vec2(sizes.gap, 2.0)), sizes);
    let left_out = match point.left_out_mm.is_finite() {
        true => format!("  {:.2}", point.left_out_mm),
        false => String::new(),
    };
    let off = if point.is_off() { "  OFF" } else { "" };
    let text = format!("{:.2}{left_out}{off}", point.residual_mm);
    words.put(
        ui,
        numbers.shrink2(vec2(sizes.gap, 0.0)),
        &text,
        cell(sizes, tone, Align2::RIGHT_CENTER),
    );
}

/// Both bars, and a line at what 95 % of distances are expected below. A bar that goes on beyond its room ends at it.
fn drawn(ui: &Ui, point: &StepPoint, room: Rect, sizes: &Sizes) {
    let reach = REACH
        * if point.expected_mm > 0.0 {
            point.expected_mm
        } else {
            1.0
        };
    let wide = |mm: f64| room.width() * (mm / reach).clamp(0.0, 1.0) as f32;
    let painter = ui.painter();
    painter.rect_filled(room, 1.0, colours::CELL);
    let colour = if point.is_off() { palette::WARN } else { palette::TARGET };
    let bar = |mm: f64| Rect::from_min_size(room.min, vec2(wide(mm), room.height()));
    painter.rect_filled(bar(point.residual_mm).shrink2(vec2(0.0, 2.0)), 1.0, colours::of(colour));
    if point.left_out_mm.is_finite() {
        let stroke = Stroke::new(1.5 * sizes.line, colours::of(palette::WORDS));
        painter.rect_stroke(bar(point.left_out_mm), 1.0, stroke, StrokeKind::Inside);
    }
    if point.expected_mm.is_finite() {
        let x = room.left() + wide(point.expected_mm);
        let stroke = Stroke::new(2.0 * sizes.line, colours::of(palette::TIP));
        painter.line_segment([pos2(x, room.top()), pos2(x, room.bottom())], stroke);
    }
}

#[cfg(test)]
mod tests {
    use super::visible;

    #[test]
    fn the_next_point_is_among_those_shown() {
        for count in 1..40 {
            for next in (0..count).chain([usize::MAX]) {
                for fit in 2..20 {
                    let shown = visible(count, next, fit);
                    assert!(shown.end <= count && shown.len() == if count <= fit { count } else { fit - 1 });
                    assert!(
                        next >= count || shown.contains(&next),
                        "{next} of {count} in {fit}: {shown:?}"
                    );
                }
            }
        }
    }
}
