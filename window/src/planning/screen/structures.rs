//! The structures of the label map beside the selected way, in words: nearest first, with what is left of each distance at least.

use guidance::safety::{Clearance, Distance};

use super::super::labels::{Beside, Found, WITHIN_MM};
use super::Known;
use crate::model::Tone;
use crate::screen::lines::Lines;

/// So many structures are named.
const NAMED: usize = 5;

pub(super) fn show(known: &Known<'_>, lines: &mut Lines<'_, '_>) {
    match known.beside {
        Beside::NotGiven => lines.put("STRUCTURES NOT CHECKED: there is no label map", Tone::Warning),
        Beside::Reading => lines.put("STRUCTURES NOT CHECKED: the label map is being read", Tone::Warning),
        Beside::Refused(why) => lines.put(&format!("STRUCTURES NOT CHECKED: {why}"), Tone::Alarm),
        Beside::NoWay => {}
        Beside::Found(found) => named(found, known.error_mm, lines),
    }
}

fn named(found: &Found, error_mm: Option<f64>, lines: &mut Lines<'_, '_>) {
    if found.grid.is_doubtful() {
        lines.put_all(&found.grid.to_string(), Tone::Warning);
    }
    for doubt in found.doubts.iter() {
        lines.put_all(&format!("The label map: {doubt}"), Tone::Warning);
    }
    for [from, to] in found.clearances.coverage.outside_mm() {
        let text = format!("NOT CHECKED from {from:.1} to {to:.1} mm: outside the label map");
        lines.put(&text, Tone::Alarm);
    }
    if let Some(mm) = found.clearances.coverage.nearer_than(error_mm) {
        let text = format!("NOT CHECKED beyond {mm:.1} mm beside the way: the label map ends");
        lines.put(&text, Tone::Alarm);
    }
    let near = found.clearances.structures.iter();
    let near: Vec<&Clearance> = near
        .filter(|one| matches!(one.distance, Distance::Nearest(_)))
        .collect();
    if near.is_empty() {
        lines.put(
            &format!("no structure of the label map within {WITHIN_MM} mm"),
            Tone::Quiet,
        );
    }
    for one in near.iter().take(NAMED) {
        let (text, tone) = words(one, &found.names.words(one.label), error_mm);
        // A name may be longer than a line, and what follows it is numbers.
        lines.put_all(&text, tone);
    }
    let rest = near.get(NAMED..).unwrap_or_default();
    if !rest.is_empty() {
        let are_clear = rest.iter().all(|one| one.is_clear_within(error_mm));
        let tone = if are_clear { Tone::Quiet } else { Tone::Alarm };
        lines.put(&format!("{} more structures within {WITHIN_MM} mm", rest.len()), tone);
    }
    if error_mm.is_none() {
        lines.put("ERROR UNKNOWN: no distance is lessened by it", Tone::Warning);
    }
}

fn words(one: &Clearance, what: &str, error_mm: Option<f64>) -> (String, Tone) {
    let Distance::Nearest(nearest) = one.distance else {
        return (String::new(), Tone::Quiet);
    };
    let at = format!("{:.1} mm deep", nearest.depth_mm);
    match (one.cuts, one.is_clear(), one.at_least_mm(error_mm)) {
        (true, ..) => (format!("CUTS {what}, {at}"), Tone::Alarm),
        (false, false, _) => (format!("MAY CUT {what}, {at}"), Tone::Alarm),
        (false, true, _) if !one.is_clear_within(error_mm) => {
            let text = format!("{what}: {:.1} mm, {at}: WITHIN THE ERROR", nearest.distance_mm);
            (text, Tone::Warning)
        }
        (false, true, Some(least)) => {
            let text = format!("{what}: {:.1} mm, at least {least:.1}, {at}", nearest.distance_mm);
            (text, Tone::Quiet)
        }
        (false, true, None) => (format!("{what}: {:.1} mm, {at}", nearest.distance_mm), Tone::Quiet),
    }
}
