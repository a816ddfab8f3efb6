//! What the localizers delivered.

use super::escape::text;
use super::measured::spread;
use super::table::{paragraph, table};
use crate::report::facts::Facts;
use crate::report::localizer::{DeviceFacts, MarkerFacts};

/// The section; nothing where no poses of markers are recorded.
pub(super) fn section(facts: &Facts) -> String {
    let found = &facts.localizers;
    if found.devices.is_empty() {
        return String::new();
    }
    let mut page = String::from("<section>\n<h2>Localizer</h2>\n");
    found.devices.iter().for_each(|device| page += &one(device));
    if found.other_frames > 0 {
        page += &paragraph(&format!(
            "{} frames of further localizers are not listed.",
            found.other_frames
        ));
    }
    page + "</section>\n"
}

fn one(device: &DeviceFacts) -> String {
    let name = match device.name.as_str() {
        "" => "The localizer has no name".to_owned(),
        name => text(name),
    };
    let arrived = device.frames - device.mapped;
    let mut page = paragraph(&format!(
        "{name}: {} frames. The capture of {} is the localizer's own stamp, mapped onto the run's clock; of {arrived} it is the arrival, \
         whose lateness is <strong>UNKNOWN</strong>.",
        device.frames, device.mapped
    ));
    let rows = [
        spread("from capture to arrival, mapped frames", device.late_ms, "ms"),
        spread("stated uncertainty of the mapped capture", device.uncertain_ms, "ms"),
    ];
    if device.mapped > 0 {
        let heads = ["Clock", "Frames", "Least", "Median", "95 %", "99 %", "Largest"];
        page += &table(&heads, &rows).unwrap_or_default();
        page += &paragraph(
            "Without the link's least delay, which no stamp shows: the scene states it (<code>least_delay_ms</code>).",
        );
    }
    for (count, what) in [
        (
            device.late_unknown,
            "mapped frames arrived before they were captured: how late they came is UNKNOWN.",
        ),
        (device.refused, "frames name a marker twice, or too many markers."),
    ] {
        if count > 0 {
            page += &paragraph(&format!("{count} {what}"));
        }
    }
    let rows: Vec<_> = device.markers.iter().map(marker).collect();
    page + &table(&["Marker", "Frames with a pose", "Frames without, and why"], &rows).unwrap_or_default()
}

fn marker(marker: &MarkerFacts) -> Vec<String> {
    let whose = match marker.marker {
        0 => "0, on the tool".to_owned(),
        1 => "1, on the patient".to_owned(),
        other => other.to_string(),
    };
    let lost: Vec<String> = marker
        .lost
        .iter()
        .map(|(why, count)| format!("{count} {why}"))
        .collect();
    vec![whose, marker.seen.to_string(), lost.join(", ")]
}
