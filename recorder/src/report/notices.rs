//! What stands at the top of a report: whatever makes less of it than a reader would take it for.

use bus::message::{TissueShown, TissueState, Workflow};

use super::facts::Notice;
use super::gather::Gathered;
use crate::wire::schema::LIBRARY;

/// All of them, the gravest first.
pub(super) fn notices(found: &Gathered, bytes: u64) -> Vec<Notice> {
    let mut notices = Vec::new();
    let mut say = |word, words: String| notices.push(Notice { word, words });
    damage(found, bytes, &mut say);
    part(found, &mut say);
    kind(found, &mut say);
    model(found, &mut say);
    confirmations(found, &mut say);
    contents(found, &mut say);
    notices
}

fn damage(found: &Gathered, bytes: u64, say: &mut impl FnMut(&'static str, String)) {
    let damage = &found.damage;
    if damage.places > 0 || damage.unreadable > 0 {
        let lost: Vec<String> = damage.lost.iter().map(|(topic, n)| format!("{n} of {topic}")).collect();
        let (places, unreadable) = (damage.places, damage.unreadable);
        let lost = match &lost[..] {
            [] => String::new(),
            lost => format!(
                "; known to be lost are {} messages: {}",
                damage.lost.values().sum::<u64>(),
                lost.join(", ")
            ),
        };
        let words = format!(
            "{places} records of the file are unreadable{lost}; {unreadable} messages are not what they should be."
        );
        say("DAMAGED", words + " This report holds what could be read.");
    }
    if let Some(at) = damage.stops_at {
        let share = 100.0 * at as f64 / bytes.max(1) as f64;
        let words = format!(
            "Nothing behind byte {at} of {bytes} ({share:.1} %) could be read: what came then is not in this report."
        );
        say("NOT READ TO ITS END", words);
    }
    if damage.is_cut_off {
        let words = "The file ends before its recording did: it was never finished, or its end is cut off.";
        say("INCOMPLETE", words.to_owned());
    } else if found.basis.recorder.is_empty() && found.basis.part.is_empty() && damage.stops_at.is_none() {
        let words = "The file is whole, but holds no word of the recorder on its end: the recording was not ended in an orderly \
                     way, or another program made the file of it (`recorder recover`, for instance).";
        say("END NOT RECORDED", words.to_owned());
    }
}

fn part(found: &Gathered, say: &mut impl FnMut(&'static str, String)) {
    let basis = &found.basis;
    for of in &basis.recovered {
        say(
            "NOT ALL OF IT",
            format!("The file was made of {of}. What is lost is not in this report."),
        );
    }
    if let (false, Some(of)) = (basis.cut.is_empty(), basis.cut.get("file")) {
        let seconds = |key: &str| {
            basis
                .cut
                .get(key)
                .and_then(|ns| ns.parse::<u64>().ok())
                .map(|ns| ns as f64 / 1e9)
        };
        let from = seconds("from_ns").map_or("?".to_owned(), |s| format!("{s:.1} s"));
        // Without an end it goes as far as the recording does.
        let to = seconds("to_ns")
            .filter(|s| *s < 1e9)
            .map_or("its end".to_owned(), |s| format!("{s:.1} s"));
        say(
            "A STRETCH",
            format!("This is a part of {of}, from {from} to {to} of the run. Its end is not the session's."),
        );
    }
    let before = basis.files_before();
    let goes_on = basis.recorder.is_empty() && !basis.part.is_empty();
    if before > 0 || goes_on {
        let behind = if goes_on {
            "; the session went on in another file"
        } else {
            ""
        };
        let words = format!("{before} files of the session came before this one{behind}. They are not in this report.");
        say("ONE PART", words);
    }
    if let Some(missing @ 1..) = basis.recorder_says("missing") {
        say(
            "MESSAGES MISSING",
            format!("By the recorder {missing} messages are missing: never published, or never recorded."),
        );
    }
    if let Some(library) = found.library.as_deref().filter(|library| *library != LIBRARY) {
        say(
            "ANOTHER VERSION",
            format!("{library} wrote the file; {LIBRARY} reads it."),
        );
    }
}

/// What is no navigation of a patient in real time says so.
fn kind(found: &Gathered, say: &mut impl FnMut(&'static str, String)) {
    let report = found.basis.run_report();
    let remade = found.basis.run.get("remade_from");
    if let Some(of) = report
        .and_then(|report| report.replay.as_ref())
        .map(|replay| &replay.recording)
        .or(remade)
    {
        say(
            "REPLAY",
            format!("This is a recording of a replay of {of}: nobody navigated. Its poses were made again."),
        );
    }
    if report.is_some_and(|report| report.simulated_time) {
        say(
            "SIMULATED TIME",
            "The run went in simulated time: no duration and no latency says how fast anything was.".to_owned(),
        );
    }
    let is_simulated = found.basis.scene_facts().is_some_and(|scene| scene.is_simulated);
    if is_simulated || found.tip.truths > 0 {
        say(
            "SIMULATED TOOL",
            "The tool was simulated: no patient was navigated.".to_owned(),
        );
    }
    if !found.basis.imported.is_empty() {
        let of = found.basis.imported.get("file").cloned().unwrap_or_default();
        say(
            "IMPORTED",
            format!("The poses were imported from a sequence ({of}); no run was recorded."),
        );
    }
}

fn confirmations(found: &Gathered, say: &mut impl FnMut(&'static str, String)) {
    let navigated = found.story.navigated;
    if found.story.is_research {
        say("RESEARCH", "Confirmations could be skipped in this run.".to_owned());
    }
    let said = [
        (
            navigated.ever(Workflow::NOT_CHECKED),
            "NOT CHECKED",
            "The run navigated on a registration that no check had passed.",
        ),
        (
            navigated.ever(Workflow::CHECK_FAILED),
            "CHECK FAILED",
            "The run navigated on a registration whose check had failed.",
        ),
        (
            navigated.ever(Workflow::BUMPED),
            "MARKER PUSHED",
            "The run navigated though the marker on the patient had been pushed.",
        ),
        (
            navigated.ever(Workflow::REJECTED),
            "IDENTITY REJECTED",
            "The run navigated though somebody had said that the examination is another patient's.",
        ),
        (
            navigated.ever_without(Workflow::CONFIRMED),
            "IDENTITY NOT CONFIRMED",
            "The run navigated without anybody's word that the examination is the patient's.",
        ),
    ];
    for (holds, word, words) in said {
        if holds {
            say(word, words.to_owned());
        }
    }
}

fn contents(found: &Gathered, say: &mut impl FnMut(&'static str, String)) {
    if found.poses.samples == 0 {
        say(
            "NO POSES",
            "The recording holds no sample of the tool that can be read.".to_owned(),
        );
    }
    let [stale, lost] = found.limits_ms();
    let assumed =
        format!("the limits of a scene that names none were taken: stale after {stale} ms, lost after {lost} ms.");
    match &found.basis.scene {
        None => say("NO SCENE", format!("The recording holds no scene; {assumed}")),
        Some(Err(why)) => say(
            "SCENE NOT READ",
            format!("The attached scene cannot be read ({why}); {assumed}"),
        ),
        Some(Ok(scene)) if [scene.stale_ms, scene.lost_ms] != [stale, lost] => {
            say(
                "SCENE CAME LATE",
                format!("The scene lies behind the first sample; {assumed}"),
            );
        }
        Some(Ok(_)) => {}
    }
    match &found.basis.report {
        None => say(
            "NO RUN REPORT",
            "The run's own report is not attached: what it found wrong is not known.".to_owned(),
        ),
        Some(Err(why)) => say(
            "RUN REPORT NOT READ",
            format!("The run's own report cannot be read: {why}."),
        ),
        Some(Ok(report)) if !report.problems.is_empty() => {
            say(
                "PROBLEMS",
                format!(
                    "The run's own report names {} problems; they are listed below.",
                    report.problems.len()
                ),
            );
        }
        Some(Ok(_)) => {}
    }
}

/// Images that a model had a part in say so; whoever reads of a session must know it too.
fn model(found: &Gathered, say: &mut impl FnMut(&'static str, String)) {
    if !found.basis.moves_organs() && found.organs.states.is_empty() {
        return;
    }
    let mut words = "Images could show organs where a model had them, moved by the tube: such a place was computed, \
                     and nobody saw it. "
        .to_owned();
    let mut twice = None;
    match found.basis.images_of_organs() {
        Some(tissue) => {
            let (moved, all) = (tissue.moved(), tissue.all());
            words += &format!(
                "Of {all} first images of a pose in the whole run {moved} did, {} of them by a state that had not settled; the others showed \
                 organs at rest, or none.",
                tissue.count(TissueShown::Approximate)
            );
            let images = tissue.covered_twice;
            twice = (images > 0).then(|| format!("On {images} images tissue lay over itself, which no tissue does."));
        }
        None => {
            words += &format!(
                "How many images did is not known: the run's own report does not say. {} settled states are recorded.",
                found.organs.count(TissueState::Settled)
            );
        }
    }
    say("MODEL", words);
    if let Some(words) = twice {
        say("TISSUE COVERED TWICE", words);
    }
}
