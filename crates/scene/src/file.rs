//! Opening files whose names come from outside: only regular ones, and never waiting for anybody; and writing them whole ([`Part`]).
//!
//! Opening a pipe waits for its writer, and reading a device may never end. So whoever is given a path by a person, a header or a
//! folder opens it here.

use std::fs::{self, File, FileType, Metadata, OpenOptions};
use std::io::{self, Read};
use std::os::unix::fs::{FileTypeExt, OpenOptionsExt};
use std::path::Path;

use rustix::fs::OFlags;

mod part;

pub use part::{Part, PartError};

/// Why a file was not opened.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// The path names a folder, a pipe, a socket or a device.
    #[error("this is {found}, expected a file")]
    NotAFile {
        /// What it is.
        found: &'static str,
    },
    /// It is longer than whatever is expected there.
    #[error("{found} bytes; at most {most} are allowed")]
    TooLong {
        /// Its length, or how much of it was read.
        found: u64,
        /// The most allowed.
        most: u64,
    },
    /// The operating system refused.
    #[error(transparent)]
    Io(#[from] io::Error),
}

impl From<OpenError> for io::Error {
    fn from(error: OpenError) -> Self {
        match error {
            OpenError::Io(source) => source,
            refused => Self::new(io::ErrorKind::InvalidInput, refused.to_string()),
        }
    }
}

/// Opens a regular file for reading, through links, and tells what is known of it; `len` is its length at this moment, and
/// whoever reads more bounds it.
///
/// # Errors
/// [`OpenError`].
pub fn open(path: &Path) -> Result<(File, Metadata), OpenError> {
    // Asked before it is opened, since opening some devices does something, and after it, since it may have been exchanged.
    check(&fs::metadata(path)?)?;
    // Should it be a pipe by now, nobody waits for its writer.
    let flags = OFlags::NONBLOCK | OFlags::NOCTTY;
    let file = OpenOptions::new()
        .read(true)
        .custom_flags(flags.bits() as i32)
        .open(path)?;
    let about = file.metadata()?;
    check(&about)?;
    Ok((file, about))
}

/// The text of a regular file of at most `most` bytes.
///
/// # Errors
/// [`OpenError`]; its `Io` is of kind [`io::ErrorKind::InvalidData`] where it is not UTF-8.
pub fn read_text(path: &Path, most: u64) -> Result<String, OpenError> {
    let (file, about) = open(path)?;
    let fits = |found: u64| match found <= most {
        true => Ok(()),
        false => Err(OpenError::TooLong { found, most }),
    };
    fits(about.len())?;
    let mut text = String::new();
    // It may grow while it is read, and some files of the kernel's state no length.
    file.take(most.saturating_add(1)).read_to_string(&mut text)?;
    fits(text.len() as u64)?;
    Ok(text)
}

fn check(about: &Metadata) -> Result<(), OpenError> {
    match kind(about.file_type()) {
        None => Ok(()),
        Some(found) => Err(OpenError::NotAFile { found }),
    }
}

/// What something is that is no regular file, in words.
pub fn kind(of: FileType) -> Option<&'static str> {
    let kinds = [
        (of.is_dir(), "a folder"),
        (of.is_fifo(), "a pipe"),
        (of.is_socket(), "a socket"),
        (of.is_char_device(), "a device"),
        (of.is_block_device(), "a disk"),
        (!of.is_file(), "no regular file"),
    ];
    kinds.into_iter().find(|(is, _)| *is).map(|(_, name)| name)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rustix::fs::{CWD, FileType as Kind, Mode, mknodat};
    use std::os::unix::fs::symlink;
    use std::os::unix::net::UnixListener;

    #[test]
    fn what_is_no_regular_file_is_refused_by_its_kind_and_never_waited_for() {
        let tmp = tempfile::tempdir().unwrap();
        let path = |name: &str| tmp.path().join(name);
        mknodat(CWD, path("pipe"), Kind::Fifo, Mode::RUSR | Mode::WUSR, 0).unwrap();
        let _socket = UnixListener::bind(path("socket")).unwrap();
        symlink("pipe", path("link")).unwrap();
        symlink("nothing", path("dangling")).unwrap();
        symlink("loop", path("loop")).unwrap();
        symlink("/dev/zero", path("zeros")).unwrap();
        let refused = |name: &str| read_text(&path(name), 10).unwrap_err().to_string();
        for (name, words) in [
            (".", "this is a folder, expected a file"),
            ("pipe", "this is a pipe, expected a file"),
            ("link", "this is a pipe, expected a file"),
            ("socket", "this is a socket, expected a file"),
            ("zeros", "this is a device, expected a file"),
            ("dangling", "No such file or directory"),
            ("loop", "Too many levels of symbolic links"),
        ] {
            let said = refused(name);
            assert!(said.contains(words), "{name}: {said}");
        }
    }

    #[test]
    fn text_is_read_up_to_the_bound() {
        let tmp = tempfile::tempdir().unwrap();
        let path = tmp.path().join("text");
        fs::write(&path, "0123456789").unwrap();
        assert_eq!(read_text(&path, 10).unwrap(), "0123456789");
        let long = |path: &Path, most| read_text(path, most).unwrap_err().to_string();
        assert_eq!(long(&path, 9), "10 bytes; at most 9 are allowed");
        // Regular by its kind and of length 0, and yet it has content.
        let text = read_text(Path::new("/proc/self/status"), 1 << 16).unwrap();
        assert!(text.starts_with("Name:"));
        assert_eq!(
            long(Path::new("/proc/self/status"), 16),
            "17 bytes; at most 16 are allowed"
        );
    }
}
