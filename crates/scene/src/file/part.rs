//! Writing a file whole or not at all: through another one beside it, which takes its name when all of it is on the disk.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::os::unix::fs::{MetadataExt, OpenOptionsExt};
use std::path::{Path, PathBuf};
use std::time::Duration;

use rustix::fs::{FlockOperation, OFlags, flock};

/// How often it is tried while somebody else writes the same file, and how long is waited in between.
const LOOKS: u32 = 40;
const BETWEEN_LOOKS: Duration = Duration::from_millis(5);

/// Why a file is not written.
#[derive(Debug, thiserror::Error)]
pub enum PartError {
    /// What lies in the place through which it is written belongs to something else.
    #[error("{part} lies beside it, through which it is written, and is no plain file of its own name; remove it")]
    NotPlain {
        /// What lies there.
        part: PathBuf,
    },
    /// Another process is writing it, or this one elsewhere.
    #[error("somebody else is writing it; try again")]
    Busy,
    /// The operating system refused.
    #[error(transparent)]
    Io(#[from] io::Error),
}

/// The file beside another, of the same name with `.part` behind it, into which that is written; locked, so that whoever else writes the
/// same file waits. Gone when this is dropped before it was renamed.
#[derive(Debug)]
pub struct Part {
    file: File,
    part: PathBuf,
    path: PathBuf,
}

impl Part {
    /// Where the part of this file lies.
    pub fn place(path: &Path) -> PathBuf {
        let mut part = path.as_os_str().to_owned();
        part.push(".part");
        PathBuf::from(part)
    }

    /// Makes it, empty, with these permissions as far as the umask leaves them. What one that died left of it is taken away; what else
    /// lies there, a link or another name of a file, is neither written through nor removed.
    ///
    /// # Errors
    /// Each variant of [`PartError`].
    pub fn lock(path: &Path, mode: u32) -> Result<Self, PartError> {
        let part = Self::place(path);
        for _ in 0..LOOKS {
            let mut options = OpenOptions::new();
            let made = options.write(true).create_new(true).mode(mode).open(&part);
            let made = match made {
                Ok(file) => Some(file),
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => None,
                Err(error) => return Err(error.into()),
            };
            let Some(file) = made.map_or_else(|| left(&part), |file| Ok(Some(file)))? else {
                continue;
            };
            // A lock ends with its process, so what nobody has locked nobody is writing.
            let is_locked = flock(&file, FlockOperation::NonBlockingLockExclusive).is_ok();
            // Who had the lock may have renamed or removed the file since.
            let about = file.metadata()?;
            let is_here = fs::symlink_metadata(&part).is_ok_and(|here| here.ino() == about.ino());
            if is_locked && is_here {
                if about.len() == 0 && about.mode() & 0o7777 & !mode == 0 {
                    let path = path.to_owned();
                    return Ok(Self { file, part, path });
                }
                // Of one that died: with its content, and permissions of then.
                fs::remove_file(&part)?;
                continue;
            }
            std::thread::sleep(BETWEEN_LOOKS);
        }
        Err(PartError::Busy)
    }

    /// The open file, for permissions.
    pub const fn file(&self) -> &File {
        &self.file
    }

    /// Writes all of it, to the disk: else a crash of the machine could leave the name on an empty file.
    ///
    /// # Errors
    /// Those of the operating system.
    pub fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.file.write_all(bytes)?;
        self.file.sync_all()
    }

    /// Gives it the file's name, in the place of what has it.
    ///
    /// # Errors
    /// Those of the operating system.
    pub fn rename(self) -> io::Result<()> {
        // Under that name it is no part any more, so that dropping this removes nothing of it.
        fs::rename(&self.part, &self.path)
    }
}

impl Drop for Part {
    fn drop(&mut self) {
        // Only while it is this one: after it was renamed the next may lie there already.
        let ino = self.file.metadata().map(|about| about.ino()).ok();
        let here = fs::symlink_metadata(&self.part).map(|here| here.ino()).ok();
        if ino.is_some() && ino == here {
            let _ = fs::remove_file(&self.part);
        }
    }
}

/// What lies in the place already, where it is a plain file of one name; `None`: it is gone meanwhile.
fn left(part: &Path) -> Result<Option<File>, PartError> {
    let refused = || PartError::NotPlain { part: part.to_owned() };
    let gone = |error: io::Error| match error.kind() {
        io::ErrorKind::NotFound => Ok(None),
        _ => Err(error.into()),
    };
    match fs::symlink_metadata(part) {
        // Through another name of a file that file would be written over.
        Ok(about) if !about.is_file() || about.nlink() > 1 => return Err(refused()),
        Ok(_) => {}
        Err(error) => return gone(error),
    }
    let flags = (OFlags::NOFOLLOW | OFlags::NONBLOCK).bits() as i32;
    let file = match OpenOptions::new().write(true).custom_flags(flags).open(part) {
        Ok(file) => file,
        Err(error) => return gone(error),
    };
    let about = file.metadata()?;
    match about.is_file() && about.nlink() <= 1 {
        true => Ok(Some(file)),
        false => Err(refused()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::fs::{PermissionsExt, symlink};

    #[test]
    fn a_file_is_whole_or_as_it_was() {
        let tmp = tempfile::tempdir().unwrap();
        let path = tmp.path().join("a");
        fs::write(&path, "before").unwrap();
        let mut part = Part::lock(&path, 0o600).unwrap();
        part.write(b"after").unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "before");
        // Another one waits, and says so in the end.
        assert!(matches!(Part::lock(&path, 0o600), Err(PartError::Busy)));
        drop(part);
        assert!(!Part::place(&path).exists());
        assert_eq!(fs::read_to_string(&path).unwrap(), "before");
        let mut part = Part::lock(&path, 0o600).unwrap();
        part.write(b"after").unwrap();
        part.rename().unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "after");
        assert_eq!(fs::metadata(&path).unwrap().permissions().mode() & 0o777, 0o600);
        assert!(!Part::place(&path).exists());
    }

    /// What one that died left, open to everybody, became the file with its permissions.
    #[test]
    fn what_one_that_died_left_has_no_part_in_the_file() {
        let tmp = tempfile::tempdir().unwrap();
        let path = tmp.path().join("a");
        for content in ["", "half of"] {
            fs::write(Part::place(&path), content).unwrap();
            fs::set_permissions(Part::place(&path), fs::Permissions::from_mode(0o644)).unwrap();
            let mut part = Part::lock(&path, 0o600).unwrap();
            part.write(b"all").unwrap();
            part.rename().unwrap();
            assert_eq!(fs::read_to_string(&path).unwrap(), "all");
            assert_eq!(fs::metadata(&path).unwrap().permissions().mode() & 0o777, 0o600);
        }
    }

    /// It was written through, into the file that the link names.
    #[test]
    fn nothing_is_written_through_a_link() {
        let tmp = tempfile::tempdir().unwrap();
        let (path, other) = (tmp.path().join("a"), tmp.path().join("other"));
        fs::write(&other, "theirs").unwrap();
        let part = Part::place(&path);
        let refused = || matches!(Part::lock(&path, 0o600), Err(PartError::NotPlain { .. }));
        symlink(&other, &part).unwrap();
        assert!(refused());
        fs::remove_file(&part).unwrap();
        symlink(tmp.path().join("nowhere"), &part).unwrap();
        assert!(refused());
        fs::remove_file(&part).unwrap();
        fs::hard_link(&other, &part).unwrap();
        assert!(refused());
        fs::remove_file(&part).unwrap();
        fs::create_dir(&part).unwrap();
        assert!(refused());
        assert_eq!(fs::read_to_string(&other).unwrap(), "theirs");
    }

    #[test]
    fn many_that_write_one_file_at_once_write_it_one_after_the_other() {
        let tmp = tempfile::tempdir().unwrap();
        let path = tmp.path().join("a");
        std::thread::scope(|scope| {
            for letter in ["a", "b", "c", "d"] {
                let path = &path;
                scope.spawn(move || {
                    for _ in 0..20 {
                        // One that finds it busy to the end has written nothing.
                        if let Ok(mut part) = Part::lock(path, 0o600) {
                            part.write(letter.repeat(1000).as_bytes()).unwrap();
                            part.rename().unwrap();
                        }
                    }
                });
            }
        });
        let text = fs::read_to_string(&path).unwrap();
        assert!(
            text.len() == 1000 && text.chars().all(|c| text.starts_with(c)),
            "{text}"
        );
        assert!(!Part::place(&path).exists());
    }
}
