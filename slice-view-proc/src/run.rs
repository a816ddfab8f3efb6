//! The renderer's process: poses in, images out.

mod draw;
mod follow;
mod look;
mod ruled;
mod tissue;

use std::collections::VecDeque;
use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::Duration;

use bus::BusError;
use bus::clock;
use bus::continuity::Continuity;
use bus::message::{Ages, Command, CommandKind, FrameStamp, FrameState, Guide, Lost, ProcessState, ToolPose, Tracked};
use bus::port::{CommandServer, Publisher, Request, SharedVolume, Subscriber, VolumeSubscriber};
use bus::process::{JoinError, Membership, Process};
use bus::session::Lead;
use bus::topic::{FRAME_STAMP, GUIDE, TOOL_POSE};
use bus::volume::VolumeView;
use bus::wake::Waits;
use geometry::{Ct, Rigid, Tool};
use scene::{Plane, Render};

use crate::guide::Chosens;
use crate::output::{Output, wordless};
use crate::overlay::{Notice, Origin};
use crate::overview::{Anatomy, LabelFile, LoadLabels};
use crate::remarks::Remarks;
use crate::render::RenderError;
use crate::reslice::{Chosen, Resampler};
use crate::tissue::{States, Tissue, states};
use follow::Strides;

/// The loop comes round at least this often: for signs of life and for volumes, which do not wake anybody.
const TICK: Duration = Duration::from_millis(20);
/// While no pose comes, the image is drawn anew this often, so that the age on it stays true.
const AGEING: Duration = Duration::from_millis(200);

/// Why a renderer ended.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// It could not join the run.
    #[error(transparent)]
    Join(#[from] JoinError),
    /// The bus failed.
    #[error(transparent)]
    Bus(#[from] BusError),
    /// An image was not drawn.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// The scene has no image of this direction.
    #[error("the scene has no {0} view: nothing to render")]
    NoView(&'static str),
}

/// What comes from others.
struct Inlets {
    poses: Subscriber<ToolPose>,
    server: CommandServer,
    /// Of organs, where any are moved in these views.
    states: Option<States>,
}

/// The state of the process between two wake-ups.
struct SliceView {
    process: Process,
    outputs: Vec<Output>,
    stamps: Publisher<FrameStamp>,
    volumes: VolumeSubscriber,
    volume: Option<SharedVolume>,
    /// The first digits of the volume's hash, as they stand on each image.
    volume_name: String,
    /// What the images must say of where their poses come from.
    origin: Origin,
    resampler: Chosen,
    continuity: Continuity,
    /// The places that a replay went to: what was published before one only says what it goes on from.
    places: Lead,
    /// What came off the bus in this turn.
    came: Vec<ToolPose>,
    /// The sample handled last, and what it came to.
    last: Option<(ToolPose, Tracked)>,
    /// From one sample to the next; 0 where there was but one.
    interval_ns: i64,
    /// Valid samples that came and were neither drawn nor passed over yet, oldest first.
    pending: VecDeque<(ToolPose, Rigid<Ct, Tool>)>,
    /// Which poses are drawn, and which of these in the global views too.
    strides: Strides,
    /// The last valid pose and when it was captured.
    last_valid: Option<(Rigid<Ct, Tool>, i64)>,
    /// Nobody publishes poses any more.
    no_poses: bool,
    remarks: Remarks,
    /// What a person chose.
    guides: Subscriber<Guide>,
    chosens: Chosens,
    /// What the images say, and when they were drawn, on the session's clock.
    drawn: Option<(FrameState, i64)>,
    /// Until then no image grows old, on the process's clock, as the session's may stand still.
    quiet_until_ns: i64,
    /// What the views cannot show, for the pilot's status and the report.
    wordless: String,
    load_labels: LoadLabels,
    /// Organs that the tube moves, where the scene has any.
    tissue: Option<Tissue>,
    folded: tissue::Folded,
    /// Where time waits for the state of a pose.
    awaited: Option<tissue::Awaited>,
}

/// Gives the surface views their anatomy: made once for all that have the same bone.
fn show_anatomy(
    outputs: &mut [Output],
    volume: &VolumeView<'_>,
    labels: Option<LabelFile<'_>>,
    alive: &mut dyn FnMut(),
) {
    let mut made: Vec<(f64, Arc<Anatomy>)> = Vec::new();
    for output in outputs.iter_mut().filter(|o| o.renderer.view().plane == Plane::Surface) {
        let bone_hu = output.renderer.view().surface.bone_hu;
        let known = made
            .iter()
            .find(|(hu, _)| *hu == bone_hu)
            .map(|(_, anatomy)| Arc::clone(anatomy));
        let anatomy = known.unwrap_or_else(|| Arc::new(Anatomy::of(volume, bone_hu, labels, alive)));
        made.push((bone_hu, Arc::clone(&anatomy)));
        output.renderer.show_anatomy(anatomy);
    }
}

/// Renders the views of one direction until asked to stop; `load_labels` reads the label map that the scene names.
///
/// # Errors
/// Each variant of [`RunError`].
pub(crate) fn run(plane: Plane, membership: &Membership, load_labels: LoadLabels) -> Result<(), RunError> {
    let name = plane.process();
    let process = Process::join(&name, membership)?;
    let moves = process.scene.tissue.is_some() && plane != Plane::Surface;
    // Before the poses: whoever is given the newest pose late is given its state before it.
    let states = moves.then(|| states(&process.bus)).transpose()?;
    let poses = Subscriber::open_waking(&process.bus, &TOOL_POSE, "", follow::ROOM)?;
    let server = CommandServer::open(&process.bus, &name)?;
    let stale = process.scene.limits.stale;
    let mut view = SliceView::new(process, plane, load_labels)?;
    let inlets = Inlets { poses, server, states };
    let waits = Waits::every(TICK)
        .message(&inlets.poses, Some(stale))
        .request(&inlets.server);
    let waits = match &inlets.states {
        Some(states) => waits.headed(states),
        None => waits,
    };
    waits.run(|| match view.step(&inlets) {
        Ok(ControlFlow::Continue(())) => ControlFlow::Continue(()),
        Ok(ControlFlow::Break(())) => ControlFlow::Break(Ok(())),
        Err(error) => ControlFlow::Break(Err(error)),
    })?
}

impl SliceView {
    fn new(mut process: Process, plane: Plane, load_labels: LoadLabels) -> Result<Self, RunError> {
        let mut outputs = Vec::new();
        for (index, view) in process.scene.views.iter().enumerate() {
            if view.plane != plane {
                continue;
            }
            outputs.push(Output::open(&process.bus, index, view)?);
        }
        // In the order in which they are drawn.
        outputs.sort_by_key(Output::may_wait);
        if outputs.is_empty() {
            return Err(RunError::NoView(plane.name()));
        }
        // What is replayed or simulated comes out the same on every machine; a surface is never a card's.
        let render = match process.session.is_ruled() || plane == Plane::Surface {
            true => Render::cpu(),
            false => process.scene.render,
        };
        Ok(Self {
            wordless: wordless(&outputs),
            load_labels,
            stamps: Publisher::open(&process.bus, &FRAME_STAMP, &plane.process())?,
            volumes: process.volumes()?,
            guides: Subscriber::open(&process.bus, &GUIDE, "", GUIDE.buffer)?,
            chosens: Chosens::default(),
            tissue: tissue::open(&process, plane)?,
            folded: tissue::Folded::default(),
            awaited: None,
            resampler: Chosen::new(render),
            process,
            outputs,
            volume: None,
            volume_name: String::new(),
            origin: Origin::Tracker,
            continuity: Continuity::default(),
            places: Lead::default(),
            came: Vec::with_capacity(follow::ROOM),
            last: None,
            interval_ns: 0,
            pending: VecDeque::with_capacity(follow::ROOM),
            strides: Strides::default(),
            last_valid: None,
            no_poses: false,
            remarks: Remarks::default(),
            drawn: None,
            quiet_until_ns: 0,
        })
    }

    fn step(&mut self, inlets: &Inlets) -> Result<ControlFlow<()>, RunError> {
        if self.process.stop.is_set() {
            self.process.beat(ProcessState::Stopping, "asked to stop")?;
            return Ok(ControlFlow::Break(()));
        }
        self.take_volume()?;
        self.hear_tissue(inlets.states.as_ref())?;
        // One a turn: who asks again and again does not keep the poses from being drawn.
        if let Some(request) = inlets.server.next()? {
            self.answer(request)?;
        }
        if self.volume.is_none() {
            self.process.beat(ProcessState::Starting, "waiting for the volume")?;
            return Ok(ControlFlow::Continue(()));
        }
        match self.process.session.is_ruled() {
            true => self.follow_ruled(inlets)?,
            false => self.follow(&inlets.poses)?,
        }
        self.outputs.iter().for_each(Output::serve_late_joiners);
        if let Some(volume) = &self.volume {
            self.resampler.advance(&volume.view());
        }
        let note = || self.resampler.note() + &self.wordless + &self.folded.note();
        self.process.beat_with(ProcessState::Ready, note)?;
        Ok(ControlFlow::Continue(()))
    }

    /// Takes over a volume from the loader. One that is not the same examination is not shown in the middle of a run.
    fn take_volume(&mut self) -> Result<(), RunError> {
        let Some(new) = self.volumes.poll()? else { return Ok(()) };
        if let Some(old) = &self.volume
            && old.hash() != new.hash()
        {
            bus::stderr_line!(
                "slice-view-proc: warning: the loader published another examination ({}); the images stay with {}",
                new.hash(),
                old.hash()
            );
            return Ok(());
        }
        // The same examination has the same surfaces.
        let is_first = self.volume.is_none();
        self.volume_name = new.hash().to_string()[..8].to_owned();
        let sliced = self
            .outputs
            .iter()
            .filter(|o| o.renderer.view().plane != Plane::Surface);
        let samplings: Vec<_> = sliced.map(|o| o.renderer.view().sampling).collect();
        let plan = self.process.scene.plan.clone();
        let is_recorded = self.process.run.replay.is_some();
        let examination = self.process.scene.volume.clone();
        let (process, mut failed) = (&mut self.process, Ok(()));
        let mut alive = || {
            if failed.is_ok() {
                failed = process.beat(ProcessState::Starting, "preparing the volume");
            }
        };
        let prepared = self.resampler.prepare(&new.view(), &samplings, &mut alive);
        prepared.map_err(RenderError::from)?;
        if is_first {
            let labels = plan.labels.as_deref().map(|path| LabelFile {
                path,
                examination: &examination,
                load: self.load_labels,
                expected: plan.labels_hash.as_deref(),
                is_recorded,
            });
            show_anatomy(&mut self.outputs, &new.view(), labels, &mut alive);
        }
        failed?;
        self.origin = match self.process.run.simulated_time {
            true => Origin::SimulatedTime,
            false => Origin::of(self.process.run.replay.as_ref(), &new.hash().to_string()),
        };
        self.volume = Some(new);
        Ok(())
    }

    fn answer(&mut self, request: Request) -> Result<(), RunError> {
        let command: Command = *request.command();
        if command.command_kind() == Some(CommandKind::NoPoses) {
            self.no_poses = true;
            self.awaited = None;
            request.reply(Ok("no pose is shown"))?;
            return match self.volume {
                Some(_) => self.age(),
                None => Ok(()),
            };
        }
        let is_known = matches!(
            command.command_kind(),
            Some(CommandKind::Render | CommandKind::Look | CommandKind::Turn)
        );
        if !is_known {
            request.reply(Err(
                "a renderer answers only requests to render a pose or a plane, to show none, and to turn a surface",
            ))?;
            return Ok(());
        }
        if self.volume.is_none() {
            request.reply(Err("there is no volume yet"))?;
            return Ok(());
        }
        if command.command_kind() == Some(CommandKind::Turn) {
            let answer = self.turn(&command);
            request.reply(answer.as_ref().map(|()| "turned").map_err(String::as_str))?;
            return Ok(());
        }
        if command.command_kind() == Some(CommandKind::Look) {
            let answer = self.look(&command)?;
            request.reply(answer.as_deref().map_err(String::as_str))?;
            return Ok(());
        }
        match command.pose.tracked() {
            Ok(Tracked::Valid(pose)) => {
                self.draw(&command.pose, Some(pose), Notice::Requested)?;
                request.reply(Ok("drawn"))?;
            }
            Ok(Tracked::Lost(reason)) => request.reply(Err(reason.words()))?,
            Err(error) => request.reply(Err(&error.to_string()))?,
        }
        Ok(())
    }

    /// Takes note of a sample that came over the bus; what it came to.
    fn take(&mut self, sample: ToolPose) -> Tracked {
        self.no_poses = false;
        let tracked = self.judged(&sample);
        if let Some((before, _)) = self.last.filter(|(before, _)| before.seq < sample.seq) {
            let passed = i64::try_from(sample.seq - before.seq).unwrap_or(i64::MAX);
            self.interval_ns = sample.t_capture_ns.saturating_sub(before.t_capture_ns) / passed;
        }
        self.last = Some((sample, tracked));
        match tracked {
            Tracked::Valid(pose) => self.last_valid = Some((pose, sample.t_capture_ns)),
            Tracked::Lost(_) => self.process.counters.lost += 1,
        }
        tracked
    }

    /// Draws a sample as old as it is.
    fn draw_now(&mut self, sample: &ToolPose, tracked: Tracked) -> Result<(), RunError> {
        let state = match tracked {
            Tracked::Valid(_) => self.ages().state(self.age_ns(sample)),
            Tracked::Lost(reason) => FrameState::Lost(reason),
        };
        self.draw_aged(sample, tracked, state)
    }

    /// What may be shown of a sample: by itself, and after those before it.
    fn judged(&mut self, sample: &ToolPose) -> Tracked {
        let session = &self.process.session;
        let now = session.clock().now_ns();
        let tracked = match sample.tracked_at(now) {
            Ok(tracked) => tracked,
            Err(error) => {
                self.refuse(&error.to_string());
                return Tracked::Lost(Lost::Refused);
            }
        };
        let frozen_ns = self.process.scene.frozen().map(clock::ns);
        let is_replay = session.is_replay();
        let judged = self.continuity.judge(sample, tracked, frozen_ns);
        self.process.counters.dropped += judged.missing;
        self.remarks.take(&judged, sample.t_capture_ns);
        if is_replay && frozen_ns.is_some() {
            self.remarks.standstill(sample, &judged);
        }
        if let Some(broken) = judged.broken.filter(|broken| broken.refuses()) {
            self.refuse(&format!("pose {}: {broken}", sample.seq));
        }
        judged.tracked
    }

    fn refuse(&mut self, why: &str) {
        if self.process.counters.refused == 0 {
            bus::stderr_line!("slice-view-proc: error: {why}. It is not shown; further ones are only counted");
        }
        self.process.counters.refused += 1;
    }

    fn ages(&self) -> Ages {
        Ages::of(&self.process.scene.limits)
    }

    fn age_ns(&self, sample: &ToolPose) -> i64 {
        let now = self.process.session.clock().now_ns();
        now.saturating_sub(sample.t_capture_ns)
    }

    /// While no sample comes, what is on the screen grows old, and says so: at once where it becomes stale or lost, and then as
    /// often as its age changes.
    fn age(&mut self) -> Result<(), RunError> {
        if self.process.clock().now_ns() < self.quiet_until_ns {
            return Ok(());
        }
        let silent = FrameState::Lost(Lost::Silent);
        let (sample, tracked) = self.last.unwrap_or((ToolPose::EMPTY, Tracked::Lost(Lost::Silent)));
        let now = self.process.session.clock().now_ns();
        let state = match self.no_poses || self.last.is_none() {
            true => silent,
            false => self.ages().of_sample(&sample, tracked, now),
        };
        let is_due = match self.drawn {
            Some((drawn, _)) if drawn != state => true,
            Some((_, at_ns)) => state != FrameState::Live && now - at_ns >= clock::ns(AGEING),
            None => true,
        };
        match is_due {
            true => self.draw_aged(&sample, tracked, state),
            false => Ok(()),
        }
    }

    /// Draws `sample`, which came to `tracked`, in this state: without a pose the last slice, dimmed.
    fn draw_aged(&mut self, sample: &ToolPose, tracked: Tracked, state: FrameState) -> Result<(), RunError> {
        match (state, tracked) {
            (FrameState::Live, Tracked::Valid(pose)) => self.draw_live(sample, pose),
            (FrameState::Stale, Tracked::Valid(pose)) => {
                self.draw(sample, Some(pose), Notice::Stale(self.age_ns(sample)))
            }
            (FrameState::Lost(reason), _) | (_, Tracked::Lost(reason)) => {
                let now = self.process.session.clock().now_ns();
                let age = self.last_valid.map(|(_, captured)| now.saturating_sub(captured));
                let placed = self.last_valid.map(|(pose, _)| pose);
                self.draw(sample, placed, Notice::Lost(reason, age))
            }
            // Only what was asked for is held.
            (FrameState::Requested | FrameState::Look, Tracked::Valid(pose)) => {
                self.draw(sample, Some(pose), Notice::Requested)
            }
        }
    }
}
