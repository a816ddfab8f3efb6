//! Every DICOM image below a folder.

use std::ffi::OsStr;
use std::fs::{self, DirEntry};
use std::num::NonZero;
use std::path::{Path, PathBuf};
use std::thread;

use super::error::{DicomError, FileError};
use super::header::{Header, Kind};

/// Folders within folders; an examination on a disc has four.
const MAX_DEPTH: usize = 8;
/// Files in an examination; a large one has ten thousand.
const MAX_FILES: usize = 100_000;
const MAX_THREADS: usize = 8;

/// What was found below a folder.
#[derive(Debug, Default)]
pub(crate) struct Scanned {
    pub headers: Vec<Header>,
    /// Files that are no DICOM images.
    pub ignored: usize,
}

/// Reads the header of every file below `folder`, side by side. Hidden files and linked folders are left out.
///
/// # Errors
/// [`DicomError`], the first in the order of paths.
pub(crate) fn scan(folder: &Path) -> Result<Scanned, DicomError> {
    let files = files_below(folder)?;
    let threads = thread::available_parallelism()
        .map_or(1, NonZero::get)
        .clamp(1, MAX_THREADS);
    let share = files.len().div_ceil(threads).max(1);
    let parts = thread::scope(|scope| {
        let workers: Vec<_> = files
            .chunks(share)
            .map(|part| scope.spawn(move || part.iter().map(|path| read(path)).collect::<Result<Vec<_>, _>>()))
            .collect();
        // In the order of paths, so that the first error is always the same one.
        workers.into_iter().map(|worker| worker.join()).collect::<Vec<_>>()
    });
    let mut scanned = Scanned::default();
    for part in parts {
        let ended = |_| DicomError::Unreadable {
            path: folder.to_owned(),
            source: std::io::Error::other("a reading thread ended"),
        };
        for kind in part.map_err(ended)?? {
            match kind {
                Kind::Image(header) => scanned.headers.push(*header),
                Kind::Object | Kind::Other => scanned.ignored += 1,
            }
        }
    }
    Ok(scanned)
}

/// A file whose name says DICOM must be.
fn read(path: &Path) -> Result<Kind, DicomError> {
    match Header::read(path)? {
        Kind::Other if has_dicom_name(path) => Err(DicomError::File {
            path: path.to_owned(),
            source: FileError::NotDicom,
        }),
        kind => Ok(kind),
    }
}

/// Whether the name ends in `.dcm`.
pub(crate) fn has_dicom_name(path: &Path) -> bool {
    path.extension()
        .is_some_and(|extension| extension.eq_ignore_ascii_case("dcm"))
}

fn files_below(folder: &Path) -> Result<Vec<PathBuf>, DicomError> {
    let (mut files, mut folders) = (Vec::new(), vec![(folder.to_owned(), 0)]);
    while let Some((path, depth)) = folders.pop() {
        let unreadable = |source| DicomError::Unreadable {
            path: path.clone(),
            source,
        };
        for entry in fs::read_dir(&path).map_err(unreadable)? {
            let entry = entry.map_err(unreadable)?;
            if is_hidden(&entry.file_name()) {
                continue;
            }
            match kind_of(&entry).map_err(unreadable)? {
                EntryKind::Folder => folders.push((entry.path(), depth + 1)),
                EntryKind::File => files.push(entry.path()),
                EntryKind::Neither => {}
            }
        }
        let too_much = |limit, what| DicomError::TooMuch {
            path: folder.to_owned(),
            limit,
            what,
        };
        if files.len() + folders.len() > MAX_FILES {
            return Err(too_much(MAX_FILES, "files"));
        }
        if folders.last().is_some_and(|(_, depth)| *depth > MAX_DEPTH) {
            return Err(too_much(MAX_DEPTH, "levels of folders"));
        }
    }
    files.sort();
    Ok(files)
}

enum EntryKind {
    Folder,
    File,
    Neither,
}

/// A link to a file is a file, one to a folder is left out: it may lead round in a circle.
fn kind_of(entry: &DirEntry) -> std::io::Result<EntryKind> {
    let kind = entry.file_type()?;
    if kind.is_dir() {
        return Ok(EntryKind::Folder);
    }
    let is_file = match kind.is_symlink() {
        true => fs::metadata(entry.path()).is_ok_and(|about| about.is_file()),
        false => kind.is_file(),
    };
    Ok(if is_file { EntryKind::File } else { EntryKind::Neither })
}

fn is_hidden(name: &OsStr) -> bool {
    name.as_encoded_bytes().starts_with(b".")
}
