//! `[tracker.calibration]` and `[tracker.registration]`: files, and the gates that they are held against.

use std::ops::RangeInclusive;

use super::super::raw::{RawTracker, RawTrackerSource};
use super::super::values::{Checked, invalid, number};
use super::check::{name, path};
use super::raw::{RawCalibrationGates, RawRegistrationGates};
use super::{CalibrationGates, CalibrationLink, LinkFile, LinkFiles, RegistrationGates, RegistrationLink};

/// Gates in mm: a gate of 0 would accept nothing that was measured.
const GATE_MM: RangeInclusive<f64> = 1e-3..=1e3;
/// A condition is 1 at the least.
const CONDITION: RangeInclusive<f64> = 1.0..=1e9;
/// A cone has a half opening up to a right angle.
const CONE_DEG: RangeInclusive<f64> = 0.1..=90.0;

/// The files of the chain's constants, which only a chain has.
pub(in super::super) fn link_files(raw: &RawTracker) -> Checked<LinkFiles> {
    let has_chain = !matches!(raw.source, RawTrackerSource::Simulated | RawTrackerSource::External);
    let tables = [
        ("calibration", raw.calibration.is_some()),
        ("registration", raw.registration.is_some()),
    ];
    if let Some((table, _)) = tables.iter().find(|(_, there)| *there && !has_chain) {
        let allowed =
            "no such table unless tracker.source is \"operating-room\", \"emitters\", \"markers\" or \"sequence\"";
        return Err(invalid(format!("tracker.{table}"), "a table", allowed));
    }
    let calibration = raw.calibration.as_ref().map(|raw| {
        Ok(CalibrationLink {
            file: link("tracker.calibration", &raw.file, raw.marker.as_deref())?,
            gates: calibration_gates(&raw.gates)?,
        })
    });
    let registration = raw.registration.as_ref().map(|raw| {
        Ok(RegistrationLink {
            file: link("tracker.registration", &raw.file, raw.marker.as_deref())?,
            unchecked_ct: raw.unchecked_ct,
            gates: registration_gates(&raw.gates)?,
        })
    });
    Ok(LinkFiles {
        calibration: calibration.transpose()?,
        registration: registration.transpose()?,
    })
}

fn link(key: &str, file: &str, marker: Option<&str>) -> Checked<LinkFile> {
    Ok(LinkFile {
        path: path(&format!("{key}.file"), file)?,
        marker: marker.map(|n| name(&format!("{key}.marker"), n)).transpose()?,
    })
}

/// A gate that may be absent.
fn gate(key: String, value: Option<f64>, range: RangeInclusive<f64>, unit: &str) -> Checked<Option<f64>> {
    value.map(|value| number(&key, value, range, unit)).transpose()
}

fn calibration_gates(raw: &RawCalibrationGates) -> Checked<CalibrationGates> {
    let key = |name: &str| format!("tracker.calibration.gates.{name}");
    let cone_deg = gate(key("min_cone_deg"), raw.min_cone_deg, CONE_DEG, "degrees")?;
    Ok(CalibrationGates {
        max_rms_mm: gate(key("max_rms_mm"), raw.max_rms_mm, GATE_MM, "mm")?,
        max_tip_error_mm: gate(key("max_tip_error_mm"), raw.max_tip_error_mm, GATE_MM, "mm")?,
        max_condition: gate(key("max_condition"), raw.max_condition, CONDITION, "")?,
        min_cone_rad: cone_deg.map(f64::to_radians),
    })
}

fn registration_gates(raw: &RawRegistrationGates) -> Checked<RegistrationGates> {
    let key = |name: &str| format!("tracker.registration.gates.{name}");
    Ok(RegistrationGates {
        max_fre_mm: gate(key("max_fre_mm"), raw.max_fre_mm, GATE_MM, "mm")?,
        max_condition: gate(key("max_condition"), raw.max_condition, CONDITION, "")?,
        max_tre_mm: gate(key("max_tre_mm"), raw.max_tre_mm, GATE_MM, "mm")?,
    })
}
