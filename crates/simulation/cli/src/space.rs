//! Scenes of solids in space: organs of a label map, pushed by a rigid tube.
//!
//! Read in three steps: the raw shape ([`raw`]), the [`plan`] whose every value can be used, and with the label map the
//! [`model`]. A [`run`] goes from state to state; [`output`] writes pictures and report.

mod body;
mod draw;
mod hold;
mod labels;
mod model;
mod output;
mod plan;
pub(crate) mod raw;
mod report;
mod run;
#[cfg(test)]
mod tests;
mod way;
mod words;

use std::path::{Path, PathBuf};

use bus::volume::OwnedVolume;

use crate::scene::{Parsed, invalid};
use labels::Labels;
use model::Model;
use plan::Plan;
use raw::RawSpaceScene;
use report::Whole;

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
}

/// What is wrong with the text of a scene in space, or what it would model, as far as that is known without its label map.
pub(crate) fn planned(text: String, path: &Path) -> Result<String, String> {
    let source = Source::parse(text, path).map_err(|error| error.to_string())?;
    let plan = Plan::new(&source.scene).map_err(|invalid| source.error_at(invalid).to_string())?;
    Ok(words::planned(&source.scene.title, &plan))
}

impl Space {
    /// Reads a scene and its label map: `instead` of the one that it names, where there is one.
    ///
    /// # Errors
    /// What is wrong, with line, column and key.
    pub(crate) fn new(text: String, path: &Path, instead: Option<&Path>, read: ReadLabels) -> Result<Self, String> {
        let source = Source::parse(text, path).map_err(|error| error.to_string())?;
        let refused = |why| source.error_at(why).to_string();
        let plan = Plan::new(&source.scene).map_err(refused)?;
        let space = &source.scene.space;
        let beside = || path.parent().unwrap_or_else(|| Path::new("")).join(&space.labels);
        let path = instead.map_or_else(beside, Path::to_owned);
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
        let labels = Labels::new(&volume).map_err(|error| why(error.to_string()))?;
        let model = Model::new(&plan, &labels).map_err(refused)?;
        Ok(Self {
            plan,
            labels,
            path,
            model,
            source,
        })
    }

    /// What it models.
    pub(crate) fn described(&self) -> String {
        let path = self.path.display().to_string();
        words::described(&self.source.scene.title, &path, &self.plan, &self.labels, &self.model)
    }

    /// Runs it, and writes what was found.
    ///
    /// # Errors
    /// What could not be written, or why the run ended early.
    pub(crate) fn run(mut self, out: &Path, tell: &mut dyn FnMut(&str)) -> Result<String, String> {
        let found = run::run(&mut self.model, &self.plan, &self.labels, tell);
        let whole = Whole {
            title: &self.source.scene.title,
            path: &self.path.display().to_string(),
            plan: &self.plan,
            labels: &self.labels,
            model: &self.model,
            run: &found,
        };
        let pictures = output::write(&whole, out).map_err(|error| error.to_string())?;
        let (scene, out) = (self.source.path.display(), out.display());
        match (&found.refused, found.saddles().first()) {
            (Some(why), _) => Err(format!("{scene}: {why}. What was found until then is in {out}")),
            (None, Some(label)) => Err(format!(
                "{scene}: {label} is no minimum or not known to be one. All states are in {out}"
            )),
            (None, None) => Ok(format!(
                "{}; {} and result.json in {out}\n",
                words::found(&found),
                pictures.join(", ")
            )),
        }
    }
}
