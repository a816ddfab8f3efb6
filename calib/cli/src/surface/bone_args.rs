//! What the commands share that register to a bone's surface.

use std::path::PathBuf;

use clap::Args;
use exchange::{LengthUnit, PatientAxes};
use surface_registration::{Limits, Options, Priors};

use super::bone::Bone;
use super::error::{FAR_MM, SurfaceCommandError};
use super::start::Begin;
use crate::commands::common::CommandError;
use crate::scene_context::SceneContext;
use crate::store;
use crate::values::{Name, Positive, Target};

/// Largest error predicted at a target, root mean square, mm, that is accepted of a probe's images where nothing else is said: 95 of 100 are then within 2.4 mm
/// where no direction is worse than another (times the root of 7.81 / 3), and so within a node of 5 mm. What it lets pass stands in docs/accuracy.md.
const MOST_BY_PROBE_MM: f64 = 1.5;

/// The bone, where the search begins, where the error counts, and what is written.
#[derive(Debug, Args)]
pub(crate) struct BoneArgs {
    /// The bone: a surface of triangles (.ply, .vtk, .stl, .obj), as calib bone makes it
    #[arg(long, value_name = "FILE")]
    pub(super) bone: PathBuf,
    /// The axes of its coordinates, where it does not say them
    #[arg(long, value_name = "lps|ras")]
    pub(super) bone_frame: Option<PatientAxes>,
    /// Its unit: m, or mm though it is at most 2 mm long [default: what its comment says, else mm]
    #[arg(long, value_name = "mm|m")]
    pub(super) bone_unit: Option<LengthUnit>,
    /// Deviation of the bone's surface from place to place [default: what calib bone says, else 0.15]
    #[arg(long, value_name = "MM", allow_hyphen_values = true)]
    pub(super) bone_mm: Option<Positive>,
    /// Deviation of an offset of the whole surface, which is fitted; 0 holds it [default: what calib bone says, else 1]
    #[arg(long, value_name = "MM", value_parser = from_zero, allow_hyphen_values = true)]
    pub(super) offset_mm: Option<f64>,
    /// Deviation of what may lie under the tip, or before the bone, on one side of it and not on the other: soft tissue, or a layer that echoes
    #[arg(long, value_name = "MM", default_value = "0", value_parser = from_zero, allow_hyphen_values = true)]
    pub(super) tissue_mm: f64,
    /// A registration that is roughly right
    #[arg(long, value_name = "FILE.json", conflicts_with = "landmarks")]
    pub(super) guess: Option<PathBuf>,
    /// By how much it may be turned
    #[arg(
        long,
        value_name = "DEGREES",
        default_value = "30",
        requires = "guess",
        allow_hyphen_values = true
    )]
    pub(super) guess_deg: Positive,
    /// By how much it may be off at the points
    #[arg(
        long,
        value_name = "MM",
        default_value = "30",
        requires = "guess",
        allow_hyphen_values = true
    )]
    pub(super) guess_mm: Positive,
    /// Three points or more that are known in both frames, as calib register takes pairs
    #[arg(long, value_name = "FILE.csv")]
    pub(super) landmarks: Option<PathBuf>,
    /// Deviation of a landmark along each axis, at least 0.5: what is known better is for calib register
    #[arg(
        long,
        value_name = "MM",
        default_value = "4",
        requires = "landmarks",
        value_parser = rough,
        allow_hyphen_values = true
    )]
    pub(super) landmark_mm: f64,
    /// Where the error counts, in the CT, LPS mm; may be given several times [default: the scene's targets]
    #[arg(long, value_name = "x,y,z", allow_hyphen_values = true)]
    pub(super) target: Vec<Target>,
    /// The largest error predicted at a target, root mean square, that is accepted [default: 2, of a probe's images 1.5]
    #[arg(long, value_name = "MM", allow_hyphen_values = true)]
    pub(super) max_tre_mm: Option<Positive>,
    /// Write the result here, as JSON
    #[arg(long, value_name = "FILE.json")]
    pub(super) out: Option<PathBuf>,
    /// Write a result that is refused here, to be looked at: as --out, in a format of its own, so that nothing registers by it
    #[arg(long, value_name = "FILE.json")]
    pub(super) keep_refused: Option<PathBuf>,
    /// Draw the points on the bone from three sides; also where the result is refused
    #[arg(long, value_name = "FILE.png")]
    pub(super) picture: Option<PathBuf>,
    /// Replace these files if they exist
    #[arg(long)]
    pub(super) overwrite: bool,
}

/// The deviation of a landmark that is known roughly. One that is told as exact would overrule the surface.
fn rough(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|error| format!("{error}"))?;
    let allowed = value.is_finite() && value >= 0.5;
    allowed
        .then_some(value)
        .ok_or_else(|| format!("{value} is not a finite number of at least 0.5"))
}

/// A number of at least 0.
pub(super) fn from_zero(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|error| format!("{error}"))?;
    let allowed = value.is_finite() && value >= 0.0;
    allowed
        .then_some(value)
        .ok_or_else(|| format!("{value} is not a finite number of at least 0"))
}

impl BoneArgs {
    /// Reads the bone.
    pub(super) fn bone(&self) -> Result<Bone, SurfaceCommandError> {
        Bone::read(&self.bone, self.bone_frame, self.bone_unit)
    }

    /// Refuses what cannot be written before the work is done.
    pub(super) fn check(&self) -> Result<(), CommandError> {
        let outputs = [&self.out, &self.keep_refused, &self.picture].map(Option::as_ref);
        for (i, out) in outputs.into_iter().enumerate() {
            if let Some(out) = out.filter(|_| outputs[..i].contains(&out)) {
                return Err(SurfaceCommandError::Twice { path: out.clone() }.into());
            }
        }
        // Beside the bone lies what calib bone says of it, which the next one would look for there.
        let beside = self.bone.with_extension("json");
        if let Some(out) = outputs.into_iter().flatten().find(|out| **out == beside) {
            return Err(SurfaceCommandError::Beside { path: out.clone() }.into());
        }
        Ok(outputs
            .into_iter()
            .flatten()
            .try_for_each(|out| store::check(out, self.overwrite))?)
    }

    /// The targets: those that are given, else the scene's. In the CT, mm.
    pub(super) fn targets(&self, scened: Option<&SceneContext>) -> Result<Vec<[f64; 3]>, SurfaceCommandError> {
        let mut targets: Vec<[f64; 3]> = self.target.iter().map(|target| target.0).collect();
        if targets.is_empty() {
            let own = scened.map(|scened| scened.scene.targets.iter().map(|target| target.centre.mm()));
            targets.extend(own.into_iter().flatten());
        }
        let far = targets.iter().find(|target| target.iter().any(|mm| mm.abs() > FAR_MM));
        match (targets.is_empty(), far) {
            (true, _) => Err(SurfaceCommandError::NoTarget),
            (false, Some(target)) => Err(SurfaceCommandError::FarTarget { target: *target }),
            (false, None) => Ok(targets),
        }
    }

    /// What a result must keep, of points of a probe's images or of a tip.
    pub(super) fn limits(&self, is_by_probe: bool) -> Limits {
        let usual = Limits::default();
        let own = if is_by_probe {
            MOST_BY_PROBE_MM
        } else {
            usual.most_tre_mm
        };
        Limits {
            most_tre_mm: self.max_tre_mm.as_ref().map_or(own, |told| told.0),
            ..usual
        }
    }

    pub(super) fn begin(&self) -> Begin {
        match (&self.guess, &self.landmarks) {
            (Some(path), _) => Begin::Guess {
                path: path.clone(),
                degrees: self.guess_deg.0,
                mm: self.guess_mm.0,
            },
            (None, Some(path)) => Begin::Landmarks {
                path: path.clone(),
                sigma_mm: self.landmark_mm,
            },
            (None, None) => Begin::Nothing,
        }
    }

    /// What is known before: as the command line says, else the bone's own file, else the usual. `alike_mm` is how far all that touches or
    /// sees the bone may lie off it alike, deviation.
    pub(super) fn options(&self, bone: &Bone, depth_scale: f64, alike_mm: f64) -> Options {
        let known = bone.record.as_ref();
        let usual = Priors::default();
        let of_bone = known.map(|record| record.surface_shared_sigma_mm.hypot(alike_mm));
        let offset_mm = self.offset_mm.or(of_bone);
        let bone_mm = self.bone_mm.map(|mm| mm.0);
        let bone_mm = bone_mm.or(known.map(|record| record.surface_sigma_mm));
        let priors = Priors {
            depth_scale,
            offset_mm: offset_mm.unwrap_or(usual.offset_mm),
            bone_mm: bone_mm.unwrap_or(usual.bone_mm),
            side_mm: self.tissue_mm,
        };
        Options {
            priors,
            ..Options::default()
        }
    }
}

/// The CT that the bone is of: what its file says, which one that is expected must be.
pub(super) fn ct_of(bone: &Bone, expected: Option<Name>) -> Result<Option<Name>, SurfaceCommandError> {
    let own = bone.record.as_ref().and_then(|record| record.ct_hash.as_deref());
    match (own, expected) {
        (Some(own), Some(expected)) if own != expected.as_str() => Err(SurfaceCommandError::OtherCt {
            path: bone.path.clone(),
            found: own.to_owned(),
            expected: expected.0,
        }),
        (own, expected) => Ok(expected.or_else(|| own.map(Name::told))),
    }
}
