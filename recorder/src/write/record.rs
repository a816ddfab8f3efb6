//! The recorder's work: drain the topics, write, close a chunk in time.

mod bound;
mod intake;
pub(crate) mod thumbnails;
pub(crate) mod watch;
mod whose;

use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use bus::clock;
use bus::message::{Counters, NOT_RECORDING, ProcessState, RECORDED_ANEW};
use bus::port::VolumeSubscriber;
use bus::process::{JoinError, Process};
use bus::run::RunContext;
use bus::topic;
use bus::{Bus, BusError};
use mcap::records::Metadata;
use scene::{RecordingSpec, Scene};

use crate::wire::proto;
use crate::wire::schema::{RunFacts, Source};
use crate::wire::seq::SeqWatch;
use crate::write::beside;
use crate::write::file_error::FileError;
use crate::write::leftovers;
use crate::write::pose_log::{Entry, Take};
use crate::write::series::{Free, Series, free_bytes};
use crate::write::session_file::{Content, Finished};
use bound::Bound;
use intake::Intake;
use thumbnails::Thumbnails;
use watch::Watch;
use whose::Whose;

/// Between two looks at the topics; the bus holds fifty times as much, and memory four hundred.
const TICK: Duration = Duration::from_millis(20);

/// Why a session is not recorded, or not any longer.
#[derive(Debug, thiserror::Error)]
pub(crate) enum RecordError {
    /// The run could not be joined.
    #[error(transparent)]
    Join(#[from] JoinError),
    /// The file.
    #[error(transparent)]
    File(#[from] FileError),
    /// The bus.
    #[error(transparent)]
    Bus(#[from] BusError),
    /// The thread that takes messages from the bus.
    #[error("taking messages from the bus: {0}")]
    Intake(#[source] io::Error),
}

/// What has come of a recording so far.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Progress {
    /// For the sign of life: `recorded` counts what no kill can lose any more.
    pub counters: Counters,
    /// How many times sequence numbers were left out, of all topics.
    pub gaps: u64,
    /// What no power cut can lose any more.
    pub durable: u64,
    /// The most messages that ever waited on a topic, and how many it has room for: beyond, they are lost.
    pub waited: (usize, usize),
    /// How many files came before this one.
    pub parts: u32,
    /// Why nothing is recorded at the moment.
    pub stopped: Option<String>,
    /// Another recorder of this run died before.
    pub is_anew: bool,
}

/// One topic being recorded.
#[derive(Debug, Default)]
struct Stream {
    seqs: SeqWatch,
    /// The most messages that came at once.
    waited: usize,
}

impl Stream {
    fn saw(&mut self, seqs: impl ExactSizeIterator<Item = u64>) {
        self.waited = self.waited.max(seqs.len());
        seqs.for_each(|seq| self.seqs.saw(seq));
    }
}

/// A session being recorded; works only when [`Recorder::step`] is called.
#[derive(Debug)]
pub(crate) struct Recorder {
    intake: Intake,
    tool: Stream,
    truth: Stream,
    emitters: Stream,
    markers: Stream,
    images: Stream,
    tissue: Stream,
    watch: Watch,
    thumbnails: Option<Thumbnails>,
    /// Where the recording says whose examination it is.
    whose: Option<Whose>,
    volume: VolumeSubscriber,
    facts: RunFacts,
    series: Series,
    refused: u64,
    bound: Bound,
    /// Another recorder was there before.
    is_anew: bool,
}

impl Recorder {
    /// Subscribes and starts the file.
    ///
    /// # Errors
    /// [`RecordError::Bus`], [`RecordError::File`], [`RecordError::Intake`].
    pub(crate) fn open(bus: &Bus, run: &RunContext, scene: &Scene, out: &Path) -> Result<Self, RecordError> {
        Self::open_on(bus, run, scene, out, free_bytes)
    }

    /// Takes the volume from here: that of the run, where the pilot handed it on.
    fn with_volumes(self, volume: VolumeSubscriber) -> Self {
        Self { volume, ..self }
    }

    /// The same with another opinion of the disk's free space.
    fn open_on(bus: &Bus, run: &RunContext, scene: &Scene, out: &Path, free: Free) -> Result<Self, RecordError> {
        let spec = scene.recording.clone().unwrap_or_default();
        let facts = RunFacts {
            name: run.name.clone(),
            epoch_ns: run.epoch_ns,
            registration_id: None,
            volume_hash: None,
            remade_from: run.replay.as_ref().map(|replay| replay.recording.display().to_string()),
        };
        let content = content(run, scene, &spec, &facts);
        let thumbnails = spec.thumbnail_every.map(|every| Thumbnails::open(bus, scene, every));
        let is_anew = run.began_ns().is_some();
        Ok(Self {
            intake: Intake::start(run, (intake::ROOM, scene.tissue.is_some()), bus.life_line())?,
            tool: Stream::default(),
            truth: Stream::default(),
            emitters: Stream::default(),
            markers: Stream::default(),
            images: Stream::default(),
            tissue: Stream::default(),
            watch: Watch::open(bus, scene)?,
            thumbnails: thumbnails.transpose()?,
            whose: spec.identity.then(|| Whose::open(bus)).transpose()?,
            volume: VolumeSubscriber::open(bus)?,
            series: match is_anew {
                false => Series::start(out, content, &spec, free)?,
                // Navigation does not wait for the disk.
                true => Series::follow(out, content, &spec, free, bus.clock().now_ns()),
            },
            is_anew,
            bound: Bound::new(run, scene),
            facts,
            refused: 0,
        })
    }

    /// Writes everything that has come, and closes the chunk if it is time. Gives what a person must be told.
    ///
    /// # Errors
    /// [`RecordError::Bus`], [`RecordError::Intake`].
    pub(crate) fn step(&mut self, now_ns: i64) -> Result<Vec<String>, RecordError> {
        let mut facts = self.facts.clone();
        self.messages(now_ns, &mut facts)?;
        self.watch.step(now_ns, &mut self.series)?;
        if let Some(thumbnails) = &mut self.thumbnails {
            thumbnails.step(now_ns, &mut self.series)?;
        }
        // A volume that is refused here is the renderers' business; poses are recorded all the same.
        // The first examination is the run's: renderers show no other.
        if let Ok(Some(volume)) = self.volume.poll() {
            facts.volume_hash.get_or_insert(volume.hash());
        }
        if facts != self.facts {
            self.series.facts(now_ns, &facts);
            self.facts = facts;
        }
        if let Some(whose) = &mut self.whose {
            whose.step(now_ns, self.facts.volume_hash, &mut self.series)?;
        }
        Ok(self.series.step(now_ns))
    }

    fn messages(&mut self, now_ns: i64, facts: &mut RunFacts) -> Result<(), RecordError> {
        let taken = self.intake.take()?;
        let (series, refused) = (&mut self.series, &mut self.refused);
        self.tool.saw(taken.tool.iter().map(|pose| pose.seq));
        for pose in taken.tool.iter().filter(|pose| self.bound.holds(pose)) {
            *refused += u64::from(pose.tracked().is_err());
            series.put(now_ns, Entry::Pose(Source::Tool, pose));
            self.watch.pose(now_ns, pose, series);
            facts.registration_id = Some(pose.registration_id);
        }
        self.truth.saw(taken.truth.iter().map(|pose| pose.seq));
        for pose in &taken.truth {
            *refused += u64::from(pose.tracked().is_err());
            series.put(now_ns, Entry::Pose(Source::Truth, pose));
        }
        self.emitters.saw(taken.emitters.iter().map(|frame| frame.seq));
        for frame in &taken.emitters {
            match proto::EmitterFrame::try_from(frame) {
                Ok(frame) => series.put(now_ns, Entry::Emitters(&frame)),
                Err(_) => *refused += 1,
            }
        }
        self.markers.saw(taken.markers.iter().map(|frame| frame.seq));
        for frame in &taken.markers {
            match proto::MarkerFrame::try_from(frame) {
                Ok(frame) => series.put(now_ns, Entry::Markers(&frame)),
                Err(_) => *refused += 1,
            }
        }
        self.images.saw(taken.images.iter().map(|image| image.header.seq));
        for image in &taken.images {
            series.put(now_ns, Entry::UsImage(&proto::RawImage::from(image)));
        }
        for mesh in &taken.meshes {
            series.mesh(now_ns, proto::TissueMesh::of(now_ns, mesh));
        }
        self.tissue.saw(taken.tissue.iter().map(|state| state.header.seq));
        for state in &taken.tissue {
            series.put(now_ns, Entry::Tissue(&proto::TissueState::from(state)));
        }
        Ok(())
    }

    /// What has come of it so far.
    pub(crate) fn progress(&self) -> Progress {
        let streams = [
            &self.tool,
            &self.truth,
            &self.emitters,
            &self.markers,
            &self.images,
            &self.tissue,
        ];
        let seqs = streams.map(|stream| stream.seqs);
        let missing = seqs.iter().map(|seqs| seqs.missing).fold(0, u64::saturating_add);
        let unrecorded = self.series.unrecorded();
        let waiting = [
            (&self.tool, &topic::TOOL_POSE),
            (&self.truth, &topic::GROUND_TRUTH),
            (&self.emitters, &topic::EMITTERS),
            (&self.markers, &topic::MARKERS),
        ];
        let waits = waiting.map(|(stream, topic)| (stream.waited, intake::ROOM + topic.buffer));
        Progress {
            counters: Counters {
                published: self.tool.seqs.range.map_or(0, |(_, last)| last.saturating_add(1)),
                recorded: self.series.written(),
                dropped: missing.saturating_add(unrecorded),
                lost: unrecorded,
                refused: self.refused,
            },
            gaps: seqs.iter().map(|seqs| seqs.gaps).sum(),
            durable: self.series.durable(),
            waited: waits.into_iter().max().unwrap_or_default(),
            parts: self.series.parts(),
            stopped: self.series.stopped(),
            is_anew: self.is_anew,
        }
    }

    /// Takes what has come since the last step, and completes the file.
    ///
    /// # Errors
    /// [`RecordError::Bus`], [`RecordError::File`], [`RecordError::Intake`].
    pub(crate) fn finish(mut self, now_ns: i64) -> Result<Finished, RecordError> {
        self.step(now_ns)?;
        let facts = self.progress().metadata();
        Ok(self.series.finish(now_ns, &facts)?)
    }
}

/// What each file of the session begins with. A file that the scene names and that cannot be read is left out, and said.
fn content(run: &RunContext, scene: &Scene, spec: &RecordingSpec, facts: &RunFacts) -> Content {
    let path = run.scene_path();
    // Where it cannot be read, making the file says so.
    let text = std::fs::read_to_string(&path).unwrap_or_default();
    let named = beside::named_files(&text, path.parent().unwrap_or(Path::new("")));
    let read = |path: &PathBuf| {
        let found = beside::read(path);
        found.map_err(|e| {
            bus::stderr_line!(
                "recorder: {} is named by the scene and not attached: {e}",
                path.display()
            )
        })
    };
    let views = scene.views.iter().map(|view| view.name.clone());
    Content {
        beside: named.iter().filter_map(|path| read(path).ok()).collect(),
        compression: spec.compression,
        is_named: spec.identity,
        views: spec.thumbnail_every.map_or(Vec::new(), |_| views.collect()),
        ..Content::new(&path, facts)
    }
}

impl Progress {
    /// The name of the metadata record of [`Progress::metadata`].
    pub(crate) const RECORD: &str = "recorder";

    /// What the last file of a session says of its recording.
    pub(crate) fn metadata(&self) -> Metadata {
        let (waited, room) = self.waited;
        let facts = [
            ("missing", self.counters.dropped.to_string()),
            ("gaps", self.gaps.to_string()),
            ("refused", self.counters.refused.to_string()),
            ("most_waiting", waited.to_string()),
            ("room_to_wait", room.to_string()),
            ("files_before", self.parts.to_string()),
        ];
        Metadata {
            name: Self::RECORD.to_owned(),
            metadata: facts.map(|(key, value)| (key.to_owned(), value)).into(),
        }
    }
}

impl std::fmt::Display for Progress {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Counters { recorded, dropped, .. } = self.counters;
        if let Some(why) = &self.stopped {
            return write!(f, "{NOT_RECORDING}, {dropped} lost: {why}");
        }
        let (waited, room) = self.waited;
        write!(f, "{recorded} on disk, {} synced; ", self.durable)?;
        if self.is_anew {
            write!(f, "{RECORDED_ANEW}; ")?;
        }
        write!(f, "{dropped} missing, {} gaps; ", self.gaps)?;
        write!(f, "{waited} of {room} waited")
    }
}

/// Records until the process is asked to stop. On an error the file stays unfinished: the next recorder of the session
/// makes a part of it.
///
/// # Errors
/// Each variant of [`RecordError`].
pub(crate) fn record(process: &mut Process, out: &Path) -> Result<Finished, RecordError> {
    let out = absolute(out)?;
    refuse_file_size_signal();
    let unfinished = match leftovers::set_aside(&out) {
        // It is tried again with each file that this recorder makes.
        Err(_) if process.run.began_ns().is_some() => Vec::new(),
        aside => aside?,
    };
    let volumes = process.volumes()?;
    let mut recorder = Recorder::open(&process.bus, &process.run, &process.scene, &out)?.with_volumes(volumes);
    let recovery = leftovers::recover_in_background(unfinished);
    while !process.stop.is_set() {
        let now_ns = process.clock().now_ns();
        for words in recorder.step(now_ns)? {
            bus::stderr_line!("recorder: {words}");
        }
        let progress = recorder.progress();
        process.counters = progress.counters;
        process.beat(ProcessState::Ready, &progress.to_string())?;
        process.clock().sleep_until(now_ns + clock::ns(TICK));
    }
    // What came last counts too, and what is in no file is said before the words that there is an end.
    let now_ns = process.clock().now_ns();
    for words in recorder.step(now_ns)? {
        bus::stderr_line!("recorder: {words}");
    }
    let progress = recorder.progress();
    process.counters = progress.counters;
    match &progress.stopped {
        Some(_) => process.beat(ProcessState::Stopping, &progress.to_string())?,
        None => process.beat(ProcessState::Stopping, "completing the recording")?,
    }
    let finished = recorder.finish(process.clock().now_ns())?;
    // Second in order: if this takes too long, this session's file is whole, and the other one is found next time.
    let _ = recovery.join();
    Ok(finished)
}

/// A file that has reached the size that a user's files may have is an error of the write, and not the end of this
/// process.
fn refuse_file_size_signal() {
    // Where it cannot be caught, the process ends there, as any other.
    let _ = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, Arc::default());
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
