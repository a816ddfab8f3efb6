//! What was restarted, refused, dropped, and what could not be read.

use super::escape::{own, text};
use super::table::{more, pairs, paragraph, table};
use super::units::moment;
use crate::report::facts::Facts;
use crate::report::run_report::RunReport;

/// What went wrong during the run.
pub(super) fn section(facts: &Facts) -> String {
    let mut page = String::from("<section>\n<h2>Restarts, refusals, problems</h2>\n");
    match facts.basis.run_report() {
        Some(report) => page += &reported(report),
        None => {
            page += &paragraph("The run's own report is not attached, or cannot be read: its problems are not known.")
        }
    }
    page += &restarts(facts);
    page += &pairs(&counts(facts));
    page += &processes(facts);
    page + &lines(facts) + "</section>\n"
}

fn reported(report: &RunReport) -> String {
    let mut page = String::from("<h3>Problems, by the run's own report</h3>\n");
    let listed = |words: &[String]| {
        let items: String = words
            .iter()
            .take(100)
            .map(|words| format!("<li>{}</li>\n", own(words)))
            .collect();
        format!("<ul>\n{items}</ul>\n") + &more(words.len().saturating_sub(100) as u64, "of them")
    };
    page += &match report.problems.is_empty() {
        true => paragraph("None."),
        false => listed(&report.problems),
    };
    if !report.notes.is_empty() {
        page += &(paragraph("It notes:") + &listed(&report.notes));
    }
    if !report.held.is_empty() {
        let held: Vec<String> = report.held.iter().take(100).map(|name| own(name)).collect();
        page += &paragraph(&format!("Ended too often and not started again: {}.", held.join(", ")));
    }
    let row = |restart: &crate::report::run_report::Restart| {
        let back = restart
            .live_again_s
            .map_or("never".to_owned(), |s| format!("after {s:.2} s"));
        vec![
            own(&restart.process),
            format!("{:.2} s", restart.at_s),
            own(&restart.cause),
            back,
        ]
    };
    let rows: Vec<_> = report.restarts.iter().take(200).map(row).collect();
    let table = table(
        &[
            "Process",
            "After the start of the navigation",
            "Why it ended",
            "Its work was there again",
        ],
        &rows,
    );
    page + &table.map_or(paragraph("It names no process that was started anew."), |table| table)
}

/// By the numbers of the processes, whatever the run's report says.
fn restarts(facts: &Facts) -> String {
    let restarts = &facts.story.restarts;
    let row = |(restart, place): (&crate::report::story::Restart, u64)| {
        let (old, new) = restart.pids;
        vec![
            place.to_string(),
            moment(restart.t_ns),
            own(&restart.process),
            format!("{old} to {new}"),
        ]
    };
    let rows: Vec<_> = restarts.listed.iter().zip(1..).map(row).collect();
    let title = "<h3>Restarts, by the signs of life in the recording</h3>\n";
    match table(&["Number", "First sign, min:s", "Process", "Process number"], &rows) {
        Some(table) => [title, &table, &more(restarts.more(), "restarts")].concat(),
        None => [
            title,
            &paragraph("None. The recorder itself is not among those whose signs are recorded."),
        ]
        .concat(),
    }
}

fn counts(facts: &Facts) -> Vec<(&'static str, String)> {
    let said = |key: &str| {
        facts
            .basis
            .recorder_says(key)
            .map_or("not told".to_owned(), |n| n.to_string())
    };
    let poses = &facts.poses;
    let mut rows = vec![
        (
            "Refused samples",
            format!("{} by this reading, {} by the recorder", poses.refused, said("refused")),
        ),
        (
            "Missing messages",
            format!(
                "{} of the tool by this reading, {} of all by the recorder",
                poses.missing,
                said("missing")
            ),
        ),
        (
            "Warnings and errors",
            format!(
                "{}; {} other lines of the log",
                facts.story.lines.count, facts.story.plain_lines
            ),
        ),
    ];
    let report = facts.basis.run_report();
    if let Some(of) = report.and_then(|report| report.poses) {
        let words = format!(
            "{} published, {} lost, {} refused, {} missing, counted anew {} times, registration changed {} times",
            of.published, of.lost, of.refused, of.missing, of.counted_anew, of.registration_changes
        );
        rows.push(("Samples, by the run", words));
    }
    for view in report.into_iter().flat_map(|report| &report.views).take(64) {
        let words = format!(
            "{} poses shown, {} passed over, {} old images unmarked",
            view.rendered, view.dropped, view.unflagged_old
        );
        rows.push(("View", format!("{}: {words}", own(&view.name))));
    }
    rows
}

fn processes(facts: &Facts) -> String {
    let row = |(name, last): (&String, &crate::report::story::Last)| {
        let counts = [last.published, last.lost, last.dropped, last.refused].map(|n| n.to_string());
        let mut row = vec![own(name), moment(last.t_ns), own(&last.state)];
        row.extend(counts);
        row.push(own(&last.note));
        row
    };
    let rows: Vec<_> = facts.story.processes.iter().map(row).collect();
    let heads = [
        "Process",
        "Last sign, min:s",
        "State",
        "Published",
        "Lost",
        "Passed over",
        "Refused",
        "Said",
    ];
    let title = "<h3>Processes, by their last recorded sign of life</h3>\n";
    let table = table(&heads, &rows).unwrap_or_else(|| paragraph("The recording does not tell of any."));
    [
        title,
        &table,
        &paragraph("Signs are recorded where state or words change: counters are as old as that."),
    ]
    .concat()
}

fn lines(facts: &Facts) -> String {
    let lines = &facts.story.lines;
    let row = |line: &crate::report::story::Line| {
        vec![
            moment(line.t_ns),
            line.level.to_owned(),
            own(&line.who),
            own(&line.words),
        ]
    };
    let rows: Vec<_> = lines.listed.iter().map(row).collect();
    let title = "<h3>Warnings and errors of the log</h3>\n";
    let table = table(&["Time, min:s", "Level", "Who", "What"], &rows).unwrap_or_else(|| paragraph("None."));
    [title, &table, &more(lines.more(), "lines")].concat()
}

/// What could not be read, and what the file holds.
pub(super) fn damage(facts: &Facts) -> String {
    let damage = &facts.damage;
    let mut page = String::from("<section>\n<h2>The file</h2>\n");
    let items: String = damage
        .words
        .listed
        .iter()
        .map(|words| format!("<li>{}</li>\n", text(words)))
        .collect();
    page += &match items.is_empty() {
        true => paragraph("Everything in it could be read."),
        false => format!("<p>What could not be read:</p>\n<ul>\n{items}</ul>\n") + &more(damage.words.more(), "places"),
    };
    let row = |(name, topic): (&String, &crate::report::facts::Topic)| {
        let counts = [topic.messages, topic.missing, topic.restarts].map(|n| n.to_string());
        let mut row = vec![own(name)];
        row.extend(counts);
        row.push(own(&topic.schema));
        row
    };
    let topics = &facts.recording.topics;
    let rows: Vec<_> = topics.iter().take(200).map(row).collect();
    let heads = ["Topic", "Messages", "Missing numbers", "Counts begun anew", "Schema"];
    page += &table(&heads, &rows).unwrap_or_default();
    page += &more(topics.len().saturating_sub(200) as u64, "topics");
    let (outside, unreadable) = (facts.poses.outside, damage.unreadable);
    page += &paragraph(&format!(
        "Poses whose source found the tip outside the examination: {outside}. Messages that are not what they should be: {unreadable}."
    ));
    page + "</section>\n"
}
