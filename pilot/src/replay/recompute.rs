//! `pilot replay --recompute`: poses made again from what the localizer delivered, through another calibration or registration.
//!
//! The replayer publishes the recorded frames of emitters or of markers in place of the poses, the run's own tracker makes poses of them, and a
//! recorder writes these. Calibration and registration are those of the command line; where it names none, those that the
//! recorded run began with, out of the recording. At the end `recorder compare` says how far the poses lie apart.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use scene::RawRecording;
use scene::raw::{RawScene, RawTrackerSource};
use scene::tracking::raw::{RawCalibrationFile, RawRegistrationFile};
use serde::Serialize;
use serde_json::Value;

use super::args::ReplayArgs;
use super::facts::Facts;
use crate::output::RECOMPUTED;
use crate::spawn;

/// Files out of the recording, in the output folder.
const LINKS: &str = "links";

/// Why poses cannot be made again.
#[derive(Debug, thiserror::Error)]
pub(crate) enum RecomputeError {
    #[error(
        "{recording} holds no {frames} (topic /{frames}), of which poses could be made again: they are recorded where the scene's \
         tracker is \"operating-room\", \"emitters\" or \"markers\". Without `--recompute` its own poses are replayed"
    )]
    NoFrames { recording: PathBuf, frames: &'static str },
    #[error("{recording}: no poses can be made of its {frames}: {why}")]
    Frames {
        recording: PathBuf,
        frames: &'static str,
        why: String,
    },
    #[error(
        "the poses of {recording} come from a tracker of source {found:?}, which makes none of {frames}; needed is a scene \
         whose tracker is {needed} and describes the tool's marker: `--scene SCENE.toml`"
    )]
    NoChain {
        recording: PathBuf,
        found: String,
        frames: &'static str,
        needed: &'static str,
    },
    #[error("--{key} {path}: {why}; give the path of a file that `calib` wrote")]
    NoFile {
        key: &'static str,
        path: PathBuf,
        why: String,
    },
    #[error(
        "{recording} holds {count} different files named {name:?}, and its scene does not say which of them was the \
         {key}: give the right one with `--{key} FILE`"
    )]
    Ambiguous {
        recording: PathBuf,
        count: usize,
        name: String,
        key: &'static str,
    },
    #[error(
        "{0} was recorded in a scene without [tissue]: there are no states that could be made again. `--recompute` makes poses again"
    )]
    NoTissue(PathBuf),
    #[error("writing {path} out of the recording: {source}")]
    Write { path: PathBuf, source: io::Error },
}

/// What poses are made again with.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Recompute {
    /// What the poses are made of, as the replayer calls it: `emitters` or `markers`; `None`: poses are the recorded ones, and a model
    /// answers them again.
    pub(crate) frames: Option<&'static str>,
    /// The file of the calibration; `None`: the numbers of the scene.
    pub(crate) calibration: Option<PathBuf>,
    /// That of the registration.
    pub(crate) registration: Option<PathBuf>,
    /// Files out of the recording: where they go, and what they say.
    files: Vec<(PathBuf, String)>,
}

/// What came of it.
#[derive(Debug, Clone, Default, Serialize)]
pub(crate) struct Recomputed {
    pub(crate) calibration: Option<PathBuf>,
    pub(crate) registration: Option<PathBuf>,
    /// What `recorder compare` found between the recorded poses and the new ones: its `compare.json`.
    pub(crate) difference: Option<Value>,
    /// The same in words.
    #[serde(skip)]
    pub(crate) words: String,
    #[serde(skip)]
    problems: Vec<String>,
}

impl Recompute {
    /// Changes `scene` so that its tracker makes poses of what the recording's localizer delivered and a recorder writes them.
    pub(crate) fn prepare(
        args: &ReplayArgs,
        facts: &Facts,
        recording: &Path,
        scene: &mut RawScene,
    ) -> Result<Self, RecomputeError> {
        let frames = Some(check(facts, recording, scene)?);
        record(scene);
        let mut links = Links {
            facts,
            recording,
            folder: absolute(&args.out).join(LINKS),
            files: Vec::new(),
        };
        let tracker = &mut scene.tracker;
        let named = tracker.calibration.as_ref().map(|link| link.file.as_str());
        let calibration = links.choose("calibration", args.calibration.as_deref(), named)?;
        let named = tracker.registration.as_ref().map(|link| link.file.as_str());
        let registration = links.choose("registration", args.registration.as_deref(), named)?;
        // Another file has to keep the gates of the scene as well, if that has any.
        if let Some(path) = &calibration {
            let link = tracker.calibration.get_or_insert_with(RawCalibrationFile::default);
            link.file = path.to_string_lossy().into_owned();
        }
        if let Some(path) = &registration {
            let link = tracker.registration.get_or_insert_with(RawRegistrationFile::default);
            link.file = path.to_string_lossy().into_owned();
        }
        Ok(Self {
            frames,
            calibration,
            registration,
            files: links.files,
        })
    }

    /// Changes `scene` so that a recorder writes what its model answers to the recorded poses.
    pub(crate) fn tissue(recording: &Path, scene: &mut RawScene) -> Result<Self, RecomputeError> {
        if scene.tissue.is_none() {
            return Err(RecomputeError::NoTissue(recording.to_owned()));
        }
        record(scene);
        Ok(Self::default())
    }

    /// Writes the files out of the recording to where the tracker looks for them.
    pub(crate) fn write_files(&self) -> Result<(), RecomputeError> {
        for (path, text) in &self.files {
            let folder = path.parent().map_or(Ok(()), fs::create_dir_all);
            folder
                .and_then(|()| fs::write(path, text))
                .map_err(|source| RecomputeError::Write {
                    path: path.clone(),
                    source,
                })?;
        }
        Ok(())
    }

    /// States that were made again and are not the recorded ones, or were not made.
    fn tissue_problem(&self, difference: Option<&Value>) -> Option<String> {
        let tissue = difference
            .filter(|_| self.frames.is_none())
            .map(|found| &found["tissue"])?;
        let count = |key: &str| tissue[key].as_u64().unwrap_or(0);
        let missing = tissue["alone"][0].as_u64().unwrap_or(0);
        let differ = count("common") - count("identical").min(count("common"));
        let words = format!(
            "{differ} states of the tissue are not the recorded ones to the bit, and {missing} were not made again"
        );
        (differ + missing > 0).then_some(words)
    }

    /// Holds the new poses against the recorded ones; table, plot and summary go into `out`.
    pub(crate) fn compare(&self, recording: &Path, out: &Path) -> Recomputed {
        let mut found = Recomputed {
            calibration: self.calibration.clone(),
            registration: self.registration.clone(),
            ..Recomputed::default()
        };
        let new = out.join(RECOMPUTED);
        let arguments = [
            "compare".as_ref(),
            recording.as_os_str(),
            new.as_os_str(),
            "--out".as_ref(),
            out.as_os_str(),
        ];
        match spawn::ask("recorder", &arguments) {
            (_, Ok(output)) if output.status.success() => {
                found.words = String::from_utf8_lossy(&output.stdout).trim_end().to_owned();
                let summary = fs::read(out.join("compare.json")).unwrap_or_default();
                found.difference = serde_json::from_slice(&summary).ok();
                found.problems.extend(self.tissue_problem(found.difference.as_ref()));
            }
            (_, Ok(_)) => found
                .problems
                .push("the new poses were not compared, for the reason given on stderr".to_owned()),
            (program, Err(error)) => found.problems.push(format!(
                "the new poses were not compared: {}: {error}",
                program.display()
            )),
        }
        found.problems.extend(shortfalls(out));
        found
    }
}

impl Recomputed {
    /// What was wrong, in words.
    pub(crate) fn problems(&self) -> &[String] {
        &self.problems
    }
}

/// What is made again goes into one file, which can be compared.
fn record(scene: &mut RawScene) {
    scene.recording = Some(RawRecording {
        rotate_mb: 0.0,
        rotate_min: 0.0,
        thumbnails_per_s: 0.0,
        ..scene.recording.clone().unwrap_or_default()
    });
}

fn absolute(path: &Path) -> PathBuf {
    std::path::absolute(path).unwrap_or_else(|_| path.to_owned())
}

/// What the poses can be made of: what is recorded and what the scene has a chain for.
fn check(facts: &Facts, recording: &Path, scene: &RawScene) -> Result<&'static str, RecomputeError> {
    let recording = recording.to_owned();
    let has_markers = facts.markers > 0;
    let (frames, count, refused) = match scene.tracker.source {
        RawTrackerSource::Markers => ("markers", facts.markers, facts.markers_refused.clone()),
        RawTrackerSource::OperatingRoom | RawTrackerSource::Emitters => {
            ("emitters", facts.emitters, facts.emitters_refused.clone())
        }
        _ if has_markers => ("markers", facts.markers, None),
        _ => ("emitters", facts.emitters, facts.emitters_refused.clone()),
    };
    if count == 0 {
        return Err(RecomputeError::NoFrames { recording, frames });
    }
    if let Some(why) = refused {
        return Err(RecomputeError::Frames { recording, frames, why });
    }
    match scene.tracker.source {
        RawTrackerSource::OperatingRoom | RawTrackerSource::Emitters | RawTrackerSource::Markers => Ok(frames),
        other => Err(RecomputeError::NoChain {
            recording,
            found: toml::Value::try_from(other).map_or_else(|_| String::new(), |v| v.as_str().unwrap_or("").to_owned()),
            frames,
            needed: match has_markers {
                true => "\"markers\"",
                false => "\"operating-room\" or \"emitters\"",
            },
        }),
    }
}

/// What the replayer says it could not do.
fn shortfalls(out: &Path) -> Vec<String> {
    let account = fs::read(out.join(super::ACCOUNT)).unwrap_or_default();
    let account: Value = serde_json::from_slice(&account).unwrap_or_default();
    let count = |key: &str| account[key].as_u64().unwrap_or(0);
    let mut found = Vec::new();
    match count("without_frames") {
        0 => {}
        n => found.push(format!(
            "{n} poses were not made again: what the localizer saw for them is not in the recording"
        )),
    }
    match count("unanswered") {
        0 => {}
        n => found.push(format!("of {n} frames the tracker made no pose in time")),
    }
    found
}

/// Where calibration and registration come from.
struct Links<'a> {
    facts: &'a Facts,
    recording: &'a Path,
    folder: PathBuf,
    files: Vec<(PathBuf, String)>,
}

impl Links<'_> {
    /// The file of the command line, else the recording's copy of the one that the scene names, else that one itself.
    fn choose(
        &mut self,
        key: &'static str,
        given: Option<&Path>,
        named: Option<&str>,
    ) -> Result<Option<PathBuf>, RecomputeError> {
        match (given, named) {
            (Some(path), _) => readable(key, path).map(Some),
            (None, Some(file)) => self.recorded(key, Path::new(file)).map(Some),
            (None, None) => Ok(None),
        }
    }

    fn recorded(&mut self, key: &'static str, path: &Path) -> Result<PathBuf, RecomputeError> {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let mut copies: Vec<&str> = self
            .facts
            .files
            .iter()
            .filter(|file| file.name == name)
            .map(|file| file.text.as_str())
            .collect();
        copies.sort_unstable();
        copies.dedup();
        match copies[..] {
            // It was not there when the recording began.
            [] => Ok(path.to_owned()),
            [text] => {
                let path = self.folder.join(name);
                self.files.push((path.clone(), text.to_owned()));
                Ok(path)
            }
            _ => Err(RecomputeError::Ambiguous {
                recording: self.recording.to_owned(),
                count: copies.len(),
                name,
                key,
            }),
        }
    }
}

/// A file that can be opened, by its whole path.
fn readable(key: &'static str, path: &Path) -> Result<PathBuf, RecomputeError> {
    let refused = |why: String| RecomputeError::NoFile {
        key,
        path: path.to_owned(),
        why,
    };
    match fs::metadata(path) {
        Ok(facts) if facts.is_file() => Ok(absolute(path)),
        Ok(_) => Err(refused("it is not a file".to_owned())),
        Err(error) => Err(refused(error.to_string())),
    }
}

#[cfg(test)]
mod tests;
