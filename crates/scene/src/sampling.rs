//! How the volume is sampled: between voxels, through a thickness, in large pixels, and on which back end.

use serde::{Deserialize, Serialize};

/// How voxels are interpolated. The formulas are with the renderer's reference back end.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Filter {
    /// The nearest voxel.
    #[serde(rename = "nearest")]
    Nearest,
    /// Trilinear.
    #[default]
    #[serde(rename = "linear")]
    Linear,
    /// Catmull-Rom cubic convolution: goes through the voxels, 4 taps an axis.
    #[serde(rename = "cubic")]
    Cubic,
    /// Cubic B-spline through the voxels (prefiltered), 4 taps an axis: the smoothest of its support.
    #[serde(rename = "b-spline")]
    BSpline,
    /// Sinc in a Lanczos window of half-width 3, 6 taps an axis.
    #[serde(rename = "sinc-3")]
    Sinc3,
    /// Sinc in a Lanczos window of half-width 5, 10 taps an axis.
    #[serde(rename = "sinc-5")]
    Sinc5,
}

impl Filter {
    /// Every filter, from the fastest to the slowest.
    pub const ALL: [Self; 6] = [
        Self::Nearest,
        Self::Linear,
        Self::Cubic,
        Self::BSpline,
        Self::Sinc3,
        Self::Sinc5,
    ];

    /// The name in the scene file and on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Nearest => "nearest",
            Self::Linear => "linear",
            Self::Cubic => "cubic",
            Self::BSpline => "b-spline",
            Self::Sinc3 => "sinc-3",
            Self::Sinc5 => "sinc-5",
        }
    }

    /// The filter of this name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|filter| filter.name() == name)
    }

    /// Voxels read along one axis.
    pub const fn taps(self) -> usize {
        match self {
            Self::Nearest => 1,
            Self::Linear => 2,
            Self::Cubic | Self::BSpline => 4,
            Self::Sinc3 => 6,
            Self::Sinc5 => 10,
        }
    }
}

/// What becomes of the samples through the thickness of a slab.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SlabMode {
    /// Their mean: a thick slice, with less noise.
    Mean,
    /// The brightest: vessels with contrast, bone (MIP).
    Maximum,
    /// The darkest: airways (MinIP).
    Minimum,
}

/// A slice with a thickness, half of it on each side of the plane.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Slab {
    /// What becomes of the samples.
    pub mode: SlabMode,
    /// Perpendicular to the plane, mm.
    pub thickness_mm: f64,
}

/// What a pixel that is larger than a voxel shows.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Minify {
    /// The mean over its area, so that fine bone does not shimmer.
    #[default]
    Area,
    /// The value at its centre, as other software samples.
    Point,
}

/// How a plane is sampled.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Sampling {
    /// Between voxels.
    pub filter: Filter,
    /// Through a thickness.
    pub slab: Option<Slab>,
    /// In pixels larger than a voxel.
    pub minify: Minify,
}

impl From<Filter> for Sampling {
    /// Thin, and at the pixels' centres.
    fn from(filter: Filter) -> Self {
        Self {
            filter,
            slab: None,
            minify: Minify::Point,
        }
    }
}

/// Thicknesses that a slab may have, mm.
pub const THICKNESS_MM: std::ops::RangeInclusive<f64> = 0.01..=500.0;

/// Who samples.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum BackEnd {
    /// A hardware GPU where there is one that proves itself, else the CPU; never a software rasteriser.
    #[default]
    Auto,
    /// A GPU, also a software one; without any the CPU, with a message.
    Gpu,
    /// The CPU: the same bits on every machine.
    Cpu,
}

/// How a GPU weighs neighbours.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum GpuWeights {
    /// By its program, in f32.
    #[default]
    Exact,
    /// By its texture sampler: faster, but weights have 8 bits (linear filter only).
    Sampler,
}

/// `[render]`
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Render {
    /// Who samples.
    pub back_end: BackEnd,
    /// How a GPU weighs neighbours.
    pub gpu_weights: GpuWeights,
}

impl Render {
    /// The CPU alone.
    pub fn cpu() -> Self {
        Self {
            back_end: BackEnd::Cpu,
            gpu_weights: GpuWeights::Exact,
        }
    }
}
