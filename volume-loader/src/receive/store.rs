//! The folder in which examinations are put: `STUDY/SERIES/INSTANCE.dcm`, named by their unique identifiers.
//!
//! While an association brings something of a series, and after one that broke off, the series lies in `STUDY/.SERIES.incomplete`.
//! Scans pass over hidden folders, so that nobody takes it for an examination by reading the folder above it.

use std::collections::BTreeSet;
use std::fs::{self, DirBuilder, File};
use std::io::{self, ErrorKind};
use std::os::unix::fs::{DirBuilderExt, PermissionsExt};
use std::path::{Path, PathBuf};

use rustix::fs::{FlockOperation, flock, statvfs};

use super::instance::{self, Ids, InstanceError};
use super::part::{PREFIX, Part, rename_new};
use super::uid::Uid;

/// Why the folder is not used.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// The operating system refused.
    #[error("{}: cannot {doing}: {source}", path.display())]
    Io {
        /// The folder.
        path: PathBuf,
        /// What was being done.
        doing: &'static str,
        /// The system's reason.
        source: io::Error,
    },
    /// Another process receives into it.
    #[error("{}: another program receives into this folder; stop it, or name another folder", path.display())]
    Busy {
        /// The folder.
        path: PathBuf,
    },
    /// Others may change what is in it.
    #[error(
        "{}: others than its owner may write into it (mode {mode:o}), and could exchange an examination: chmod go-w, or name a new \
         folder", path.display()
    )]
    Open {
        /// The folder.
        path: PathBuf,
        /// Its permissions.
        mode: u32,
    },
}

/// Why an instance was not given its name.
#[derive(Debug, thiserror::Error)]
pub(crate) enum PlaceError {
    #[error("another one of this name is there with other content, and is kept")]
    Different,
    #[error("the series is there twice, as complete and as incomplete; put one of the folders away")]
    Twice,
    #[error(
        "it was incomplete before, and of the {there} instances that are there now this association brought {brought}: whether others are \
         missing nobody knows"
    )]
    NotAll { there: usize, brought: usize },
    #[error("what is there of this name cannot be read: {0}")]
    Unreadable(#[from] InstanceError),
    #[error("it cannot be put into its folder: {0}")]
    Io(#[from] io::Error),
}

/// What became of an instance.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Placed {
    New,
    /// It was there already, byte for byte.
    Same,
}

/// A folder for examinations, used by one process at a time.
#[derive(Debug)]
pub struct Store {
    folder: PathBuf,
    /// Locked as long as it is open.
    _lock: File,
}

/// Makes a folder for its owner alone, where there is none.
fn private_folder(path: &Path) -> io::Result<()> {
    match DirBuilder::new().mode(0o700).create(path) {
        Err(error) if error.kind() == ErrorKind::AlreadyExists => match is_folder(path)? {
            true => Ok(()),
            false => Err(io::Error::new(
                ErrorKind::NotADirectory,
                "something else is there in the place of a folder",
            )),
        },
        made => made,
    }
}

/// Whether there is a folder; a link to one is none.
fn is_folder(path: &Path) -> io::Result<bool> {
    match fs::symlink_metadata(path) {
        Ok(about) => Ok(about.is_dir()),
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(false),
        Err(error) => Err(error),
    }
}

fn sync(folder: &Path) -> io::Result<()> {
    File::open(folder)?.sync_all()
}

impl Store {
    /// Takes the folder, and makes it where there is none. What a process that was killed left unfinished is removed.
    ///
    /// # Errors
    /// [`StoreError`].
    pub fn open(folder: &Path) -> Result<Self, StoreError> {
        let path = folder.to_owned();
        let io = |doing| {
            let path = path.clone();
            move |source| StoreError::Io { path, doing, source }
        };
        match DirBuilder::new().mode(0o700).create(folder) {
            Err(error) if error.kind() != ErrorKind::AlreadyExists => return Err(io("make it")(error)),
            _ => {}
        }
        let about = fs::metadata(folder).map_err(io("look at it"))?;
        if !about.is_dir() {
            let source = io::Error::new(ErrorKind::NotADirectory, "this is no folder");
            return Err(io("use it")(source));
        }
        let mode = about.permissions().mode() & 0o777;
        if mode & 0o022 != 0 {
            return Err(StoreError::Open { path, mode });
        }
        let lock = File::open(folder).map_err(io("open it"))?;
        if flock(&lock, FlockOperation::NonBlockingLockExclusive).is_err() {
            return Err(StoreError::Busy { path });
        }
        for entry in fs::read_dir(folder).map_err(io("list it"))? {
            let entry = entry.map_err(io("list it"))?;
            if entry.file_name().as_encoded_bytes().starts_with(PREFIX.as_bytes()) {
                fs::remove_file(entry.path()).map_err(io("remove what was left unfinished in it"))?;
            }
        }
        let folder = folder.to_owned();
        Ok(Self { folder, _lock: lock })
    }

    /// Where it is.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Bytes that are free on its disk.
    pub(crate) fn free(&self) -> io::Result<u64> {
        let about = statvfs(&self.folder)?;
        Ok(about.f_bavail.saturating_mul(about.f_frsize))
    }

    /// Folders of a series: complete, and not.
    fn folders(&self, [study, series]: [&Uid; 2]) -> [PathBuf; 2] {
        let study = self.folder.join(study.as_str());
        [study.join(series.as_str()), study.join(format!(".{series}.incomplete"))]
    }

    /// Gives an instance its name, in the folder of what is incomplete.
    ///
    /// # Errors
    /// [`PlaceError`]; nothing is changed then.
    pub(crate) fn place(&self, mut part: Part, ids: &Ids, syntax: &Uid) -> Result<Placed, PlaceError> {
        let [complete, open] = self.folders([&ids.study, &ids.series]);
        let name = format!("{}.dcm", ids.instance);
        let data_at = part.data_at();
        let file = part.written()?;
        for folder in [&complete, &open] {
            let path = folder.join(&name);
            // A link is something, too, wherever it leads.
            if fs::symlink_metadata(&path).is_ok() {
                return match instance::is_same(&path, file, data_at, syntax)? {
                    true => Ok(Placed::Same),
                    false => Err(PlaceError::Different),
                };
            }
        }
        self.reopen([&ids.study, &ids.series])?;
        match part.name(&open.join(&name))? {
            true => sync(&open)?,
            // Put there by somebody else in this moment.
            false => return Err(PlaceError::Different),
        }
        Ok(Placed::New)
    }

    /// The series is incomplete from now on.
    fn reopen(&self, series: [&Uid; 2]) -> Result<(), PlaceError> {
        let [complete, open] = self.folders(series);
        let study = self.folder.join(series[0].as_str());
        if !is_folder(&study)? {
            private_folder(&study)?;
            sync(&self.folder)?;
        }
        match (is_folder(&complete)?, is_folder(&open)?) {
            (true, true) => Err(PlaceError::Twice),
            (true, false) => match rename_new(&complete, &open)? {
                true => Ok(()),
                false => Err(PlaceError::Twice),
            },
            (false, true) => Ok(()),
            (false, false) => {
                private_folder(&open)?;
                Ok(sync(&study)?)
            }
        }
    }

    /// The series has its name from now on, where it had not; where it lies. With `needed` only where no other instances are there.
    ///
    /// # Errors
    /// [`PlaceError`]; it is incomplete then.
    pub(crate) fn complete(&self, series: [&Uid; 2], needed: Option<&BTreeSet<Uid>>) -> Result<PathBuf, PlaceError> {
        let [complete, open] = self.folders(series);
        if is_folder(&open)? {
            if let Some(needed) = needed {
                let there = fs::read_dir(&open)?.count();
                let brought = needed.len();
                if there > brought {
                    return Err(PlaceError::NotAll { there, brought });
                }
            }
            if !rename_new(&open, &complete)? {
                return Err(PlaceError::Twice);
            }
            sync(&self.folder.join(series[0].as_str()))?;
        }
        Ok(complete)
    }

    /// Where a series lies, and whether that is among what is incomplete.
    pub(crate) fn path(&self, series: [&Uid; 2]) -> (PathBuf, bool) {
        let [complete, open] = self.folders(series);
        if open.is_dir() { (open, true) } else { (complete, false) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::receive::instance::tests::instance;

    fn uid(text: &str) -> Uid {
        Uid::checked(text.as_bytes()).unwrap()
    }

    fn put(store: &Store, names: [&str; 3], pixels: &[u8], syntax: &str) -> Result<Placed, PlaceError> {
        let [class, syntax] = ["1.2.840.10008.5.1.4.1.1.2", syntax].map(uid);
        let [instance_uid, study, series] = names.map(uid);
        let mut part = Part::create(store.folder(), [&class, &instance_uid, &syntax])?;
        part.write(&instance(names, pixels))?;
        let ids = Ids {
            class,
            instance: instance_uid,
            study,
            series,
            has_pixels: true,
        };
        store.place(part, &ids, &syntax)
    }

    const IMPLICIT: &str = "1.2.840.10008.1.2";

    #[test]
    fn an_instance_is_hidden_until_its_series_is_complete_and_is_never_written_over() {
        let tmp = tempfile::tempdir().unwrap();
        let folder = tmp.path().join("in");
        let store = Store::open(&folder).unwrap();
        let names = ["1.31", "1.1", "1.21"];
        let (study, series) = (uid("1.1"), uid("1.21"));
        assert_eq!(put(&store, names, b"aa", IMPLICIT).unwrap(), Placed::New);
        let hidden = folder.join("1.1/.1.21.incomplete/1.31.dcm");
        assert!(hidden.is_file() && !folder.join("1.1/1.21").exists());
        assert_eq!(put(&store, names, b"aa", IMPLICIT).unwrap(), Placed::Same);
        let before = fs::read(&hidden).unwrap();
        assert!(matches!(
            put(&store, names, b"ab", IMPLICIT),
            Err(PlaceError::Different)
        ));
        assert!(matches!(
            put(&store, names, b"aa", "1.2.840.10008.1.2.1"),
            Err(PlaceError::Different)
        ));
        let path = store.complete([&study, &series], None).unwrap();
        assert_eq!(path, folder.join("1.1/1.21"));
        assert_eq!(fs::read(path.join("1.31.dcm")).unwrap(), before);
        // What is the same changes nothing; what is new makes the series incomplete again.
        assert_eq!(put(&store, names, b"aa", IMPLICIT).unwrap(), Placed::Same);
        assert!(path.is_dir());
        assert!(matches!(
            put(&store, names, b"ab", IMPLICIT),
            Err(PlaceError::Different)
        ));
        assert!(path.is_dir());
        assert_eq!(
            put(&store, ["1.32", "1.1", "1.21"], b"cc", IMPLICIT).unwrap(),
            Placed::New
        );
        assert!(!path.exists());
        assert_eq!(fs::read_dir(store.path([&study, &series]).0).unwrap().count(), 2);
        fs::create_dir(&path).unwrap();
        assert!(matches!(
            put(&store, ["1.33", "1.1", "1.21"], b"", IMPLICIT),
            Err(PlaceError::Twice)
        ));
        assert!(matches!(
            store.complete([&study, &series], None),
            Err(PlaceError::Twice)
        ));
        for entry in [&folder, &folder.join("1.1"), &folder.join("1.1/.1.21.incomplete")] {
            assert_eq!(
                fs::metadata(entry).unwrap().permissions().mode() & 0o777,
                0o700,
                "{entry:?}"
            );
        }
        assert_eq!(fs::metadata(&hidden).unwrap().permissions().mode() & 0o777, 0o600);
        assert!(fs::read_dir(&folder).unwrap().count() == 1);
    }

    #[test]
    fn a_link_in_the_place_of_a_folder_or_a_file_leads_nowhere() {
        let tmp = tempfile::tempdir().unwrap();
        let (folder, other) = (tmp.path().join("in"), tmp.path().join("other"));
        let store = Store::open(&folder).unwrap();
        fs::create_dir(&other).unwrap();
        std::os::unix::fs::symlink(&other, folder.join("1.1")).unwrap();
        assert!(put(&store, ["1.31", "1.1", "1.21"], b"aa", IMPLICIT).is_err());
        fs::create_dir_all(folder.join("1.2")).unwrap();
        std::os::unix::fs::symlink(&other, folder.join("1.2/.1.21.incomplete")).unwrap();
        assert!(put(&store, ["1.31", "1.2", "1.21"], b"aa", IMPLICIT).is_err());
        fs::create_dir_all(folder.join("1.3/1.21")).unwrap();
        std::os::unix::fs::symlink("/dev/zero", folder.join("1.3/1.21/1.31.dcm")).unwrap();
        assert!(put(&store, ["1.31", "1.3", "1.21"], b"aa", IMPLICIT).is_err());
        assert_eq!(fs::read_dir(&other).unwrap().count(), 0);
    }

    #[test]
    fn a_folder_is_one_process_s_own_and_nobody_else_s_to_write() {
        let tmp = tempfile::tempdir().unwrap();
        let folder = tmp.path().join("in");
        let store = Store::open(&folder).unwrap();
        assert!(matches!(Store::open(&folder), Err(StoreError::Busy { .. })));
        drop(store);
        fs::write(folder.join(".part-1-2"), "left").unwrap();
        fs::write(folder.join("notes"), "mine").unwrap();
        drop(Store::open(&folder).unwrap());
        assert!(!folder.join(".part-1-2").exists() && folder.join("notes").exists());
        fs::set_permissions(&folder, fs::Permissions::from_mode(0o770)).unwrap();
        let said = Store::open(&folder).unwrap_err().to_string();
        assert!(said.contains("mode 770") && said.contains("chmod go-w"), "{said}");
        let file = tmp.path().join("file");
        fs::write(&file, "").unwrap();
        assert!(Store::open(&file).unwrap_err().to_string().contains("no folder"));
        assert!(
            Store::open(&tmp.path().join("no/in"))
                .unwrap_err()
                .to_string()
                .contains("cannot make it")
        );
    }
}
