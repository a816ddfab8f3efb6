//! `calib surface`: registers points of a bone's surface to the bone, and writes the file that a tracker reads.

mod args;
mod bone;
mod bone_args;
mod error;
mod file;
mod picture;
mod points;
mod report;
mod start;
mod sweep;
#[cfg(test)]
mod tests;

use std::path::{Path, PathBuf};

pub(crate) use args::{SURFACE_HELP, SurfaceArgs};
pub(crate) use sweep::{SWEEP_HELP, SweepArgs};

use geometry::Point;
use surface_registration::{Limits, Options, Refusal, SurfaceRegistration};

use crate::commands::Outcome;
use crate::commands::common::{CommandError, gates_text};
use crate::input_files::source::Source;
use crate::register::judge;
use crate::register::solve::{From, To};
use crate::scene_context::SceneContext;
use crate::store;
use bone::Bone;
use error::SurfaceCommandError;
use points::{Measured, Shared};
use start::{Begin, Begun};

/// Name of the frame of the bone.
const TO: &str = "ct";

/// One registration to be made.
struct Asked {
    options: Options,
    limits: Limits,
    begin: Begin,
    points: PathBuf,
    noise_mm: Option<f64>,
    held_mm: f64,
    shared: Shared,
    /// In the CT, mm; at least one.
    targets: Vec<[f64; 3]>,
    /// Name of the frame of the points.
    from: String,
    ct_hash: Option<String>,
    marker: Option<String>,
    out: Option<PathBuf>,
    picture: Option<PathBuf>,
    json: bool,
}

/// What was found, and all that it rests on.
struct Made<'a> {
    asked: &'a Asked,
    bone: &'a Bone,
    measured: Measured,
    begun: Begun,
    source: Source,
    found: SurfaceRegistration<To, From>,
    targets: Vec<Point<To>>,
    refusals: Vec<Refusal>,
}

/// Does what is asked; what is refused, by the numerics or by a scene's gates, is told and not written.
fn register(bone: &Bone, asked: &Asked, scened: Option<&SceneContext>) -> Result<Outcome, CommandError> {
    let made = make(bone, asked)?;
    let mut file = file::describe(&made);
    let (judged, of_scene) = judge(&mut file, scened)?;
    let refused = made.refused().or(of_scene);
    if let Some(path) = &asked.picture {
        let png = picture::png(&made).map_err(|what| SurfaceCommandError::Picture {
            path: path.clone(),
            what,
        })?;
        store::write_bytes(path, Ok(png), asked.inputs(bone).chain([asked.points.as_path()]))?;
    }
    let mut text = match asked.json {
        true => file.to_json()?,
        // A scene's gates alone accept nothing: beside a refusal they have no verdict.
        false if made.refusals.is_empty() => report::text(&made, &file) + &judged,
        false => report::text(&made, &file) + &gates_text(&file.gates),
    };
    let written = match (&asked.out, &refused) {
        (Some(out), None) => {
            store::write(out, file.to_json(), asked.inputs(bone).chain([asked.points.as_path()]))?;
            format!("\nwritten to {}\n", out.display())
        }
        (Some(out), Some(_)) => format!("\nnot written to {}\n", out.display()),
        (None, _) => String::new(),
    };
    if !asked.json {
        text += &written;
    }
    Ok(Outcome { text, refused })
}

fn make<'a>(bone: &'a Bone, asked: &'a Asked) -> Result<Made<'a>, SurfaceCommandError> {
    let source = Source::read(&asked.points).map_err(crate::input_files::columns::TableError::from)?;
    let measured = Measured::read(
        &source,
        points::Asked {
            path: &asked.points,
            noise_mm: asked.noise_mm,
            held_mm: asked.held_mm,
            shared: asked.shared.clone(),
        },
    )?;
    let begun = asked.begin.read(TO, &asked.from)?;
    let found = surface_registration::register(
        &bone.surface,
        &bone.field,
        &measured.points,
        &begun.start,
        &asked.options,
    )
    .map_err(|source| SurfaceCommandError::Register {
        path: asked.points.clone(),
        bone: bone.path.clone(),
        source,
    })?;
    let targets: Vec<Point<To>> = asked.targets.iter().map(|[x, y, z]| Point::new(*x, *y, *z)).collect();
    let refusals = asked.limits.judge(&found, &targets);
    Ok(Made {
        asked,
        bone,
        measured,
        begun,
        source,
        found,
        targets,
        refusals,
    })
}

impl Made<'_> {
    /// Why it must not be used, in words.
    fn refused(&self) -> Option<String> {
        let words: Vec<String> = self.refusals.iter().map(Refusal::to_string).collect();
        let path = self.asked.points.display();
        (!words.is_empty()).then(|| format!("the registration of {path} is not accepted: {}", words.join("; ")))
    }
}

impl Asked {
    /// The files that are read, which nothing may be written over.
    fn inputs<'a>(&'a self, bone: &'a Bone) -> impl Iterator<Item = &'a Path> {
        let begin = match &self.begin {
            Begin::Guess { path, .. } | Begin::Landmarks { path, .. } => Some(path.as_path()),
            Begin::Nothing => None,
        };
        std::iter::once(bone.path.as_path()).chain(begin)
    }
}
