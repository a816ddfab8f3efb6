//! The page: everything in one file, nothing loaded, nothing running.

use std::fmt::Write;

use picture::base64;

use super::summary::{Summary, WITHIN_MM};
use crate::images;
use crate::plan::Plan;
use crate::record::{Ended, Row};
use crate::statistics::Estimate;
use crate::truth::LINKS;

const STYLE: &str = "body{font:15px sans-serif;max-width:75em;margin:2em auto;padding:0 1em;color:#222}table{border-collapse:collapse;margin:1em 0}\
                     td,th{border:1px solid #bbb;padding:.25em .6em;text-align:right}td:first-child,th:first-child{text-align:left}\
                     .bad{background:#fbd9d3;font-weight:bold}img{max-width:100%}";
const POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'; img-src data:";
/// Of the worst lines so many are told.
const WORST: usize = 10;

type Charts = [(&'static str, &'static str, Vec<u8>)];

/// The whole page.
pub(super) fn page(plan: &Plan, summaries: &[Summary], rows: &[Row], charts: &Charts) -> String {
    let mut text = format!(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"/><meta http-equiv=\"Content-Security-Policy\" content=\"{POLICY}\"/>\
         <title>Study</title><style>{STYLE}</style></head><body>\n<h1>Does the tube reach the node, and was the predicted error right?</h1>\n"
    );
    // Writing to a string does not fail.
    let _ = writeln!(text, "<p>{}</p>", escaped(&what(plan)));
    text += &accuracy(summaries);
    text += &coverage(summaries);
    text += &budget(summaries);
    text += &ways(summaries);
    text += &refused(summaries);
    for (_, what, png) in charts {
        let _ = writeln!(
            text,
            "<h2>{}</h2>\n<img alt=\"{}\" src=\"data:image/png;base64,{}\"/>",
            escaped(what),
            escaped(what),
            base64::encode(png)
        );
    }
    text += &worst(rows);
    text + &limits() + "</body></html>\n"
}

fn what(plan: &Plan) -> String {
    let images = images::count(plan);
    format!(
        "{} operations in {} strata of {}, hash {}. In silico throughout: patient, scanner, localizer and operator are simulated, and the \
         truth is the simulator's. {images} different examinations are used: operations of a stratum share them in turn, and so do strata whose CTs \
         are of the same numbers. All else is made anew for each operation. Tables tell of what was not refused.",
        plan.operations(),
        plan.strata.len(),
        plan.files.join(", "),
        &plan.hash[..16.min(plan.hash.len())]
    )
}

fn accuracy(summaries: &[Summary]) -> String {
    let first = [
        "stratum",
        "operations",
        "targets",
        "error, median, mm",
        "95 % within, mm",
    ];
    let mut head = first.map(str::to_owned).to_vec();
    head.extend(WITHIN_MM.map(|mm| format!("within {mm} mm, %")));
    head.extend(["tip from the target, median, mm", "95 % within, mm"].map(str::to_owned));
    let row = |s: &Summary| {
        let mut cells = vec![
            plain(&s.name),
            plain(s.approached),
            plain(s.errors_mm.len()),
            length(s.tre_mm[0]),
            length(s.tre_mm[1]),
        ];
        cells.extend(s.within.map(percent));
        cells.extend(s.miss_mm.map(length));
        cells
    };
    section("True error at the targets", &head, summaries.iter().map(row))
        + "<p>In brackets intervals of 95 %, by order statistics and after Clopper and Pearson, for as many independent observations as there \
           are operations: the targets of one share a registration.</p>\n"
}

fn coverage(summaries: &[Summary]) -> String {
    let head = [
        "stratum",
        "predicted radius of 95 %, median, mm",
        "within it, %",
        "within the ellipsoid of 95 %, %",
        "NEES, mean",
        "NEES in 95 of 100 studies",
        "word",
    ];
    let row = |s: &Summary| {
        let (nees, [low, high]) = s.nees;
        let word = match s.keeps_its_word() {
            None => plain("nothing predicted"),
            Some(true) => plain("kept"),
            Some(false) => bad("NOT KEPT"),
        };
        vec![
            plain(&s.name),
            plain(format!("{:.2}", s.predicted_mm)),
            percent(s.covered),
            percent(s.in_ellipsoid),
            match nees > high {
                true => bad(format!("{nees:.2}")),
                false => plain(format!("{nees:.2}")),
            },
            match high.is_finite() {
                true => plain(format!("{low:.2} to {high:.2}")),
                false => plain(""),
            },
            word,
        ]
    };
    section(
        "Was the predicted error right?",
        &head.map(str::to_owned),
        summaries.iter().map(row),
    ) + "<p>The ball is as wide as the longest axis of the ellipsoid, and holds more than 95 % where the axes differ; the ellipsoid holds \
           95 % if the covariance is right, and the mean of NEES is 3.</p>\n"
}

fn budget(summaries: &[Summary]) -> String {
    let mut head = vec!["stratum".to_owned()];
    head.extend(LINKS.iter().map(|link| format!("{link}: found / predicted, mm")));
    let row = |s: &Summary| {
        let mut cells = vec![plain(&s.name)];
        let both = |[found, predicted]: [f64; 2]| match predicted.is_finite() {
            true => plain(format!("{found:.3} / {predicted:.3}")),
            false => plain(format!("{found:.3} / none")),
        };
        cells.extend(s.links.map(both));
        cells
    };
    section(
        "What each link has made of it (root mean square)",
        &head,
        summaries.iter().map(row),
    ) + "<p>registration: touches, tool and CT of the registration; bump: the marker on the patient was moved on it; reference and frame: the noise of the last \
           frame at the patient's marker and at the tool's; marker: the calibrated emitters; tool: tip, base and seat. Nobody predicts a bump, nor \
           the error of calibrated emitters.</p>\n"
}

fn ways(summaries: &[Summary]) -> String {
    let head = [
        "stratum",
        "arrived",
        "of these with the tip outside the target",
        "given up",
        "refused",
        "time to the target, median, s",
        "pictures without a pose, %",
    ];
    let row = |s: &Summary| {
        vec![
            plain(&s.name),
            plain(s.lines[1]),
            match s.false_arrivals {
                0 => plain(0),
                many => bad(many),
            },
            plain(s.lines[2]),
            plain(s.lines[3]),
            length(s.time_s),
            plain(format!("{:.1}", 100.0 * s.lost)),
        ]
    };
    section(
        "The ways to the targets",
        &head.map(str::to_owned),
        summaries.iter().map(row),
    )
}

fn refused(summaries: &[Summary]) -> String {
    let head = ["stratum", "step", "lines", "right", "wrong", "not to be judged"];
    let rows = summaries.iter().flat_map(|s| {
        s.refusals.iter().map(move |(step, [all, right, wrong])| {
            vec![
                plain(&s.name),
                plain(step),
                plain(all),
                plain(right),
                plain(wrong),
                plain(all - right - wrong),
            ]
        })
    });
    let mut text = section("Refusals", &head.map(str::to_owned), rows);
    for s in summaries.iter().filter(|s| s.missed[1] > 0) {
        let [missed, moved] = s.missed;
        let _ = writeln!(
            text,
            "<p>{}: in {moved} operations the marker on the patient was moved before the check; {missed} of them passed it.</p>",
            escaped(&s.name)
        );
    }
    text + "<p>A refusal of the check is right where the true error at the target is beyond the predicted radius, or beyond what is allowed. What \
            was refused before there was a pose cannot be judged.</p>\n"
}

fn worst(rows: &[Row]) -> String {
    let mut known: Vec<&Row> = rows
        .iter()
        .filter(|row| row.ended != Ended::Refused && row.tre_mm.is_finite())
        .collect();
    known.sort_by(|a, b| b.tre_mm.total_cmp(&a.tre_mm));
    let mut head = [
        "stratum",
        "operation",
        "target",
        "error, mm",
        "predicted, mm",
        "tip from the target, mm",
    ]
    .map(str::to_owned)
    .to_vec();
    head.extend(LINKS.map(str::to_owned));
    let row = |row: &&Row| {
        let mut cells = vec![plain(&row.stratum), plain(row.number), plain(&row.target)];
        cells.extend([row.tre_mm, row.predicted_mm, row.miss_mm].map(|mm| plain(format!("{mm:.2}"))));
        cells.extend(row.links.map(|[found, _]| plain(format!("{found:.2}"))));
        cells
    };
    section(
        "The worst of what was not refused",
        &head,
        known.iter().take(WORST).map(row),
    )
}

fn limits() -> String {
    "<h2>What this does not say</h2>\n<p>No person, no tissue and no real localizer was measured. The scanner has neither streaks nor distortion, the beads do \
     not move on the skin, the noise of the localizer is white and normal and is stated as it is, the reference's emitters are as \
     drawn, and the base is as drawn but for its seat.</p>\n"
        .to_owned()
}

/// A cell: its text, and whether it warns.
type Cell = (String, bool);

fn plain(value: impl ToString) -> Cell {
    (value.to_string(), false)
}

fn bad(value: impl ToString) -> Cell {
    (value.to_string(), true)
}

fn length(e: Estimate) -> Cell {
    plain(format!("{:.2} ({:.2} to {:.2})", e.found, e.interval[0], e.interval[1]))
}

fn percent(e: Estimate) -> Cell {
    let [found, low, high] = [e.found, e.interval[0], e.interval[1]].map(|share| 100.0 * share);
    plain(format!("{found:.1} ({low:.1} to {high:.1})"))
}

fn section(title: &str, head: &[String], rows: impl Iterator<Item = Vec<Cell>>) -> String {
    let mut text = format!("<h2>{}</h2>\n<table><tr>", escaped(title));
    for cell in head {
        text += &format!("<th>{}</th>", escaped(cell));
    }
    text += "</tr>\n";
    for row in rows {
        text += "<tr>";
        for (cell, warns) in row {
            let class = if warns { " class=\"bad\"" } else { "" };
            text += &format!("<td{class}>{}</td>", escaped(&cell));
        }
        text += "</tr>\n";
    }
    text + "</table>\n"
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}
