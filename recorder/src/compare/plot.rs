//! A comparison as a picture: distance and angle over the session.

use picture::Canvas;
use picture::chart::{Axis, COLOURS, Chart, Mark, Series};

use super::{Compared, Difference, Summary};

const WIDTH: u32 = 1100;
const HEIGHT: u32 = 480;

/// The largest of so many neighbours is drawn where there are more poses than columns: a peak is never left out.
const COLUMNS: usize = 2000;

/// Draws the distance of the tips above the angle.
pub(super) fn draw(compared: &Compared, summary: &Summary) -> Canvas {
    let tips = chart(
        compared,
        &format!(
            "Distance of the tips: rms {:.3}, 95 % {:.3}, max {:.3} mm",
            summary.tip_mm.rms, summary.tip_mm.p95, summary.tip_mm.max
        ),
        "distance, mm",
        &|d| d.tip_mm(),
    );
    let angles = chart(
        compared,
        &format!(
            "Angle: rms {:.3}, 95 % {:.3}, max {:.3} deg",
            summary.angle_deg.rms, summary.angle_deg.p95, summary.angle_deg.max
        ),
        "angle, deg",
        &|d| d.angle_rad().map(f64::to_degrees),
    );
    let mut canvas = Canvas::new(WIDTH, 2 * HEIGHT);
    for (chart, y) in [(tips, 0), (angles, HEIGHT)] {
        let drawn = chart.draw(WIDTH, HEIGHT).canvas;
        canvas.paste(drawn.rgba(), WIDTH, 0, y);
    }
    canvas
}

fn chart(compared: &Compared, title: &str, axis: &str, value: &dyn Fn(&Difference) -> Option<f64>) -> Chart {
    let all = &compared.differences;
    let zero_ns = all.first().map_or(0, |d| d.t_device_ns);
    let mut chart = Chart::new(title, Axis::linear("time from the first pose, s"), Axis::linear(axis));
    let points = |d: &Difference| Some([bus::clock::ms(d.t_device_ns.saturating_sub(zero_ns)) / 1e3, value(d)?]);
    let points: Vec<[f64; 2]> = all.iter().filter_map(points).collect();
    let step = points.len().div_ceil(COLUMNS).max(1);
    let peaks = points
        .chunks(step)
        .filter_map(|near| near.iter().max_by(|a, b| a[1].total_cmp(&b[1])));
    chart.push(Series::scatter("", COLOURS[0], Mark::Small, peaks.copied()));
    chart
}
