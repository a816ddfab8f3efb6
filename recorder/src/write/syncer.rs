//! Tells the disk to keep what it was given, on a thread of its own: nobody waits for it but whoever asks.

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{self, Receiver, Sender};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use bus::clock;

use crate::write::paths;

enum Job {
    /// `fdatasync`; then `messages` in all survive a power cut.
    Data { file: Arc<File>, messages: u64 },
    /// A file that is complete gets its name once the disk has it.
    Whole {
        file: Arc<File>,
        from: PathBuf,
        to: PathBuf,
    },
}

#[derive(Debug, Default)]
struct Shared {
    busy: AtomicBool,
    durable: AtomicU64,
    problem: Mutex<Option<String>>,
}

/// The thread that waits for the disk.
#[derive(Debug)]
pub(crate) struct Syncer {
    jobs: Option<Sender<Job>>,
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
    every_ns: i64,
    next_ns: i64,
}

impl Syncer {
    /// A thread that syncs data at most once in `every`.
    pub(crate) fn start(every: Duration) -> Self {
        let (jobs, waiting) = mpsc::channel();
        let shared = Arc::<Shared>::default();
        let theirs = Arc::clone(&shared);
        Self {
            jobs: Some(jobs),
            shared,
            thread: Some(thread::spawn(move || work(&waiting, &theirs))),
            every_ns: clock::ns(every),
            next_ns: i64::MIN,
        }
    }

    /// Asks for a sync of `file`, with `messages` in all handed over so far; not where one is under way or was a moment
    /// ago: the next call asks for everything that this one would have.
    pub(crate) fn data(&mut self, now_ns: i64, file: &Arc<File>, messages: u64) {
        if now_ns < self.next_ns || self.shared.busy.swap(true, Ordering::AcqRel) {
            return;
        }
        self.next_ns = now_ns.saturating_add(self.every_ns);
        let file = Arc::clone(file);
        self.send(Job::Data { file, messages });
    }

    /// Gives a complete file its name once the disk has it.
    pub(crate) fn whole(&self, file: Arc<File>, from: PathBuf, to: PathBuf) {
        self.send(Job::Whole { file, from, to });
    }

    fn send(&self, job: Job) {
        // The thread ends only when the channel does.
        let _ = self.jobs.as_ref().map(|jobs| jobs.send(job));
    }

    /// Messages that survive a power cut.
    pub(crate) fn durable(&self) -> u64 {
        self.shared.durable.load(Ordering::Acquire)
    }

    /// Why the disk does not keep what it was given, once.
    pub(crate) fn take_problem(&self) -> Option<String> {
        let mut problem = self.shared.problem.lock().unwrap_or_else(PoisonError::into_inner);
        problem.take()
    }

    /// Waits until everything asked for is done, and goes on.
    #[cfg(test)]
    pub(crate) fn settle(&mut self) {
        self.finish();
        let (jobs, waiting) = mpsc::channel();
        let theirs = Arc::clone(&self.shared);
        self.thread = Some(thread::spawn(move || work(&waiting, &theirs)));
        self.jobs = Some(jobs);
    }

    /// Waits until everything asked for is done.
    pub(crate) fn finish(&mut self) {
        self.jobs = None;
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

impl Drop for Syncer {
    fn drop(&mut self) {
        self.finish();
    }
}

fn work(jobs: &Receiver<Job>, shared: &Shared) {
    for job in jobs {
        let done = match job {
            Job::Data { file, messages } => {
                let done = file.sync_data().map_err(|e| e.to_string());
                if done.is_ok() {
                    shared.durable.fetch_max(messages, Ordering::AcqRel);
                }
                shared.busy.store(false, Ordering::Release);
                done
            }
            Job::Whole { file, from, to } => {
                let done = name(&file, &from, &to);
                done.map_err(|e| format!("completing {}: {e}", to.display()))
            }
        };
        if let Err(problem) = done {
            *shared.problem.lock().unwrap_or_else(PoisonError::into_inner) = Some(problem);
        }
    }
}

fn name(file: &File, from: &Path, to: &Path) -> io::Result<()> {
    file.sync_all()?;
    fs::rename(from, to)?;
    paths::sync_folder(to)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_synced_is_known_and_not_asked_for_too_often() {
        let tmp = tempfile::tempdir().unwrap();
        let file = Arc::new(File::create(tmp.path().join("f")).unwrap());
        let mut syncer = Syncer::start(Duration::from_secs(1));
        syncer.data(0, &file, 5);
        // Within the second: not asked for.
        syncer.data(999_999_999, &file, 9);
        syncer.finish();
        assert_eq!((syncer.durable(), syncer.take_problem()), (5, None));
    }

    #[test]
    fn a_complete_file_gets_its_name_and_a_failure_is_told() {
        let tmp = tempfile::tempdir().unwrap();
        let (from, to) = (tmp.path().join("a.recording"), tmp.path().join("a"));
        let file = Arc::new(File::create(&from).unwrap());
        let mut syncer = Syncer::start(Duration::from_secs(1));
        syncer.whole(Arc::clone(&file), from, to.clone());
        syncer.whole(file, tmp.path().join("missing"), tmp.path().join("b"));
        syncer.finish();
        assert!(to.exists());
        let problem = syncer.take_problem().unwrap();
        assert!(
            problem.contains("completing") && problem.contains("No such file"),
            "{problem}"
        );
    }
}
