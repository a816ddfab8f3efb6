//! Whether what was written is still where it was put: a person, or a program that cleans, may remove it meanwhile.

use std::fs::{self, File, Metadata};
use std::io::ErrorKind;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

use crate::write::file_error::FileError;
use crate::write::paths;

/// The place of the growing file.
#[derive(Debug)]
pub(super) struct Place {
    path: PathBuf,
    /// Whether its name led to it when it was made: some network file systems number files anew, and there only the count of
    /// names tells.
    is_named: bool,
}

impl Place {
    /// Of `file`, which was made under `path` just now.
    pub(super) fn of(file: &File, path: PathBuf) -> Self {
        let is_named = matches!((file.metadata(), fs::symlink_metadata(&path)),
            (Ok(file), Ok(named)) if id(&file) == id(&named));
        Self { path, is_named }
    }

    /// Refuses a file that has no name any more, or whose name leads elsewhere. One that cannot be asked is taken to be there.
    ///
    /// # Errors
    /// [`FileError::Removed`], [`FileError::Moved`].
    pub(super) fn check(&self, file: &File) -> Result<(), FileError> {
        let Ok(about) = file.metadata() else { return Ok(()) };
        let path = || self.path.clone();
        if about.nlink() == 0 {
            return Err(FileError::Removed { path: path() });
        }
        let is_there = match fs::symlink_metadata(&self.path) {
            Ok(named) => id(&about) == id(&named) || !self.is_named,
            Err(e) => !is_missing(e.kind()),
        };
        match is_there {
            true => Ok(()),
            false => Err(FileError::Moved { path: path() }),
        }
    }
}

/// A device, and a file's number on it.
type Id = (u64, u64);

fn id(about: &Metadata) -> Id {
    (about.dev(), about.ino())
}

fn is_missing(kind: ErrorKind) -> bool {
    matches!(kind, ErrorKind::NotFound | ErrorKind::NotADirectory)
}

/// An earlier file of this process.
#[derive(Debug)]
pub(super) struct Part {
    place: PartPlace,
    messages: u64,
}

#[derive(Debug)]
enum PartPlace {
    /// It is this one when it is whole, and growing before.
    At(PathBuf),
    /// Moved: the same number and length tell it where it comes back. It does not grow any more.
    Elsewhere(Id, u64),
    /// It has no name; its number may be another's by now.
    Removed,
}

impl Part {
    /// Of that name once it is whole.
    pub(super) fn at(out: PathBuf, messages: u64) -> Self {
        let place = PartPlace::At(out);
        Self { place, messages }
    }

    /// `file`, whose name leads to it no longer.
    pub(super) fn lost(file: &File, messages: u64) -> Self {
        let about = file.metadata().ok().filter(|about| about.nlink() > 0);
        let place = about.map_or(PartPlace::Removed, |about| {
            PartPlace::Elsewhere(id(&about), about.len())
        });
        Self { place, messages }
    }

    /// Whether it is under none of its names: growing first, as it is renamed from that to the other.
    fn is_gone(&self) -> bool {
        let is_gone = |path: &Path| fs::symlink_metadata(path).is_err_and(|e| is_missing(e.kind()));
        match &self.place {
            PartPlace::At(out) => is_gone(&paths::recording(out)) && is_gone(out),
            PartPlace::Elsewhere(..) | PartPlace::Removed => true,
        }
    }

    /// A disk that was away may be back.
    fn look_among(&mut self, unfinished: &[PathBuf]) {
        let PartPlace::Elsewhere(number, length) = self.place else {
            return;
        };
        let is_it = |path: &&PathBuf| {
            fs::symlink_metadata(path).is_ok_and(|found| id(&found) == number && found.len() == length)
        };
        if let Some(out) = unfinished
            .iter()
            .find(is_it)
            .and_then(|path| paths::without_recording(path))
        {
            self.place = PartPlace::At(out);
        }
    }
}

/// The earlier files of this process.
#[derive(Debug, Default)]
pub(super) struct Parts(Vec<Part>);

impl Parts {
    /// One more. Where an earlier one had its name, that one has been removed.
    pub(super) fn push(&mut self, part: Part) {
        let name = |part: &Part| match &part.place {
            PartPlace::At(out) => Some(out.clone()),
            PartPlace::Elsewhere(..) | PartPlace::Removed => None,
        };
        let its = name(&part);
        for earlier in self
            .0
            .iter_mut()
            .filter(|earlier| its.is_some() && name(earlier) == its)
        {
            earlier.place = PartPlace::Removed;
        }
        self.0.push(part);
    }

    /// Messages in those that are gone.
    pub(super) fn gone(&self) -> u64 {
        let gone = self.0.iter().filter(|part| part.is_gone());
        gone.map(|part| part.messages).sum()
    }

    /// Takes note of the names of those among `unfinished` whose names were not known.
    pub(super) fn look_among(&mut self, unfinished: &[PathBuf]) {
        self.0.iter_mut().for_each(|part| part.look_among(unfinished));
    }
}
