//! A marker as the table of a scene.

use std::fmt::Write;

use crate::calibration::{EmitterRecord, MarkerRecord};

/// How far to each side an emitter shines where nothing says: an infrared diode, degrees.
const CONE_DEG: f64 = 60.0;

/// `[tracker.room.marker]`, ready to be pasted; `cone_deg` is the half-angle in which emitters with a normal are seen.
///
/// # Errors
/// The emitters without a place, by number: a scene has none without.
pub(crate) fn table(marker: &MarkerRecord, name: &str, cone_deg: Option<f64>) -> Result<String, Vec<usize>> {
    let missing = |i: &usize| marker.emitters[*i].is_none();
    let list: Vec<usize> = (0..marker.emitters.len()).filter(missing).collect();
    if !list.is_empty() {
        return Err(list);
    }
    let mut text = format!("[tracker.room.marker]         # {name}, mm\nemitters = [\n");
    for emitter in marker.emitters.iter().flatten() {
        let place = numbers(emitter.at_mm, 4);
        let normal = emitter.normal.map(|n| format!(", normal = {}", numbers(n, 6)));
        // Writing to a string does not fail.
        let _ = writeln!(text, "  {{ at_mm = {place}{} }},", normal.unwrap_or_default());
    }
    text.push_str("]\n");
    if marker
        .emitters
        .iter()
        .flatten()
        .any(|e: &EmitterRecord| e.normal.is_some())
    {
        let _ = writeln!(
            text,
            "cone_deg = {:.1}               # an emitter is seen this far to each side",
            cone_deg.unwrap_or(CONE_DEG)
        );
    }
    Ok(text)
}

fn numbers(v: [f64; 3], digits: usize) -> String {
    // No zero with a sign.
    let [x, y, z] = v.map(|x| {
        if x.abs() < 0.5 * 10.0_f64.powi(-(digits as i32)) {
            0.0
        } else {
            x
        }
    });
    format!("[{x:.digits$}, {y:.digits$}, {z:.digits$}]")
}
