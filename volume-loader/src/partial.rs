//! A file that is written under another name and renamed when it is whole.

use std::fs::{File, OpenOptions};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use crate::write::error::{WriteError, io};

/// A file under a name of its own in its target's folder, removed again unless it is renamed.
pub(crate) struct Partial {
    file: File,
    path: PathBuf,
    target: PathBuf,
    done: bool,
}

impl Partial {
    /// A new, empty file beside `target`.
    ///
    /// # Errors
    /// [`WriteError::Io`].
    pub(crate) fn create(target: &Path) -> Result<Self, WriteError> {
        // Two writers of one process, and of two, never share a name.
        static COUNT: AtomicU64 = AtomicU64::new(0);
        let count = COUNT.fetch_add(1, Ordering::Relaxed);
        let name = target.file_name().unwrap_or_default().to_string_lossy();
        let path = target.with_file_name(format!(".{name}.{}-{count}.part", std::process::id()));
        let file = OpenOptions::new().write(true).create_new(true).open(&path);
        let file = file.map_err(io(target, "make a new file beside it"))?;
        Ok(Self {
            file,
            path,
            target: target.to_owned(),
            done: false,
        })
    }

    /// A handle to write with; all handles share one position.
    ///
    /// # Errors
    /// [`WriteError::Io`].
    pub(crate) fn file(&self) -> Result<File, WriteError> {
        self.file.try_clone().map_err(io(&self.target, "write it"))
    }

    /// Brings what was written to the disk.
    ///
    /// # Errors
    /// [`WriteError::Io`].
    pub(crate) fn sync(&self) -> Result<(), WriteError> {
        self.file.sync_all().map_err(io(&self.target, "bring it to the disk"))
    }

    /// Gives the file its name; what had the name before is gone.
    ///
    /// # Errors
    /// [`WriteError::Io`].
    pub(crate) fn rename(mut self) -> Result<(), WriteError> {
        self.sync()?;
        std::fs::rename(&self.path, &self.target).map_err(io(&self.target, "give it its name"))?;
        self.done = true;
        Ok(())
    }
}

impl Drop for Partial {
    fn drop(&mut self) {
        if !self.done {
            // Nobody is left to tell: the first failure is already on its way up.
            let _ = std::fs::remove_file(&self.path);
        }
    }
}
