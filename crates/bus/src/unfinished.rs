//! Shared memory that a process was killed in the midst of making.
//!
//! iceoryx2 makes a segment without the right to read, gives it its size, fills it, and only then lets others read it. Who opens one
//! that has no size yet waits until it has one, without end (0.10, `dynamic_storage::posix_shared_memory`): where its maker was
//! killed in between, one process after the other stands still there, the pilot too. Others wait in vain for what will never be
//! readable. So the keeper of a run takes such segments away, on a thread of its own that asks iceoryx2 nothing.

use std::collections::HashSet;
use std::fs::{self, Metadata};
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use crate::run::SHM_DIR;

/// How often it is looked for them: a few hundred files, 0.3 ms.
const EVERY: Duration = Duration::from_millis(100);
/// The owner's right to read.
const READABLE: u32 = 0o400;

/// Takes away what is unfinished and nobody's, until it is dropped.
#[derive(Debug)]
pub(crate) struct Sweeper {
    is_done: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Sweeper {
    /// Looks after the segments whose names begin with `prefix`. Where the system gives no thread, nobody looks after them.
    pub(crate) fn start(prefix: String) -> Self {
        let is_done = Arc::new(AtomicBool::new(false));
        let done = Arc::clone(&is_done);
        let look = move || {
            while !done.load(Ordering::Relaxed) {
                remove_unfinished(Path::new(SHM_DIR), &prefix);
                std::thread::park_timeout(EVERY);
            }
        };
        let thread = std::thread::Builder::new().name("sweeper".to_owned()).spawn(look);
        Self {
            is_done,
            thread: thread.ok(),
        }
    }
}

impl Drop for Sweeper {
    fn drop(&mut self) {
        self.is_done.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            thread.thread().unpark();
            let _ = thread.join();
        }
    }
}

/// A file, whatever its name.
type Identity = (u64, u64);

fn identity(found: &Metadata) -> Identity {
    (found.dev(), found.ino())
}

/// Removes the segments of `folder` that were never finished and that no process has open any more: their makers have died.
fn remove_unfinished(folder: &Path, prefix: &str) {
    let unfinished: Vec<(PathBuf, Identity)> = fs::read_dir(folder)
        .into_iter()
        .flatten()
        .flatten()
        .filter(|entry| entry.file_name().to_string_lossy().starts_with(prefix))
        .filter_map(|entry| {
            let found = entry
                .metadata()
                .ok()
                .filter(|found| found.is_file() && found.mode() & READABLE == 0)?;
            Some((entry.path(), identity(&found)))
        })
        .collect();
    if unfinished.is_empty() {
        return;
    }
    // After they were seen: who makes one has it open from its first moment until it is finished.
    let open = open_files(folder);
    for (path, file) in unfinished {
        // Unless it was finished, and closed, meanwhile.
        let is_so_still =
            fs::symlink_metadata(&path).is_ok_and(|now| identity(&now) == file && now.mode() & READABLE == 0);
        if is_so_still && !open.contains(&file) {
            let _ = fs::remove_file(path);
        }
    }
}

/// The files of `folder` that any process has open, as far as this one may know: those of its own user.
fn open_files(folder: &Path) -> HashSet<Identity> {
    let processes = fs::read_dir("/proc").into_iter().flatten().flatten();
    let descriptors = processes
        .filter(|process| {
            process
                .file_name()
                .to_string_lossy()
                .bytes()
                .all(|byte| byte.is_ascii_digit())
        })
        .flat_map(|process| fs::read_dir(process.path().join("fd")).into_iter().flatten().flatten());
    descriptors
        .filter(|descriptor| fs::read_link(descriptor.path()).is_ok_and(|file| file.starts_with(folder)))
        .filter_map(|descriptor| fs::metadata(descriptor.path()).ok())
        .map(|found| identity(&found))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs::{File, Permissions};
    use std::os::unix::fs::PermissionsExt;

    #[test]
    fn only_what_is_unfinished_and_nobodys_is_removed() {
        let folder = tempfile::tempdir().unwrap();
        let made = |name: &str, mode: u32| {
            let path = folder.path().join(name);
            let file = File::create(&path).unwrap();
            fs::set_permissions(path, Permissions::from_mode(mode)).unwrap();
            file
        };
        let _held = made("run_a", 0o200);
        drop(made("run_b", 0o200));
        drop(made("run_c", 0o600));
        drop(made("other_d", 0o200));
        remove_unfinished(folder.path(), "run_");
        let mut left: Vec<String> = fs::read_dir(folder.path())
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        left.sort();
        assert_eq!(left, ["other_d", "run_a", "run_c"]);
    }
}
