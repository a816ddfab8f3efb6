//! Organs that the tube moves: how far, and whether their model knows it.

use super::summary::Summary;
use super::table::{Cell, Table, length, percent, plain};
use crate::record::{Ended, Row};
use crate::statistics::{CHI_SQUARE_95, LEVEL, quantile, share};
use crate::truth::LINKS;

/// What begins the word of an approach of which nobody knows where the organs truly were.
const UNKNOWN: &str = "truth";
/// Where the error by organs stands among those of the links.
const AT: usize = LINKS.len() - 1;

/// The table; `None` where no tube moved organs.
pub(super) fn table(summaries: &[Summary], rows: &[Row]) -> Option<Table> {
    let head = [
        "stratum",
        "approaches",
        "moved by the tube, median, mm",
        "95 of 100 within, mm",
        "of them the model has a state and states its error",
        "the model is off by, median, mm",
        "95 of 100 within, mm",
        "stated radius of 95 %, median, mm",
        "within that radius, %",
        "within the stated ellipsoid, %",
        "error of the image at rest, median, mm",
        "error of the image with the model, median, mm",
        "what the model had in the end",
    ];
    let of = |s: &Summary| {
        let of_stratum = |row: &&Row| row.stratum == s.name && row.ended != Ended::Refused && !row.model.is_empty();
        let own: Vec<&Row> = rows.iter().filter(of_stratum).collect();
        (!own.is_empty()).then(|| cells(&s.name, &own))
    };
    let lines: Vec<Vec<Cell>> = summaries.iter().filter_map(of).collect();
    (!lines.is_empty()).then(|| {
        Table::new("Organs that the tube moves", &head, lines.into_iter()).noted(
            "The true organs have other numbers than the model, drawn from the standard deviations that the scene of organs gives them, are pushed by the true poses, and \
             have the same meshes: what is told is of those numbers and of the poses, not of the mesh, of the law, nor of what holds an organ where. The ellipsoid is of the numbers alone, and thin where they all move a place the same way: what the noise of poses moves it by is not in it. `truth` before a word: the true organs did not settle, and nothing is told.",
        )
    })
}

fn cells(name: &str, rows: &[&Row]) -> Vec<Cell> {
    let known: Vec<&&Row> = rows.iter().filter(|row| !row.model.starts_with(UNKNOWN)).collect();
    let stated: Vec<&&Row> = known
        .iter()
        .filter(|row| {
            row.model_numbers[..3]
                .iter()
                .all(|number| number.is_finite() || *number == f64::INFINITY)
        })
        .copied()
        .collect();
    let ends = |of: &dyn Fn(&Row) -> f64, rows: &[&&Row], p: f64| {
        let mut values: Vec<f64> = rows
            .iter()
            .map(|row| of(row))
            .filter(|value| value.is_finite())
            .collect();
        values.sort_by(f64::total_cmp);
        length(quantile(&values, p, values.len() as f64))
    };
    let n = stated.len() as f64;
    let within = |is: &dyn Fn([f64; 4]) -> bool| {
        let count = stated.iter().filter(|row| is(row.model_numbers)).count();
        percent(share(count as f64 / n, n))
    };
    vec![
        plain(name),
        plain(rows.len()),
        ends(&|row| row.links[AT][0], &known, 0.5),
        ends(&|row| row.links[AT][0], &known, LEVEL),
        plain(stated.len()),
        ends(&|row| row.model_numbers[0], &known, 0.5),
        ends(&|row| row.model_numbers[0], &known, LEVEL),
        ends(&|row| row.model_numbers[1], &stated, 0.5),
        within(&|[off_mm, radius_mm, ..]| off_mm <= radius_mm),
        within(&|[_, _, nees, _]| nees <= CHI_SQUARE_95),
        ends(&|row| row.tre_mm, &known, 0.5),
        ends(&|row| row.model_numbers[3], &known, 0.5),
        plain(words(rows)),
    ]
}

/// Each word with how often it was, the most frequent first; what follows a colon says why, and is in the file.
fn words(rows: &[&Row]) -> String {
    let mut counts = std::collections::BTreeMap::<&str, usize>::new();
    for row in rows {
        let word = row.model.split(':').next().unwrap_or_default();
        *counts.entry(word).or_default() += 1;
    }
    let mut counts: Vec<_> = counts.into_iter().collect();
    counts.sort_by_key(|(word, count)| (std::cmp::Reverse(*count), *word));
    let each: Vec<String> = counts.iter().map(|(word, count)| format!("{count} {word}")).collect();
    each.join("; ")
}
