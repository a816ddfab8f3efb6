//! The recorder's work: drain the topics, write, close a chunk in time.

use std::io;
use std::path::{Path, PathBuf};
use std::time::Duration;

use bus::clock;
use bus::message::{Counters, ProcessState, ToolPose};
use bus::port::{Subscriber, VolumeSubscriber};
use bus::process::{JoinError, Process};
use bus::run::RunContext;
use bus::topic::{self, Topic};
use bus::{Bus, BusError};

use crate::file_error::FileError;
use crate::leftovers;
use crate::schema::{RunFacts, Source};
use crate::seq::SeqWatch;
use crate::session_file::{Finished, SessionFile};

/// Between two looks at the topics; their buffers hold a thousand times as much.
const TICK: Duration = Duration::from_millis(20);
/// Where the scene asks for no recording but somebody started this process.
const DEFAULT_CHUNK: Duration = Duration::from_millis(500);

/// Why a session is not recorded, or not any longer.
#[derive(Debug, thiserror::Error)]
pub enum RecordError {
    /// The run could not be joined.
    #[error(transparent)]
    Join(#[from] JoinError),
    /// The file.
    #[error(transparent)]
    File(#[from] FileError),
    /// The bus.
    #[error(transparent)]
    Bus(#[from] BusError),
}

/// What has come of a recording so far.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Progress {
    /// For the sign of life: `recorded` counts what no kill can lose any more.
    pub counters: Counters,
    /// How many times sequence numbers were left out, of both topics.
    pub gaps: u64,
}

/// One topic being recorded.
#[derive(Debug)]
struct Stream {
    subscriber: Subscriber<ToolPose>,
    source: Source,
    depth: usize,
    seqs: SeqWatch,
}

impl Stream {
    fn open(bus: &Bus, topic: &Topic, source: Source) -> Result<Self, BusError> {
        Ok(Self {
            subscriber: Subscriber::open(bus, topic, "", topic.buffer)?,
            source,
            depth: topic.buffer,
            seqs: SeqWatch::default(),
        })
    }
}

/// A session being recorded; works only when [`Recorder::step`] is called.
#[derive(Debug)]
pub struct Recorder {
    streams: [Stream; 2],
    volume: VolumeSubscriber,
    facts: RunFacts,
    facts_changed: bool,
    file: SessionFile,
    chunk_ns: i64,
    flush_at_ns: Option<i64>,
    refused: u64,
}

impl Recorder {
    /// Subscribes and starts the file. A chunk is closed `chunk` after its first pose came.
    ///
    /// # Errors
    /// [`RecordError::Bus`], [`RecordError::File`].
    pub fn open(bus: &Bus, run: &RunContext, chunk: Duration, out: &Path) -> Result<Self, RecordError> {
        let facts = RunFacts {
            name: run.name.clone(),
            epoch_ns: run.epoch_ns,
            registration_id: None,
            volume_hash: None,
        };
        Ok(Self {
            streams: [
                Stream::open(bus, &topic::TOOL_POSE, Source::Tool)?,
                Stream::open(bus, &topic::GROUND_TRUTH, Source::Truth)?,
            ],
            volume: VolumeSubscriber::open(bus)?,
            file: SessionFile::create(out, &run.scene_path(), &facts)?,
            facts,
            facts_changed: false,
            chunk_ns: clock::ns(chunk),
            flush_at_ns: None,
            refused: 0,
        })
    }

    /// Writes everything that has come, and closes the chunk if it is time.
    ///
    /// # Errors
    /// [`RecordError::Bus`], [`RecordError::File`].
    pub fn step(&mut self, now_ns: i64) -> Result<(), RecordError> {
        for index in 0..self.streams.len() {
            self.drain(index)?;
        }
        self.look_at_volume();
        if std::mem::take(&mut self.facts_changed) {
            self.file.facts(&self.facts)?;
        }
        if self.file.unwritten().messages == 0 {
            return Ok(());
        }
        let flush_at_ns = *self.flush_at_ns.get_or_insert(now_ns.saturating_add(self.chunk_ns));
        if now_ns >= flush_at_ns {
            self.flush()?;
        }
        Ok(())
    }

    fn flush(&mut self) -> Result<(), RecordError> {
        self.flush_at_ns = None;
        Ok(self.file.flush()?)
    }

    /// Takes what one topic holds; not more than its buffer, so that a flood cannot keep this process from stopping.
    fn drain(&mut self, index: usize) -> Result<(), RecordError> {
        for _ in 0..self.streams[index].depth {
            let stream = &mut self.streams[index];
            let Some(pose) = stream.subscriber.next()? else { break };
            stream.seqs.saw(pose.seq);
            self.file.pose(stream.source, &pose)?;
            self.refused += u64::from(pose.tracked().is_err());
            if stream.source == Source::Tool {
                self.facts_changed |= self.facts.registration_id != Some(pose.registration_id);
                self.facts.registration_id = Some(pose.registration_id);
            }
        }
        Ok(())
    }

    /// Notes the volume's hash. A volume that is refused here is the renderers' business; poses are recorded all the same.
    fn look_at_volume(&mut self) {
        if let Ok(Some(volume)) = self.volume.poll() {
            self.facts_changed |= self.facts.volume_hash != Some(volume.hash());
            self.facts.volume_hash = Some(volume.hash());
        }
    }

    /// What has come of it so far.
    pub fn progress(&self) -> Progress {
        let missing = self.streams.iter().map(|stream| stream.seqs.missing);
        Progress {
            counters: Counters {
                recorded: self.file.written(),
                dropped: missing.fold(0, u64::saturating_add),
                refused: self.refused,
                ..Counters::default()
            },
            gaps: self.streams.iter().map(|stream| stream.seqs.gaps).sum(),
        }
    }

    /// Takes what has come since the last step, and completes the file.
    ///
    /// # Errors
    /// [`RecordError::Bus`], [`RecordError::File`].
    pub fn finish(mut self, now_ns: i64) -> Result<Finished, RecordError> {
        self.step(now_ns)?;
        Ok(self.file.finish()?)
    }
}

impl std::fmt::Display for Progress {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Counters { recorded, dropped, .. } = self.counters;
        write!(f, "{recorded} poses on disk, {dropped} missing in {} gaps", self.gaps)
    }
}

/// Records until the process is asked to stop. On an error the file stays unfinished: the next recorder of the session
/// makes a part of it.
///
/// # Errors
/// Each variant of [`RecordError`].
pub fn record(process: &mut Process, out: &Path) -> Result<Finished, RecordError> {
    let out = absolute(out)?;
    let unfinished = leftovers::set_aside(&out)?;
    let chunk = process
        .scene
        .recording
        .as_ref()
        .map_or(DEFAULT_CHUNK, |recording| recording.chunk);
    let mut recorder = Recorder::open(&process.bus, &process.run, chunk, &out)?;
    let recovery = leftovers::recover_in_background(unfinished);
    while !process.stop.is_set() {
        let now_ns = process.clock().now_ns();
        recorder.step(now_ns)?;
        let progress = recorder.progress();
        process.counters = progress.counters;
        process.beat(ProcessState::Ready, &progress.to_string())?;
        process.clock().sleep_until(now_ns + clock::ns(TICK));
    }
    process.beat(ProcessState::Stopping, "completing the recording")?;
    let finished = recorder.finish(process.clock().now_ns())?;
    // Second in order: if this takes too long, this session's file is whole, and the other one is found next time.
    let _ = recovery.join();
    Ok(finished)
}

/// So that messages name a place that means the same to the pilot.
fn absolute(out: &Path) -> Result<PathBuf, FileError> {
    std::path::absolute(out).map_err(|source: io::Error| FileError::Create {
        path: out.to_owned(),
        source,
    })
}

#[cfg(test)]
mod tests;
