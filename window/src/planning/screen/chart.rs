//! What the tube's axis meets along the planned way, in HU.

use egui::{Align2, Pos2, Rect, Shape, Stroke, StrokeKind, Ui, pos2, vec2};
use guidance::plan::{DENSE_HU, Trajectory};
use guidance::safety::Section;
use picture::palette;

use super::super::labels::{Beside, WITHIN_MM};
use super::Known;
use crate::colours;
use crate::screen::words::{Type, Words};
use crate::sizes::Sizes;

/// From the bottom to the top of the chart, HU.
const RANGE_HU: [f64; 2] = [-1000.0, 1500.0];
/// Points of the line, one for each so many pixels.
const STEP_PX: f32 = 2.0;

pub(super) fn show(
    ui: &Ui,
    known: &Known<'_>,
    way: Option<&Trajectory>,
    room: Rect,
    (sizes, words): (&Sizes, &mut Words),
) {
    let Some(way) = way else { return };
    let line = 1.2 * sizes.plain;
    let (title, below) = room.split_top_bottom_at_y(room.top() + line);
    let (plot, foot) = below.split_top_bottom_at_y(below.bottom() - line);
    let painter = ui.painter();
    painter.rect_filled(plot, 0.0, colours::CELL);
    painter.rect_stroke(plot, 0.0, Stroke::new(sizes.line, colours::LINE), StrokeKind::Inside);
    let how = |align| Type {
        size: sizes.plain,
        colour: colours::of(palette::WORDS),
        ground: colours::GROUND,
        align,
    };
    let (title, middle) = title.split_left_right_at_fraction(0.38);
    words.put(ui, title, "HU along the axis", how(Align2::LEFT_CENTER));
    let (left, right) = foot.split_left_right_at_fraction(0.5);
    words.put(ui, left, "entry", how(Align2::LEFT_CENTER));
    words.put(ui, right, &format!("{:.1} mm", way.depth_mm), how(Align2::RIGHT_CENTER));
    dense(ui, plot, (sizes, words));
    if let Beside::Found(found) = known.beside {
        distances(ui, &found.sections, way.depth_mm, plot, sizes);
        words.put(
            ui,
            middle,
            "line: distance to the nearest structure, 0 to 20 mm",
            how(Align2::CENTER_CENTER),
        );
    }
    for run in runs(known, way, plot) {
        let points = run.len();
        let stroke = Stroke::new(1.6 * sizes.line, colours::of(palette::TUBE));
        if points > 1 {
            painter.add(Shape::line(run, stroke));
        }
    }
}

/// The distance from the tube's wall to the nearest structure, part by part: 0 at the bottom, [`WITHIN_MM`] at the top, broken where none
/// is so near. Parts that are not checked are hatched by bars over the whole height.
fn distances(ui: &Ui, sections: &[Section], length_mm: f64, plot: Rect, sizes: &Sizes) {
    let x = |mm: f64| plot.left() + (mm / length_mm) as f32 * plot.width();
    for section in sections {
        let [from, to] = [x(section.from_mm), x(section.to_mm)];
        if !section.is_inside_map {
            let bar = Rect::from_min_max(pos2(from, plot.top()), pos2((from + to) / 2.0, plot.bottom()));
            ui.painter().rect_filled(bar, 0.0, colours::of(palette::WARN));
            continue;
        }
        let Some((_, nearest)) = section.nearest else { continue };
        let part = (nearest.distance_mm / WITHIN_MM).clamp(0.0, 1.0) as f32;
        let y = plot.bottom() - part * plot.height();
        let colour = if nearest.distance_mm <= 0.0 {
            palette::ALARM
        } else {
            palette::TARGET
        };
        let stroke = Stroke::new(2.0 * sizes.line, colours::of(colour));
        ui.painter().line_segment([pos2(from, y), pos2(to, y)], stroke);
    }
}

/// The line above which it is as dense as bone.
fn dense(ui: &Ui, plot: Rect, (sizes, words): (&Sizes, &mut Words)) {
    let y = height(f64::from(DENSE_HU), plot);
    let ends = [pos2(plot.left(), y), pos2(plot.right(), y)];
    let dash = 6.0 * sizes.line;
    let stroke = Stroke::new(sizes.line, colours::of(palette::WARN));
    ui.painter().extend(Shape::dashed_line(&ends, stroke, dash, dash));
    let text = format!("{DENSE_HU} HU: bone");
    let wide = crate::sizes::ADVANCE * sizes.plain * text.len() as f32;
    let room = Rect::from_min_size(
        pos2(plot.right() - wide - sizes.gap, y - 1.2 * sizes.plain),
        vec2(wide, 1.2 * sizes.plain),
    );
    let how = Type {
        size: sizes.plain,
        colour: colours::of(palette::WORDS),
        ground: colours::CELL,
        align: Align2::RIGHT_CENTER,
    };
    if room.top() > plot.top() {
        words.put(ui, room, &text, how);
    }
}

fn height(hu: f64, plot: Rect) -> f32 {
    let part = (hu - RANGE_HU[0]) / (RANGE_HU[1] - RANGE_HU[0]);
    plot.bottom() - part.clamp(0.0, 1.0) as f32 * plot.height()
}

/// The line, broken where the way leaves the examination.
fn runs(known: &Known<'_>, way: &Trajectory, plot: Rect) -> Vec<Vec<Pos2>> {
    let count = (plot.width() / STEP_PX).max(2.0) as usize;
    let mut runs = vec![Vec::new()];
    for k in 0..=count {
        let part = k as f64 / count as f64;
        let hu = (known.hu)(way.at(part * way.depth_mm));
        let x = plot.left() + part as f32 * plot.width();
        match (hu, runs.last_mut()) {
            (Some(hu), Some(run)) => run.push(pos2(x, height(f64::from(hu), plot))),
            (None, Some(run)) if !run.is_empty() => runs.push(Vec::new()),
            _ => {}
        }
    }
    runs
}
