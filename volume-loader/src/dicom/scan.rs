//! Every DICOM image below a folder.

use std::ffi::OsStr;
use std::fs::{self, DirEntry};
use std::io::ErrorKind;
use std::num::NonZero;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

use super::error::{DicomError, FileError};
use super::header::{Header, Kind};

/// Folders within folders; an examination on a disc has four.
const MAX_DEPTH: usize = 8;
/// Files in an examination; a large one has ten thousand.
const MAX_FILES: usize = 100_000;
/// Slices in all of them, with the frames of files that hold several.
const MAX_SLICES: usize = 100_000;
const MAX_THREADS: usize = 8;
/// So many of what is left out are named.
const MAX_NAMED: usize = 5;

/// What was found below a folder.
#[derive(Debug, Default)]
pub(crate) struct Scanned {
    pub headers: Vec<Header>,
    /// Files that are no DICOM images.
    pub ignored: usize,
    /// What is no file, and was not opened.
    pub left_out: LeftOut,
}

/// What was passed over because it is no file, by name.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct LeftOut {
    named: Vec<String>,
    count: usize,
}

impl LeftOut {
    fn add(&mut self, path: &Path, what: &str) {
        self.count += 1;
        if self.named.len() < MAX_NAMED {
            self.named.push(format!("{} ({what})", path.display()));
        }
    }

    /// For a person; `None` where nothing was left out.
    pub(crate) fn told(&self) -> Option<String> {
        let more = match self.count - self.named.len() {
            0 => String::new(),
            more => format!(" and {more} more"),
        };
        (self.count > 0).then(|| format!("not read, as it is no file: {}{more}", self.named.join(", ")))
    }
}

/// Reads the header of every file below `folder`, side by side; `folder` may be one file. Hidden files are left out, and by
/// name whatever is no file, and linked folders. A file that cannot be read may be a slice of the volume: without it there is none.
///
/// # Errors
/// [`DicomError`], the first in the order of paths.
pub(crate) fn scan(folder: &Path) -> Result<Scanned, DicomError> {
    let (files, left_out) = match folder.is_file() {
        true => (vec![folder.to_owned()], LeftOut::default()),
        false => files_below(folder)?,
    };
    let slices = AtomicUsize::new(0);
    let read = |path: &PathBuf| {
        let kind = read(path)?;
        let found = match &kind {
            Kind::Images(headers) => headers.len(),
            Kind::Object | Kind::Other => 0,
        };
        // What was held before this file, and it: no folder of small files asks for more memory than that.
        match slices.fetch_add(found, Ordering::Relaxed) + found <= MAX_SLICES {
            true => Ok(kind),
            false => Err(too_much(folder, MAX_SLICES, "slices")),
        }
    };
    let threads = thread::available_parallelism()
        .map_or(1, NonZero::get)
        .clamp(1, MAX_THREADS);
    let share = files.len().div_ceil(threads).max(1);
    let parts = thread::scope(|scope| {
        let workers: Vec<_> = files
            .chunks(share)
            .map(|part| scope.spawn(|| part.iter().map(read).collect::<Result<Vec<_>, DicomError>>()))
            .collect();
        // In the order of paths, so that the first error is always the same one.
        workers.into_iter().map(|worker| worker.join()).collect::<Vec<_>>()
    });
    let mut scanned = Scanned {
        left_out,
        ..Scanned::default()
    };
    for part in parts {
        let ended = |_| DicomError::Unreadable {
            path: folder.to_owned(),
            source: std::io::Error::other("a reading thread ended"),
        };
        for kind in part.map_err(ended)?? {
            match kind {
                Kind::Images(headers) => scanned.headers.extend(headers),
                Kind::Object | Kind::Other => scanned.ignored += 1,
            }
        }
    }
    Ok(scanned)
}

/// A file whose name says DICOM must be.
///
/// # Errors
/// [`DicomError::File`], [`DicomError::Unreadable`].
pub(crate) fn read(path: &Path) -> Result<Kind, DicomError> {
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

fn files_below(folder: &Path) -> Result<(Vec<PathBuf>, LeftOut), DicomError> {
    let (mut files, mut folders) = (Vec::new(), vec![(folder.to_owned(), 0)]);
    let mut left_out = Vec::new();
    while let Some((path, depth)) = folders.pop() {
        let unreadable = |source| unreadable(&path, source);
        for entry in fs::read_dir(&path).map_err(unreadable)? {
            let entry = entry.map_err(unreadable)?;
            if is_hidden(&entry.file_name()) {
                continue;
            }
            match kind_of(&entry)? {
                EntryKind::Folder => folders.push((entry.path(), depth + 1)),
                EntryKind::File => files.push(entry.path()),
                EntryKind::Neither(what) => left_out.push((entry.path(), what)),
            }
        }
        if files.len() + folders.len() + left_out.len() > MAX_FILES {
            return Err(too_much(folder, MAX_FILES, "files"));
        }
        if folders.last().is_some_and(|(_, depth)| *depth > MAX_DEPTH) {
            return Err(too_much(folder, MAX_DEPTH, "levels of folders"));
        }
    }
    files.sort();
    left_out.sort();
    let mut told = LeftOut::default();
    left_out.iter().for_each(|(path, what)| told.add(path, what));
    Ok((files, told))
}

fn too_much(folder: &Path, limit: usize, what: &'static str) -> DicomError {
    DicomError::TooMuch {
        path: folder.to_owned(),
        limit,
        what,
    }
}

fn unreadable(path: &Path, source: std::io::Error) -> DicomError {
    DicomError::Unreadable {
        path: path.to_owned(),
        source,
    }
}

enum EntryKind {
    Folder,
    File,
    /// What it is.
    Neither(&'static str),
}

/// A link to a file is a file, one to a folder is left out: it may lead round in a circle.
///
/// # Errors
/// [`DicomError::Dangling`], [`DicomError::Unreadable`]: a slice may have been there.
fn kind_of(entry: &DirEntry) -> Result<EntryKind, DicomError> {
    let path = entry.path();
    let kind = entry.file_type().map_err(|source| unreadable(&path, source))?;
    if kind.is_dir() {
        return Ok(EntryKind::Folder);
    }
    let found = match kind.is_symlink() {
        true => match fs::metadata(&path) {
            Ok(about) if about.is_dir() => return Ok(EntryKind::Neither("a link to a folder")),
            Ok(about) => about.file_type(),
            Err(error) if error.kind() == ErrorKind::NotFound => return Err(DicomError::Dangling { path }),
            Err(source) => return Err(unreadable(&path, source)),
        },
        false => kind,
    };
    Ok(scene::file::kind(found).map_or(EntryKind::File, EntryKind::Neither))
}

fn is_hidden(name: &OsStr) -> bool {
    name.as_encoded_bytes().starts_with(b".")
}
