//! The methods, and what else a calibration may be told.

use super::noise::PoseNoise;

/// How tip and pivot are found; see [the module](super).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Method {
    /// Both at once by linear least squares; all poses count.
    Algebraic,
    /// The tip by differences of poses, then the pivot; all poses count.
    TwoStep,
    /// The pivot as the centre of a sphere, then the tip; all poses count.
    Sphere,
    /// As algebraic, with weights that forget poses which slipped.
    Robust,
    /// Most likely under noise of translations and rotations, with such weights.
    #[default]
    ErrorsInVariables,
}

impl Method {
    /// All methods, the default last.
    pub const ALL: [Self; 5] = [
        Self::Algebraic,
        Self::TwoStep,
        Self::Sphere,
        Self::Robust,
        Self::ErrorsInVariables,
    ];

    /// Its name on command lines and in files.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Algebraic => "algebraic",
            Self::TwoStep => "two-step",
            Self::Sphere => "sphere",
            Self::Robust => "robust",
            Self::ErrorsInVariables => "errors-in-variables",
        }
    }
}

/// What a calibration may be told.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Options {
    /// How it is done.
    pub method: Method,
    /// The noise of the poses; only its ratio counts.
    pub noise: PoseNoise,
}
