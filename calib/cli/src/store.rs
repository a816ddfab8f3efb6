//! Writing the result: whole or not at all, and never over something unasked.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Why the result was not written.
#[derive(Debug, thiserror::Error)]
pub(crate) enum StoreError {
    /// Something has this name.
    #[error("writing {path}: there is a file of this name; give another --out, or --overwrite to replace it")]
    Exists { path: PathBuf },
    /// The name is a folder's.
    #[error("writing {path}: this is a folder; give --out the name of a file")]
    Folder { path: PathBuf },
    /// The name is an input's.
    #[error("writing {path}: this is the file that the points were read from; give another --out")]
    Input { path: PathBuf },
    /// The system refused.
    #[error("writing {path}: {source}. Nothing was left under that name; check that the folder exists and has space")]
    Write { path: PathBuf, source: io::Error },
}

/// Refuses what cannot be written before the work is done.
pub(crate) fn check(path: &Path, overwrite: bool) -> Result<(), StoreError> {
    let owned = || path.to_owned();
    match fs::symlink_metadata(path) {
        Ok(found) if found.is_dir() => Err(StoreError::Folder { path: owned() }),
        Ok(_) if !overwrite => Err(StoreError::Exists { path: owned() }),
        _ => Ok(()),
    }
}

/// Writes under a temporary name and renames, so that a file of this name is always whole.
pub(crate) fn write<'a>(
    path: &Path,
    text: io::Result<String>,
    inputs: impl Iterator<Item = &'a Path>,
) -> Result<(), StoreError> {
    write_bytes(path, text.map(String::into_bytes), inputs)
}

/// The same of bytes.
pub(crate) fn write_bytes<'a>(
    path: &Path,
    bytes: io::Result<Vec<u8>>,
    mut inputs: impl Iterator<Item = &'a Path>,
) -> Result<(), StoreError> {
    let place = |path: &Path| fs::canonicalize(path).ok();
    if place(path).is_some_and(|out| inputs.any(|input| place(input).as_ref() == Some(&out))) {
        return Err(StoreError::Input { path: path.to_owned() });
    }
    let mut part = path.as_os_str().to_owned();
    part.push(".part");
    let part = PathBuf::from(part);
    let written = bytes.and_then(|bytes| {
        let mut out = File::create(&part)?;
        out.write_all(&bytes)?;
        // Else a crash of the machine could leave the name on an empty file.
        out.sync_all()?;
        fs::rename(&part, path)
    });
    written.map_err(|source| {
        let _ = fs::remove_file(&part);
        StoreError::Write {
            path: path.to_owned(),
            source,
        }
    })
}
