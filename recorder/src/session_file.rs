//! One file of a session: growing under its own name, whole under the asked-for one.

use std::fs::{self, File, TryLockError};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::time::UNIX_EPOCH;

use bus::message::ToolPose;
use mcap::McapResult;

use crate::file_error::{FileError, write_error};
use crate::paths;
use crate::pose_log::{PoseLog, Unwritten};
use crate::schema::{RunFacts, Source};

/// A recording on disk.
#[derive(Debug)]
pub struct SessionFile {
    log: PoseLog<BufWriter<File>>,
    out: PathBuf,
    recording: PathBuf,
}

/// A recording that is whole.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Finished {
    /// Its name: the asked-for one, or a part of it where that was taken.
    pub path: PathBuf,
    /// Poses in it, of both topics.
    pub messages: u64,
}

impl SessionFile {
    /// Starts `out` under the name of a growing file, with the scene and the run's facts in front.
    ///
    /// # Errors
    /// [`FileError::Create`] also where a growing file of that name exists; [`FileError::Scene`], [`FileError::Write`].
    pub fn create(out: &Path, scene: &Path, facts: &RunFacts) -> Result<Self, FileError> {
        let recording = paths::recording(out);
        let (toml, created_ns) = read_scene(scene).map_err(|source| FileError::Scene {
            path: scene.to_owned(),
            source,
        })?;
        let file = File::options().write(true).create_new(true).open(&recording);
        let file = file.and_then(locked).map_err(|source| FileError::Create {
            path: recording.clone(),
            source,
        })?;
        let start = |file| -> McapResult<_> {
            let mut log = PoseLog::new(BufWriter::new(file))?;
            log.scene(&toml, created_ns)?;
            log.facts(facts)?;
            log.flush()?;
            Ok(log)
        };
        let log = start(file).map_err(|e| write_error(&recording, &e, Unwritten::default()))?;
        Ok(Self {
            log,
            out: out.to_owned(),
            recording,
        })
    }

    /// Takes a pose; it is on disk after the next [`SessionFile::flush`].
    ///
    /// # Errors
    /// [`FileError::Write`].
    pub fn pose(&mut self, source: Source, pose: &ToolPose) -> Result<(), FileError> {
        let taken = self.log.pose(source, pose);
        self.checked(taken)
    }

    /// Writes down what is known of the run.
    ///
    /// # Errors
    /// [`FileError::Write`].
    pub fn facts(&mut self, facts: &RunFacts) -> Result<(), FileError> {
        let written = self.log.facts(facts);
        self.checked(written)
    }

    /// Hands everything to the operating system: killing this process loses none of it.
    ///
    /// # Errors
    /// [`FileError::Write`], with what is lost.
    pub fn flush(&mut self) -> Result<(), FileError> {
        let flushed = self.log.flush();
        self.checked(flushed)
    }

    fn checked(&self, written: McapResult<()>) -> Result<(), FileError> {
        written.map_err(|e| write_error(&self.recording, &e, self.log.unwritten()))
    }

    /// Poses that no kill can lose any more, of both topics.
    pub fn written(&self) -> u64 {
        self.log.written()
    }

    /// What a kill would lose now.
    pub fn unwritten(&self) -> Unwritten {
        self.log.unwritten()
    }

    /// Completes the file, waits until the disk has it, and gives it its name. Nothing is overwritten: where `out`
    /// exists, the name is the next free part of it.
    ///
    /// # Errors
    /// [`FileError::Write`], [`FileError::Rename`].
    pub fn finish(mut self) -> Result<Finished, FileError> {
        self.flush()?;
        let messages = self.written();
        let whole = self.log.finish().and_then(|file| Ok(synced(file)?));
        whole.map_err(|e| write_error(&self.recording, &e, Unwritten::default()))?;
        let to = if self.out.exists() {
            paths::free_part(&self.out)
        } else {
            self.out
        };
        let renamed = fs::rename(&self.recording, &to).and_then(|()| paths::sync_folder(&to));
        renamed.map_err(|source| FileError::Rename {
            from: self.recording,
            to: to.clone(),
            source,
        })?;
        Ok(Finished { path: to, messages })
    }
}

/// Marks the file as being written, for as long as this process lives.
fn locked(file: File) -> io::Result<File> {
    match file.try_lock() {
        Ok(()) => Ok(file),
        // Some network file systems have no locks: recording goes on without.
        Err(TryLockError::Error(e)) if e.kind() == io::ErrorKind::Unsupported => Ok(file),
        Err(e) => Err(e.into()),
    }
}

pub(crate) fn synced(mut file: BufWriter<File>) -> io::Result<()> {
    file.flush()?;
    file.get_ref().sync_all()
}

/// The scene's text and its wall-clock time, ns since 1970.
fn read_scene(path: &Path) -> io::Result<(String, u64)> {
    let text = fs::read_to_string(path)?;
    let changed = fs::metadata(path)?.modified()?;
    let since_1970 = changed.duration_since(UNIX_EPOCH).unwrap_or_default();
    Ok((text, u64::try_from(since_1970.as_nanos()).unwrap_or(u64::MAX)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing;

    fn scene(dir: &Path) -> PathBuf {
        let path = dir.join("scene.toml");
        fs::write(&path, "seed = 1\n").unwrap();
        path
    }

    #[test]
    fn the_name_says_whether_the_file_is_whole() {
        let tmp = tempfile::tempdir().unwrap();
        let out = tmp.path().join("s.mcap");
        let mut file = SessionFile::create(&out, &scene(tmp.path()), &testing::facts()).unwrap();
        file.pose(Source::Tool, &testing::pose(0)).unwrap();
        assert!(!out.exists() && paths::recording(&out).exists());
        let finished = file.finish().unwrap();
        assert_eq!((finished.path.as_path(), finished.messages), (out.as_path(), 1));
        assert!(!paths::recording(&out).exists());
    }

    #[test]
    fn a_whole_recording_is_never_overwritten() {
        let tmp = tempfile::tempdir().unwrap();
        let out = tmp.path().join("s.mcap");
        fs::write(&out, "precious").unwrap();
        let file = SessionFile::create(&out, &scene(tmp.path()), &testing::facts()).unwrap();
        assert_eq!(file.finish().unwrap().path, tmp.path().join("s.1.mcap"));
        assert_eq!(fs::read_to_string(&out).unwrap(), "precious");
    }

    #[test]
    fn a_missing_folder_is_explained() {
        let tmp = tempfile::tempdir().unwrap();
        let out = tmp.path().join("missing/s.mcap");
        let error = SessionFile::create(&out, &scene(tmp.path()), &testing::facts())
            .unwrap_err()
            .to_string();
        assert!(error.contains("missing/s.mcap.recording: No such file"), "{error}");
    }
}
