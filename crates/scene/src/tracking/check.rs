//! From the raw tables to the checked ones.

use std::ops::RangeInclusive;
use std::path::PathBuf;
use std::time::Duration;

use geometry::{Frame, Rigid, checked};

use super::super::operating_room::{Deviations, check as shared};
use super::super::raw::{RawRigid, RawTracker, RawTrackerSource};
use super::super::values::{Checked, UNIT_TOLERANCE, invalid, number};
use super::raw::{RawEmitterSource, RawMarkerSource, RawNoise, RawSequence};
use super::{EmitterSource, MarkerSource, Noise, PosedMarkers, SequenceSource};

/// The longest name of a marker or transform, bytes.
const NAME_BYTES: usize = 64;

pub(in super::super) fn emitters(raw: &RawEmitterSource, tool_mm: f64) -> Checked<EmitterSource> {
    let at = "tracker.emitters";
    let key = |name: &str| format!("{at}.{name}");
    Ok(EmitterSource {
        marker: shared::marker(&key("marker"), &raw.marker)?,
        marker_from_tool: shared::marker_from_tool(&key("marker"), &raw.marker, tool_mm)?,
        reference: raw
            .reference
            .as_ref()
            .map(|on| shared::reference(&key("reference"), on))
            .transpose()?,
        noise: noise(&raw.localizer)?,
        gates: shared::gates(&key("gates"), &raw.gates)?,
        reference_gates: shared::gates(&key("reference_gates"), &raw.reference_gates)?,
    })
}

/// Deviations above 0, as emitters are weighted by their inverse squares, and within a factor of 50 of each other, so that
/// these can be inverted.
fn noise(raw: &RawNoise) -> Checked<Noise> {
    let within = |name: &str, value: f64, range: RangeInclusive<f64>, unit: &str| {
        number(&format!("tracker.emitters.localizer.{name}"), value, range, unit)
    };
    let across_mm = within("across_mm", raw.across_mm, 1e-3..=50.0, "mm")?;
    let ratio = across_mm / 50.0..=across_mm * 50.0;
    Ok(Noise {
        across_mm,
        depth_mm: within("depth_mm", raw.depth_mm, ratio, "mm, as across_mm is what it is")?,
        at_mm: within("at_mm", raw.at_mm, 1.0..=1e5, "mm")?,
        growth_across: within("growth_across", raw.growth_across, 0.0..=4.0, "")?,
        growth_depth: within("growth_depth", raw.growth_depth, 0.0..=4.0, "")?,
        quantisation_mm: within("quantisation_mm", raw.quantisation_mm, 0.0..=10.0, "mm")?,
    })
}

pub(in super::super) fn sequence(raw: &RawSequence) -> Checked<SequenceSource> {
    let at = "tracker.sequence";
    Ok(SequenceSource {
        file: path(&format!("{at}.file"), &raw.file)?,
        markers: posed(
            at,
            &RawPosed {
                marker: raw.marker.as_deref(),
                reference: raw.reference.as_deref(),
                marker_from_tool: &raw.marker_from_tool,
                ct_from_reference: &raw.ct_from_reference,
                noise_mm: raw.noise_mm,
                noise_deg: raw.noise_deg,
            },
        )?,
    })
}

pub(in super::super) fn markers(raw: &RawMarkerSource) -> Checked<MarkerSource> {
    let at = "tracker.markers";
    let gate = |mm| number(&format!("{at}.max_error_mm"), mm, 1e-3..=1e3, "mm");
    Ok(MarkerSource {
        markers: posed(
            at,
            &RawPosed {
                marker: raw.marker.as_deref(),
                reference: raw.reference.as_deref(),
                marker_from_tool: &raw.marker_from_tool,
                ct_from_reference: &raw.ct_from_reference,
                noise_mm: raw.noise_mm,
                noise_deg: raw.noise_deg,
            },
        )?,
        max_error_mm: raw.max_error_mm.map(gate).transpose()?,
    })
}

/// The keys that both tables have.
struct RawPosed<'a> {
    marker: Option<&'a str>,
    reference: Option<&'a str>,
    marker_from_tool: &'a RawRigid,
    ct_from_reference: &'a RawRigid,
    noise_mm: Option<f64>,
    noise_deg: f64,
}

fn posed(at: &str, raw: &RawPosed<'_>) -> Checked<PosedMarkers> {
    let key = |name: &str| format!("{at}.{name}");
    if raw.reference.is_none() && *raw.ct_from_reference != RawRigid::default() {
        let allowed = format!("no such table unless {at}.reference names a marker");
        return Err(invalid(key("ct_from_reference"), "a table", allowed));
    }
    if raw.reference.is_some() && raw.reference == raw.marker {
        let found = format!("{:?}", raw.marker.unwrap_or_default());
        return Err(invalid(
            key("reference"),
            found,
            format!("another one than {at}.marker"),
        ));
    }
    let turn = number(&key("noise_deg"), raw.noise_deg, 0.0..=45.0, "degrees")?;
    let shift = raw.noise_mm.map(|mm| number(&key("noise_mm"), mm, 0.0..=50.0, "mm"));
    Ok(PosedMarkers {
        marker: raw.marker.map(|n| name(&key("marker"), n)).transpose()?,
        marker_from_tool: rigid(&key("marker_from_tool"), raw.marker_from_tool)?,
        reference: match raw.reference {
            Some(marker) => Some((
                name(&key("reference"), marker)?,
                rigid(&key("ct_from_reference"), raw.ct_from_reference)?,
            )),
            None => None,
        },
        noise: shift.transpose()?.map(|shift_mm| Deviations {
            shift_mm,
            turn_rad: turn.to_radians(),
        }),
    })
}

pub(in super::super) fn smoothing(raw: &RawTracker) -> Checked<Option<Duration>> {
    let Some(smoothing) = &raw.smoothing else {
        return Ok(None);
    };
    if raw.source == RawTrackerSource::External {
        let allowed = "no such table with tracker.source = \"external\": poses are shown as they come";
        return Err(invalid("tracker.smoothing", "a table", allowed));
    }
    let key = "tracker.smoothing.time_constant_ms";
    let ms = number(key, smoothing.time_constant_ms, 1.0..=1000.0, "ms")?;
    Ok(Some(Duration::from_secs_f64(ms / 1e3)))
}

pub(super) fn path(key: &str, text: &str) -> Checked<PathBuf> {
    // A path that was empty in the scene is its folder.
    if text.is_empty() || text.ends_with('/') {
        return Err(invalid(key, format!("{text:?}"), "the path of a file"));
    }
    Ok(PathBuf::from(text))
}

pub(super) fn name(key: &str, text: &str) -> Checked<String> {
    if text.is_empty() || text.len() > NAME_BYTES {
        return Err(invalid(key, format!("{text:?}"), format!("1 to {NAME_BYTES} bytes")));
    }
    Ok(text.to_owned())
}

fn rigid<To: Frame, From: Frame>(key: &str, raw: &RawRigid) -> Checked<Rigid<To, From>> {
    checked::rigid(raw.quaternion, raw.translation_mm, UNIT_TOLERANCE).map_err(|e| {
        let found = format!("{:?}, {:?}", raw.quaternion, raw.translation_mm);
        invalid(key, found, e.to_string())
    })
}
