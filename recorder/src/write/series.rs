//! The files of one session, one after the other: rotated by size and time, stopped while the disk is full.
//!
//! Complete parts are `FILE.1.mcap`, `FILE.2.mcap`...; the last one is `FILE.mcap`. Where a file can be written no longer,
//! it stays as it is, as a part that grows no more; what comes is counted and not recorded until there is room again.
//! Nobody but the recorder is held up by any of this.

pub(crate) mod part;
mod place;
mod room;
mod state;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use bus::clock;
use bus::message::Level;
use mcap::records::Metadata;
use scene::RecordingSpec;

use crate::wire::proto::{self, Identity, Log};
use crate::wire::schema::RunFacts;
use crate::write::file_error::FileError;
use crate::write::leftovers;
use crate::write::paths;
use crate::write::pose_log::{Entry, Take};
use crate::write::session_file::{Content, Finished, SessionFile};
use crate::write::syncer::Syncer;
use place::{Part, Parts, Place};
use room::check_room;
pub(crate) use room::{Free, free_bytes};
use state::{State, stopped, writing};

/// Between two looks at the disk's free space.
const LOOK_NS: i64 = 1_000_000_000;
/// After a failure that free space does not explain, the next file is tried after this.
const AGAIN_NS: i64 = 5_000_000_000;
/// More must be free for recording to go on than for it to stop: it must not start and stop all the time.
const ROOM_AGAIN: f64 = 1.25;

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
    /// What earlier files of this process held when they were left.
    earlier: u64,
    /// Those files.
    left: Parts,
    /// How much of it is not where it was put, as somebody removed it.
    gone: u64,
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
        let file = SessionFile::create(out, &content)?;
        Ok(Self::with(writing(file, out, i64::MIN), out, content, spec, free))
    }

    /// Goes on in the place of a recorder that died: where no file can be made, that is said, and tried again later.
    pub(crate) fn follow(out: &Path, content: Content, spec: &RecordingSpec, free: Free, now_ns: i64) -> Self {
        let mut series = Self::with(stopped(now_ns, 0), out, content, spec, free);
        match check_room(out, spec.min_free_bytes, free) {
            Ok(()) => series.resume(now_ns),
            Err(error) => series.stopped_by(now_ns, &error),
        }
        series
    }

    fn with(state: State, out: &Path, content: Content, spec: &RecordingSpec, free: Free) -> Self {
        Self {
            state,
            out: out.to_owned(),
            content,
            spec: spec.clone(),
            syncer: Syncer::start(spec.sync),
            free,
            look_ns: i64::MIN,
            earlier: 0,
            left: Parts::default(),
            gone: 0,
            unrecorded: 0,
            parts: 0,
            notices: Vec::new(),
            said: 0,
        }
    }

    /// Takes a message, or counts it as not recorded.
    fn take(&mut self, now_ns: i64, entry: Entry<'_>) {
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

    /// Writes down whose examination it is, in this file and in those to come.
    pub(crate) fn identity(&mut self, now_ns: i64, identity: Identity) {
        self.take(now_ns, Entry::Identity(&identity));
        self.content.identity = Some(identity);
    }

    /// Writes down organs at rest, in this file and in those to come.
    pub(crate) fn mesh(&mut self, now_ns: i64, mesh: proto::TissueMesh) {
        self.take(now_ns, Entry::TissueMesh(&mesh));
        self.content.mesh = Some(mesh);
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
            ..
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
        // What every file begins with does not fill one by itself.
        let full = self
            .spec
            .rotate_bytes
            .is_some_and(|most| file.bytes() >= most.max(2 * file.head()));
        let since = now_ns.saturating_sub(*since_ns);
        let old = self.spec.rotate_after.is_some_and(|most| since >= clock::ns(most));
        if full || old {
            self.close(now_ns);
            self.resume(now_ns);
        }
    }

    /// Completes the file as a part, and is stopped; [`Series::resume`] goes on.
    fn close(&mut self, now_ns: i64) {
        let State::Writing { file, place, .. } = &mut self.state else {
            return;
        };
        // What is in memory fails here, where it is counted, and not behind the index.
        let said = place
            .check(file.file())
            .and_then(|()| file.metadata(&part::record(self.parts)));
        let flushed = said.and_then(|()| file.flush());
        if flushed.is_err() {
            return self.stop_on(now_ns, flushed);
        }
        let State::Writing { file, .. } = std::mem::replace(&mut self.state, stopped(now_ns, 0)) else {
            return;
        };
        let messages = file.written();
        self.earlier += messages;
        match file.complete() {
            Ok(whole) => {
                self.parts += 1;
                self.left.push(Part::at(whole.to.clone(), messages));
                self.syncer.whole(whole.file, whole.from, whole.to);
            }
            Err(error) => self.stopped_by(now_ns, &error),
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
        if let Ok(unfinished) = &aside {
            self.left.look_among(unfinished);
        }
        if let Some((written_ns, _)) = &mut self.content.guide {
            *written_ns = now_ns;
        }
        if let Some(workflow) = &mut self.content.workflow {
            workflow.t_ns = now_ns;
        }
        if let Some(mesh) = &mut self.content.mesh {
            mesh.t_ns = now_ns;
        }
        match aside.and_then(|_| SessionFile::create(&self.out, &self.content)) {
            Ok(file) => {
                self.unrecorded += unrecorded;
                if !why.is_empty() {
                    let words = format!("recording goes on; {unrecorded} messages were not recorded meanwhile");
                    self.notices.push((now_ns, Level::Warning, words));
                }
                self.state = writing(file, &self.out, now_ns);
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
        if let State::Writing { file, place, .. } = &self.state {
            let checked = place.check(file.file());
            self.stop_on(now_ns, checked);
        }
        self.look_for_parts(now_ns);
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

    /// Earlier files that somebody removed or took away: what they held is not in the session.
    fn look_for_parts(&mut self, now_ns: i64) {
        let gone = self.left.gone();
        if let Some(more) = gone.checked_sub(self.gone).filter(|&more| more > 0) {
            let words =
                format!("earlier files of this session are not where they were put: {more} messages were in them");
            self.notices.push((now_ns, Level::Error, words));
        }
        self.gone = gone;
    }

    fn stop_on(&mut self, now_ns: i64, done: Result<(), FileError>) {
        let Err(mut error) = done else { return };
        // A disk may say late what it did not keep: by then recording has stopped, and what is counted since stays.
        if matches!(self.state, State::Writing { .. })
            && let State::Writing { file, place, .. } = std::mem::replace(&mut self.state, stopped(now_ns, 0))
        {
            self.state = stopped(now_ns, file.unwritten().messages);
            self.leave(*file, &place, &mut error);
        }
        self.stopped_by(now_ns, &error);
    }

    /// Leaves a file that cannot be written any longer as it is, under the name of a part.
    fn leave(&mut self, file: SessionFile, place: &Place, error: &mut FileError) {
        let messages = file.written();
        self.earlier += messages;
        self.parts += 1;
        let handle = Arc::clone(file.file());
        if place.check(&handle).is_err() {
            // Whatever has its name is another's.
            file.forget();
            self.gone += messages;
            return self.left.push(Part::lost(&handle, messages));
        }
        // Where it cannot be given another name, the next file cannot be made, and that is told.
        let Ok(left) = file.abandon() else { return };
        if let Some(out) = paths::without_recording(&left) {
            self.left.push(Part::at(out, messages));
        }
        if let FileError::Write { path, .. } = error {
            *path = left;
        }
    }

    /// Notes why nothing is recorded; said once for each cause.
    fn stopped_by(&mut self, now_ns: i64, error: &FileError) {
        let State::Stopped { why, again_ns, .. } = &mut self.state else {
            return;
        };
        // In place of a file that somebody took away there may be another with the next look: signs of life have said why by then.
        let wait_ns = match error {
            FileError::Removed { .. } | FileError::Moved { .. } => LOOK_NS,
            _ => AGAIN_NS,
        };
        *again_ns = now_ns.saturating_add(wait_ns);
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
            self.take(now_ns, Entry::Log(t_ns, &log));
        }
    }

    /// Poses and frames of the localizer that no kill can lose any more.
    pub(crate) fn written(&self) -> u64 {
        let growing = match &self.state {
            State::Writing { file, .. } => file.written(),
            State::Stopped { .. } => 0,
        };
        self.earlier.saturating_sub(self.gone) + growing
    }

    /// Those that no power cut can lose any more.
    pub(crate) fn durable(&self) -> u64 {
        // Not known is how much of what is gone was synced: all of it, until the next sync says more.
        self.syncer.durable().saturating_sub(self.gone)
    }

    /// How many files came before this one.
    pub(crate) fn parts(&self) -> u32 {
        self.parts
    }

    /// Why nothing is recorded at the moment. Files are named without their folder: a sign of life has little room for words.
    pub(crate) fn stopped(&self) -> Option<String> {
        self.state.why(self.out.parent())
    }

    /// Messages that came and are in no file: none could be written, or it was removed.
    pub(crate) fn unrecorded(&self) -> u64 {
        let now = match &self.state {
            State::Writing { .. } => 0,
            State::Stopped { unrecorded, .. } => *unrecorded,
        };
        self.unrecorded + self.gone + now
    }

    /// Completes the last file, with `facts` about it, and waits for the disk. The number of messages is that of all files.
    ///
    /// # Errors
    /// What completing it meets; [`FileError::NotRecording`] where nothing is recorded at the moment.
    pub(crate) fn finish(mut self, now_ns: i64, facts: &Metadata) -> Result<Finished, FileError> {
        if let State::Writing { file, place, .. } = &mut self.state {
            let written = place.check(file.file()).and_then(|()| file.metadata(facts));
            self.stop_on(now_ns, written);
        }
        let unrecorded = self.unrecorded();
        let finished = match self.state {
            State::Writing { file, .. } => file.finish(),
            State::Stopped { why, .. } => Err(FileError::NotRecording { why, unrecorded }),
        };
        self.syncer.finish();
        let messages = finished?;
        Ok(Finished {
            messages: messages.messages + self.earlier.saturating_sub(self.gone),
            ..messages
        })
    }
}

impl Take for Series {
    fn put(&mut self, now_ns: i64, entry: Entry<'_>) {
        self.take(now_ns, entry);
    }

    /// In this file and in front of those to come.
    fn guide(&mut self, now_ns: i64, guide: &proto::Guide) {
        self.content.guide = Some((now_ns, guide.clone()));
        self.take(now_ns, Entry::Guide(now_ns, guide));
    }

    /// In this file and in front of those to come.
    fn workflow(&mut self, now_ns: i64, workflow: &proto::Workflow) {
        self.content.workflow = Some(workflow.clone());
        self.take(now_ns, Entry::Workflow(workflow));
    }
}

#[cfg(test)]
mod tests;
