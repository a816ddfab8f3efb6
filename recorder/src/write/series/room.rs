//! Room on a disk.

use std::io;
use std::path::Path;

use crate::write::file_error::FileError;

/// How much is free on the disk of a folder, bytes.
pub(crate) type Free = fn(&Path) -> io::Result<u64>;

/// What is free for this user.
pub(crate) fn free_bytes(folder: &Path) -> io::Result<u64> {
    let facts = rustix::fs::statvfs(folder)?;
    Ok(facts.f_bavail.saturating_mul(facts.f_frsize))
}

/// Refuses a disk with less than `wanted` bytes free. One that cannot tell is taken to have room.
pub(super) fn check_room(out: &Path, wanted: u64, free: Free) -> Result<(), FileError> {
    let folder = out.parent().filter(|folder| !folder.as_os_str().is_empty());
    match free(folder.unwrap_or(Path::new("."))) {
        Ok(free) if free < wanted => Err(FileError::NoRoom {
            path: out.to_owned(),
            free_mb: free as f64 / 1e6,
            wanted_mb: wanted as f64 / 1e6,
        }),
        _ => Ok(()),
    }
}
