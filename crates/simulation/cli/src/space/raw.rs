//! The scene file of solids in space as it is written: every key known, every type right, nothing else checked.

use std::path::PathBuf;

use serde::Deserialize;

use crate::scene::raw::{Pair, RawUnits};

/// A place or a vector of the patient: LPS, mm.
pub(crate) type Triple = [f64; 3];

/// The whole file.
///
/// Sliding contact of organs with bone or with one another will be a table of its own here; until there is a term for it, the
/// key is unknown and refused as such.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawSpaceScene {
    /// For people: above every picture.
    pub(crate) title: String,
    /// `[units]`: `mm` and `N/mm2`, as the label map's places are mm.
    pub(crate) units: RawUnits,
    /// `[space]`
    pub(crate) space: RawSpace,
    /// `[[organs]]`
    pub(crate) organs: Vec<RawOrgan>,
    /// `[[rigid]]`
    #[serde(default)]
    pub(crate) rigid: Vec<RawRigid>,
    /// `[[attachments]]`
    #[serde(default)]
    pub(crate) attachments: Vec<RawAttachment>,
    /// `[surroundings]`; absent: nothing is around the organs.
    #[serde(default)]
    pub(crate) surroundings: Option<RawSurroundings>,
    /// `[tube]`
    pub(crate) tube: RawTube,
    /// `[[targets]]`
    #[serde(default)]
    pub(crate) targets: Vec<RawTarget>,
    /// `[search]`
    #[serde(default)]
    pub(crate) search: RawSpaceSearch,
    /// `[output]`
    #[serde(default)]
    pub(crate) output: RawSpaceOutput,
}

/// `[space]`: what says that a scene is of solids in space.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawSpace {
    /// The label map, relative to the scene file.
    pub(crate) labels: PathBuf,
    /// SHA-256 of that file, 64 hexadecimal digits: another one is refused.
    #[serde(default)]
    pub(crate) labels_sha256: Option<String>,
    /// For people: what to do where it is not there.
    #[serde(default)]
    pub(crate) obtain: Option<String>,
}

/// `[[organs]]`: a label that is a deformable solid.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawOrgan {
    pub(crate) name: String,
    pub(crate) label: u16,
    #[serde(default)]
    pub(crate) law: RawSpaceLaw,
    /// `[weight, exponent]` of each term of an Ogden law.
    #[serde(default)]
    pub(crate) ogden: Option<Vec<Pair>>,
    /// Young's modulus, N/mm^2.
    pub(crate) young: f64,
    /// Standard deviation of its logarithm.
    #[serde(default)]
    pub(crate) young_spread: Option<f64>,
    pub(crate) poisson: f64,
    /// Standard deviation.
    #[serde(default)]
    pub(crate) poisson_spread: Option<f64>,
    /// Standard deviation of the smoothing of the label's surface, mm.
    pub(crate) smoothing: f64,
    /// What is done about several parts.
    #[serde(default)]
    pub(crate) parts: RawParts,
    #[serde(default)]
    pub(crate) fill_holes: bool,
    pub(crate) cubes: RawCubes,
}

/// The form of the energy.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum RawSpaceLaw {
    StVenantKirchhoff,
    Linear,
    #[default]
    NeoHookean,
    StableNeoHookean,
    Ogden,
}

/// What is done about a label of several parts.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum RawParts {
    #[default]
    Refuse,
    Largest,
}

/// `cubes = { side, levels, within }`
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawCubes {
    /// Side of the largest, mm.
    pub(crate) side: f64,
    /// Times that they are halved near the tube's way.
    #[serde(default)]
    pub(crate) levels: u32,
    /// How near, mm from the axis of the way: of each halving, so as many numbers as levels.
    #[serde(default)]
    pub(crate) within: Vec<f64>,
}

/// `[[rigid]]`: labels that do not move. Organs are attached to them; they are no obstacle.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawRigid {
    pub(crate) name: String,
    pub(crate) labels: Vec<u16>,
}

/// `[[attachments]]`: an organ held by what is rigid, where it is near.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawAttachment {
    pub(crate) organ: String,
    /// Names of `[[rigid]]`.
    pub(crate) to: Vec<String>,
    /// As near as this to a voxel of theirs, mm.
    pub(crate) within: f64,
    pub(crate) kind: RawKind,
    /// Of `tied`: Young's modulus of what is between, N/mm^2.
    #[serde(default)]
    pub(crate) young: Option<f64>,
    /// Of `tied`: standard deviation of the logarithm of that.
    #[serde(default)]
    pub(crate) young_spread: Option<f64>,
    /// Of `tied`: its thickness, mm.
    #[serde(default)]
    pub(crate) margin: Option<f64>,
}

/// How it holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum RawKind {
    /// Nodes keep their place.
    Fixed,
    /// Springs at points of the surface, along and across it.
    Tied,
}

/// `[surroundings]`: a soft bath at every point of a surface that no attachment holds.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawSurroundings {
    /// N/mm^2.
    pub(crate) young: f64,
    /// Standard deviation of its logarithm.
    #[serde(default)]
    pub(crate) young_spread: Option<f64>,
    /// Its thickness, mm.
    pub(crate) margin: f64,
    /// Nearer than this to the axis of the tube's way there is none, mm.
    pub(crate) corridor: f64,
}

/// `[tube]`: rigid, with round ends.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawTube {
    pub(crate) diameter: f64,
    #[serde(default)]
    pub(crate) length: Option<f64>,
    /// Where the tip starts, outside the organs.
    pub(crate) entry: Triple,
    /// A place that it moves towards.
    #[serde(default)]
    pub(crate) target: Option<Triple>,
    /// Or the direction that it moves in.
    #[serde(default)]
    pub(crate) direction: Option<Triple>,
    /// How far it goes from where it first touches, mm.
    pub(crate) stroke: f64,
    /// From state to state, mm.
    pub(crate) step: f64,
}

/// `[[targets]]`: a place of an organ, told and drawn wherever the organ takes it.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawTarget {
    pub(crate) name: String,
    /// At rest.
    pub(crate) at: Triple,
    /// The organ that it must lie in; absent: whichever it lies in.
    #[serde(default)]
    pub(crate) organ: Option<String>,
}

/// `[search]`
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct RawSpaceSearch {
    /// The most Newton steps of one search.
    pub(crate) most_steps: usize,
}

impl Default for RawSpaceSearch {
    fn default() -> Self {
        Self { most_steps: 400 }
    }
}

/// `[output]`
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct RawSpaceOutput {
    /// What cuts show.
    pub(crate) field: RawSpaceField,
    /// Pixels of the picture of the shape.
    pub(crate) size: [u32; 2],
    /// How many states the strip shows, at most.
    pub(crate) strip: usize,
    /// Whether errors of the last state are looked for.
    pub(crate) errors: bool,
}

impl Default for RawSpaceOutput {
    fn default() -> Self {
        Self {
            field: RawSpaceField::Displacement,
            size: [900, 700],
            strip: 6,
            errors: false,
        }
    }
}

/// What cuts show.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum RawSpaceField {
    Displacement,
    VonMises,
}
