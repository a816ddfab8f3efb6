//! Where a chart's parts lie on the image, and drawing them. Colours are drawn in negative.

use super::span::Span;
use super::{Chart, Mark, Series, negative};
use crate::{Anchor, Canvas, Line, Rgb};

const TEXT: f32 = 17.0;
const TITLE: f32 = 21.0;
/// Advance of a character of the typeface per size.
const ADVANCE: f64 = 0.52;
const ROW: f64 = 24.0;
const INK: Rgb = Rgb(20, 20, 20);
const GRID: Rgb = Rgb(205, 205, 205);
const FINE_GRID: Rgb = Rgb(233, 233, 233);
/// Length of a legend's line, pixels.
const SAMPLE: f64 = 26.0;

/// The rectangle that the axes enclose, and what they show.
pub(super) struct Frame {
    left: f64,
    right: f64,
    top: f64,
    bottom: f64,
    spans: [Span; 2],
}

fn text_width(text: &str, size: f32) -> f64 {
    text.chars().count() as f64 * ADVANCE * f64::from(size)
}

fn put(canvas: &mut Canvas, at: [f64; 2], text: &str, size: f32, anchor: Anchor) {
    canvas.text(at, text, size, negative(INK), anchor);
}

fn line(colour: Rgb, width: f32) -> Line {
    Line::solid(negative(colour), width)
}

impl Frame {
    pub(super) fn new(chart: &Chart, spans: [Span; 2], [width, height]: [u32; 2]) -> Self {
        let labels = spans[1].ticks();
        let widest = labels
            .iter()
            .map(|(_, label)| text_width(label, TEXT))
            .fold(0.0, f64::max);
        let left = widest + 26.0;
        let legend = legend_width(chart);
        let right = f64::from(width) - if legend > 0.0 { legend + 24.0 } else { 30.0 };
        let (top, bottom) = (76.0, f64::from(height) - 66.0);
        Self {
            left,
            right: right.max(left + 1.0),
            top,
            bottom: bottom.max(top + 1.0),
            spans,
        }
    }

    /// The pixel of a point; `None` where it has none.
    fn pixel(&self, [x, y]: [f64; 2]) -> Option<[f64; 2]> {
        let (x, y) = (self.spans[0].fraction(x)?, self.spans[1].fraction(y)?);
        Some([
            self.left + x * (self.right - self.left),
            self.bottom - y * (self.bottom - self.top),
        ])
    }

    pub(super) fn draw_axes(&self, canvas: &mut Canvas, chart: &Chart) {
        let [x_ticks, y_ticks] = [self.spans[0].ticks(), self.spans[1].ticks()];
        for fine in [true, false] {
            for (at, label) in x_ticks.iter().filter(|(_, label)| label.is_empty() == fine) {
                self.x_tick(canvas, *at, label);
            }
            for (at, label) in y_ticks.iter().filter(|(_, label)| label.is_empty() == fine) {
                self.y_tick(canvas, *at, label);
            }
        }
        let corners = [
            [self.left, self.top],
            [self.right, self.top],
            [self.right, self.bottom],
            [self.left, self.bottom],
            [self.left, self.top],
        ];
        canvas.polyline(&corners, line(INK, 1.5));
        let middle = (self.left + self.right) / 2.0;
        put(canvas, [20.0, 24.0], &chart.title, TITLE, Anchor::Left);
        put(canvas, [20.0, 54.0], &chart.y.title, TEXT, Anchor::Left);
        put(
            canvas,
            [middle, self.bottom + 46.0],
            &chart.x.title,
            TEXT,
            Anchor::Centre,
        );
    }

    fn x_tick(&self, canvas: &mut Canvas, at: f64, label: &str) {
        let x = self.left + self.spans[0].part(at) * (self.right - self.left);
        let grid = if label.is_empty() { FINE_GRID } else { GRID };
        canvas.line([x, self.top], [x, self.bottom], line(grid, 1.0));
        put(canvas, [x, self.bottom + 18.0], label, TEXT, Anchor::Centre);
    }

    fn y_tick(&self, canvas: &mut Canvas, at: f64, label: &str) {
        let y = self.bottom - self.spans[1].part(at) * (self.bottom - self.top);
        let grid = if label.is_empty() { FINE_GRID } else { GRID };
        canvas.line([self.left, y], [self.right, y], line(grid, 1.0));
        put(canvas, [self.left - 8.0, y], label, TEXT, Anchor::Right);
    }

    /// Draws a series; returns how many of its points have no place.
    pub(super) fn draw_series(&self, canvas: &mut Canvas, series: &Series) -> usize {
        let pixels: Vec<Option<[f64; 2]>> = series.points.iter().map(|p| self.pixel(*p)).collect();
        if series.line_width > 0.0 {
            for run in pixels.split(Option::is_none) {
                let run: Vec<[f64; 2]> = run.iter().copied().flatten().collect();
                canvas.polyline(&run, stroke(series));
            }
        }
        for pixel in pixels.iter().flatten() {
            draw_mark(canvas, *pixel, series);
        }
        pixels.iter().filter(|pixel| pixel.is_none()).count()
    }

    pub(super) fn draw_legend(&self, canvas: &mut Canvas, chart: &Chart) {
        let x = self.right + 16.0;
        for (row, series) in named(chart).enumerate() {
            let y = self.top + 10.0 + row as f64 * ROW;
            if series.line_width > 0.0 {
                canvas.line([x, y], [x + SAMPLE, y], stroke(series));
            }
            draw_mark(canvas, [x + SAMPLE / 2.0, y], series);
            put(canvas, [x + SAMPLE + 10.0, y], &series.name, TEXT, Anchor::Left);
        }
    }
}

fn named(chart: &Chart) -> impl Iterator<Item = &Series> {
    chart.series.iter().filter(|series| !series.name.is_empty())
}

/// 0 where there is no legend.
fn legend_width(chart: &Chart) -> f64 {
    let widths = named(chart).map(|series| text_width(&series.name, TEXT) + SAMPLE + 16.0);
    widths.fold(0.0, f64::max)
}

fn stroke(series: &Series) -> Line {
    Line {
        dashed: series.dashed,
        ..line(series.colour, series.line_width)
    }
}

fn draw_mark(canvas: &mut Canvas, [x, y]: [f64; 2], series: &Series) {
    let thin = line(series.colour, 2.0);
    // A circle whose line is as wide as its diameter is filled.
    let filled = |radius: f64| (radius / 2.0, line(series.colour, radius as f32));
    let mut joined = |offsets: &[[f64; 2]]| {
        let points: Vec<[f64; 2]> = offsets.iter().map(|[dx, dy]| [x + dx, y + dy]).collect();
        canvas.polyline(&points, thin);
    };
    match series.mark {
        Mark::None => {}
        Mark::Square => joined(&[[-5.0, -5.0], [5.0, -5.0], [5.0, 5.0], [-5.0, 5.0], [-5.0, -5.0]]),
        Mark::Triangle => joined(&[[-6.0, 5.0], [6.0, 5.0], [0.0, -6.0], [-6.0, 5.0]]),
        Mark::Cross => {
            joined(&[[-5.0, -5.0], [5.0, 5.0]]);
            joined(&[[-5.0, 5.0], [5.0, -5.0]]);
        }
        Mark::Circle => canvas.circle([x, y], 5.5, thin),
        Mark::Dot | Mark::Small => {
            let (radius, pen) = filled(if series.mark == Mark::Dot { 6.0 } else { 3.0 });
            canvas.circle([x, y], radius, pen);
        }
    }
}
