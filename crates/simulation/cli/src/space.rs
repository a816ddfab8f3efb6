//! Scenes of solids in space: organs of a label map, pushed by a rigid tube.
//!
//! The crate `organs` reads the file and makes the [`Model`] of it with its label map. A [`run`] goes from state to state; [`output`] writes pictures and report.

mod draw;
mod errors;
mod output;
mod report;
mod run;
#[cfg(test)]
mod tests;
mod tissue;
mod words;

use std::path::{Path, PathBuf};

use bus::volume::OwnedVolume;
use organs::numbers::invalid;
use organs::{Labels, Model, Parsed, Plan, RawSpaceScene, sha};

use errors::Said;
use report::{Origin, Whole};
use run::Run;

/// Reads the label map at a path.
pub type ReadLabels = fn(&Path) -> Result<OwnedVolume, Box<dyn std::error::Error + Send + Sync>>;

/// A scene in space.
pub(crate) type Source = Parsed<RawSpaceScene>;

/// A scene with all that it describes.
pub(crate) struct Space {
    source: Source,
    plan: Plan,
    labels: Labels,
    /// Of the label map.
    path: PathBuf,
    model: Model,
    origin: Origin,
}

/// What is wrong with the text of a scene in space, or what it would model, as far as that is known without its label map.
pub(crate) fn planned(text: String, path: &Path) -> Result<String, String> {
    let source = Source::parse(text, path).map_err(|error| error.to_string())?;
    let plan = Plan::new(&source.scene).map_err(|invalid| source.error_at(invalid).to_string())?;
    Ok(words::planned(&source.scene.title, &plan))
}

/// What all reports of a run have in common.
#[derive(Clone, Copy)]
struct Given<'a> {
    title: &'a str,
    path: &'a str,
    plan: &'a Plan,
    labels: &'a Labels,
    origin: &'a Origin,
}

impl<'a> Given<'a> {
    fn whole(self, model: &'a Model, run: &'a Run, errors: &'a Said, complete: bool) -> Whole<'a> {
        Whole {
            title: self.title,
            path: self.path,
            plan: self.plan,
            labels: self.labels,
            model,
            run,
            origin: self.origin,
            errors,
            complete,
        }
    }
}

impl Space {
    /// Reads a scene and its label map: `instead` of the one that it names, where there is one.
    ///
    /// # Errors
    /// What is wrong, with line, column and key.
    pub(crate) fn new(text: String, path: &Path, instead: Option<&Path>, read: ReadLabels) -> Result<Self, String> {
        let source = Source::parse(text.clone(), path).map_err(|error| error.to_string())?;
        let refused = |why| source.error_at(why).to_string();
        let plan = Plan::new(&source.scene).map_err(refused)?;
        let space = &source.scene.space;
        let named = || scene::labels_beside(path, &space.labels);
        let (scene, path) = (path, instead.map_or_else(named, Path::to_owned));
        let why = |found: String| {
            let obtain = space
                .obtain
                .as_deref()
                .map(|how| format!("; {how}"))
                .unwrap_or_default();
            let allowed = format!("a label map (NIfTI) of orthogonal axes; another one: --labels FILE{obtain}");
            refused(invalid("space.labels", format!("{}: {found}", path.display()), allowed))
        };
        let volume = read(&path).map_err(|error| why(error.to_string()))?;
        let slice = |z, out: &mut [i16]| volume.view().slice(z, out);
        let labels = Labels::new(&volume.grid, volume.hash.to_string(), slice);
        let labels = labels.map_err(|error| why(error.to_string()))?;
        let labels_sha256 = sha::of_labels(&path).map_err(|error| why(error.to_string()))?;
        sha::pinned(plan.labels_sha256.as_deref(), &path, labels_sha256.as_deref()).map_err(refused)?;
        let model = Model::new(&plan, &labels).map_err(refused)?;
        let origin = Origin {
            path: scene.display().to_string(),
            sha256: sha::of(text.as_bytes()),
            text,
            labels_sha256,
        };
        Ok(Self {
            plan,
            labels,
            path,
            model,
            origin,
            source,
        })
    }

    /// What it models.
    pub(crate) fn described(&self) -> String {
        let path = self.path.display().to_string();
        words::described(&self.source.scene.title, &path, &self.plan, &self.labels, &self.model)
    }

    /// Looks for the errors of the last state, whatever the scene says.
    pub(crate) fn ask_for_errors(&mut self) {
        self.plan.errors = true;
    }

    /// Runs it, and writes what was found: `result.json` after each state, pictures at the end.
    ///
    /// # Errors
    /// What could not be written, or why the run ended early.
    pub(crate) fn run(self, out: &Path, tell: &mut dyn FnMut(&str)) -> Result<String, String> {
        let Self {
            source,
            plan,
            labels,
            path,
            mut model,
            origin,
        } = self;
        let given = Given {
            title: &source.scene.title,
            path: &path.display().to_string(),
            plan: &plan,
            labels: &labels,
            origin: &origin,
        };
        let early = if plan.errors { Said::NotYet } else { Said::NotAsked };
        let mut keep = |model: &Model, run: &Run| output::keep(&given.whole(model, run, &early, false), out);
        let found = run::run(&mut model, &plan, &labels, tell, &mut keep).map_err(|error| error.to_string())?;
        let errors = match plan.errors {
            true => errors::of(&found, &plan, &labels, &model, tell),
            false => Said::NotAsked,
        };
        let whole = given.whole(&model, &found, &errors, true);
        let pictures = output::write(&whole, out).map_err(|error| error.to_string())?;
        let (scene, out) = (source.path.display(), out.display());
        match (&found.refused, found.saddles().first()) {
            (Some(why), _) => Err(format!("{scene}: {why}. What was found until then is in {out}")),
            (None, Some(label)) => Err(format!(
                "{scene}: {label} is no minimum or not known to be one. All states are in {out}"
            )),
            (None, None) => Ok(format!(
                "{}; {} and result.json in {out}\n{}",
                words::found(&found),
                pictures.join(", "),
                words::errors(&errors, &model)
            )),
        }
    }
}
