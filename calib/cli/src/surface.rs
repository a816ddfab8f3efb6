//! `calib surface`: registers points of a bone's surface to the bone, and writes the file that a tracker reads.

mod args;
mod bone;
mod bone_args;
mod calibrated;
mod error;
mod file;
mod line;
mod mirror;
mod picture;
mod points;
mod report;
mod start;
mod sweep;
#[cfg(test)]
mod tests;

use std::path::{Path, PathBuf};

pub(crate) use args::{SURFACE_HELP, SurfaceArgs};
pub(crate) use line::{BONE_LINE_HELP, BoneLineArgs};
pub(crate) use sweep::{SWEEP_HELP, SweepArgs};

use geometry::{Point, Vector};
use surface_registration::{Limits, Options, Refusal, Start, SurfaceRegistration};

use crate::commands::Outcome;
use crate::commands::common::{CommandError, gates_text};
use crate::input_files::columns::TableError;
use crate::input_files::source::Source;
use crate::register::judge;
use crate::register::solve::{From, To};
use crate::scene_context::SceneContext;
use crate::store;
use bone::Bone;
use error::SurfaceCommandError;
use mirror::Mirror;
use points::{Measured, Shared};
use start::{Begin, Begun};

/// Name of the frame of the bone.
const TO: &str = "ct";

/// The format of a result that was refused: no reader of registrations takes it.
pub const REFUSED_FORMAT: &str = "trocar-refused-registration";

/// How far beyond what is told of a guess a result may lie: the search begins within, and a fit goes a little on from there.
const BEYOND: f64 = 1.2;

/// One registration to be made.
struct Asked {
    options: Options,
    limits: Limits,
    begin: Begin,
    points: PathBuf,
    noise_mm: Option<f64>,
    held_mm: f64,
    shared: Shared,
    /// The file of the tip.
    tip: Option<PathBuf>,
    /// In the CT, mm; at least one.
    targets: Vec<[f64; 3]>,
    /// Name of the frame of the points.
    from: String,
    ct_hash: Option<String>,
    marker: Option<String>,
    out: Option<PathBuf>,
    /// Where a result goes that is refused.
    keep_refused: Option<PathBuf>,
    picture: Option<PathBuf>,
    json: bool,
    /// What is not against the result, and should be known.
    warnings: Vec<String>,
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
    /// How far it lies from the guess, where that is further than was told.
    beyond: Option<String>,
    /// What speaks for a mirrored picture.
    mirrored: Option<String>,
}

/// Does what is asked; what is refused, by the numerics or by a scene's gates, is told and not written.
fn register(bone: &Bone, asked: &Asked, scened: Option<&SceneContext>) -> Result<Outcome, CommandError> {
    let source = Source::read(&asked.points).map_err(TableError::from)?;
    let mut made = make(bone, asked, source)?;
    made.look_for_a_mirror();
    for warning in made.warnings() {
        bus::stderr_line!("calib: warning: {warning}");
    }
    let mut file = file::describe(&made);
    let (judged, of_scene) = judge(&mut file, scened)?;
    let refused = made.refused().or(of_scene);
    if let Some(path) = &asked.picture {
        let png = picture::png(&made, refused.as_deref()).map_err(|what| SurfaceCommandError::Picture {
            path: path.clone(),
            what,
        })?;
        store::write_bytes(path, Ok(png), asked.inputs(bone).chain([asked.points.as_path()]))?;
    }
    let mut text = match asked.json {
        // A file of a refused registration looks like any other to whoever reads it.
        true if refused.is_some() => String::new(),
        true => file.to_json()?,
        // A scene's gates alone accept nothing: beside a refusal they have no verdict.
        false if made.against().is_empty() => report::text(&made, &file, refused.is_none()) + &judged,
        false => report::text(&made, &file, false) + &gates_text(&file.gates),
    };
    let mut written = match (&asked.out, &refused) {
        (Some(out), None) => {
            store::write(out, file.to_json(), asked.inputs(bone).chain([asked.points.as_path()]))?;
            format!("\nwritten to {}\n", out.display())
        }
        (Some(out), Some(_)) => format!("\nnot written to {}\n", out.display()),
        (None, _) => String::new(),
    };
    if let (Some(path), Some(_)) = (&asked.keep_refused, &refused) {
        REFUSED_FORMAT.clone_into(&mut file.format);
        store::write(path, file.to_json(), asked.inputs(bone).chain([asked.points.as_path()]))?;
        written += &format!("kept in {}, by which nothing is registered\n", path.display());
    }
    if !asked.json {
        text += &written;
    }
    Ok(Outcome { text, refused })
}

/// The registration of the points that a file has, or will have.
fn make<'a>(bone: &'a Bone, asked: &'a Asked, source: Source) -> Result<Made<'a>, SurfaceCommandError> {
    let measured = Measured::read(
        &source,
        points::Asked {
            path: &asked.points,
            noise_mm: asked.noise_mm,
            held_mm: asked.held_mm,
            shared: asked.shared.clone(),
        },
    )?;
    let begun = asked.begin.read(&asked.of())?;
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
    let beyond = beyond(&begun, &measured, &found);
    Ok(Made {
        asked,
        bone,
        measured,
        begun,
        source,
        found,
        targets,
        refusals,
        beyond,
        mirrored: None,
    })
}

/// Why a result is not what a guess allows: fits go on from where they are begun, and nothing was searched out there.
fn beyond(begun: &Begun, measured: &Measured, found: &SurfaceRegistration<To, From>) -> Option<String> {
    let Start::Guess {
        pose,
        turn_rad,
        shift_mm,
    } = &begun.start
    else {
        return None;
    };
    let found = found.transform.transform();
    let turn = (found * pose.inverse()).rotation().vector().radians();
    let turned = turn.iter().fold(0.0, |length, part| f64::hypot(length, *part));
    let points = measured.points.points();
    let shifts = points.iter().map(|point| (found * point.place) - (*pose * point.place));
    let sum = shifts.fold(Vector::new(0.0, 0.0, 0.0), |sum, shift| sum + shift);
    let shifted = sum.norm() / points.len() as f64;
    (turned > BEYOND * turn_rad || shifted > BEYOND * shift_mm).then(|| {
        format!(
            "the result is turned by {:.0} degrees against the guess and {shifted:.0} mm off at the points, and {:.0} degrees and \
             {shift_mm:.0} mm were told: nothing was searched out there; tell more, or search without a guess",
            turned.to_degrees(),
            turn_rad.to_degrees()
        )
    })
}

impl Made<'_> {
    /// Everything that is against it, in words.
    fn against(&self) -> Vec<String> {
        let refusals = self.refusals.iter().map(Refusal::to_string);
        refusals
            .chain(self.beyond.clone())
            .chain(self.mirrored.clone())
            .collect()
    }

    /// Registers the points as a mirrored picture would have shown them; it takes as long as the registration, and is done at its end alone.
    fn look_for_a_mirror(&mut self) {
        let Some(mirrored) = &self.measured.mirrored else {
            return;
        };
        let bone = (&self.bone.surface, &self.bone.field);
        let how = (&self.begun.start, &self.asked.options);
        let mirror = Mirror::of(bone, mirrored, how, &self.found, &self.targets);
        self.mirrored = mirror.refused(self.asked.limits.least_margin);
    }

    /// What is not against it, and should be known.
    fn warnings(&self) -> Vec<String> {
        let of_order = self.found.order.why_not();
        let is_of_probe = matches!(self.measured.shared, Shared::Probe(..));
        let of_mirror = (is_of_probe && self.measured.mirrored.is_none())
            .then(|| "whether the probe's picture was mirrored could not be looked at: its calibration does not say the array (calib probe --array), or mirrored points are no cloud".to_owned());
        self.asked
            .warnings
            .iter()
            .cloned()
            .chain(of_order)
            .chain(of_mirror)
            .collect()
    }

    /// Why it must not be used, in words.
    fn refused(&self) -> Option<String> {
        let words = self.against();
        let path = self.asked.points.display();
        (!words.is_empty()).then(|| format!("the registration of {path} is not accepted: {}", words.join("; ")))
    }
}

impl Asked {
    /// What a guess must be of.
    fn of(&self) -> start::Of<'_> {
        start::Of {
            to: TO,
            from: &self.from,
            ct_hash: self.ct_hash.as_deref(),
            marker: self.marker.as_deref(),
        }
    }

    /// The files that are read, which nothing may be written over.
    fn inputs<'a>(&'a self, bone: &'a Bone) -> impl Iterator<Item = &'a Path> {
        let begin = match &self.begin {
            Begin::Guess { path, .. } | Begin::Landmarks { path, .. } => Some(path.as_path()),
            Begin::Nothing => None,
        };
        let bone = [bone.path.as_path(), bone.beside.as_path()];
        bone.into_iter().chain(begin).chain(self.tip.as_deref())
    }
}
