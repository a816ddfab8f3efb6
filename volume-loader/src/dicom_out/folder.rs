//! A folder that is whole or absent.

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use super::ExportError;
use super::error::io;

/// A folder under a name of its own beside its target, removed again unless it is renamed.
#[derive(Debug)]
pub(super) struct Partial {
    path: PathBuf,
    /// What it will replace or become: links, `.` and `..` followed.
    target: PathBuf,
    done: bool,
}

impl Partial {
    /// A new folder beside `target`, which must be absent or an empty folder.
    ///
    /// # Errors
    /// [`ExportError::NotEmpty`], [`ExportError::NotAFolder`], [`ExportError::Io`].
    pub(super) fn create(target: &Path) -> Result<Self, ExportError> {
        let target = match check_empty(target)? {
            true => target.canonicalize().map_err(io(target, "find its place"))?,
            false => target.to_owned(),
        };
        // Two writers of one process, and of two, never share a name.
        static COUNT: AtomicU64 = AtomicU64::new(0);
        let count = COUNT.fetch_add(1, Ordering::Relaxed);
        let name = target.file_name().unwrap_or_default().to_string_lossy();
        let path = target.with_file_name(format!(".{name}.{}-{count}.part", std::process::id()));
        fs::create_dir(&path).map_err(io(&target, "make a new folder beside it"))?;
        let done = false;
        Ok(Self { path, target, done })
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// Gives the folder its name.
    ///
    /// # Errors
    /// [`ExportError::Io`], also where somebody has put something there meanwhile.
    pub(super) fn rename(mut self) -> Result<(), ExportError> {
        fs::rename(&self.path, &self.target).map_err(io(&self.target, "give the folder its name"))?;
        self.done = true;
        Ok(())
    }
}

impl Drop for Partial {
    fn drop(&mut self) {
        if !self.done {
            // Nobody is left to tell: the first failure is already on its way up.
            let _ = fs::remove_dir_all(&self.path);
        }
    }
}

/// Whether there is an empty folder; anything else that is there is refused.
fn check_empty(target: &Path) -> Result<bool, ExportError> {
    let path = target.to_owned();
    match fs::metadata(target) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(false),
        Err(error) => return Err(io(target, "look at it")(error)),
        Ok(about) if !about.is_dir() => return Err(ExportError::NotAFolder { path }),
        Ok(_) => {}
    }
    let mut entries = fs::read_dir(target).map_err(io(target, "list it"))?;
    match entries.next() {
        None => Ok(true),
        Some(entry) => {
            let found = entry.map_err(io(target, "list it"))?.file_name();
            let found = found.to_string_lossy().into_owned();
            Err(ExportError::NotEmpty { path, found })
        }
    }
}
