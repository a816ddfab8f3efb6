//! What a process of a run would have the one know that follows on it, should it die: a file in the run's folder.

use std::io;
use std::path::PathBuf;

use super::{KEPT, RunContext, RunError, io_error, own};

impl RunContext {
    /// Keeps these bytes for the process of this name that comes next, in the place of what was kept before: whole, or not at all.
    ///
    /// # Errors
    /// [`RunError::Io`].
    pub fn keep(&self, process: &str, bytes: &[u8]) -> Result<(), RunError> {
        let path = self.kept_path(process);
        own::write(&path, bytes).map_err(io_error("writing", &path))
    }

    /// What the process of this name that was there before has kept; `None` where it kept nothing.
    ///
    /// # Errors
    /// [`RunError::Io`].
    pub fn kept(&self, process: &str) -> Result<Option<Vec<u8>>, RunError> {
        let path = self.kept_path(process);
        match own::read(&path) {
            Ok(bytes) => Ok(Some(bytes)),
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
            Err(error) => Err(io_error("reading", &path)(error)),
        }
    }

    /// Forgets it.
    ///
    /// # Errors
    /// [`RunError::Io`].
    pub fn forget_kept(&self, process: &str) -> Result<(), RunError> {
        let path = self.kept_path(process);
        match std::fs::remove_file(&path) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => Err(io_error("removing", &path)(error)),
            _ => Ok(()),
        }
    }

    fn kept_path(&self, process: &str) -> PathBuf {
        self.dir.join(format!("{KEPT}{process}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_kept_is_there_for_who_comes_next_and_gone_with_the_run() {
        let folder = tempfile::tempdir().unwrap();
        let run = RunContext::new(folder.path(), 0).unwrap();
        assert_eq!(run.kept("localizer").unwrap(), None);
        run.keep("localizer", b"one").unwrap();
        run.keep("localizer", b"two").unwrap();
        assert_eq!(run.kept("localizer").unwrap().as_deref(), Some(&b"two"[..]));
        assert_eq!(run.kept("tracker").unwrap(), None);
        run.forget_kept("localizer").unwrap();
        run.forget_kept("localizer").unwrap();
        assert_eq!(run.kept("localizer").unwrap(), None);
        run.keep("localizer", b"three").unwrap();
        run.sweep();
        assert_eq!(run.kept("localizer").unwrap(), None);
        // A link that somebody put there is not followed.
        std::os::unix::fs::symlink("/etc/passwd", folder.path().join("kept-localizer")).unwrap();
        assert!(run.kept("localizer").is_err());
    }
}
