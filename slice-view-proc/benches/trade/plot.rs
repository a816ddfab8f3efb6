//! The curve as a table for other programs and as a picture.

use std::fmt::Write;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use bus::scene::Filter;
use picture::chart::{Axis, COLOURS, Chart, Mark, Series};
use picture::{Canvas, PngError, Rgb, write_png};

use super::measure::{BackEnd, Row};

/// One panel of the picture, pixels.
const PANEL: [u32; 2] = [900, 640];
const GREY: Rgb = Rgb(60, 60, 60);

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

/// RMS on each field, and the 99th percentile on the last one: four panels.
fn picture(rows: &[Row]) -> Canvas {
    let mut fields: Vec<&str> = rows.iter().map(|row| row.field).collect();
    fields.dedup();
    let mut panels: Vec<Chart> = fields.iter().map(|field| chart(rows, field, 0, "RMS error")).collect();
    panels.extend(
        fields
            .last()
            .map(|field| chart(rows, field, 1, "99th percentile of the error")),
    );
    let [width, height] = PANEL;
    let mut canvas = Canvas::new(2 * width, height * panels.len().div_ceil(2) as u32);
    for (i, panel) in panels.iter().enumerate() {
        paste(
            &mut canvas,
            &panel.draw(width, height).canvas,
            [i as u32 % 2 * width, i as u32 / 2 * height],
        );
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

fn chart(rows: &[Row], field: &str, which: usize, what: &str) -> Chart {
    let mut chart = Chart::new(
        format!("{field}: {what} against time"),
        // The same for all panels, and wide enough for the slowest machine and the fastest card.
        Axis::log("time of an image of 256, 512, 1024 pixels a side, ms (CPU; gpu: until it is there)")
            .within(0.1, 40_000.0),
        Axis::log(format!("{what}, HU")),
    );
    for (filter, colour) in Filter::ALL.into_iter().zip(COLOURS) {
        chart.push(Series::joined(filter.name(), colour, Mark::None, []));
        for back_end in BackEnd::ALL {
            let mine = rows
                .iter()
                .filter(|row| row.field == field && row.filter == filter && row.back_end == back_end);
            let points = mine.map(|row| [row.ms, row.error[which]]);
            chart.push(Series::joined("", colour, mark(back_end), points));
        }
    }
    // The sampler has the mark of the card, on the line of its filter.
    for back_end in BackEnd::ALL.into_iter().filter(|b| *b != BackEnd::Sampler) {
        chart.push(Series::scatter(back_end.name(), GREY, mark(back_end), []));
    }
    chart
}

fn mark(back_end: BackEnd) -> Mark {
    match back_end {
        BackEnd::Vector => Mark::Dot,
        BackEnd::Portable => Mark::Circle,
        BackEnd::Reference => Mark::Square,
        BackEnd::Gpu | BackEnd::Sampler => Mark::Cross,
    }
}
