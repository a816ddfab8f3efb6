//! The page: everything in one file, nothing loaded, nothing running.

use std::fmt::Write;

use picture::base64;

use super::table::Table;
use crate::images;
use crate::plan::Plan;
use crate::worst::Kept;

const STYLE: &str = "body{font:15px sans-serif;max-width:75em;margin:2em auto;padding:0 1em;color:#222}table{border-collapse:collapse;margin:1em 0}\
                     td,th{border:1px solid #bbb;padding:.25em .6em;text-align:right}td:first-child,th:first-child{text-align:left}\
                     .bad{background:#fbd9d3;font-weight:bold}img{max-width:100%}pre{overflow-x:auto}";
const POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'; img-src data:";

/// A chart: its file's name, what it shows, the PNG.
pub(super) type Chart = (String, String, Vec<u8>);

/// The whole page, of so many lines.
pub(super) fn page(plan: &Plan, tables: &[Table], charts: &[Chart], kept: &[Kept], lines: usize) -> String {
    let mut text = format!(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"/><meta http-equiv=\"Content-Security-Policy\" content=\"{POLICY}\"/>\
         <title>Study</title><style>{STYLE}</style></head><body>\n<h1>Does the tube reach the node, and was the predicted error right?</h1>\n"
    );
    // Writing to a string does not fail.
    let _ = writeln!(text, "<p>{}</p>", escaped(&what(plan)));
    let all: u64 = plan
        .strata
        .iter()
        .map(|s| s.operations * s.dials.targets.len() as u64)
        .sum();
    if (lines as u64) < all {
        let _ = writeln!(
            text,
            "<p class=\"bad\">On its way: {lines} of {all} lines are here.</p>"
        );
    }
    tables.iter().for_each(|table| text += &section(table));
    text += &replays(kept);
    for (_, what, png) in charts {
        let _ = writeln!(
            text,
            "<h2>{}</h2>\n<img alt=\"{}\" src=\"data:image/png;base64,{}\"/>",
            escaped(what),
            escaped(what),
            base64::encode(png)
        );
    }
    text + &limits() + "</body></html>\n"
}

/// The same tables as Markdown.
pub(super) fn markdown(plan: &Plan, tables: &[Table]) -> String {
    let tables = tables.iter().map(Table::markdown).collect::<String>();
    format!("# Tables\n\n{}\n\n{tables}", what(plan))
}

fn what(plan: &Plan) -> String {
    let images = images::count(plan);
    let bones = match plan.strata.iter().any(|stratum| stratum.dials.surface.is_some()) {
        true => {
            " The bone that some register by is one pelvis, taken from each of these images once: its errors are the same for all that share the image."
        }
        false => "",
    };
    format!(
        "{} operations in {} strata of {}, hash {}. In silico throughout: patient, scanner, localizer and operator are simulated, and the \
         truth is the simulator's. {images} different examinations are used: operations of a stratum share them in turn, and so do strata whose CTs \
         are of the same numbers. All else is made anew for each operation. Tables tell of what was not refused.{bones}",
        plan.operations(),
        plan.strata.len(),
        plan.files.join(", "),
        &plan.hash[..16.min(plan.hash.len())]
    )
}

/// How the worst operations are looked at.
fn replays(kept: &[Kept]) -> String {
    if kept.is_empty() {
        return String::new();
    }
    let mut text = "<p>The worst were done once more and are kept as recordings, with their scenes and calibrations: what the operator was shown, and the \
                    true pose beside it. In the folder of this page:</p>\n<pre>"
        .to_owned();
    for one in kept {
        text += &escaped(&one.command());
        text.push('\n');
    }
    text + "</pre>\n"
}

fn limits() -> String {
    "<h2>What this does not say</h2>\n<p>No person, no tissue and no real localizer was measured. The scanner has neither streaks nor distortion, the beads do \
     not move on the skin, organs breathe only where a stratum says so, along one axis and alike each time, the noise of the localizer is white and normal and is stated as it is, the reference's emitters are as \
     drawn, and the base is as drawn but for its seat. Ultrasound is simulated: tissue does not give way to the probe, and the probe is \
     calibrated in a tank whose sound is as fast as the scanner takes it for.</p>\n"
        .to_owned()
}

fn section(table: &Table) -> String {
    let mut text = format!("<h2>{}</h2>\n<table><tr>", escaped(&table.title));
    for cell in &table.head {
        text += &format!("<th>{}</th>", escaped(cell));
    }
    text += "</tr>\n";
    for row in &table.rows {
        text += "<tr>";
        for cell in row {
            let class = if cell.warns { " class=\"bad\"" } else { "" };
            text += &format!("<td{class}>{}</td>", escaped(&cell.text));
        }
        text += "</tr>\n";
    }
    text += "</table>\n";
    for note in &table.notes {
        text += &format!("<p>{}</p>\n", escaped(note));
    }
    text
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}
