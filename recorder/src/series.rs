//! The files of one session, one after the other: rotated by size and time, stopped while the disk is full.
//!
//! Complete parts are `FILE.1.mcap`, `FILE.2.mcap`...; the last one is `FILE.mcap`. Where a file can be written no longer,
//! it stays as it is, as a part that grows no more; what comes is counted and not recorded until there is room again.
//! Nobody but the recorder is held up by any of this.

use std::fs::File;
use std::io;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

use bus::clock;
use bus::message::Level;
use bus::scene::RecordingSpec;
use mcap::records::Metadata;

use crate::file_error::FileError;
use crate::leftovers;
use crate::pose_log::Entry;
use crate::proto::Log;
use crate::schema::RunFacts;
use crate::session_file::{Content, Finished, SessionFile};
use crate::syncer::Syncer;

/// Between two looks at the disk's free space.
const LOOK_NS: i64 = 1_000_000_000;
/// After a failure that free space does not explain, the next file is tried after this.
const AGAIN_NS: i64 = 5_000_000_000;
/// More must be free for recording to go on than for it to stop: it must not start and stop all the time.
const ROOM_AGAIN: f64 = 1.25;

/// How much is free on the disk of a folder, bytes.
pub(crate) type Free = fn(&Path) -> io::Result<u64>;

/// What is free for this user.
pub(crate) fn free_bytes(folder: &Path) -> io::Result<u64> {
    let facts = rustix::fs::statvfs(folder)?;
    Ok(facts.f_bavail.saturating_mul(facts.f_frsize))
}

#[derive(Debug)]
enum State {
    Writing {
        file: Box<SessionFile>,
        since_ns: i64,
        flush_at_ns: Option<i64>,
    },
    Stopped {
        why: String,
        unrecorded: u64,
        again_ns: i64,
    },
}

/// A session's files.
#[derive(Debug)]
pub(crate) struct Series {
    out: PathBuf,
    content: Content,
    spec: RecordingSpec,
    state: State,
    syncer: Syncer,
    free: Free,
    look_ns: i64,
    /// What earlier files of this process hold.
    earlier: u64,
    /// Messages that came while nothing could be recorded, before the last time that recording went on.
    unrecorded: u64,
    /// How many files came before.
    parts: u32,
    /// What must be said, and goes into the log as soon as there is a file.
    notices: Vec<(i64, Level, String)>,
    /// How many of them were said.
    said: usize,
}

impl Series {
    /// Starts the first file.
    ///
    /// # Errors
    /// [`FileError::NoRoom`], and those of [`SessionFile::create`].
    pub(crate) fn start(out: &Path, content: Content, spec: &RecordingSpec, free: Free) -> Result<Self, FileError> {
        check_room(out, spec.min_free_bytes, free)?;
        Ok(Self {
            state: writing(SessionFile::create(out, &content)?, i64::MIN),
            out: out.to_owned(),
            content,
            spec: spec.clone(),
            syncer: Syncer::start(spec.sync),
            free,
            look_ns: i64::MIN,
            earlier: 0,
            unrecorded: 0,
            parts: 0,
            notices: Vec::new(),
            said: 0,
        })
    }

    /// Takes a message, or counts it as not recorded.
    pub(crate) fn put(&mut self, now_ns: i64, entry: Entry<'_>) {
        let taken = match &mut self.state {
            State::Writing { file, .. } => file.put(entry),
            State::Stopped { unrecorded, .. } => {
                *unrecorded += u64::from(entry.counted().is_some());
                Ok(())
            }
        };
        self.stop_on(now_ns, taken);
    }

    /// Writes down what is known of the run, in this file and in those to come.
    pub(crate) fn facts(&mut self, now_ns: i64, facts: &RunFacts) {
        self.content.facts = facts.clone();
        if let State::Writing { file, .. } = &mut self.state {
            let written = file.facts(facts);
            self.stop_on(now_ns, written);
        }
    }

    /// Closes a chunk, rotates, looks at the disk, each if it is time. Gives what a person must be told.
    pub(crate) fn step(&mut self, now_ns: i64) -> Vec<String> {
        self.look(now_ns);
        self.flush(now_ns);
        self.rotate(now_ns);
        let words = self
            .notices
            .iter()
            .skip(self.said)
            .map(|(_, _, words)| words.clone())
            .collect();
        self.write_notices(now_ns);
        words
    }

    fn flush(&mut self, now_ns: i64) {
        let State::Writing {
            file,
            since_ns,
            flush_at_ns,
        } = &mut self.state
        else {
            return;
        };
        if *since_ns == i64::MIN {
            *since_ns = now_ns;
        }
        if !file.is_dirty() {
            return;
        }
        let due = *flush_at_ns.get_or_insert(now_ns.saturating_add(clock::ns(self.spec.chunk)));
        if now_ns < due {
            return;
        }
        *flush_at_ns = None;
        let flushed = file.flush();
        if flushed.is_ok() {
            let total = self.earlier + file.written();
            self.syncer.data(now_ns, file.file(), total);
        }
        self.stop_on(now_ns, flushed);
    }

    fn rotate(&mut self, now_ns: i64) {
        let State::Writing { file, since_ns, .. } = &self.state else {
            return;
        };
        let full = self.spec.rotate_bytes.is_some_and(|most| file.bytes() >= most);
        let since = now_ns.saturating_sub(*since_ns);
        let old = self.spec.rotate_after.is_some_and(|most| since >= clock::ns(most));
        if full || old {
            self.close(now_ns);
            self.resume(now_ns);
        }
    }

    /// Completes the file as a part, and is stopped; [`Series::resume`] goes on.
    fn close(&mut self, now_ns: i64) {
        let stopped = State::Stopped {
            why: String::new(),
            unrecorded: 0,
            again_ns: now_ns,
        };
        let State::Writing { file, .. } = std::mem::replace(&mut self.state, stopped) else {
            return;
        };
        self.earlier += file.written() + file.unwritten().messages;
        let unwritten = file.unwritten().messages;
        match file.complete() {
            Ok(whole) => {
                self.parts += 1;
                self.syncer.whole(whole.file, whole.from, whole.to);
            }
            Err(error) => {
                self.earlier -= unwritten;
                self.stopped_by(now_ns, &error);
            }
        }
    }

    /// Starts the next file; where that fails, tries again later.
    fn resume(&mut self, now_ns: i64) {
        let State::Stopped { why, unrecorded, .. } = &self.state else {
            return;
        };
        let (why, unrecorded) = (why.clone(), *unrecorded);
        // A file that could not be given another name when it ended still has this one.
        let aside = leftovers::set_aside(&self.out);
        match aside.and_then(|_| SessionFile::create(&self.out, &self.content)) {
            Ok(file) => {
                self.unrecorded += unrecorded;
                if !why.is_empty() {
                    let words = format!("recording goes on; {unrecorded} messages were not recorded meanwhile");
                    self.notices.push((now_ns, Level::Warning, words));
                }
                self.state = writing(file, now_ns);
            }
            Err(error) => self.stopped_by(now_ns, &error),
        }
    }

    /// Once a second: whether the disk has room, and whether it keeps what it was given.
    fn look(&mut self, now_ns: i64) {
        if now_ns < self.look_ns {
            return;
        }
        self.look_ns = now_ns.saturating_add(LOOK_NS);
        if let Some(why) = self.syncer.take_problem() {
            let path = self.out.clone();
            self.stop_on(now_ns, Err(FileError::Sync { path, why }));
        }
        if let State::Writing { file, .. } = &self.state
            && is_removed(file.file())
        {
            let path = self.out.clone();
            self.stop_on(now_ns, Err(FileError::Removed { path }));
        }
        match &self.state {
            State::Writing { .. } => {
                if let Err(error) = check_room(&self.out, self.spec.min_free_bytes, self.free) {
                    self.close(now_ns);
                    self.stopped_by(now_ns, &error);
                }
            }
            State::Stopped { again_ns, .. } => {
                let wanted = (self.spec.min_free_bytes as f64 * ROOM_AGAIN) as u64;
                if now_ns >= *again_ns && check_room(&self.out, wanted, self.free).is_ok() {
                    self.resume(now_ns);
                }
            }
        }
    }

    fn stop_on(&mut self, now_ns: i64, done: Result<(), FileError>) {
        let Err(mut error) = done else { return };
        let state = State::Stopped {
            why: String::new(),
            unrecorded: 0,
            again_ns: now_ns,
        };
        if let State::Writing { file, .. } = std::mem::replace(&mut self.state, state) {
            // What is in a file that has been removed is nowhere.
            let removed = is_removed(file.file());
            self.earlier += if removed { 0 } else { file.written() };
            if let State::Stopped { unrecorded, .. } = &mut self.state {
                *unrecorded = file.unwritten().messages + if removed { file.written() } else { 0 };
            }
            // Where it cannot be given another name, the next file cannot be made, and that is told.
            if let (Ok(left), FileError::Write { path, .. }) = (file.abandon(), &mut error) {
                *path = left;
            }
            self.parts += 1;
        }
        self.stopped_by(now_ns, &error);
    }

    /// Notes why nothing is recorded; said once for each cause.
    fn stopped_by(&mut self, now_ns: i64, error: &FileError) {
        let State::Stopped { why, again_ns, .. } = &mut self.state else {
            return;
        };
        *again_ns = now_ns.saturating_add(AGAIN_NS);
        let first = why.is_empty();
        *why = error.to_string();
        if first {
            let words = format!("NOT RECORDING: {error}. Navigation goes on, and recording does once it can");
            self.notices.push((now_ns, Level::Error, words));
        }
    }

    /// Puts what was said into the log of the file, once there is one.
    fn write_notices(&mut self, now_ns: i64) {
        if matches!(self.state, State::Stopped { .. }) {
            // Not more than a file can tell of.
            self.notices.truncate(64);
            self.said = self.notices.len();
            return;
        }
        self.said = 0;
        for (t_ns, level, words) in std::mem::take(&mut self.notices) {
            let log = Log::new(t_ns, level, "recorder", words);
            self.put(now_ns, Entry::Log(t_ns, &log));
        }
    }

    /// Poses and frames of emitters that no kill can lose any more.
    pub(crate) fn written(&self) -> u64 {
        match &self.state {
            State::Writing { file, .. } => self.earlier + file.written(),
            State::Stopped { .. } => self.earlier,
        }
    }

    /// Those that no power cut can lose any more.
    pub(crate) fn durable(&self) -> u64 {
        self.syncer.durable()
    }

    /// How many files came before this one.
    pub(crate) fn parts(&self) -> u32 {
        self.parts
    }

    /// Why nothing is recorded at the moment.
    pub(crate) fn stopped(&self) -> Option<&str> {
        match &self.state {
            State::Writing { .. } => None,
            State::Stopped { why, .. } => Some(why),
        }
    }

    /// Messages that came and are in no file, because none could be written.
    pub(crate) fn unrecorded(&self) -> u64 {
        let now = match &self.state {
            State::Writing { .. } => 0,
            State::Stopped { unrecorded, .. } => *unrecorded,
        };
        self.unrecorded + now
    }

    /// Completes the last file, with `facts` about it, and waits for the disk. The number of messages is that of all files.
    ///
    /// # Errors
    /// What completing it meets; [`FileError::NotRecording`] where nothing is recorded at the moment.
    pub(crate) fn finish(mut self, now_ns: i64, facts: &Metadata) -> Result<Finished, FileError> {
        if let State::Writing { file, .. } = &mut self.state {
            let written = file.metadata(facts);
            self.stop_on(now_ns, written);
        }
        let finished = match self.state {
            State::Writing { file, .. } => file.finish(),
            State::Stopped { why, unrecorded, .. } => Err(FileError::NotRecording { why, unrecorded }),
        };
        self.syncer.finish();
        let messages = finished?;
        Ok(Finished {
            messages: messages.messages + self.earlier,
            ..messages
        })
    }
}

/// Whether a file has no name any more: what is written into it is lost when it is closed. One that cannot be asked is taken to
/// have its name.
fn is_removed(file: &File) -> bool {
    file.metadata().is_ok_and(|about| about.nlink() == 0)
}

fn writing(file: SessionFile, since_ns: i64) -> State {
    State::Writing {
        file: Box::new(file),
        since_ns,
        flush_at_ns: None,
    }
}

/// Refuses a disk with less than `wanted` bytes free. One that cannot tell is taken to have room.
fn check_room(out: &Path, wanted: u64, free: Free) -> Result<(), FileError> {
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

#[cfg(test)]
mod tests;
