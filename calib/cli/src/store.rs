//! Writing the result: whole or not at all, and never over something unasked.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use scene::file::{Part, PartError};

/// Why the result was not written.
#[derive(Debug, thiserror::Error)]
pub(crate) enum StoreError {
    /// Something has this name.
    #[error("writing {path}: there is a file of this name; give another --out, or --overwrite to replace it")]
    Exists { path: PathBuf },
    /// The name is a folder's.
    #[error("writing {path}: this is a folder; give --out the name of a file")]
    Folder { path: PathBuf },
    /// What has the name is no file: a device, a pipe.
    #[error("writing {path}: this is no file; give another --out")]
    NotAFile { path: PathBuf },
    /// Nothing can be written there.
    #[error("writing {path}: there is no folder {folder}; make it, or give another --out")]
    NoFolder { path: PathBuf, folder: PathBuf },
    /// The name is an input's.
    #[error("writing {path}: this is the file that the points were read from; give another --out")]
    Input { path: PathBuf },
    /// Something lies where it is written through before anything is done.
    #[error(
        "writing {path}: {part} lies beside it, through which it is written; it is yours, or of a command that did not end. Look at it and \
         remove it"
    )]
    Left { path: PathBuf, part: PathBuf },
    /// What lies where it is written through is something else's, or somebody else is writing it.
    #[error("writing {path}: {source}")]
    Part { path: PathBuf, source: PartError },
    /// The system refused.
    #[error("writing {path}: {source}. Nothing was left under that name; check that the folder exists and has space")]
    Write { path: PathBuf, source: io::Error },
}

/// Refuses what cannot be written before the work is done.
pub(crate) fn check(path: &Path, overwrite: bool) -> Result<(), StoreError> {
    let owned = || path.to_owned();
    match fs::symlink_metadata(path) {
        Ok(found) if found.is_dir() => Err(StoreError::Folder { path: owned() }),
        // Renamed over, a device would be gone for everybody.
        Ok(found) if !(found.is_file() || found.is_symlink()) => Err(StoreError::NotAFile { path: owned() }),
        Ok(_) if !overwrite => Err(StoreError::Exists { path: owned() }),
        // An earlier one that died may have left it, and so may somebody who calls files so: a person looks.
        _ if fs::symlink_metadata(Part::place(path)).is_ok() => Err(StoreError::Left {
            path: owned(),
            part: Part::place(path),
        }),
        _ => folder_of(path).map_or(Ok(()), |folder| {
            let path = owned();
            Err(StoreError::NoFolder { path, folder })
        }),
    }
}

/// The folder that a file would be in, where there is none.
fn folder_of(path: &Path) -> Option<PathBuf> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty())?;
    (!folder.is_dir()).then(|| folder.to_owned())
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
    let bytes = bytes.map_err(|source| StoreError::Write {
        path: path.to_owned(),
        source,
    })?;
    // Results are for everybody whom the umask lets read them: they name no patient.
    let part = Part::lock(path, 0o666);
    let written = part.and_then(|mut part| {
        part.write(&bytes)?;
        Ok(part.rename()?)
    });
    written.map_err(|error| {
        let path = path.to_owned();
        match error {
            PartError::Io(source) => StoreError::Write { path, source },
            source => StoreError::Part { path, source },
        }
    })
}
