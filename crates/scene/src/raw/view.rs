//! A view as it is written.

use serde::{Deserialize, Serialize};

use crate::sampling::{Filter, Minify, Slab};

/// `[[views]]`
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawView {
    /// Names the topic and the PNG.
    pub name: String,
    /// The plane's direction.
    pub plane: Plane,
    /// Whole patient or zoomed at the tip.
    pub extent: Extent,
    /// Width and height, pixels.
    #[serde(default = "default_size")]
    pub size: [u32; 2],
    /// Local views: what the image's shorter side shows, mm.
    #[serde(default = "default_field_mm")]
    pub field_mm: f64,
    /// How voxels are interpolated.
    #[serde(default)]
    pub filter: Filter,
    /// A thickness; absent: a thin slice.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub slab: Option<Slab>,
    /// What pixels larger than a voxel show.
    #[serde(default)]
    pub minify: Minify,
    /// Perpendicular views: how far in front of the tip the plane lies, mm.
    #[serde(default)]
    pub ahead_mm: f64,
    /// How HU become grey.
    #[serde(default)]
    pub window: RawWindow,
    /// Perpendicular views: what points up.
    #[serde(default)]
    pub up: Up,
    /// How large words on the image are.
    #[serde(default = "default_text")]
    pub text: f64,
    /// What is drawn over the slice.
    #[serde(default)]
    pub overlay: Drawn,
    /// Surface views: from where, and of what; absent: from the front.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub surface: Option<RawSurface>,
}

fn default_text() -> f64 {
    1.0
}

fn default_size() -> [u32; 2] {
    [512, 512]
}

fn default_field_mm() -> f64 {
    100.0
}

/// Direction of a slice plane, or the overview in three dimensions; one process renders each.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Plane {
    /// Across the body, seen from the feet.
    Axial,
    /// Coronal, seen from the front.
    Frontal,
    /// Seen from the patient's left.
    Sagittal,
    /// Perpendicular to the tube through its tip, seen along the tube.
    Perpendicular,
    /// No slice: bone and structures as surfaces, seen from a place that stands still.
    Surface,
}

impl Plane {
    /// The name in the scene file.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Axial => "axial",
            Self::Frontal => "frontal",
            Self::Sagittal => "sagittal",
            Self::Perpendicular => "perpendicular",
            Self::Surface => "surface",
        }
    }

    /// The name of the process that renders this direction.
    pub fn process(self) -> String {
        format!("view-{}", self.name())
    }
}

/// How much of the patient an image shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Extent {
    /// The whole examination.
    Global,
    /// A field around the tip.
    Local,
}

/// What points up in a perpendicular image.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Up {
    /// The patient's head.
    #[default]
    Superior,
    /// The patient's front.
    Anterior,
    /// The tool's own +y: the image turns with the handle.
    Tool,
}

/// What is drawn over the slice.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Drawn {
    /// Lines and all words.
    #[default]
    All,
    /// Lines, and the words on what the image claims and rests on: a window around it says the rest.
    State,
}

/// `surface = { from = "left", field_mm = 400, bone_hu = 300 }`
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RawSurface {
    /// From where the patient is seen.
    pub from: RawFrom,
    /// What the image's shorter side shows, mm; absent: the whole examination.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub field_mm: Option<f64>,
    /// Voxels of so many HU and more are bone.
    pub bone_hu: f64,
}

impl Default for RawSurface {
    fn default() -> Self {
        Self {
            from: RawFrom::Named("anterior".to_owned()),
            field_mm: None,
            bone_hu: 300.0,
        }
    }
}

/// A named direction or its angles.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum RawFrom {
    /// `anterior`, `left`, `posterior`, `right`, `head`, `feet`.
    Named(String),
    /// Numbers.
    Angles(RawAngles),
}

/// `from = { azimuth_deg = 30, elevation_deg = 20 }`
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawAngles {
    /// From the front towards the patient's left, degrees.
    pub azimuth_deg: f64,
    /// From there towards the head, degrees.
    #[serde(default)]
    pub elevation_deg: f64,
}

/// A named window or its numbers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum RawWindow {
    /// `abdomen`, `soft-tissue`, `bone`, `lung`, `vessels`.
    Named(String),
    /// Numbers.
    Levels(RawLevels),
}

impl Default for RawWindow {
    fn default() -> Self {
        Self::Named("abdomen".to_owned())
    }
}

/// `window = { centre_hu = 40, width_hu = 400 }`
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawLevels {
    /// The HU shown as middle grey.
    pub centre_hu: f64,
    /// From black to white, HU.
    pub width_hu: f64,
}
