//! The scene file as it is written: every key known, every type right, nothing else checked.

pub(crate) use organs::raw::RawUnits;
use serde::Deserialize;

/// A point or a vector.
pub(crate) type Pair = [f64; 2];

/// The whole file.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawScene {
    /// For people: above every picture.
    pub(crate) title: String,
    /// `[units]`
    pub(crate) units: RawUnits,
    /// `[[materials]]`
    #[serde(default)]
    pub(crate) materials: Vec<RawMaterial>,
    /// `[[solids]]`
    pub(crate) solids: Vec<RawSolid>,
    /// `[[walls]]`
    #[serde(default)]
    pub(crate) walls: Vec<RawWall>,
    /// `[[links]]`
    #[serde(default)]
    pub(crate) links: Vec<RawLink>,
    /// `[[forces]]`
    #[serde(default)]
    pub(crate) forces: Vec<RawForce>,
    /// `[contact]`; absent: solids pass through one another.
    #[serde(default)]
    pub(crate) contact: Option<RawContact>,
    /// `[search]`
    #[serde(default)]
    pub(crate) search: RawSearch,
    /// `[[steps]]`, one after the other
    #[serde(default)]
    pub(crate) steps: Vec<RawStep>,
    /// `[output]`
    #[serde(default)]
    pub(crate) output: RawOutput,
}

/// `[[materials]]`
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawMaterial {
    pub(crate) name: String,
    pub(crate) law: RawLaw,
    /// Young's modulus, units of stress.
    pub(crate) young: f64,
    /// Poisson's ratio.
    pub(crate) poisson: f64,
    /// Elements with pressures of their own, for ratios near 1/2.
    #[serde(default)]
    pub(crate) mixed: bool,
    /// `[weight, exponent]` of each term of an Ogden law.
    #[serde(default)]
    pub(crate) ogden: Option<Vec<Pair>>,
}

/// The form of the energy.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum RawLaw {
    StVenantKirchhoff,
    Linear,
    NeoHookean,
    StableNeoHookean,
    Ogden,
}

/// `[[solids]]`: one of the shapes, and what is done to it.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawSolid {
    pub(crate) name: String,
    /// Name of a material; absent for polygons, which are rigid.
    #[serde(default)]
    pub(crate) material: Option<String>,
    /// Force on a unit of reference area.
    #[serde(default)]
    pub(crate) weight: Pair,
    #[serde(default)]
    pub(crate) rectangle: Option<RawRectangle>,
    #[serde(default)]
    pub(crate) ring: Option<RawRing>,
    #[serde(default)]
    pub(crate) rounded: Option<RawRounded>,
    #[serde(default)]
    pub(crate) polygon: Option<RawPolygon>,
    #[serde(default)]
    pub(crate) mesh: Option<RawMesh>,
    /// Deform it by the nine nodes of this block only.
    #[serde(default)]
    pub(crate) global: Option<RawBox>,
    /// Nodes in this box of the reference configuration keep their place.
    #[serde(default)]
    pub(crate) held: Option<RawBox>,
    /// An instrument: it moves by the steps alone.
    #[serde(default)]
    pub(crate) driven: bool,
    #[serde(default)]
    pub(crate) start: RawStart,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawRectangle {
    pub(crate) corner: Pair,
    pub(crate) size: Pair,
    pub(crate) elements: [usize; 2],
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawRing {
    pub(crate) centre: Pair,
    /// Inner, outer.
    pub(crate) radii: Pair,
    /// Round, through the thickness.
    pub(crate) elements: [usize; 2],
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawRounded {
    pub(crate) centre: Pair,
    pub(crate) half_axes: Pair,
    /// Radians.
    #[serde(default)]
    pub(crate) turned: f64,
    pub(crate) elements: [usize; 2],
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawPolygon {
    /// Counter-clockwise.
    pub(crate) vertices: Vec<Pair>,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawMesh {
    pub(crate) nodes: Vec<Pair>,
    /// Nine nodes each, counted from 0: row by row of the element, counter-clockwise.
    pub(crate) elements: Vec<[usize; 9]>,
}

#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawBox {
    pub(crate) low: Pair,
    pub(crate) high: Pair,
}

/// `start = {}`: in this order, deformed, then turned, then moved.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct RawStart {
    /// The linear map of positions about `about`, row by row; for meshes.
    pub(crate) affine: Option<[Pair; 2]>,
    /// What is added to it: second-order coefficients `[xx, xy, yy]` of each coordinate about `about`; for meshes.
    pub(crate) bent: Option<[[f64; 3]; 2]>,
    /// Radians, counter-clockwise about `about`.
    pub(crate) turned: f64,
    /// Absent: the middle of the box round it.
    pub(crate) about: Option<Pair>,
    /// A translation.
    pub(crate) moved: Pair,
}

/// `[[walls]]`: solids keep out of `<x, normal> <= offset`.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawWall {
    pub(crate) name: String,
    pub(crate) normal: Pair,
    pub(crate) offset: f64,
    /// Names of the solids that it keeps out; absent: all that are not driven.
    #[serde(default)]
    pub(crate) keeps: Option<Vec<String>>,
}

/// `[[links]]`: a point of a solid at a fixed point, or at a point of another solid.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawLink {
    pub(crate) solid: String,
    /// Of its boundary, in the reference configuration.
    pub(crate) at: Pair,
    /// A fixed point, or with `to_solid` a point of its boundary.
    pub(crate) to: Pair,
    #[serde(default)]
    pub(crate) to_solid: Option<String>,
    /// Present: a spring of this stiffness, force by length. Absent: it holds exactly.
    #[serde(default)]
    pub(crate) spring: Option<f64>,
}

/// `[[forces]]`: a dead force on a point of a solid.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawForce {
    pub(crate) solid: String,
    /// Of its boundary, in the reference configuration.
    pub(crate) at: Pair,
    pub(crate) force: Pair,
}

/// `[contact]`: solids against solids.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct RawContact {
    /// Distances over which solids push one another, at first and at last; absent: 1e-2 and 1e-3 of the largest.
    pub(crate) widths: Option<Pair>,
    /// Units of stress; absent: 0.1 of the stiffest material.
    pub(crate) stiffness: Option<f64>,
    /// What is done about solids that overlap at the start.
    pub(crate) overlaps: RawOverlaps,
    /// Names of the two solids of each pair that keeps apart; one twice: it keeps out of itself. Absent: every two.
    pub(crate) pairs: Option<Vec<[String; 2]>>,
}

/// What is done about overlaps at the start.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum RawOverlaps {
    /// The scene is refused, with the pairs.
    #[default]
    Refuse,
    /// Whole solids are moved apart.
    Move,
    /// Parameters change as little as can be: along the gradient of the constraint.
    Push,
}

/// `[search]`
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct RawSearch {
    /// Look for equilibria; else states are shown as they are placed.
    pub(crate) settle: bool,
    /// How walls hold: `exact`, `barrier`, or the one after the other.
    pub(crate) walls: RawWalls,
    /// The most Newton steps of one search.
    pub(crate) most_steps: usize,
    /// End each frame with exact contact; else behind the barriers.
    pub(crate) exact: bool,
    /// Keep a state every so many steps of the first search, to show the way.
    pub(crate) watch: Option<usize>,
}

impl Default for RawSearch {
    fn default() -> Self {
        Self {
            settle: true,
            walls: RawWalls::default(),
            most_steps: 400,
            exact: true,
            watch: None,
        }
    }
}

/// How walls hold.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum RawWalls {
    /// Multipliers, from the start.
    Exact,
    /// A barrier of the contact's width.
    Barrier,
    /// A barrier that hands over to multipliers.
    #[default]
    BarrierThenExact,
}

/// `[[steps]]`
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawStep {
    pub(crate) frames: usize,
    /// What moves in each of the frames.
    pub(crate) moves: Vec<RawMove>,
}

/// What moves, and by how much in a frame: a wall, or a driven solid.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawMove {
    #[serde(default)]
    pub(crate) wall: Option<String>,
    /// By how much a wall's offset grows.
    #[serde(default)]
    pub(crate) advance: Option<f64>,
    #[serde(default)]
    pub(crate) solid: Option<String>,
    /// By how much a solid is moved.
    #[serde(default)]
    pub(crate) by: Option<Pair>,
    /// By how much it is turned about its centre, radians.
    #[serde(default)]
    pub(crate) turned: f64,
}

/// `[output]`
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct RawOutput {
    /// Pictures of the last state.
    pub(crate) fields: Vec<RawField>,
    /// Arrows of the forces of contacts and links.
    pub(crate) forces: bool,
    /// Pixels.
    pub(crate) size: [u32; 2],
    /// What is seen; absent: all that the solids pass through.
    pub(crate) region: Option<RawBox>,
    /// How many states the strip shows, at most.
    pub(crate) strip: usize,
    /// Which field strip and animation show.
    pub(crate) film: RawField,
    /// Tangent, normal and second derivative along a boundary.
    pub(crate) cursors: Option<RawCursors>,
}

impl Default for RawOutput {
    fn default() -> Self {
        Self {
            fields: vec![RawField::Shape],
            forces: true,
            size: [900, 700],
            region: None,
            strip: 6,
            film: RawField::Shape,
            cursors: None,
        }
    }
}

/// A picture of a state.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum RawField {
    Shape,
    Gradient,
    Energy,
    VonMises,
    Principal,
}

/// Cursors along the boundary of a solid.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawCursors {
    pub(crate) solid: String,
    /// How far apart, length of the reference boundary.
    pub(crate) every: f64,
}
