//! The scene file of solids in space as it is written: every key known, every type right, nothing else checked.

use std::path::PathBuf;

use serde::Deserialize;

/// A place or a vector of the patient: LPS, mm.
pub type Triple = [f64; 3];

/// `[units]`: names only. Numbers are in them as they stand.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawUnits {
    /// Of every length.
    pub length: String,
    /// Of Young's moduli. Weights are stress by length; forces stress times length squared, in the plane of a unit of depth.
    pub stress: String,
}

/// The whole file.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawSpaceScene {
    /// For people: above every picture.
    pub title: String,
    /// `[units]`: `mm` and `N/mm2`, as the label map's places are mm.
    pub units: RawUnits,
    /// `[space]`
    pub space: RawSpace,
    /// `[[organs]]`
    pub organs: Vec<RawOrgan>,
    /// `[[rigid]]`
    #[serde(default)]
    pub rigid: Vec<RawRigid>,
    /// `[[attachments]]`
    #[serde(default)]
    pub attachments: Vec<RawAttachment>,
    /// `[[contacts]]`
    #[serde(default)]
    pub contacts: Vec<RawContact>,
    /// `[surroundings]`; absent: nothing is around the organs.
    #[serde(default)]
    pub surroundings: Option<RawSurroundings>,
    /// `[tube]`
    pub tube: RawTube,
    /// `[[targets]]`
    #[serde(default)]
    pub targets: Vec<RawTarget>,
    /// `[search]`
    #[serde(default)]
    pub search: RawSpaceSearch,
    /// `[output]`
    #[serde(default)]
    pub output: RawSpaceOutput,
}

/// `[space]`: what says that a scene is of solids in space.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawSpace {
    /// The label map, relative to the scene file.
    pub labels: PathBuf,
    /// SHA-256 of that file, 64 hexadecimal digits: another one is refused.
    #[serde(default)]
    pub labels_sha256: Option<String>,
    /// For people: what to do where it is not there.
    #[serde(default)]
    pub obtain: Option<String>,
}

/// `[[organs]]`: a label that is a deformable solid.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawOrgan {
    /// 1 to 64 characters on one line, of no other organ.
    pub name: String,
    /// Of the label map, above 0.
    pub label: u16,
    /// `law`: the form of the energy.
    #[serde(default)]
    pub law: RawSpaceLaw,
    /// `[weight, exponent]` of each term of an Ogden law.
    #[serde(default)]
    pub ogden: Option<Vec<[f64; 2]>>,
    /// Young's modulus, N/mm^2.
    pub young: f64,
    /// Standard deviation of its logarithm.
    #[serde(default)]
    pub young_spread: Option<f64>,
    /// Poisson's ratio.
    pub poisson: f64,
    /// Standard deviation.
    #[serde(default)]
    pub poisson_spread: Option<f64>,
    /// Standard deviation of the smoothing of the label's surface, mm.
    pub smoothing: f64,
    /// What is done about several parts.
    #[serde(default)]
    pub parts: RawParts,
    /// Whether holes inside the label count as organ.
    #[serde(default)]
    pub fill_holes: bool,
    /// Of its mesh.
    pub cubes: RawCubes,
}

/// The form of the energy.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum RawSpaceLaw {
    /// `st-venant-kirchhoff`
    StVenantKirchhoff,
    /// `linear`: of the symmetric gradient, for small rotations only.
    Linear,
    /// `neo-hookean`: never inverts.
    #[default]
    NeoHookean,
    /// `stable-neo-hookean`: finite at inversion, and pushes back from it.
    StableNeoHookean,
    /// `ogden`: a sum of terms of principal stretches.
    Ogden,
}

/// What is done about a label of several parts.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum RawParts {
    /// The scene is refused.
    #[default]
    Refuse,
    /// The largest is the organ, the others are left out.
    Largest,
}

/// `cubes = { side, levels, within }`
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawCubes {
    /// Side of the largest, mm.
    pub side: f64,
    /// Times that they are halved near the tube's way.
    #[serde(default)]
    pub levels: u32,
    /// How near, mm from the axis of the way: of each halving, so as many numbers as levels.
    #[serde(default)]
    pub within: Vec<f64>,
}

/// `[[rigid]]`: labels that do not move. Organs are attached to them; they are an obstacle to organs of `[[contacts]]` alone.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawRigid {
    /// 1 to 64 characters on one line, of no other table of these.
    pub name: String,
    /// Of the label map, above 0; each of this table alone.
    pub labels: Vec<u16>,
}

/// `[[attachments]]`: an organ held by what is rigid, where it is near.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawAttachment {
    /// Name of one of `[[organs]]`.
    pub organ: String,
    /// Names of `[[rigid]]`.
    pub to: Vec<String>,
    /// As near as this to a voxel of theirs, mm.
    pub within: f64,
    /// `kind`: nodes or springs.
    pub kind: RawKind,
    /// Of `tied`: Young's modulus of what is between, N/mm^2.
    #[serde(default)]
    pub young: Option<f64>,
    /// Of `tied`: standard deviation of the logarithm of that.
    #[serde(default)]
    pub young_spread: Option<f64>,
    /// Of `tied`: its thickness, mm.
    #[serde(default)]
    pub margin: Option<f64>,
}

/// `[[contacts]]`: an organ that slides along what is rigid, without friction, and does not enter it.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawContact {
    /// Name of one of `[[organs]]`.
    pub organ: String,
    /// Names of `[[rigid]]`: one surface around all of them.
    pub with: Vec<String>,
    /// Standard deviation of the smoothing of that surface, mm; absent: as the organ's.
    #[serde(default)]
    pub smoothing: Option<f64>,
    /// Radius of a ball that fits behind that surface wherever the organ comes, mm: how thick it is at least. What is thinner is left out, and refused where the organ comes to it.
    pub ball: f64,
}

/// How it holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum RawKind {
    /// Nodes keep their place.
    Fixed,
    /// Springs at points of the surface, along and across it.
    Tied,
}

/// `[surroundings]`: a soft bath at every point of a surface that no attachment holds.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawSurroundings {
    /// Young's modulus, N/mm^2.
    pub young: f64,
    /// Standard deviation of its logarithm.
    #[serde(default)]
    pub young_spread: Option<f64>,
    /// Its thickness, mm.
    pub margin: f64,
    /// Nearer than this to the axis of the tube's way there is none, mm.
    pub corridor: f64,
}

/// `[tube]`: rigid, with round ends.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawTube {
    /// mm.
    pub diameter: f64,
    /// From the middle of one round end to that of the other, mm; absent: 200.
    #[serde(default)]
    pub length: Option<f64>,
    /// Where the tip starts, outside the organs.
    pub entry: Triple,
    /// A place that it moves towards.
    #[serde(default)]
    pub target: Option<Triple>,
    /// Or the direction that it moves in, of any length.
    #[serde(default)]
    pub direction: Option<Triple>,
    /// How far it goes from where it first touches, mm.
    pub stroke: f64,
    /// From state to state, mm.
    pub step: f64,
}

/// `[[targets]]`: a place of an organ, told and drawn wherever the organ takes it.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawTarget {
    /// 1 to 64 characters on one line, of no other target.
    pub name: String,
    /// At rest.
    pub at: Triple,
    /// The organ that it must lie in; absent: whichever it lies in.
    #[serde(default)]
    pub organ: Option<String>,
}

/// `[search]`
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RawSpaceSearch {
    /// The most Newton steps of one search.
    pub most_steps: usize,
}

impl Default for RawSpaceSearch {
    fn default() -> Self {
        Self { most_steps: 400 }
    }
}

/// `[output]`
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RawSpaceOutput {
    /// What cuts show.
    pub field: RawSpaceField,
    /// Pixels of the picture of the shape.
    pub size: [u32; 2],
    /// How many states the strip shows, at most.
    pub strip: usize,
    /// Whether errors of the last state are looked for.
    pub errors: bool,
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
pub enum RawSpaceField {
    /// How far tissue has moved, mm.
    Displacement,
    /// Von Mises's stress, N/mm2.
    VonMises,
}
