//! A file that is being received: hidden, readable by its owner alone, and gone again unless it is given its name.

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Seek, Write};
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use dicom_object::FileMetaTableBuilder;
use rustix::fs::{CWD, RenameFlags, renameat_with};

use super::uid::Uid;

/// Names of such files begin with it, so that scans pass them over and what a killed process left is found.
pub(super) const PREFIX: &str = ".part-";
const BUFFER_BYTES: usize = 1 << 20;

/// A file on its way.
#[derive(Debug)]
pub(crate) struct Part {
    path: PathBuf,
    file: BufWriter<File>,
    /// Where the data set begins.
    data_at: u64,
    /// Bytes of the data set.
    data: u64,
}

impl Part {
    /// A new one in `folder`: preamble and File Meta Information (PS3.10 section 7.1) for a data set in this coding.
    ///
    /// # Errors
    /// Those of the system.
    pub(crate) fn create(folder: &Path, [class, instance, syntax]: [&Uid; 3]) -> io::Result<Self> {
        static COUNT: AtomicU64 = AtomicU64::new(0);
        let count = COUNT.fetch_add(1, Ordering::Relaxed);
        let path = folder.join(format!("{PREFIX}{}-{count}", std::process::id()));
        // Neither an older file nor one that a link leads to is written over.
        let file = OpenOptions::new()
            .read(true)
            .write(true)
            .create_new(true)
            .mode(0o600)
            .open(&path)?;
        let mut part = Self {
            path,
            file: BufWriter::with_capacity(BUFFER_BYTES, file),
            data_at: 0,
            data: 0,
        };
        let meta = FileMetaTableBuilder::new()
            .media_storage_sop_class_uid(class.as_str())
            .media_storage_sop_instance_uid(instance.as_str())
            .transfer_syntax(syntax.as_str());
        let meta = meta.build().map_err(io::Error::other)?;
        part.file.write_all(&[0; 128])?;
        part.file.write_all(b"DICM")?;
        meta.write(&mut part.file).map_err(io::Error::other)?;
        part.data_at = part.file.stream_position()?;
        Ok(part)
    }

    /// More of the data set.
    ///
    /// # Errors
    /// Those of the system.
    pub(crate) fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.data += bytes.len() as u64;
        self.file.write_all(bytes)
    }

    /// Where the data set begins.
    pub(crate) fn data_at(&self) -> u64 {
        self.data_at
    }

    /// Bytes of the data set so far.
    pub(crate) fn data(&self) -> u64 {
        self.data
    }

    /// Puts all of it on the disk, and gives it to be read from its beginning.
    ///
    /// # Errors
    /// Those of the system.
    pub(crate) fn written(&mut self) -> io::Result<&File> {
        self.file.flush()?;
        let file = self.file.get_mut();
        file.sync_all()?;
        file.rewind()?;
        Ok(file)
    }

    /// Gives it its name, where nothing is; `false` where something is.
    ///
    /// # Errors
    /// Those of the system.
    pub(crate) fn name(&self, path: &Path) -> io::Result<bool> {
        rename_new(&self.path, path)
    }
}

/// Renames what nothing is in the way of; `false` where something is.
pub(super) fn rename_new(from: &Path, to: &Path) -> io::Result<bool> {
    match renameat_with(CWD, from, CWD, to, RenameFlags::NOREPLACE) {
        Ok(()) => Ok(true),
        Err(rustix::io::Errno::EXIST) => Ok(false),
        Err(error) => Err(error.into()),
    }
}

impl Drop for Part {
    fn drop(&mut self) {
        // Where it was given its name there is nothing of this one any more.
        let _ = fs::remove_file(&self.path);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn uids() -> [Uid; 3] {
        ["1.2.840.10008.5.1.4.1.1.2", "1.2.3", "1.2.840.10008.1.2"].map(|text| Uid::checked(text.as_bytes()).unwrap())
    }

    #[test]
    fn nothing_is_left_of_what_was_not_named_also_after_a_panic() {
        let tmp = tempfile::tempdir().unwrap();
        let uids = uids();
        let part = || Part::create(tmp.path(), uids.each_ref()).unwrap();
        let count = || fs::read_dir(tmp.path()).unwrap().count();
        let mut dropped = part();
        dropped.write(b"abc").unwrap();
        assert_eq!(count(), 1);
        drop(dropped);
        assert_eq!(count(), 0);
        let panics = std::panic::catch_unwind(|| {
            let _part = part();
            panic!("in the middle");
        });
        assert!(panics.is_err() && count() == 0);
        let (mut kept, path) = (part(), tmp.path().join("1.2.3.dcm"));
        kept.write(b"abc").unwrap();
        kept.written().unwrap();
        assert!(kept.name(&path).unwrap());
        let second = part();
        assert!(!second.name(&path).unwrap());
        drop((kept, second));
        assert_eq!(count(), 1);
        let bytes = fs::read(&path).unwrap();
        assert!(bytes.ends_with(b"abc") && &bytes[128..132] == b"DICM");
    }
}
