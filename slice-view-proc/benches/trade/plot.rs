//! The curve as a table for other programs and as a picture.

use std::fmt::Write;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use picture::chart::{Axis, COLOURS, Chart, Mark, Series};
use picture::{Canvas, PngError, Rgb, write_png};
use scene::Filter;

use super::measure::{BackEnd, Row};

/// One panel of the picture, pixels.
const PANEL: [u32; 2] = [720, 520];
const GREY: Rgb = Rgb(60, 60, 60);
/// Of the lines, so that the marks stand out.
const LIGHT: Rgb = Rgb(170, 170, 170);

/// Why the results were not written.
#[derive(Debug)]
pub(crate) enum PlotError {
    Table(PathBuf, io::Error),
    Picture(PngError),
}

impl std::fmt::Display for PlotError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Table(path, source) => write!(f, "writing {}: {source}", path.display()),
            Self::Picture(source) => source.fmt(f),
        }
    }
}

/// Writes `trade.csv` and `trade.png` and returns their folder, `out/bench` of the workspace.
pub(crate) fn write(rows: &[Row]) -> Result<PathBuf, PlotError> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../out/bench");
    let csv = folder.join("trade.csv");
    let written = fs::create_dir_all(&folder).and_then(|()| fs::write(&csv, table(rows)));
    written.map_err(|source| PlotError::Table(csv, source))?;
    let canvas = picture(rows);
    write_png(&folder.join("trade.png"), &canvas, &[]).map_err(PlotError::Picture)?;
    Ok(folder)
}

fn table(rows: &[Row]) -> String {
    let mut text = "field,filter,back_end,size,ms,rms_hu,p99_hu,max_hu\n".to_owned();
    for row in rows {
        let [rms, p99, max] = row.error;
        let (filter, back_end) = (row.filter.name(), row.back_end.name());
        let _ = writeln!(
            text,
            "{},{filter},{back_end},{},{:.4},{rms:e},{p99:e},{max:e}",
            row.field, row.size, row.ms
        );
    }
    text
}

/// RMS on each field, and the 99th percentile on the last one: a row of panels each, one panel for each size of image.
fn picture(rows: &[Row]) -> Canvas {
    let mut fields: Vec<&str> = rows.iter().map(|row| row.field).collect();
    fields.dedup();
    let mut sizes: Vec<u32> = rows.iter().map(|row| row.size).collect();
    sizes.sort_unstable();
    sizes.dedup();
    let mut lines: Vec<_> = fields.iter().map(|field| (*field, 0, "RMS error")).collect();
    lines.extend(fields.last().map(|field| (*field, 1, "99th percentile")));
    let [width, height] = PANEL;
    let mut canvas = Canvas::new(width * sizes.len() as u32, height * lines.len() as u32);
    for (down, (field, which, what)) in (0_u32..).zip(lines) {
        for (across, &size) in (0_u32..).zip(&sizes) {
            let of_panel: Vec<&Row> = rows
                .iter()
                .filter(|row| row.field == field && row.size == size)
                .collect();
            let title = format!("{field}, {size} x {size}: {what}");
            let panel = chart(&of_panel, title, which).draw(width, height).canvas;
            paste(&mut canvas, &panel, [across * width, down * height]);
        }
    }
    canvas
}

fn paste(onto: &mut Canvas, panel: &Canvas, [left, top]: [u32; 2]) {
    let bytes = |pixels: u32| pixels as usize * 4;
    let (stride, width) = (bytes(onto.width()), bytes(panel.width()));
    let first = top as usize * stride + bytes(left);
    let lines = onto.rgba_mut()[first..].chunks_mut(stride);
    for (line, row) in lines.zip(panel.rgba().chunks_exact(width)) {
        line[..width].copy_from_slice(row);
    }
}

/// What a reader chooses by: each back end's filters joined from the coarsest to the finest.
fn chart(rows: &[&Row], title: String, which: usize) -> Chart {
    let mut chart = Chart::new(
        title,
        // The same for all panels, and wide enough for the slowest machine and the fastest card.
        Axis::log("time of an image, ms (CPU; gpu: until it is there)").within(0.1, 40_000.0),
        Axis::log("error, HU").within(1.0, 1000.0),
    );
    for back_end in BackEnd::ALL {
        let mine = rows.iter().filter(|row| row.back_end == back_end);
        chart.push(Series::joined(
            "",
            LIGHT,
            Mark::None,
            mine.map(|row| [row.ms, row.error[which]]),
        ));
    }
    for (filter, colour) in Filter::ALL.into_iter().zip(COLOURS) {
        chart.push(Series::joined(filter.name(), colour, Mark::None, []));
        for row in rows.iter().filter(|row| row.filter == filter) {
            chart.push(Series::scatter(
                "",
                colour,
                mark(row.back_end),
                [[row.ms, row.error[which]]],
            ));
        }
    }
    for back_end in BackEnd::ALL {
        chart.push(Series::scatter(back_end.name(), GREY, mark(back_end), []));
    }
    chart
}

fn mark(back_end: BackEnd) -> Mark {
    match back_end {
        BackEnd::Vector => Mark::Dot,
        BackEnd::Portable => Mark::Circle,
        BackEnd::Reference => Mark::Square,
        BackEnd::Gpu => Mark::Cross,
        BackEnd::Sampler => Mark::Small,
    }
}
