//! Folders and files that nobody but their user can exchange.
//!
//! Who makes a run's folder first, or may write into a folder above it, can put another scene or registration under a running
//! navigation. So every level is looked at, also where links lead: those above may be changed by their user and root only (or are
//! sticky, as /tmp is), and the run's own belongs to the user and is closed to all others.

use std::fs::{self, DirBuilder, File, Metadata, OpenOptions, Permissions};
use std::io::{self, Read};
use std::os::unix::fs::{DirBuilderExt, MetadataExt, OpenOptionsExt, PermissionsExt};
use std::path::{Path, PathBuf};

use super::{RunError, io_error};
use scene::file;

/// Group and others may write.
const WRITE_BY_GROUP: u32 = 0o020;
const WRITE_BY_OTHERS: u32 = 0o002;
/// Only a file's owner may rename or remove it in such a folder.
const STICKY: u32 = 0o1000;
/// A scene has at most 1 MiB before its defaults are written out.
const MOST_BYTES: u64 = 4 << 20;

/// Creates `dir` with what is missing above it, for this user only, and refuses one that others own or may change. The mode of a
/// folder that is there already is left alone: it may be one that others need.
pub(super) fn make(dir: &Path) -> Result<(), RunError> {
    DirBuilder::new()
        .recursive(true)
        .mode(0o700)
        .create(dir)
        .map_err(io_error("creating", dir))?;
    check(dir)
}

/// Refuses a run's folder that others own, or may change or exchange at any level.
pub(super) fn check(dir: &Path) -> Result<(), RunError> {
    let found = about(dir)?;
    is_owned(dir, &found)?;
    if !found.is_dir() {
        return Err(open_to_others(dir, "it is a link or a file, and no folder".to_owned()));
    }
    if found.mode() & 0o077 != 0 {
        let words = format!("mode {:o}, needed is 700", found.mode() & 0o777);
        return Err(open_to_others(dir, words));
    }
    let named = std::path::absolute(dir).map_err(io_error("reading", dir))?;
    let real = fs::canonicalize(dir).map_err(io_error("reading", dir))?;
    // From the root on: who may change a level may do anything with those below.
    let above = |path: &Path| path.ancestors().skip(1).map(Path::to_owned).collect::<Vec<_>>();
    for level in above(&named).iter().rev().chain(above(&real).iter().rev()) {
        check_above(level, &about(level)?)?;
    }
    Ok(())
}

fn about(path: &Path) -> Result<Metadata, RunError> {
    fs::symlink_metadata(path).map_err(io_error("reading", path))
}

fn me() -> u32 {
    rustix::process::getuid().as_raw()
}

fn is_owned(dir: &Path, found: &Metadata) -> Result<bool, RunError> {
    match found.uid() == me() {
        true => Ok(true),
        false => Err(RunError::Foreign {
            dir: dir.to_owned(),
            owner: found.uid(),
            me: me(),
        }),
    }
}

/// A level above belongs to the system or to this user, and nobody else may exchange what lies in it. A link leads where its owner
/// wants, and has no mode.
fn check_above(level: &Path, found: &Metadata) -> Result<(), RunError> {
    if found.uid() != 0 {
        is_owned(level, found)?;
    }
    let mode = found.mode();
    if found.file_type().is_symlink() || mode & STICKY != 0 {
        return Ok(());
    }
    // Of root's group is root; any other may have members that nobody here knows.
    let by_group = mode & WRITE_BY_GROUP != 0 && found.gid() != 0;
    match mode & WRITE_BY_OTHERS != 0 || by_group {
        true => Err(open_to_others(
            level,
            format!("mode {:o}: others may write into it", mode & 0o7777),
        )),
        false => Ok(()),
    }
}

fn open_to_others(level: &Path, found: String) -> RunError {
    RunError::Open {
        level: level.to_owned(),
        found,
    }
}

/// The bytes of a run's own file: a regular one of this user's, no link, that nobody else may write.
pub(super) fn read(path: &Path) -> io::Result<Vec<u8>> {
    let refuse = |why: String| Err(io::Error::new(io::ErrorKind::PermissionDenied, why));
    // In a folder that is closed to others nobody exchanges it between this and the next line.
    if fs::symlink_metadata(path)?.is_symlink() {
        return refuse("it is a link".to_owned());
    }
    let (file, found) = file::open(path)?;
    if found.uid() != me() {
        return refuse(format!("it belongs to user {}, not to you ({})", found.uid(), me()));
    }
    if found.mode() & (WRITE_BY_OTHERS | WRITE_BY_GROUP) != 0 {
        return refuse(format!("mode {:o}: others may write it", found.mode() & 0o777));
    }
    let mut bytes = Vec::new();
    file.take(MOST_BYTES + 1).read_to_end(&mut bytes)?;
    match bytes.len() as u64 <= MOST_BYTES {
        true => Ok(bytes),
        false => refuse(format!("it has more than {MOST_BYTES} bytes")),
    }
}

/// Writes a run's own file, readable by its user only: whole, or not at all.
pub(super) fn write(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let part = PathBuf::from(format!("{}.part", path.display()));
    // A link or a file that somebody left there is removed, never written through.
    match fs::remove_file(&part) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
        _ => {}
    }
    let mut file = create_new(&part)?;
    io::Write::write_all(&mut file, bytes)?;
    fs::rename(&part, path)
}

fn create_new(path: &Path) -> io::Result<File> {
    OpenOptions::new().write(true).create_new(true).mode(0o600).open(path)
}

/// Closes the files in `folder` whose names begin with `prefix` to everybody but their user.
pub(crate) fn close_files(folder: &Path, prefix: &str) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let is_open = |found: Metadata| found.is_file() && found.uid() == me() && found.mode() & 0o077 != 0;
        if entry.file_name().to_string_lossy().starts_with(prefix) && entry.metadata().is_ok_and(is_open) {
            // What cannot be closed is another user's, or has gone.
            let _ = fs::set_permissions(entry.path(), Permissions::from_mode(0o600));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::fs::symlink;

    fn mode(path: &Path, mode: u32) {
        fs::set_permissions(path, Permissions::from_mode(mode)).unwrap();
    }

    #[test]
    fn every_level_of_a_run_is_closed_to_others() {
        let tmp = tempfile::tempdir().unwrap();
        let dir = tmp.path().join("trocar/demo");
        make(&dir).unwrap();
        assert_eq!(fs::metadata(&dir).unwrap().mode() & 0o777, 0o700);
        // One's own that is open is not closed: it may be the system's, and named by mistake.
        mode(&dir, 0o755);
        assert!(make(&dir).unwrap_err().to_string().contains("mode 755, needed is 700"));
        assert_eq!(fs::metadata(&dir).unwrap().mode() & 0o777, 0o755);
        mode(&dir, 0o700);
        // A level above into which a group may write.
        let group = |gid| std::os::unix::fs::chown(tmp.path(), None, Some(gid));
        mode(tmp.path(), 0o770);
        if rustix::process::getuid().is_root() && group(100).is_ok() {
            assert!(check(&dir).unwrap_err().to_string().contains("others may write"));
            group(0).unwrap();
            check(&dir).unwrap();
        }
        // A level above into which others may write.
        mode(tmp.path(), 0o777);
        let text = make(&dir).unwrap_err().to_string();
        let level = tmp.path().display().to_string();
        assert!(text.contains(&level) && text.contains("others may write"), "{text}");
        // Where it is sticky they cannot exchange what is not theirs.
        mode(tmp.path(), 0o1777);
        make(&dir).unwrap();
    }

    #[test]
    fn a_link_is_no_folder_of_a_run_and_where_links_above_lead_is_looked_at() {
        let tmp = tempfile::tempdir().unwrap();
        make(&tmp.path().join("open/demo")).unwrap();
        symlink(tmp.path().join("open/demo"), tmp.path().join("demo")).unwrap();
        let text = check(&tmp.path().join("demo")).unwrap_err().to_string();
        assert!(text.contains("no folder"), "{text}");
        // Where it leads nothing is changed.
        mode(&tmp.path().join("open"), 0o755);
        symlink(tmp.path().join("open"), tmp.path().join("other")).unwrap();
        assert!(make(&tmp.path().join("other")).is_err());
        assert_eq!(fs::metadata(tmp.path().join("open")).unwrap().mode() & 0o777, 0o755);
        symlink(tmp.path().join("open"), tmp.path().join("trocar")).unwrap();
        check(&tmp.path().join("trocar/demo")).unwrap();
        mode(&tmp.path().join("open"), 0o777);
        let text = check(&tmp.path().join("trocar/demo")).unwrap_err().to_string();
        assert!(text.contains("open: mode 777"), "{text}");
    }

    #[test]
    fn a_file_of_a_run_is_no_link_and_nobody_elses() {
        let tmp = tempfile::tempdir().unwrap();
        let (file, link) = (tmp.path().join("f"), tmp.path().join("l"));
        write(&file, b"1").unwrap();
        assert_eq!(fs::metadata(&file).unwrap().mode() & 0o777, 0o600);
        assert_eq!(read(&file).unwrap(), b"1");
        symlink(&file, &link).unwrap();
        assert!(read(&link).is_err());
        mode(&file, 0o666);
        assert!(read(&file).unwrap_err().to_string().contains("others may write it"));
        // A link where the part is written is not followed.
        fs::write(tmp.path().join("victim"), b"v").unwrap();
        symlink(tmp.path().join("victim"), tmp.path().join("f.part")).unwrap();
        write(&file, b"2").unwrap();
        assert_eq!(fs::read(tmp.path().join("victim")).unwrap(), b"v");
        fs::write(&file, vec![b'x'; (4 << 20) + 1]).unwrap();
        mode(&file, 0o600);
        assert!(read(&file).unwrap_err().to_string().contains("more than"));
    }

    /// As a run's segment of iceoryx2's that is made for everybody.
    #[test]
    fn files_of_a_prefix_are_closed() {
        let tmp = tempfile::tempdir().unwrap();
        for name in ["tr1_a", "other"] {
            fs::write(tmp.path().join(name), b"x").unwrap();
            mode(&tmp.path().join(name), 0o666);
        }
        close_files(tmp.path(), "tr1_");
        let found = |name: &str| fs::metadata(tmp.path().join(name)).unwrap().mode() & 0o777;
        assert_eq!((found("tr1_a"), found("other")), (0o600, 0o666));
    }
}
