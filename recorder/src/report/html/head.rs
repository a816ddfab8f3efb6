//! The head of a page: which recording, of what time, of whom, and what must be known first.

use super::escape::{own, text};
use super::table::{pairs, paragraph};
use super::units::{bytes, length, moment, wall};
use crate::report::facts::{Facts, Whose};

/// The head.
pub(super) fn section(facts: &Facts) -> String {
    let device =
        "<p class=\"device\">Research software, not a medical device. Nothing here may be used to treat anybody.</p>\n";
    [device.to_owned(), notices(facts), pairs(&rows(facts))].concat()
}

fn notices(facts: &Facts) -> String {
    if facts.notices.is_empty() {
        return paragraph(
            "The recording is whole and was ended in an orderly way; the run's own report names no problem.",
        );
    }
    let items = facts
        .notices
        .iter()
        .map(|notice| format!("<li><strong>{}</strong>: {}</li>\n", notice.word, text(&notice.words)));
    format!(
        "<div class=\"notices\"><strong>Read this first</strong>\n<ul>\n{}</ul></div>\n",
        items.collect::<String>()
    )
}

fn rows(facts: &Facts) -> Vec<(&'static str, String)> {
    let recording = &facts.recording;
    let basis = &facts.basis;
    let said = |value: Option<&String>| value.map_or("not told".to_owned(), |value| own(value));
    let scene = basis.run_report().and_then(|report| report.scene.as_ref());
    let mut rows = vec![
        (
            "Recording",
            format!("{}, {}", own(&recording.name), bytes(recording.bytes)),
        ),
        ("BLAKE3 of the file", recording.blake3.clone()),
        ("Run", said(basis.run.get("name"))),
        ("Scene", said(scene)),
        ("Recorded", recorded(facts)),
        ("Time of the run", span(facts)),
        ("Written by", said(recording.written_by.as_ref())),
        ("Report made by", text(facts.made_by)),
    ];
    rows.push(("Examination of", whose(&facts.identity)));
    rows
}

/// Stamps of messages count from the run's epoch, of which no wall clock is told; the attached files bear wall-clock times.
fn recorded(facts: &Facts) -> String {
    let said = [
        (facts.basis.begun_wall_ns, "scene written down"),
        (facts.basis.reported_wall_ns, "run's report written"),
    ];
    let said: Vec<String> = said
        .into_iter()
        .filter(|(ns, _)| *ns > 0)
        .map(|(ns, what)| format!("{what} {}", wall(ns)))
        .collect();
    match said.is_empty() {
        true => "not told: the recording holds no wall-clock time".to_owned(),
        false => said.join("; "),
    }
}

fn span(facts: &Facts) -> String {
    match facts.recording.span_ns {
        Some((from, to)) => {
            let length = length(facts.length_ns());
            format!("from {} to {} min:s, {length}", moment(from), moment(to))
        }
        None => "no messages".to_owned(),
    }
}

fn whose(identity: &Whose) -> String {
    match identity {
        Whose::NotAsked => "not shown; <code>--identity</code> shows it where the recording holds it".to_owned(),
        Whose::NotRecorded => "the recording holds no identity".to_owned(),
        Whose::Said {
            name,
            patient_id,
            birth_date,
            study_date,
            description,
            source,
        } => {
            let fields = [
                ("name", name),
                ("number", patient_id),
                ("born", birth_date),
                ("examined", study_date),
                ("examination", description),
                ("by", source),
            ];
            let told = fields.iter().filter(|(_, value)| !value.is_empty());
            let told: Vec<String> = told.map(|(what, value)| format!("{what}: {}", own(value))).collect();
            told.join("; ")
        }
    }
}
