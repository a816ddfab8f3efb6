//! One file of a session: growing under its own name, whole under the asked-for one.

use std::fs::{self, File, TryLockError};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use mcap::McapResult;
use mcap::records::Metadata;
use scene::Compression;

use crate::wire::proto::{self, Identity};
use crate::wire::schema::RunFacts;
use crate::write::beside::Beside;
use crate::write::file_error::{FileError, write_error};
use crate::write::paths;
use crate::write::pose_log::{Entry, PoseLog, Unwritten};
use crate::write::scene_text;
use crate::write::sink::Sink;

/// What every file of a session begins with, and how it is written.
#[derive(Debug, Clone)]
pub struct Content {
    /// The scene file.
    pub scene: PathBuf,
    /// What is known of the run.
    pub facts: RunFacts,
    /// Files attached beside the scene.
    pub beside: Vec<Beside>,
    /// How chunks are compressed.
    pub compression: Compression,
    /// The views that have small images.
    pub views: Vec<String>,
    /// Whether the file says whose examination it is, in the scene and by itself; else nothing in it does.
    pub is_named: bool,
    /// Whose it is, once that is known, in a file that says so.
    pub identity: Option<Identity>,
    /// What was chosen last before the file began, and when the file began, ns; `None`: nothing that is known.
    pub guide: Option<(i64, proto::Guide)>,
    /// How far the run had come when the file began, with that time.
    pub workflow: Option<proto::Workflow>,
    /// The organs at rest that the states of the file are of.
    pub mesh: Option<proto::TissueMesh>,
}

impl Content {
    /// The scene and the facts, nothing else.
    pub fn new(scene: &Path, facts: &RunFacts) -> Self {
        Self {
            scene: scene.to_owned(),
            facts: facts.clone(),
            beside: Vec::new(),
            compression: Compression::Zstd,
            views: Vec::new(),
            is_named: false,
            identity: None,
            guide: None,
            workflow: None,
            mesh: None,
        }
    }
}

/// A recording on disk.
#[derive(Debug)]
pub struct SessionFile {
    log: PoseLog<Sink>,
    file: Arc<File>,
    size: Arc<AtomicU64>,
    /// Bytes that it began with.
    head: u64,
    out: PathBuf,
    recording: PathBuf,
}

/// A recording that is whole.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Finished {
    /// Its name: the asked-for one, or a part of it where that was taken.
    pub path: PathBuf,
    /// Poses and frames of the localizer in it.
    pub messages: u64,
}

/// A recording that is complete, and waits for the disk and for its name.
#[derive(Debug)]
pub struct Complete {
    /// The file.
    pub file: Arc<File>,
    /// Its name until the disk has it.
    pub from: PathBuf,
    /// Its name from then on.
    pub to: PathBuf,
}

impl SessionFile {
    /// Starts `out` under the name of a growing file, with what every file begins with in front.
    ///
    /// # Errors
    /// [`FileError::Create`] also where a growing file of that name exists; [`FileError::Scene`], [`FileError::Write`].
    pub fn create(out: &Path, content: &Content) -> Result<Self, FileError> {
        let recording = paths::recording(out);
        let (toml, created_ns) =
            scene_text::read(&content.scene, content.is_named).map_err(|source| FileError::Scene {
                path: content.scene.clone(),
                source,
            })?;
        let file = File::options().write(true).create_new(true).open(&recording);
        let file = file.and_then(locked).map_err(|source| FileError::Create {
            path: recording.clone(),
            source,
        })?;
        let file = Arc::new(file);
        let sink = Sink::new(Arc::clone(&file));
        let size = sink.size();
        let start = || -> McapResult<_> {
            let mut log = PoseLog::new(sink, content.compression, &content.views)?;
            log.scene(&toml, created_ns)?;
            for beside in &content.beside {
                log.attach(&beside.name, beside.media_type, &beside.bytes, beside.changed_ns)?;
            }
            log.facts(&content.facts)?;
            if content.is_named {
                log.with_identity()?;
            }
            if let Some(identity) = content.identity.as_ref().filter(|_| content.is_named) {
                log.put(Entry::Identity(identity))?;
            }
            if let Some((now_ns, guide)) = &content.guide {
                log.put(Entry::Guide(*now_ns, guide))?;
            }
            if let Some(workflow) = &content.workflow {
                log.put(Entry::Workflow(workflow))?;
            }
            if let Some(mesh) = &content.mesh {
                log.put(Entry::TissueMesh(mesh))?;
            }
            log.flush()?;
            Ok(log)
        };
        let log = start().map_err(|e| {
            // Made just now, and empty but for what every file begins with.
            let _ = fs::remove_file(&recording);
            write_error(&recording, &e, Unwritten::default())
        })?;
        Ok(Self {
            log,
            file,
            head: size.load(Ordering::Relaxed),
            size,
            out: out.to_owned(),
            recording,
        })
    }

    /// Takes a message; it is on disk after the next [`SessionFile::flush`].
    ///
    /// # Errors
    /// [`FileError::Write`].
    pub fn put(&mut self, entry: Entry<'_>) -> Result<(), FileError> {
        let taken = self.log.put(entry);
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

    /// Writes a metadata record.
    ///
    /// # Errors
    /// [`FileError::Write`].
    pub fn metadata(&mut self, metadata: &Metadata) -> Result<(), FileError> {
        let written = self.log.metadata(metadata);
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

    /// Poses and frames of the localizer that no kill can lose any more.
    pub fn written(&self) -> u64 {
        self.log.written()
    }

    /// What a kill would lose now.
    pub fn unwritten(&self) -> Unwritten {
        self.log.unwritten()
    }

    /// Whether anything came since the last flush.
    pub fn is_dirty(&self) -> bool {
        self.log.is_dirty()
    }

    /// Bytes that it began with: scene, schemas, organs at rest.
    pub fn head(&self) -> u64 {
        self.head
    }

    /// Bytes that no kill can lose any more.
    pub fn bytes(&self) -> u64 {
        self.size.load(Ordering::Relaxed)
    }

    /// The file, for whoever waits for the disk.
    pub fn file(&self) -> &Arc<File> {
        &self.file
    }

    /// Completes the file, waits until the disk has it, and gives it its name. Nothing is overwritten: where `out`
    /// exists, the name is the next free part of it.
    ///
    /// # Errors
    /// [`FileError::Write`], [`FileError::Sync`] where the disk did not keep it, [`FileError::Rename`].
    pub fn finish(mut self) -> Result<Finished, FileError> {
        self.flush()?;
        let messages = self.written();
        let whole = self.log.finish().and_then(|mut sink| Ok(sink.flush()?));
        whole.map_err(|e| write_error(&self.recording, &e, Unwritten::default()))?;
        self.file.sync_all().map_err(|e| FileError::Sync {
            path: self.recording.clone(),
            why: e.to_string(),
        })?;
        let to = if self.out.exists() {
            paths::free_part(&self.out)
        } else {
            self.out
        };
        renamed(&self.recording, &to)?;
        Ok(Finished { path: to, messages })
    }

    /// Completes the file as a part of the session, without waiting for the disk: the name of the growing file is free
    /// for the next one.
    ///
    /// # Errors
    /// [`FileError::Write`], [`FileError::Rename`].
    pub fn complete(mut self) -> Result<Complete, FileError> {
        self.flush()?;
        let whole = self.log.finish().and_then(|mut sink| Ok(sink.flush()?));
        whole.map_err(|e| write_error(&self.recording, &e, Unwritten::default()))?;
        let to = paths::free_part(&self.out);
        let from = paths::recording(&to);
        renamed(&self.recording, &from)?;
        let file = self.file;
        Ok(Complete { file, from, to })
    }

    /// Leaves the file as it is, as the growing file of a part: the name is free for the next one. Gives its new name.
    ///
    /// # Errors
    /// [`FileError::Rename`].
    pub fn abandon(self) -> Result<PathBuf, FileError> {
        drop(self.log.abandon());
        let to = paths::recording(&paths::free_part(&self.out));
        renamed(&self.recording, &to)?;
        Ok(to)
    }

    /// Leaves a file that has its name no longer, and touches nothing that has it now.
    pub fn forget(self) {
        drop(self.log.abandon());
    }
}

fn renamed(from: &Path, to: &Path) -> Result<(), FileError> {
    let done = fs::rename(from, to).and_then(|()| paths::sync_folder(to));
    done.map_err(|source| FileError::Rename {
        from: from.to_owned(),
        to: to.to_owned(),
        source,
    })
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing;
    use crate::wire::schema::Source;

    fn content(dir: &Path) -> Content {
        let path = dir.join("scene.toml");
        fs::write(&path, "seed = 1\n").unwrap();
        Content::new(&path, &testing::facts())
    }

    #[test]
    fn the_name_says_whether_the_file_is_whole() {
        let tmp = tempfile::tempdir().unwrap();
        let out = tmp.path().join("s.mcap");
        let mut file = SessionFile::create(&out, &content(tmp.path())).unwrap();
        file.put(Entry::Pose(Source::Tool, &testing::pose(0))).unwrap();
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
        let file = SessionFile::create(&out, &content(tmp.path())).unwrap();
        assert_eq!(file.finish().unwrap().path, tmp.path().join("s.1.mcap"));
        assert_eq!(fs::read_to_string(&out).unwrap(), "precious");
    }

    #[test]
    fn a_missing_folder_is_explained() {
        let tmp = tempfile::tempdir().unwrap();
        let out = tmp.path().join("missing/s.mcap");
        let error = SessionFile::create(&out, &content(tmp.path())).unwrap_err().to_string();
        assert!(error.contains("missing/s.mcap.recording: No such file"), "{error}");
    }

    #[test]
    fn a_part_is_complete_and_leaves_the_name_to_the_next() {
        let tmp = tempfile::tempdir().unwrap();
        let out = tmp.path().join("s.mcap");
        let first = SessionFile::create(&out, &content(tmp.path())).unwrap();
        let complete = first.complete().unwrap();
        assert_eq!(complete.to, tmp.path().join("s.1.mcap"));
        assert!(crate::read::info::info(&complete.from).unwrap().damage.is_empty());
        let second = SessionFile::create(&out, &content(tmp.path())).unwrap();
        let left = second.abandon().unwrap();
        assert_eq!(left, tmp.path().join("s.2.mcap.recording"));
        assert!(SessionFile::create(&out, &content(tmp.path())).is_ok());
    }

    #[test]
    fn what_stands_beside_the_scene_is_attached() {
        let tmp = tempfile::tempdir().unwrap();
        let out = tmp.path().join("s.mcap");
        let mut content = content(tmp.path());
        content.beside.push(Beside {
            name: "tool.json".to_owned(),
            media_type: "application/json",
            bytes: b"{}".to_vec(),
            changed_ns: 5,
        });
        let finished = SessionFile::create(&out, &content).unwrap().finish().unwrap();
        let session = crate::read::seek::Session::open(&finished.path).unwrap();
        assert_eq!(session.attachment("tool.json").unwrap().as_deref(), Some(&b"{}"[..]));
    }
}
