//! The checks of the registration on known points, before and during the navigation.

use super::escape::{own, text};
use super::table::{more, paragraph, table};
use super::units::{moment, number};
use crate::report::facts::Facts;
use crate::report::story::Check;

/// The section.
pub(super) fn section(facts: &Facts) -> String {
    let page = String::from("<section>\n<h2>Checks of the registration</h2>\n");
    let checks = &facts.story.checks;
    let rows: Vec<_> = checks.listed.iter().map(row).collect();
    let heads = [
        "Told, min:s",
        "Registration",
        "Points",
        "Worst distance",
        "Verdict",
        "The point that failed",
    ];
    let content = match table(&heads, &rows) {
        Some(table) => {
            let words = "A check fails as a whole where one point does. The registration is that of the poses before; how far the other \
                         points were off is not recorded.";
            table + &more(checks.more(), "checks") + &paragraph(words)
        }
        None if facts.story.plain_lines == 0 => {
            paragraph("The recording holds no log of the pilot: whether known points were touched is not known.")
        }
        None => paragraph(
            "<strong>None</strong> is told of in this recording: no known point was touched, or it was not accepted.",
        ),
    };
    page + &content + "</section>\n"
}

fn row(check: &Check) -> Vec<String> {
    let said = &check.said;
    let id = check.registration.as_ref();
    let verdict = match said.verdict {
        "passed" => "passed".to_owned(),
        other => format!("<strong>{}</strong>", text(other)),
    };
    vec![
        moment(check.t_ns),
        id.map_or("UNKNOWN".to_owned(), |id| format!("<code>{}</code>", text(id))),
        said.points.to_string(),
        format!("{} mm", number(said.worst_mm)),
        verdict,
        if said.because.is_empty() {
            "-".to_owned()
        } else {
            own(&said.because)
        },
    ]
}
