//! The files of a report: refused before anything is read, and there whole or not at all.

use std::fs::{self, File};
use std::io::Write;
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};

use super::{ReportError, Wanted};
use crate::write::paths;

/// The page, and the JSON beside it where it is wanted.
///
/// # Errors
/// [`ReportError::Exists`], [`ReportError::Itself`].
pub(super) fn targets(input: &Path, out: &Path, wanted: Wanted) -> Result<Vec<PathBuf>, ReportError> {
    let mut files = vec![out.to_owned()];
    if wanted.json {
        files.push(out.with_extension("json"));
    }
    let same = |a: &Path, b: &Path| fs::canonicalize(a).is_ok_and(|a| fs::canonicalize(b).is_ok_and(|b| a == b));
    for (place, file) in files.iter().enumerate() {
        if same(input, file) || files[..place].contains(file) {
            return Err(ReportError::Itself(file.clone()));
        }
        // A link that leads nowhere is in the way too.
        if fs::symlink_metadata(file).is_ok() && !wanted.force {
            return Err(ReportError::Exists(file.clone()));
        }
    }
    Ok(files)
}

/// Writes each text into its file. None has its name before all are written.
///
/// # Errors
/// [`ReportError::Write`].
pub(super) fn write(files: &[PathBuf], texts: &[String]) -> Result<(), ReportError> {
    let written = files.iter().zip(texts).try_for_each(|(file, text)| partial(file, text));
    let named = written.and_then(|()| files.iter().try_for_each(|file| named(file)));
    if named.is_err() {
        for file in files {
            // Of no use; if it cannot be removed, its name says so.
            let _ = fs::remove_file(paths::partial(file));
        }
    }
    named
}

fn partial(file: &Path, text: &str) -> Result<(), ReportError> {
    let path = paths::partial(file);
    // What an earlier report left is of no use, and may be open to others, or lead elsewhere.
    let _ = fs::remove_file(&path);
    let mut options = File::options();
    options.write(true).create_new(true).mode(0o600);
    let written = options.open(&path).and_then(|mut file| {
        file.write_all(text.as_bytes())?;
        file.sync_all()
    });
    written.map_err(|source| ReportError::Write { path, source })
}

fn named(file: &Path) -> Result<(), ReportError> {
    let path = paths::partial(file);
    let renamed = fs::rename(&path, file).and_then(|()| paths::sync_folder(file));
    renamed.map_err(|source| ReportError::Write { path, source })
}
