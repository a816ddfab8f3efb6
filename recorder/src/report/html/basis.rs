//! What the session rests on: examination, registration, calibrations, instrument, and which stages the run came through.

use bus::message::Workflow;

use super::escape::{own, text};
use super::table::{more, pairs, paragraph, table};
use super::units::{bytes, length, moment, number};
use crate::report::facts::Facts;
use crate::report::run_report::Volume;

/// The section.
pub(super) fn section(facts: &Facts) -> String {
    let mut page = String::from("<section>\n<h2>What it rests on</h2>\n");
    page += &pairs(&rows(facts));
    page += "<h3>Registrations in use</h3>\n";
    let ids = facts.poses.registrations.listed.iter();
    let rows: Vec<_> = ids
        .map(|(t_ns, id)| vec![moment(*t_ns), format!("<code>{}</code>", text(id))])
        .collect();
    let ids = table(&["From, min:s", "Registration id"], &rows);
    page += &ids.unwrap_or_else(|| paragraph("No valid pose says which."));
    page += &more(facts.poses.registrations.more(), "changes of the registration");
    page += "<h3>Attached calibrations and registrations</h3>\n";
    page += &files(facts);
    page += "<h3>Stages of the workflow</h3>\n";
    page + &stages(facts) + "</section>\n"
}

fn rows(facts: &Facts) -> Vec<(&'static str, String)> {
    let basis = &facts.basis;
    let report = basis.run_report();
    let volume = report.and_then(|report| report.volume.as_ref());
    let hash = basis.run.get("volume_hash").or(volume.map(|volume| &volume.hash));
    let mut rows = vec![
        (
            "Examination, hash",
            hash.map_or("not told".to_owned(), |hash| format!("<code>{}</code>", text(hash))),
        ),
        (
            "Examination, size",
            volume.map_or("not told: it is in the run's report".to_owned(), size),
        ),
    ];
    if let Some(scene) = basis.scene_facts() {
        let (mm, across) = (number(scene.tool_length_mm), number(scene.tool_diameter_mm));
        rows.push((
            "Instrument",
            format!("{}, {mm} mm long, {across} mm across", own(&scene.tool)),
        ));
        rows.push((
            "Poses come from",
            format!("{}, {} a second", scene.source, number(scene.rate_hz)),
        ));
        let (stale, lost) = (number(scene.stale_ms), number(scene.lost_ms));
        rows.push((
            "Limits",
            format!("a pose is stale after {stale} ms and lost after {lost} ms"),
        ));
    }
    if let Some(share) = report
        .and_then(|report| report.accuracy.as_ref())
        .and_then(|a| a.outside_share)
    {
        rows.push((
            "Tip outside the examination",
            format!("{} % of the valid poses", number(100.0 * share)),
        ));
    }
    rows
}

fn size(volume: &Volume) -> String {
    let [x, y, z] = volume.dims;
    let [a, b, c] = volume.spacing_mm().map(number);
    let marks = match volume.marks.is_empty() {
        true => String::new(),
        false => format!("; {}", own(&volume.marks)),
    };
    format!("{x} x {y} x {z} voxels, {a} x {b} x {c} mm each{marks}")
}

fn files(facts: &Facts) -> String {
    let files = &facts.basis.files;
    let row = |file: &crate::report::basis::Attached| {
        let id = file
            .id
            .as_ref()
            .map_or("-".to_owned(), |id| format!("<code>{}</code>", text(id)));
        vec![
            own(&file.name),
            file.kind.to_owned(),
            id,
            own(&file.stated),
            bytes(file.bytes),
        ]
    };
    let rows: Vec<_> = files.listed.iter().map(row).collect();
    let table = table(&["File", "What it is", "Id", "Stated", "Size"], &rows);
    let none = "None is attached: the poses rest on what the scene itself says, or on nothing that is told here.";
    table.unwrap_or_else(|| paragraph(none)) + &more(files.more(), "attached files")
}

fn stages(facts: &Facts) -> String {
    let row = |stage: &crate::report::story::Stage| {
        let marks = match stage.marks.is_empty() {
            true => "-".to_owned(),
            false => stage.marks.join(", "),
        };
        vec![moment(stage.t_ns), stage.stage.clone(), marks]
    };
    let stages = &facts.story.stages;
    let rows: Vec<_> = stages.listed.iter().map(row).collect();
    let Some(table) = table(&["From, min:s", "Stage", "What stood on the screens"], &rows) else {
        return paragraph(
            "The recording does not tell of stages: whether anything was confirmed or checked is not known.",
        );
    };
    let times = facts
        .stages_ns
        .iter()
        .map(|(stage, ns)| format!("{} {}", text(stage), length(*ns)));
    let times: Vec<String> = times.collect();
    [
        table,
        more(stages.more(), "changes"),
        paragraph(&format!("Time at each: {}.", times.join(", "))),
        reached(facts),
    ]
    .concat()
}

/// What was skipped on the way.
fn reached(facts: &Facts) -> String {
    let navigated = facts.story.navigated;
    if !navigated.is_reached {
        return paragraph("The run never reached NAVIGATING in this recording.");
    }
    let identity = if navigated.ever(Workflow::REJECTED) {
        "REJECTED by a person for some or all of the navigation"
    } else if navigated.ever_without(Workflow::CONFIRMED) {
        "skipped for some or all of the navigation"
    } else {
        "confirmed by a person"
    };
    let check = if navigated.ever(Workflow::CHECK_FAILED | Workflow::BUMPED) {
        "FAILED for some or all of the navigation"
    } else if navigated.ever(Workflow::NOT_CHECKED) {
        "NOT CHECKED for some or all of the navigation"
    } else {
        "passed"
    };
    paragraph(&format!(
        "Whose examination it is: {identity}. Check of the registration: {check}."
    ))
}
