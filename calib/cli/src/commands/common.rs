//! What the commands share: where poses come from, where results go, and what can go wrong.

use std::path::{Path, PathBuf};

use clap::Args;

use crate::bounds::NotJudged;
use crate::calibration::{CalibrationError, CalibrationFile, Gate, Recorded};
use crate::input_files::columns::TableError;
use crate::live::{DwellError, FollowMarkers, Lacks, Listened, LiveArgs, LiveError, Run};
use crate::poses::{self, PosesError, Recording};
use crate::scene_context::SceneContext;
use crate::store::{self, StoreError};
use crate::values::Name;

/// The recording.
#[derive(Debug, Args)]
pub(crate) struct PosesArgs {
    /// Folder of 4x4 matrices, .csv file or PLUS sequence (.mha)
    #[arg(long, value_name = "PATH", required_unless_present = "live", conflicts_with = "live")]
    pub(crate) poses: Option<PathBuf>,
    /// Which transform of a sequence, for instance StylusToTracker, or which to compose of those that lead there
    #[arg(long, value_name = "NAME")]
    pub(crate) transform: Option<String>,
    /// Refuse time stamps that go backwards or stand still, and poses that repeat
    #[arg(long)]
    pub(crate) strict: bool,
    #[command(flatten)]
    pub(crate) live: LiveArgs,
    /// Keep the poses of the run in this file too, which --poses reads
    #[arg(long, value_name = "FILE.csv", requires = "live")]
    pub(crate) keep: Option<PathBuf>,
}

/// Names and the file of the result.
#[derive(Debug, Clone, Args)]
pub(crate) struct OutArgs {
    /// Name of the instrument, to be checked when the file is used [default: tool, or the scene's]
    #[arg(long)]
    tool: Option<Name>,
    /// Name of the marker on it, to be checked when the file is used [default: marker, or the scene's]
    #[arg(long)]
    marker: Option<Name>,
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
    Live(#[from] LiveError),
    #[error(transparent)]
    Dwell(#[from] DwellError),
    #[error("give the name of a run with --live, or a recording with --poses")]
    NoRun,
    #[error(transparent)]
    Store(#[from] StoreError),
    #[error(transparent)]
    NotJudged(#[from] NotJudged),
    #[error(transparent)]
    Calibration(#[from] CalibrationError),
    #[error(transparent)]
    Table(#[from] TableError),
    #[error("writing the result as JSON: {0}")]
    Encode(#[from] std::io::Error),
    /// What one command alone has to say.
    #[error(transparent)]
    Own(Box<dyn std::error::Error + Send + Sync>),
}

/// The errors of one command, kept beside it.
pub(crate) trait OwnError: std::error::Error + Send + Sync + 'static {}

impl<E: OwnError> From<E> for CommandError {
    fn from(error: E) -> Self {
        Self::Own(Box::new(error))
    }
}

/// What the person at the instrument is asked for.
pub(crate) struct Asked {
    /// For so long unless told otherwise.
    pub(crate) seconds: f64,
    /// To do what.
    pub(crate) what: &'static str,
}

impl Asked {
    /// A motion that calibrates.
    pub(crate) const MOTION: Self = Self {
        seconds: 20.0,
        what: "move the instrument",
    };
}

impl PosesArgs {
    /// Reads the recording, or listens to the run; `advise` says of the motion so far what is still missing.
    pub(crate) fn read(
        &self,
        run: Option<&mut Run<'_>>,
        asked: &Asked,
        advise: impl Fn(&Recording) -> Lacks,
    ) -> Result<Recording, CommandError> {
        if let (None, Some(path)) = (&run, &self.poses) {
            return Ok(Recording::read(path, self.transform.as_deref(), self.strict)?);
        }
        let run = run.ok_or(CommandError::NoRun)?;
        let seconds = self.live.seconds_or(asked.seconds);
        if !self.live.watch.is_there() {
            bus::stderr_line!("calib: listening to run {} for {seconds} s; {}", run.name(), asked.what);
        }
        let name = run.name().to_owned();
        // The poses that the result would be made of, not one more: what is shown meanwhile must not promise another.
        let lacks = |heard: &Listened| match Recording::heard(&name, heard) {
            Ok(recording) => advise(&recording),
            Err(_) => Lacks {
                words: heard.why.clone(),
                motion: None,
            },
        };
        let heard = run.listen(seconds, Some(&lacks))?;
        if let Some(path) = &self.keep {
            poses::keep(path, &heard)?;
        }
        Ok(Recording::heard(run.name(), &heard)?)
    }

    /// The run to listen to, where the command line names one.
    pub(crate) fn open<'a>(
        &self,
        scened: Option<&'a SceneContext>,
        follow: FollowMarkers,
    ) -> Result<Option<Run<'a>>, LiveError> {
        // Before twenty seconds are spent.
        if let Some(keep) = &self.keep {
            store::check(keep, false)?;
        }
        Run::open(scened, &self.live, follow)
    }

    /// The files that were read.
    pub(crate) fn inputs(&self) -> Vec<&Path> {
        self.poses.iter().chain(&self.keep).map(PathBuf::as_path).collect()
    }
}

impl OutArgs {
    /// The instrument's name.
    pub(crate) fn tool(&self) -> &str {
        self.tool.as_ref().map_or("tool", Name::as_str)
    }

    /// The marker's.
    pub(crate) fn marker(&self) -> &str {
        self.marker.as_ref().map_or("marker", Name::as_str)
    }

    /// With the names of a scene, which those given must be.
    pub(crate) fn of(&self, scened: Option<&SceneContext>) -> Result<Self, LiveError> {
        let Some(scened) = scened else { return Ok(self.clone()) };
        Ok(Self {
            tool: Some(scened.tool(self.tool.as_ref())?),
            marker: Some(scened.marker(self.marker.as_ref())?),
            ..self.clone()
        })
    }

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
    let words: Vec<String> = broken.map(|g| format!("{}: {}", g.words(), g.found_words())).collect();
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
        of: None,
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
        crate::text::shown(&recording.path.display().to_string())
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
    let word = match (gates.is_empty(), gates.iter().all(|gate| gate.kept)) {
        (true, _) => "no gate was given",
        (false, true) => "accepted",
        (false, false) => "NOT ACCEPTED",
    };
    gates_text(gates) + "verdict          " + word + "\n"
}

/// Gates a line.
pub(crate) fn gates_text(gates: &[Gate]) -> String {
    let word = |gate: &Gate| if gate.kept { "kept" } else { "NOT KEPT" };
    let line = |gate: &Gate| {
        format!(
            "gate             {}: {}, {}\n",
            gate.words(),
            gate.found_words(),
            word(gate)
        )
    };
    gates.iter().map(line).collect()
}
