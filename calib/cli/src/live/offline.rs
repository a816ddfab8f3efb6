//! Poses that a caller holds in the place of a run: the files that commands read are written of them, by the functions that a live run
//! goes through.

use std::path::Path;

use geometry::{Marker, Tracker, Uncertain, UncertainPoint};

use super::touches::add_of;
use super::{Listened, LiveError, MostMotion, tip_in, touched};
use crate::commands::common::CommandError;
use crate::poses;

/// Why poses gave no file.
#[derive(Debug, thiserror::Error)]
#[error(transparent)]
pub struct OfflineError(#[from] Box<dyn std::error::Error + Send + Sync>);

impl From<LiveError> for OfflineError {
    fn from(error: LiveError) -> Self {
        Self(Box::new(error))
    }
}

impl From<CommandError> for OfflineError {
    fn from(error: CommandError) -> Self {
        Self(Box::new(error))
    }
}

/// What was heard of a marker.
#[derive(Debug, Clone, Default)]
pub struct HeardPoses {
    /// Its poses, in the localizer or in the marker on the patient, which the tracker stands for.
    pub poses: Vec<Uncertain<Tracker, Marker>>,
    /// When each was captured, s.
    pub times_s: Vec<f64>,
    /// Frames without a pose.
    pub lost: usize,
    /// Why the last of these had none.
    pub why: String,
}

impl HeardPoses {
    /// Writes a file that `calib pivot`, `spin` and `seat` read (`--poses`), as `--keep` writes it of a run.
    ///
    /// # Errors
    /// [`OfflineError`]: a file that is there already, or cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), OfflineError> {
        Ok(poses::keep(path, &self.listened())?)
    }

    /// Adds the touch of the point `name` to the file `to`, as `calib touch --tip` does of a run of the tool `tool`: the mean
    /// place of the tip that `tip` names, in the frame `frame` (`tracker` or `reference`), with its covariance. `seconds` is how
    /// long it took, for words.
    ///
    /// # Errors
    /// [`OfflineError`]: a tip that moved, too few or too many lost frames, a file of another tip.
    pub fn touch(
        &self,
        (name, tool, frame): (&str, &str, &str),
        tip: &Path,
        to: &Path,
        seconds: f64,
    ) -> Result<UncertainPoint<Tracker>, OfflineError> {
        let (file, tip_in_marker) = tip_in(tip)?;
        file.of_tool(tip, "run", tool).map_err(CommandError::from)?;
        let touch = touched(name, &self.listened(), &tip_in_marker, MostMotion::USUAL, seconds)?;
        add_of(to, (name, tool, frame), &tip_in_marker, (&touch.place, &touch.shared))?;
        Ok(touch.place)
    }

    fn listened(&self) -> Listened {
        let mut listened = Listened::recorded(self.poses.clone(), self.times_s.clone(), Vec::new());
        listened.frames += self.lost;
        listened.why.clone_from(&self.why);
        listened
    }
}
