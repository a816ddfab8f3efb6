//! The study file as it is written: every key may be left out, none may be unknown.

use serde::Deserialize;

/// The whole file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawStudy {
    pub(super) seed: Option<u64>,
    pub(super) operations: Option<u64>,
    pub(super) display: Option<String>,
    #[serde(default)]
    pub(super) all: RawDials,
    pub(super) sweep: Option<toml::Table>,
    #[serde(default)]
    pub(super) stratum: Vec<RawDials>,
}

/// What a stratum may set.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct RawDials {
    /// Of strata alone, as the next.
    pub(super) name: Option<String>,
    pub(super) operations: Option<u64>,
    pub(super) display: Option<String>,
    pub(super) targets: Option<Vec<String>>,
    pub(super) radius_mm: Option<f64>,
    pub(super) ct: RawCt,
    pub(super) beads: RawBeads,
    pub(super) registration: Option<String>,
    pub(super) surface: Option<RawSurface>,
    pub(super) marker: RawMarker,
    pub(super) reference: RawReference,
    pub(super) localizer: RawLocalizer,
    pub(super) calibration: RawCalibration,
    pub(super) touch: RawTouch,
    pub(super) check: RawCheck,
    pub(super) occlusion: RawOcclusion,
    pub(super) breathing: RawBreathing,
    pub(super) tissue: RawTissue,
    pub(super) bump: RawBump,
    pub(super) planted: RawPlanted,
}

#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct RawCt {
    pub(super) spacing_mm: Option<[f64; 3]>,
    pub(super) noise_hu: Option<f64>,
    pub(super) images: Option<u64>,
    pub(super) fresh: Option<bool>,
}

#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct RawBeads {
    pub(super) diameter_mm: Option<f64>,
    pub(super) touched: Option<u64>,
    pub(super) places: Option<String>,
    pub(super) at_mm: Option<Vec<[f64; 3]>>,
}

#[derive(Debug, Clone, Copy, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct RawSurface {
    pub(super) share: Option<f64>,
    pub(super) every: Option<u64>,
    pub(super) speed_percent: Option<f64>,
    pub(super) guess_mm: Option<f64>,
    pub(super) wire_images: Option<u64>,
    pub(super) phantom_mm: Option<f64>,
    pub(super) phantom_deg: Option<f64>,
}

#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct RawMarker {
    pub(super) emitters: Option<u64>,
    pub(super) radius_mm: Option<f64>,
    pub(super) width: Option<f64>,
    pub(super) cone_deg: Option<f64>,
    pub(super) made_mm: Option<f64>,
}

#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct RawLocalizer {
    pub(super) across_mm: Option<f64>,
    pub(super) depth_mm: Option<f64>,
    pub(super) rate_hz: Option<f64>,
    pub(super) latency_ms: Option<f64>,
    pub(super) uptime_s: Option<f64>,
    pub(super) turned_deg: Option<f64>,
    pub(super) moved_mm: Option<[f64; 3]>,
}

#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct RawReference {
    pub(super) turned_deg: Option<f64>,
}

#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct RawCalibration {
    pub(super) marker_frames: Option<u64>,
    pub(super) pivot_s: Option<f64>,
    pub(super) seat_mm: Option<f64>,
    pub(super) seat_deg: Option<f64>,
}

#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct RawTouch {
    pub(super) error_mm: Option<f64>,
    pub(super) stated_mm: Option<f64>,
    pub(super) tremor_mm: Option<f64>,
    pub(super) seconds: Option<f64>,
}

#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct RawCheck {
    pub(super) max_mm: Option<f64>,
}

#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct RawOcclusion {
    pub(super) share: Option<f64>,
    pub(super) every_s: Option<f64>,
}

#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct RawBreathing {
    pub(super) mm: Option<f64>,
    pub(super) period_s: Option<f64>,
}

#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct RawTissue {
    pub(super) scene: Option<String>,
    pub(super) aimed: Option<String>,
    pub(super) told: Option<String>,
    pub(super) rate_hz: Option<f64>,
}

#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct RawBump {
    pub(super) share: Option<f64>,
    pub(super) mm: Option<f64>,
    pub(super) deg: Option<f64>,
}

#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct RawPlanted {
    pub(super) link: Option<String>,
    pub(super) mm: Option<f64>,
    pub(super) understated: Option<f64>,
}
