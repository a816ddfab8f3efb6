//! What the commands share: where poses come from, where results go, and what can go wrong.

use std::path::{Path, PathBuf};

use clap::Args;

use crate::base::{DrawingFileError, NoBase, NoSeat};
use crate::bundle::{DrawingError, NoMarker};
use crate::calibration::{CalibrationError, CalibrationFile, Gate, Recorded};
use crate::cli::Name;
use crate::columns::TableError;
use crate::f2554::F2554Error;
use crate::poses::{PosesError, Recording};
use crate::rom::{NoTool, RomError};
use crate::store::{self, StoreError};

/// The recording.
#[derive(Debug, Args)]
pub(crate) struct PosesArgs {
    /// Folder of 4x4 matrices, .csv file or PLUS sequence (.mha)
    #[arg(long, value_name = "PATH")]
    pub(crate) poses: PathBuf,
    /// Which transform of a sequence, for instance StylusToTracker
    #[arg(long, value_name = "NAME")]
    pub(crate) transform: Option<String>,
    /// Refuse time stamps that go backwards or stand still, and poses that repeat
    #[arg(long)]
    pub(crate) strict: bool,
}

/// Names and the file of the result.
#[derive(Debug, Args)]
pub(crate) struct OutArgs {
    /// Name of the instrument, to be checked when the file is used
    #[arg(long, default_value = "tool")]
    pub(crate) tool: Name,
    /// Name of the marker on it, to be checked when the file is used
    #[arg(long, default_value = "marker")]
    pub(crate) marker: Name,
    /// Write the result here, as JSON
    #[arg(long, value_name = "FILE.json")]
    pub(crate) out: Option<PathBuf>,
    /// Replace that file if it exists
    #[arg(long, requires = "out")]
    pub(crate) overwrite: bool,
    /// Print the result as JSON and nothing else
    #[arg(long)]
    pub(crate) json: bool,
}

/// What a command has to say.
#[derive(Debug)]
pub(crate) struct Outcome {
    /// For stdout.
    pub(crate) text: String,
    /// Why the result was not accepted, where it was not.
    pub(crate) refused: Option<String>,
}

/// Why there is no result.
#[derive(Debug, thiserror::Error)]
pub(crate) enum CommandError {
    #[error(transparent)]
    Poses(#[from] PosesError),
    #[error(transparent)]
    Store(#[from] StoreError),
    #[error(transparent)]
    Calibration(#[from] CalibrationError),
    #[error("pivot calibration from the {poses} poses of {path}{left_out}: {refused}")]
    Pivot {
        poses: usize,
        path: PathBuf,
        left_out: String,
        refused: Box<calib::pivot::Refused>,
    },
    #[error("spin calibration from the {poses} poses of {path}{left_out}: {refused}")]
    Spin {
        poses: usize,
        path: PathBuf,
        left_out: String,
        refused: Box<calib::spin::Refused>,
    },
    #[error("the tool's frame from {pivot} and {spin}: {refused}")]
    Tool {
        pivot: PathBuf,
        spin: PathBuf,
        refused: Box<calib::spin::Refused>,
    },
    #[error("{path}: the pivot calibration has no covariance (method {method}); make it by errors-in-variables")]
    NoCovariance { path: PathBuf, method: String },
    #[error("--towards: the direction must not be 0,0,0")]
    NoDirection,
    #[error(transparent)]
    Table(#[from] TableError),
    #[error(transparent)]
    Drawing(#[from] DrawingError),
    #[error(transparent)]
    NoMarker(#[from] NoMarker),
    #[error(transparent)]
    BaseDrawing(#[from] DrawingFileError),
    #[error(transparent)]
    NoBase(#[from] NoBase),
    #[error(transparent)]
    NoSeat(#[from] NoSeat),
    #[error(transparent)]
    Rom(#[from] RomError),
    #[error(transparent)]
    NoTool(#[from] NoTool),
    #[error(transparent)]
    F2554(#[from] F2554Error),
    #[error("no table for a scene: emitters {missing:?} have no place; record frames that show them")]
    NoTable { missing: Vec<usize> },
    #[error("give a file of frames, or --rom")]
    NoInput,
    #[error("writing the result as JSON: {0}")]
    Encode(#[from] std::io::Error),
}

impl PosesArgs {
    pub(crate) fn read(&self) -> Result<Recording, PosesError> {
        Recording::read(&self.poses, self.transform.as_deref(), self.strict)
    }
}

impl OutArgs {
    /// Refuses what cannot be written before the work is done.
    pub(crate) fn check(&self) -> Result<(), StoreError> {
        self.out
            .as_deref()
            .map_or(Ok(()), |out| store::check(out, self.overwrite))
    }

    /// Writes an accepted file; its words, or the file itself with `--json`.
    pub(crate) fn finish(
        &self,
        file: CalibrationFile,
        mut text: String,
        inputs: &[&Path],
    ) -> Result<Outcome, CommandError> {
        let file = file.sealed()?;
        let refused = broken(&file.gates);
        let encoded = file.to_json()?;
        if let Some(out) = &self.out {
            if refused.is_none() {
                store::write(out, Ok(encoded.clone()), inputs.iter().copied())?;
                text.push_str(&format!("\nwritten to {}, id {}\n", out.display(), file.id));
            } else {
                text.push_str(&format!("\nnot written to {}\n", out.display()));
            }
        }
        let text = if self.json { encoded } else { text };
        Ok(Outcome { text, refused })
    }
}

/// The gates that were not kept, in words.
pub(crate) fn broken(gates: &[Gate]) -> Option<String> {
    let broken = gates.iter().filter(|gate| !gate.kept);
    let words: Vec<String> = broken
        .map(|g| format!("--{} {}: found {:.4}", g.name, g.limit, g.found))
        .collect();
    (!words.is_empty()).then(|| format!("the result is not accepted: {}", words.join("; ")))
}

/// A gate that the result must stay below, or above where `at_least`; none without a limit.
pub(crate) fn gate(name: &str, limit: Option<f64>, found: f64, at_least: bool) -> Option<Gate> {
    let limit = limit?;
    let kept = if at_least { found >= limit } else { found <= limit };
    let name = name.to_owned();
    Some(Gate {
        name,
        limit,
        found,
        kept,
    })
}

/// What of a recording does not take part, for an error: nothing where all does.
pub(crate) fn left_out(recording: &Recording) -> String {
    let Recording {
        frames,
        invalid,
        repeated,
        ..
    } = recording;
    if invalid + repeated == 0 {
        return String::new();
    }
    format!(" (of its {frames} frames {invalid} are not valid and {repeated} repeat the one before)")
}

/// What was read, in words.
pub(crate) fn recorded_text(recording: &Recording) -> String {
    let name = recording
        .transform
        .as_deref()
        .map_or(String::new(), |name| format!(" ({name})"));
    let mut text = format!(
        "{} poses from {} frames of {}{name}\n",
        recording.poses.len(),
        recording.frames,
        crate::report::shown(&recording.path.display().to_string())
    );
    let Recording {
        invalid,
        repeated,
        backwards,
        same_time,
        most_off,
        ..
    } = recording;
    for (count, what) in [
        (invalid, "frames are marked as not valid and were left out"),
        (repeated, "poses repeat the one before and were left out"),
        (backwards, "time stamps go backwards; --strict refuses that"),
        (
            same_time,
            "time stamps are equal to the one before; --strict refuses that",
        ),
    ] {
        if *count > 0 {
            text.push_str(&format!("  {count} {what}\n"));
        }
    }
    if *most_off > 1e-9 {
        text.push_str(&format!(
            "  rotations were off by up to {most_off:.1e} and were put right\n"
        ));
    }
    text
}

/// What was read, for the file.
pub(crate) fn recorded(recording: &Recording) -> Recorded {
    Recorded {
        path: recording.path.to_string_lossy().into_owned(),
        bytes: recording.bytes,
        source_blake3: recording.blake3.clone(),
        transform: recording.transform.clone(),
        frames: recording.frames,
        poses: recording.poses.len(),
        invalid: recording.invalid,
        repeated: recording.repeated,
        backwards: recording.backwards,
        same_time: recording.same_time,
        matrix_off: recording.most_off,
    }
}

/// The verdict on gates, in words.
pub(crate) fn verdict_text(gates: &[Gate]) -> String {
    let mut text = String::new();
    for gate in gates {
        let word = if gate.kept { "kept" } else { "NOT KEPT" };
        text.push_str(&format!(
            "gate             --{} {}: found {:.4}, {word}\n",
            gate.name, gate.limit, gate.found
        ));
    }
    let word = match (gates.is_empty(), gates.iter().all(|gate| gate.kept)) {
        (true, _) => "no gate was given",
        (false, true) => "accepted",
        (false, false) => "NOT ACCEPTED",
    };
    text + "verdict          " + word + "\n"
}
