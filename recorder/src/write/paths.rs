//! Names of recordings: `FILE.mcap` is whole, `FILE.mcap.recording` is not, `FILE.1.mcap` is an earlier or later part.

use std::ffi::OsString;
use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

const RECORDING: &str = "recording";

fn with_suffix(path: &Path, suffix: &str) -> PathBuf {
    let mut name = OsString::from(path);
    name.push(".");
    name.push(suffix);
    PathBuf::from(name)
}

/// The name of `out` while it grows.
pub fn recording(out: &Path) -> PathBuf {
    with_suffix(out, RECORDING)
}

/// The name of `out` while it is made from another file.
pub fn partial(out: &Path) -> PathBuf {
    with_suffix(out, "partial")
}

/// The name under which a damaged recording is kept once what is readable of it is in a file of its own.
pub fn damaged(recording: &Path) -> PathBuf {
    with_suffix(recording, "damaged")
}

/// `path` without `.recording`, or `None` where it does not end so.
pub fn without_recording(path: &Path) -> Option<PathBuf> {
    let is_recording = path.extension().is_some_and(|extension| extension == RECORDING);
    is_recording.then(|| path.with_extension(""))
}

/// `FILE.N.mcap` for `FILE.mcap`.
pub fn part(out: &Path, n: u32) -> PathBuf {
    let mut name = out.file_stem().unwrap_or_default().to_owned();
    name.push(format!(".{n}"));
    if let Some(extension) = out.extension() {
        name.push(".");
        name.push(extension);
    }
    out.with_file_name(name)
}

/// The first part of `out` whose name is taken neither by a file nor by its recording, nor by a damaged one.
pub fn free_part(out: &Path) -> PathBuf {
    let taken = |part: &PathBuf| {
        let recording = recording(part);
        part.exists() || recording.exists() || damaged(&recording).exists()
    };
    (1..u32::MAX)
        .map(|n| part(out, n))
        .find(|part| !taken(part))
        .unwrap_or_else(|| part(out, u32::MAX))
}

/// Makes a file's new name last through a power failure.
pub(crate) fn sync_folder(path: &Path) -> io::Result<()> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    File::open(folder.unwrap_or(Path::new(".")))?.sync_all()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names() {
        let out = Path::new("/d/a.b.mcap");
        assert_eq!(recording(out), Path::new("/d/a.b.mcap.recording"));
        assert_eq!(without_recording(&recording(out)).as_deref(), Some(out));
        assert_eq!(without_recording(out), None);
        assert_eq!(part(out, 3), Path::new("/d/a.b.3.mcap"));
        assert_eq!(part(Path::new("plain"), 1), Path::new("plain.1"));
    }

    #[test]
    fn parts_are_never_overwritten() {
        let tmp = tempfile::tempdir().unwrap();
        let out = tmp.path().join("s.mcap");
        assert_eq!(free_part(&out), tmp.path().join("s.1.mcap"));
        std::fs::write(tmp.path().join("s.1.mcap"), "").unwrap();
        std::fs::write(tmp.path().join("s.2.mcap.recording"), "").unwrap();
        std::fs::write(tmp.path().join("s.3.mcap.recording.damaged"), "").unwrap();
        assert_eq!(free_part(&out), tmp.path().join("s.4.mcap"));
    }
}
