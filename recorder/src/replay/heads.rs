//! Looks beside the replay whether every record lies where the recording's index has it.
//!
//! Whoever opens a recording goes by its index, which says so of itself; a chunk whose head is damaged is then passed over as a record
//! of another kind. To look at each head is to read a page of the file for each chunk, which takes seconds for a large file that the
//! memory does not have: the first image does not wait for that.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use crate::read::damage::OpenError;
use crate::read::seek::{self, Stated};

/// Leaves the processor to whoever shows images.
const NICE: i32 = 19;
/// More differences are not told: one head that is damaged is a difference of its chunk and of all behind it at most.
const MOST: usize = 100;

/// A thread that looks once.
#[derive(Debug, Default)]
pub(super) struct Heads {
    found: Arc<Mutex<Vec<String>>>,
}

impl Heads {
    /// Begins to look at `recording`. The thread ends with the process: nothing is to be waited for.
    pub(super) fn begin(recording: &Path) -> Self {
        let heads = Self::default();
        let (found, path) = (Arc::clone(&heads.found), recording.to_owned());
        let spawned = std::thread::Builder::new()
            .name("heads".to_owned())
            .spawn(move || look(path, &found));
        if let Err(error) = spawned {
            heads.put(vec![format!("no thread to look at its records: {error}")]);
        }
        heads
    }

    /// What was found so far, in words.
    pub(super) fn found(&self) -> Vec<String> {
        self.found.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    fn put(&self, words: Vec<String>) {
        *self.found.lock().unwrap_or_else(PoisonError::into_inner) = words;
    }
}

fn look(path: PathBuf, found: &Arc<Mutex<Vec<String>>>) {
    // Of this thread alone. Where the system refuses it, the looking only takes the more of the processor.
    let _ = rustix::process::setpriority_process(None, NICE);
    let mut words = differences(&path).unwrap_or_else(|error| vec![error.to_string()]);
    words.truncate(MOST);
    *found.lock().unwrap_or_else(PoisonError::into_inner) = words;
}

/// Where the index says something else than the records; nothing where there is none to go by.
fn differences(path: &Path) -> Result<Vec<String>, OpenError> {
    match seek::stated(path)? {
        // Whatever an index may leave out, as those of other programs do, is no fault of it.
        Stated::Index(summary) => Ok(seek::differences(path, &summary, false)?.found),
        Stated::Unnamed(_) | Stated::Nothing | Stated::Unreadable(_) => Ok(Vec::new()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing;
    use std::time::Duration;

    fn of(bytes: &[u8]) -> Vec<String> {
        let tmp = tempfile::tempdir().unwrap();
        let path = tmp.path().join("s.mcap");
        std::fs::write(&path, bytes).unwrap();
        differences(&path).unwrap()
    }

    /// A chunk whose head is damaged was left out of a replay, and only the pilot's question before it said so.
    #[test]
    fn a_chunk_that_is_not_where_the_index_has_it_is_told() {
        let whole = testing::finished(3, 5);
        assert_eq!(of(&whole), Vec::<String>::new());
        assert_eq!(of(&testing::unfinished(3, 5)), Vec::<String>::new());
        let names = whole.windows(4).enumerate().filter(|(_, w)| w == b"zstd");
        // Of each chunk but the first, which has no messages, the opcode.
        for (at, _) in names.skip(1).take(3) {
            let mut flipped = whole.clone();
            flipped[at - (1 + 8 + 16 + 8 + 4 + 4)] ^= 0x40;
            let found = of(&flipped);
            assert!(
                found[0].starts_with("the index lists 4 chunks, and there are 3"),
                "{found:?}"
            );
            assert!(found[1].contains("lost are 5 of /tool_pose"), "{found:?}");
        }
    }

    #[test]
    fn it_is_told_while_the_replay_goes_on() {
        let tmp = tempfile::tempdir().unwrap();
        let path = tmp.path().join("s.mcap");
        let heads = Heads::begin(&path);
        // Nothing has been opened yet that could be missed: a file that is not there is told too.
        while heads.found().is_empty() {
            std::thread::sleep(Duration::from_millis(1));
        }
        assert!(heads.found()[0].contains("s.mcap"), "{:?}", heads.found());
    }
}
