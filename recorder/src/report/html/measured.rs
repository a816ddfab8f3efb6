//! What was measured: times of the states, errors at the tip, latencies; each as a drawing and in numbers.

use super::axis::TimeAxis;
use super::curve::{self, Course};
use super::strip;
use super::table::{pairs, paragraph, table};
use super::units::{length, moment, number};
use crate::report::facts::Facts;
use crate::report::quantity::Spread;

/// The times of the states.
pub(super) fn states(facts: &Facts, time: &TimeAxis) -> String {
    let mut page = String::from("<section class=\"page\">\n<h2>What happened when</h2>\n");
    if facts.recording.span_ns.is_none() {
        return page + &paragraph("There are no messages.") + "</section>\n";
    }
    page += &strip::draw(facts, time);
    let whole = facts.length_ns();
    let share = |ns: u64| format!("{:.1} %", 100.0 * ns as f64 / whole.max(1) as f64);
    let row = |(state, ns): &(String, u64)| vec![state.clone(), length(*ns), share(*ns)];
    let mut rows: Vec<_> = facts.states_ns.iter().map(row).collect();
    rows.push(vec![
        "<strong>together</strong>".to_owned(),
        length(whole),
        share(whole),
    ]);
    page += &table(&["State", "Time", "Share"], &rows).unwrap_or_default();
    page += &paragraph(
        "By the captures of the samples: a moment is live where the newest sample captured by then had a pose and was not older than \
         the limit, stale where it was older, lost where there was no pose. Where samples are missing, what is older than \
         the limit is lost: whether they were never made or never recorded is not known. No gap counts as live beyond the limit.",
    );
    page + &samples(facts) + &longest(facts) + "</section>\n"
}

fn samples(facts: &Facts) -> String {
    let poses = &facts.poses;
    let reasons: Vec<String> = poses.lost.iter().map(|(why, n)| format!("{n} {why}")).collect();
    let reasons = if reasons.is_empty() {
        String::new()
    } else {
        format!(" ({})", reasons.join(", "))
    };
    let lost: u64 = poses.lost.values().sum();
    pairs(&[
        (
            "Samples",
            format!(
                "{}: {} with a pose, {lost} without{reasons}, {} refused",
                poses.samples, poses.valid, poses.refused
            ),
        ),
        (
            "Missing samples",
            format!(
                "{} numbers never came; the numbers began anew {} times",
                poses.missing, poses.counted_anew
            ),
        ),
    ])
}

fn longest(facts: &Facts) -> String {
    if facts.lost_times == 0 {
        return paragraph("The pose was never lost.");
    }
    let row = |span: &crate::report::states::LostSpan| {
        let ns = (span.to_ns - span.from_ns).unsigned_abs();
        vec![moment(span.from_ns), length(ns), span.why.to_owned()]
    };
    let rows: Vec<_> = facts.lost_longest.iter().map(row).collect();
    let table = table(&["From, min:s", "For", "Why, at its beginning"], &rows).unwrap_or_default();
    paragraph(&format!("The pose was lost {} times; the longest:", facts.lost_times)) + &table
}

/// The errors at the tip.
pub(super) fn tip(facts: &Facts, time: &TimeAxis) -> String {
    let mut page = String::from("<section class=\"page\">\n<h2>Error at the tip</h2>\n");
    let (curves, tip) = (&facts.curves, &facts.tip);
    let predicted = Course {
        name: "predicted, 95 % of errors are below",
        of: &curves.predicted,
        class: "line",
    };
    let found = Course {
        name: "true, of the simulated tool",
        of: &curves.found,
        class: "band",
    };
    // The true one first: the prediction is drawn over it.
    let courses: Vec<Course<'_>> = match tip.true_mm {
        Some(_) => vec![found, predicted],
        None => vec![predicted],
    };
    if tip.predicted_95_mm.is_none() && tip.true_mm.is_none() {
        page += &paragraph("<strong>UNKNOWN</strong>: no pose of the recording says how large its error is.");
    } else {
        page += &curve::draw("Error at the tip over the time of the run", "mm", time, &courses);
    }
    let rows = [
        spread("predicted with each pose, 95 %", tip.predicted_95_mm, "mm"),
        spread("true, against the simulated tool", tip.true_mm, "mm"),
    ];
    page += &table(
        &[
            "Error at the tip",
            "Poses",
            "Least",
            "Median",
            "95 %",
            "99 %",
            "Largest",
        ],
        &rows,
    )
    .unwrap_or_default();
    if tip.unknown > 0 {
        page += &paragraph(&format!(
            "Of {} poses the error is <strong>UNKNOWN</strong>: the source predicts none.",
            tip.unknown
        ));
    }
    match tip.true_mm {
        None => page += &paragraph("No true poses are recorded: only a simulation has them."),
        Some(_) if tip.compared > 0 => {
            let share = 100.0 * tip.beyond as f64 / tip.compared as f64;
            page += &paragraph(&format!(
                "{} of {} poses ({share:.1} %) lie further from the truth than predicted; 5 % are to be expected.",
                tip.beyond, tip.compared
            ));
        }
        Some(_) => {}
    }
    page += &paragraph(
        "The predicted error holds what calibration, registration and noise are said to be; it knows nothing of tissue that moved.",
    );
    page + "</section>\n"
}

/// A row of a table: how the numbers are spread.
pub(super) fn spread(name: &str, spread: Option<Spread>, unit: &str) -> Vec<String> {
    let mut row = vec![name.to_owned()];
    match spread {
        Some(Spread {
            count,
            min,
            p50,
            p95,
            p99,
            max,
        }) => {
            row.push(count.to_string());
            row.extend([min, p50, p95, p99, max].map(|value| format!("{} {unit}", number(value))));
        }
        None => {
            row.push("0".to_owned());
            row.extend(std::iter::repeat_n("UNKNOWN".to_owned(), 5));
        }
    }
    row
}

/// The latencies.
pub(super) fn latency(facts: &Facts, time: &TimeAxis) -> String {
    let mut page = String::from("<section>\n<h2>Latency</h2>\n");
    if facts.latency_ms.is_some() {
        let course = Course {
            name: "from capture to publication",
            of: &facts.curves.latency,
            class: "line",
        };
        page += &curve::draw("Latency over the time of the run", "ms", time, &[course]);
    }
    let report = facts.basis.run_report();
    if report.is_some_and(|report| report.simulated_time) {
        page += &paragraph("<strong>SIMULATED TIME</strong>: these numbers say nothing of how fast anything was.");
    }
    let mut rows = vec![spread(
        "from capture to publication, by the recording",
        facts.latency_ms,
        "ms",
    )];
    let stages = report.into_iter().flat_map(|report| &report.latency_ms);
    // The report of the run has no least one.
    rows.extend(stages.map(|(stage, l)| {
        let numbers = [l.p50, l.p95, l.p99, l.max].map(|value| format!("{} ms", number(value)));
        let mut row = vec![stage_words(stage), l.count.to_string(), "-".to_owned()];
        row.extend(numbers);
        row
    }));
    page += &table(
        &["Latency", "Samples", "Least", "Median", "95 %", "99 %", "Largest"],
        &rows,
    )
    .unwrap_or_default();
    if facts.latency_unknown > 0 {
        page += &paragraph(&format!(
            "{} samples were published before they were captured: their latency is UNKNOWN.",
            facts.latency_unknown
        ));
    }
    if report.is_none_or(|report| report.latency_ms.is_empty()) {
        page += &paragraph(
            "The way from publication to the pixels is not in the recording, and no report of the run is attached that tells of it.",
        );
    }
    page + "</section>\n"
}

/// A stage of the run's report in words.
fn stage_words(stage: &str) -> String {
    let words = match stage {
        "capture_to_publish" => "from capture to publication, by the run, of what images showed",
        "capture_to_publish_all" => "from capture to publication, by the run",
        "publish_to_seen" => "from publication to the renderer",
        "seen_to_rendered" => "drawing",
        "rendered_to_framed" => "handing over",
        "pose_to_pixels" => "from capture to the image, as a whole",
        other => return super::escape::own(other),
    };
    words.to_owned()
}
