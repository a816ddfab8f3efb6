//! The picture: a panel for each group of dials.

use std::path::Path;

use picture::chart::{Axis, COLOURS, Chart, Mark, Series};
use picture::{Canvas, Rgb, write_png};

use super::dials::GROUPS;
use super::rows::Measured;

/// Pixels of a panel.
const PANEL: [u32; 2] = [900, 640];
const ACROSS: u32 = 2;

/// Writes the picture.
///
/// # Errors
/// In words: a point that cannot be drawn, or the file.
pub(super) fn write(measured: &[Measured], path: &Path) -> Result<(), String> {
    let [width, height] = PANEL;
    let mut canvas = Canvas::new(ACROSS * width, (GROUPS.len() as u32).div_ceil(ACROSS) * height);
    for (number, place) in (0..GROUPS.len()).zip(0_u32..) {
        let drawn = chart(measured, number).draw(width, height);
        if drawn.skipped > 0 {
            return Err(format!("{}: {} points cannot be drawn", GROUPS[number], drawn.skipped));
        }
        canvas.paste(
            drawn.canvas.rgba(),
            width,
            place % ACROSS * width,
            place / ACROSS * height,
        );
    }
    write_png(path, &canvas, &[]).map_err(|e| e.to_string())
}

fn chart(measured: &[Measured], group: usize) -> Chart {
    let mut chart = Chart::new(
        GROUPS[group],
        Axis::log("time, over that of the bold setting"),
        Axis::log("error, over that of the bold setting"),
    );
    for (one, k) in measured.iter().filter(|m| m.dial.group == group).zip(0..) {
        let Some(error) = one.chosen().map(|chosen| chosen.error) else {
            continue;
        };
        let colour = COLOURS[k % 6];
        let mark = if one.dial.is_scale { Mark::Small } else { Mark::Triangle };
        let points: Vec<[f64; 2]> = one.settings.iter().map(|s| [s.ratio, s.error / error]).collect();
        let first = points.first().copied();
        let kind = if one.dial.is_scale {
            Series::joined
        } else {
            Series::scatter
        };
        chart.push(kind(one.dial.title, colour, mark, points));
        if one.dial.is_scale {
            chart.push(Series::scatter("", colour, Mark::Dot, first));
        }
    }
    chart.push(Series::scatter(
        "the bold setting",
        Rgb(0, 0, 0),
        Mark::Square,
        [[1.0, 1.0]],
    ));
    chart
}
