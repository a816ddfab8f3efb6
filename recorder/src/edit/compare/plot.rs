//! A comparison as a picture: distance, its components and angle over the session.

use picture::Canvas;
use picture::chart::{Axis, COLOURS, Chart, Mark, Series};

use super::{Compared, Difference, Summary};

const WIDTH: u32 = 1100;
const HEIGHT: u32 = 400;

/// The largest of so many neighbours is drawn where there are more poses than columns: a peak is never left out.
const COLUMNS: usize = 2000;

/// Draws the distance of the tips, where the second lies from the first, and the angle, one below the other. The names of all
/// series are equally long, so that the same moment is at the same place in all three.
pub(super) fn draw(compared: &Compared, summary: &Summary) -> Canvas {
    let tips = chart(
        compared,
        format!(
            "Distance of the tips: rms {:.3}, 95 % {:.3}, max {:.3} mm",
            summary.tip_mm.rms, summary.tip_mm.p95, summary.tip_mm.max
        ),
        "distance, mm",
        &[("distance ", &|d| d.tip_mm())],
    );
    let components = chart(
        compared,
        "Where the second tip lies from the first".to_owned(),
        "second minus first, mm",
        &[
            ("left", &|d| d.apart.map(|([x, _, _], _)| x)),
            ("posterior", &|d| d.apart.map(|([_, y, _], _)| y)),
            ("superior", &|d| d.apart.map(|([_, _, z], _)| z)),
        ],
    );
    let angles = chart(
        compared,
        format!(
            "Angle: rms {:.3}, 95 % {:.3}, max {:.3} deg",
            summary.angle_deg.rms, summary.angle_deg.p95, summary.angle_deg.max
        ),
        "angle, deg",
        &[("angle    ", &|d| d.angle_rad().map(f64::to_degrees))],
    );
    let mut canvas = Canvas::new(WIDTH, 3 * HEIGHT);
    for (chart, row) in [tips, components, angles].into_iter().zip(0..) {
        let drawn = chart.draw(WIDTH, HEIGHT).canvas;
        canvas.paste(drawn.rgba(), WIDTH, 0, row * HEIGHT);
    }
    canvas
}

/// A name and what it stands for.
type Named<'a> = (&'a str, &'a dyn Fn(&Difference) -> Option<f64>);

fn chart(compared: &Compared, title: String, axis: &str, values: &[Named<'_>]) -> Chart {
    let all = &compared.differences;
    let zero_ns = all.first().map_or(0, |d| d.t_device_ns);
    let mut chart = Chart::new(title, Axis::linear("time from the first pose, s"), Axis::linear(axis));
    let at_s = |d: &Difference| bus::clock::ms(d.t_device_ns.saturating_sub(zero_ns)) / 1e3;
    for ((name, value), colour) in values.iter().zip(COLOURS) {
        let points: Vec<[f64; 2]> = all.iter().filter_map(|d| Some([at_s(d), value(d)?])).collect();
        let step = points.len().div_ceil(COLUMNS).max(1);
        let peaks = points
            .chunks(step)
            .filter_map(|near| near.iter().max_by(|a, b| a[1].abs().total_cmp(&b[1].abs())));
        chart.push(Series::scatter(*name, colour, Mark::Small, peaks.copied()));
    }
    chart
}
