//! Charts of a study.

use std::io;

use picture::chart::{Axis, COLOURS, Chart, Mark, Series};
use picture::encode_png;

use super::page;
use super::summary::Summary;
use crate::record::{Ended, Row};
use crate::truth::LINKS;

/// Pixels of a chart.
const SIZE: [u32; 2] = [1000, 640];

/// The charts; the strata of sweeps, which may be hundreds and have curves of their own, are in the budget alone.
pub(super) fn all(summaries: &[Summary], swept: &[&str], rows: &[Row]) -> io::Result<Vec<page::Chart>> {
    let alone = summaries
        .iter()
        .filter(|summary| !swept.contains(&summary.name.as_str()));
    let alone: Vec<Summary> = alone.cloned().collect();
    let charts = [
        (
            "tre.png",
            "How many of the true errors at targets are within a distance",
            errors(&alone),
        ),
        (
            "budget.png",
            "What each link has made of the error, over what it predicts: on the line both are alike",
            budget(summaries),
        ),
        (
            "predicted.png",
            "The true error over the predicted radius; 95 of 100 are to lie below the line",
            predicted(rows, &alone),
        ),
    ];
    charts
        .into_iter()
        .filter(|(name, ..)| !alone.is_empty() || *name == "budget.png")
        .map(|(name, what, chart)| drawn(name, what, &chart))
        .collect()
}

/// A chart as it is kept.
pub(super) fn drawn(name: &str, what: &str, chart: &Chart) -> io::Result<page::Chart> {
    let canvas = chart.draw(SIZE[0], SIZE[1]).canvas;
    let png = encode_png(&canvas, &[("title", what.to_owned())]).map_err(io::Error::other)?;
    Ok((name.to_owned(), what.to_owned(), png))
}

/// Colours and marks, no two alike.
pub(super) fn colours() -> impl Iterator<Item = (picture::Rgb, Mark)> {
    let marks = [Mark::Dot, Mark::Square, Mark::Triangle, Mark::Cross];
    marks
        .into_iter()
        .flat_map(|mark| COLOURS.into_iter().map(move |colour| (colour, mark)))
}

fn errors(summaries: &[Summary]) -> Chart {
    let mut chart = Chart::new(
        "",
        Axis::linear("error at the target, mm"),
        Axis::linear("share within, %").within(0.0, 100.0),
    );
    for (summary, (colour, _)) in summaries.iter().zip(colours()) {
        let count = summary.errors_mm.len() as f64;
        let points = (1..)
            .zip(&summary.errors_mm)
            .map(|(k, mm)| [*mm, 100.0 * f64::from(k) / count]);
        chart.push(Series::joined(&summary.name, colour, Mark::None, points));
    }
    chart
}

fn budget(summaries: &[Summary]) -> Chart {
    let (x, y) = (
        Axis::linear("predicted, mm (root mean square)"),
        Axis::linear("found, mm"),
    );
    let mut chart = Chart::new("", x, y);
    let mut most = 0.1_f64;
    for (link, (colour, mark)) in colours().enumerate().take(LINKS.len()) {
        let of = summaries.iter().map(|summary| summary.links[link]);
        let points: Vec<[f64; 2]> = of
            .map(|[found, predicted]| [predicted, found])
            .filter(|p| p.iter().all(|v| v.is_finite()))
            .collect();
        most = points.iter().flatten().fold(most, |most, mm| most.max(*mm));
        if !points.is_empty() {
            chart.push(Series::scatter(LINKS[link], colour, mark, points));
        }
    }
    chart.push(Series::joined("alike", COLOURS[7], Mark::None, [[0.0; 2], [most; 2]]).dashed());
    chart
}

fn predicted(rows: &[Row], summaries: &[Summary]) -> Chart {
    let (x, y) = (
        Axis::linear("predicted radius of 95 %, mm"),
        Axis::linear("true error, mm"),
    );
    let mut chart = Chart::new("", x, y);
    let mut most = 1.0_f64;
    for (summary, (colour, _)) in summaries.iter().zip(colours()) {
        let of = rows
            .iter()
            .filter(|row| row.stratum == summary.name && row.ended != Ended::Refused && row.is_within().is_some());
        let points: Vec<[f64; 2]> = of.map(|row| [row.predicted_mm, row.tre_mm]).collect();
        most = points.iter().fold(most, |most, p| most.max(p[0]));
        chart.push(Series::scatter(&summary.name, colour, Mark::Small, points));
    }
    chart.push(Series::joined("", COLOURS[6], Mark::None, [[0.0; 2], [most; 2]]).dashed());
    chart
}
