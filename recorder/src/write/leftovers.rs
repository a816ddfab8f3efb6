//! What a killed recorder left behind.
//!
//! Its file is moved aside at once, to the name of a part, so that the new recording starts without delay; then it is
//! made whole on a thread of its own. If this recorder is killed too, the next one finds both.

use std::fs::{self, File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
use std::thread::{self, JoinHandle};

use crate::edit::recover::recover;
use crate::write::file_error::FileError;
use crate::write::paths;

/// Moves a growing file of `out` aside, if there is one whose recorder is dead; gives all parts of `out` that are not
/// whole, the one moved aside among them.
///
/// # Errors
/// [`FileError::Busy`] where the recorder lives, [`FileError::Rename`].
pub(crate) fn set_aside(out: &Path) -> Result<Vec<PathBuf>, FileError> {
    let recording = paths::recording(out);
    if recording.exists() {
        if is_locked(&recording) {
            return Err(FileError::Busy { path: recording });
        }
        let to = paths::recording(&paths::free_part(out));
        fs::rename(&recording, &to).map_err(|source| FileError::Rename {
            from: recording,
            to,
            source,
        })?;
    }
    Ok(unfinished_parts(out))
}

fn is_locked(path: &Path) -> bool {
    File::open(path).is_ok_and(|file| matches!(file.try_lock(), Err(TryLockError::WouldBlock)))
}

fn unfinished_parts(out: &Path) -> Vec<PathBuf> {
    let stop = paths::free_part(out);
    let parts = (1..).map(|n| paths::part(out, n)).take_while(|part| *part != stop);
    parts
        .map(|part| paths::recording(&part))
        .filter(|recording| recording.exists())
        .collect()
}

/// Makes each of these files whole, on a thread of its own. What happens is said on stderr.
pub(crate) fn recover_in_background(unfinished: Vec<PathBuf>) -> JoinHandle<()> {
    thread::spawn(move || {
        for recording in unfinished {
            bus::stderr_line!("recorder: {}", make_whole(&recording));
        }
    })
}

/// Makes one file whole, and says in words what came of it.
fn make_whole(recording: &Path) -> String {
    let Some(out) = paths::without_recording(recording) else {
        return format!("{} is not the name of a growing file", recording.display());
    };
    let (from, to) = (recording.display(), out.display());
    let info = match recover(recording, &out) {
        Ok(info) => info,
        Err(e) => return format!("an earlier recording was cut short and stays as it is, in {from}: {e}"),
    };
    let messages = info.tally.messages();
    let found: Vec<_> = info.damage.iter().map(ToString::to_string).collect();
    let found = found.join("; ");
    match retire(recording, info.is_intact()) {
        Ok(()) => format!("an earlier recording was cut short; {messages} messages of it are in {to} ({found})"),
        Err(e) => format!("{messages} messages of {from} are in {to} ({found}); putting the first away: {e}"),
    }
}

/// Removes a file that was recovered in full; keeps one with damage, for somebody who can read more of it.
fn retire(recording: &Path, intact: bool) -> io::Result<()> {
    match intact {
        true => fs::remove_file(recording),
        false => fs::rename(recording, paths::damaged(recording)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing;

    fn names(dir: &Path) -> Vec<String> {
        let entries = fs::read_dir(dir).unwrap();
        let mut names: Vec<_> = entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn each_killed_recording_becomes_a_part() {
        let tmp = tempfile::tempdir().unwrap();
        let out = tmp.path().join("s.mcap");
        for kill in 1..=2 {
            fs::write(paths::recording(&out), testing::unfinished(kill, 4)).unwrap();
            let unfinished = set_aside(&out).unwrap();
            assert_eq!(unfinished.len(), 1);
            recover_in_background(unfinished).join().unwrap();
        }
        assert_eq!(names(tmp.path()), ["s.1.mcap", "s.2.mcap"]);
        let info = crate::read::info::info(&tmp.path().join("s.2.mcap")).unwrap();
        assert_eq!(info.tally.messages(), 2 * 4 * 5);
    }

    #[test]
    fn damaged_and_unreadable_ones_are_kept() {
        let tmp = tempfile::tempdir().unwrap();
        let out = tmp.path().join("s.mcap");
        let mut bytes = testing::unfinished(3, 20);
        let middle = bytes.len() / 2;
        bytes[middle] ^= 1;
        fs::write(paths::recording(&out), bytes).unwrap();
        recover_in_background(set_aside(&out).unwrap()).join().unwrap();
        assert_eq!(names(tmp.path()), ["s.1.mcap", "s.1.mcap.recording.damaged"]);
        fs::write(paths::recording(&out), "").unwrap();
        recover_in_background(set_aside(&out).unwrap()).join().unwrap();
        assert_eq!(names(tmp.path()).len(), 3);
        assert!(tmp.path().join("s.2.mcap.recording").exists());
    }

    #[test]
    fn a_living_recorder_is_left_alone() {
        let tmp = tempfile::tempdir().unwrap();
        let out = tmp.path().join("s.mcap");
        let file = File::create(paths::recording(&out)).unwrap();
        file.try_lock().unwrap();
        assert!(matches!(set_aside(&out), Err(FileError::Busy { .. })));
        drop(file);
        assert_eq!(set_aside(&out).unwrap().len(), 1);
    }
}
