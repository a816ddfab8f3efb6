//! Tables and pictures.

use std::path::Path;

use picture::Canvas;
use picture::chart::{Axis, COLOURS, Chart, Mark, Series};

use super::Row;

pub(super) fn table(rows: &[Row]) {
    println!(
        "| link | stamps by | error, mean | p50 | p99 | max, ms | later than the arrival by, ms | backwards, frames | stated, median ms | holds, % |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|");
    for row in rows {
        println!("| {} |", cells(row).join(" | "));
    }
}

pub(super) fn csv(rows: &[Row]) -> String {
    let lines = rows
        .iter()
        .map(|row| cells(row).map(|cell| format!("\"{cell}\"")).join(","));
    let head = "link,by,mean_ms,p50_ms,p99_ms,max_ms,future_ms,backwards,stated_ms,holds_percent";
    std::iter::once(head.to_owned())
        .chain(lines)
        .collect::<Vec<_>>()
        .join("\n")
        + "\n"
}

fn cells(row: &Row) -> [String; 10] {
    let [p50, p99, most] = [0.5, 0.99, 1.0].map(|q| format!("{:.3}", row.quantile_ms(q)));
    let stated = row
        .stated
        .map_or_else(String::new, |(_, median)| format!("{median:.3}"));
    let holds = row.stated.map_or_else(String::new, |(held, _)| format!("{held:.2}"));
    let (mean, future) = (format!("{:.3}", row.mean_ms), format!("{:.3}", row.future_ms));
    let (link, by, back) = (row.link.to_owned(), row.by.to_owned(), row.backwards.to_string());
    [link, by, mean, p50, p99, most, future, back, stated, holds]
}

const SIZE: [u32; 2] = [760, 500];
/// The least error that is drawn, ms: below it curves run along the edge.
const LEAST_MS: f64 = 1e-4;

/// For each link, the share of frames whose error is larger than what stands below.
pub(super) fn picture(rows: &[Row], path: &Path) {
    let links: Vec<&[Row]> = rows.chunks(4).collect();
    let [width, height] = SIZE;
    let mut sheet = Canvas::new(2 * width, height * links.len().div_ceil(2) as u32);
    for (k, rows) in links.iter().enumerate() {
        let drawn = chart(rows).draw(width, height);
        let (x, y) = (k as u32 % 2 * width, k as u32 / 2 * height);
        sheet.paste(drawn.canvas.rgba(), width, x, y);
    }
    picture::write_png(path, &sheet, &[]).unwrap();
}

fn chart(rows: &[Row]) -> Chart {
    let x = Axis::log("error, ms").within(LEAST_MS, 1000.0);
    let y = Axis::log("frames with a larger error, %").within(0.02, 100.0);
    let mut chart = Chart::new(rows[0].link, x, y);
    for (row, colour) in rows.iter().zip([COLOURS[7], COLOURS[1], COLOURS[4], COLOURS[0]]) {
        let count = row.errors_ms.len();
        let larger = |k: usize| 100.0 * (count - k) as f64 / count as f64;
        let points = (0..count).map(|k| [row.errors_ms[k].max(LEAST_MS), larger(k)]);
        // As many points as pixels are enough; the last ones are few and far apart.
        let points = points.enumerate().filter(|(k, _)| k % 20 == 0 || count - k < 400);
        let points = points.map(|(_, point)| point).filter(|p| p[1] >= 0.02);
        let mut series = Series::joined(row.by, colour, Mark::None, points);
        series.line_width = 2.5;
        chart.push(series);
    }
    chart
}
