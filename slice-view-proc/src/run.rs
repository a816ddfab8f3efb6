//! The renderer's process: poses in, images out.

use std::ops::ControlFlow;
use std::time::Duration;

use bus::BusError;
use bus::clock::{self, Clock};
use bus::message::{Command, CommandKind, FrameHeader, FrameStamp, Lost, PoseError, ProcessState, ToolPose, Tracked};
use bus::port::{CommandServer, FramePublisher, Publisher, Request, SharedVolume, Subscriber, VolumeSubscriber};
use bus::process::{JoinError, Membership, Process};
use bus::run::ReplayOf;
use bus::scene::Plane;
use bus::topic::{FRAME_STAMP, HELD_FRAME, TOOL_POSE, VIEW_FRAME};
use bus::wake::Waits;
use geometry::{Ct, Rigid, Tool};

use crate::accuracy::Accuracy;
use crate::overlay::{Notice, Origin};
use crate::render::{RenderError, Rendered, Renderer};
use crate::reslice::{Chosen, Resampler};

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

/// One view and the places its images go to.
struct Output {
    index: u32,
    renderer: Renderer,
    live: FramePublisher,
    held: FramePublisher,
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
    /// The sample handled last.
    last: Option<ToolPose>,
    /// The last valid pose and when it was captured.
    last_valid: Option<(Rigid<Ct, Tool>, i64)>,
    /// On the process's clock, as the session's may stand still.
    next_ageing_ns: i64,
}

/// Renders the views of one direction until asked to stop.
///
/// # Errors
/// Each variant of [`RunError`].
pub(crate) fn run(plane: Plane, membership: &Membership) -> Result<(), RunError> {
    let name = plane.process();
    let process = Process::join(&name, membership)?;
    let poses = Subscriber::open_waking(&process.bus, &TOOL_POSE, "", 1)?;
    let server = CommandServer::open(&process.bus, &name)?;
    let stale = process.scene.limits.stale;
    let mut view = SliceView::new(process, plane)?;
    Waits::every(TICK)
        .message(&poses, Some(stale))
        .request(&server)
        .run(|| match view.step(&poses, &server) {
            Ok(ControlFlow::Continue(())) => ControlFlow::Continue(()),
            Ok(ControlFlow::Break(())) => ControlFlow::Break(Ok(())),
            Err(error) => ControlFlow::Break(Err(error)),
        })?
}

impl SliceView {
    fn new(process: Process, plane: Plane) -> Result<Self, RunError> {
        let mut outputs = Vec::new();
        for (index, view) in process.scene.views.iter().enumerate() {
            if view.plane != plane {
                continue;
            }
            let bytes = view.size[0] as usize * view.size[1] as usize * 4;
            outputs.push(Output {
                index: index as u32,
                live: FramePublisher::open(&process.bus, &VIEW_FRAME, &view.name, bytes)?,
                held: FramePublisher::open(&process.bus, &HELD_FRAME, &view.name, bytes)?,
                renderer: Renderer::new(view.clone()),
            });
        }
        if outputs.is_empty() {
            return Err(RunError::NoView(plane.name()));
        }
        Ok(Self {
            stamps: Publisher::open(&process.bus, &FRAME_STAMP, &plane.process())?,
            volumes: VolumeSubscriber::open(&process.bus)?,
            resampler: Chosen::new(process.scene.render),
            process,
            outputs,
            volume: None,
            volume_name: String::new(),
            origin: Origin::Tracker,
            last: None,
            last_valid: None,
            next_ageing_ns: 0,
        })
    }

    fn step(&mut self, poses: &Subscriber<ToolPose>, server: &CommandServer) -> Result<ControlFlow<()>, RunError> {
        if self.process.stop.is_set() {
            self.process.beat(ProcessState::Stopping, "asked to stop")?;
            return Ok(ControlFlow::Break(()));
        }
        self.take_volume()?;
        while let Some(request) = server.next()? {
            self.answer(request)?;
        }
        if self.volume.is_none() {
            self.process.beat(ProcessState::Starting, "waiting for the volume")?;
            return Ok(ControlFlow::Continue(()));
        }
        let newest = poses.newest()?;
        // After the pose was taken: its replayer has said before it what time it is.
        let jumped = self.process.session.follow()?;
        if jumped {
            self.forget();
        }
        let session = &self.process.session;
        match newest.filter(|pose| !jumped || !session.is_yet_to_come(pose.t_publish_ns)) {
            Some(pose) => self.show(pose)?,
            None => self.age()?,
        }
        self.process.beat(ProcessState::Ready, &self.resampler.note())?;
        Ok(ControlFlow::Continue(()))
    }

    /// Takes over a volume from the loader. One that is not the same examination is not shown in the middle of a run.
    fn take_volume(&mut self) -> Result<(), RunError> {
        let Some(new) = self.volumes.poll()? else { return Ok(()) };
        if let Some(old) = &self.volume
            && old.hash() != new.hash()
        {
            bus::say!(
                "slice-view-proc: warning: the loader published another examination ({}); the images stay with {}",
                new.hash(),
                old.hash()
            );
            return Ok(());
        }
        self.volume_name = new.hash().to_string()[..8].to_owned();
        let samplings: Vec<_> = self.outputs.iter().map(|o| o.renderer.view().sampling).collect();
        let (process, mut failed) = (&mut self.process, Ok(()));
        let mut alive = || {
            if failed.is_ok() {
                failed = process.beat(ProcessState::Starting, "preparing the volume");
            }
        };
        let prepared = self.resampler.prepare(&new.view(), &samplings, &mut alive);
        prepared.map_err(RenderError::from)?;
        failed?;
        self.origin = match self.process.run.simulated_time {
            true => Origin::SimulatedTime,
            false => origin(self.process.run.replay.as_ref(), &new.hash().to_string()),
        };
        self.volume = Some(new);
        Ok(())
    }

    fn answer(&mut self, request: Request) -> Result<(), RunError> {
        let command: Command = *request.command();
        if command.command_kind() != Some(CommandKind::Render) {
            request.reply(Err("a renderer answers only requests to render a pose"))?;
            return Ok(());
        }
        if self.volume.is_none() {
            request.reply(Err("there is no volume yet"))?;
            return Ok(());
        }
        match command.pose.tracked() {
            Ok(Tracked::Valid(pose)) => {
                self.draw(&command.pose, Some(pose), Notice::Held)?;
                request.reply(Ok("drawn"))?;
            }
            Ok(Tracked::Lost(reason)) => request.reply(Err(reason.words()))?,
            Err(error) => request.reply(Err(&error.to_string()))?,
        }
        Ok(())
    }

    /// A replay went elsewhere: what was shown last is neither old nor the one before what comes.
    fn forget(&mut self) {
        self.last = None;
        self.last_valid = None;
        self.next_ageing_ns = self.process.clock().now_ns() + clock::ns(AGEING);
    }

    /// Draws a sample that came over the bus.
    fn show(&mut self, sample: ToolPose) -> Result<(), RunError> {
        if let Some(last) = self.last {
            self.process.counters.dropped += sample.seq.saturating_sub(last.seq + 1);
        }
        self.last = Some(sample);
        let now = self.process.session.clock().now_ns();
        let tracked = sample.tracked_at(now).unwrap_or_else(|error| self.refuse(&error));
        match tracked {
            Tracked::Valid(pose) => {
                self.last_valid = Some((pose, sample.t_capture_ns));
                self.draw(&sample, Some(pose), self.notice_for_age(now - sample.t_capture_ns))
            }
            Tracked::Lost(reason) => self.draw_lost(&sample, reason),
        }
    }

    fn refuse(&mut self, error: &PoseError) -> Tracked {
        if self.process.counters.refused == 0 {
            bus::say!("slice-view-proc: error: {error}. It is not shown; further ones are only counted");
        }
        self.process.counters.refused += 1;
        Tracked::Lost(Lost::Refused)
    }

    fn notice_for_age(&self, age_ns: i64) -> Notice {
        if age_ns > clock::ns(self.process.scene.limits.stale) {
            Notice::Stale(age_ns)
        } else {
            Notice::Live
        }
    }

    fn draw_lost(&mut self, sample: &ToolPose, reason: Lost) -> Result<(), RunError> {
        self.process.counters.lost += 1;
        let now = self.process.session.clock().now_ns();
        let shown = self.last_valid;
        let notice = Notice::Lost(reason, shown.map(|(_, captured)| now - captured));
        self.draw(sample, shown.map(|(pose, _)| pose), notice)
    }

    /// While no sample comes: what is on the screen grows old, and says so.
    fn age(&mut self) -> Result<(), RunError> {
        let now = self.process.session.clock().now_ns();
        let limit = clock::ns(self.process.scene.limits.stale);
        let last = self.last.unwrap_or(ToolPose::EMPTY);
        let age = now - last.t_capture_ns;
        if self.process.clock().now_ns() < self.next_ageing_ns || (self.last.is_some() && age <= limit) {
            return Ok(());
        }
        match last.tracked() {
            Ok(Tracked::Valid(pose)) => self.draw(&last, Some(pose), Notice::Stale(age)),
            _ => self.draw_lost(&last, Lost::Silent),
        }
    }

    /// Draws and publishes every view of this process.
    fn draw(&mut self, sample: &ToolPose, pose: Option<Rigid<Ct, Tool>>, notice: Notice) -> Result<(), RunError> {
        let Some(volume) = &self.volume else { return Ok(()) };
        let clock = self.process.session.clock();
        let t_seen_ns = clock.now_ns();
        self.next_ageing_ns = self.process.clock().now_ns() + clock::ns(AGEING);
        let mut what = Rendered {
            volume: volume.view(),
            volume_name: &self.volume_name,
            marks: volume.header().marks(),
            pose,
            accuracy: pose.map(|pose| Accuracy::of(sample, pose)),
            notice,
            origin: self.origin,
            seq: sample.seq,
            registration_id: sample.registration_id,
        };
        let scene = &self.process.scene;
        let stale_ns = clock::ns(scene.limits.stale);
        for output in &mut self.outputs {
            // An image that claims to be live must be handed over while its pose is young. A machine that was held up
            // in between draws it again, with its age.
            loop {
                output.renderer.render(&what, scene, &mut self.resampler)?;
                let stamp = FrameStamp {
                    volume_hash: volume.hash().0,
                    view: output.index,
                    t_seen_ns,
                    t_rendered_ns: clock.now_ns(),
                    ..stamp_of(sample, &what)
                };
                let latest_ns = match what.notice {
                    Notice::Live => sample.t_capture_ns.saturating_add(stale_ns),
                    _ => i64::MAX,
                };
                if let Some(sent) = output.send(stamp, clock, latest_ns)? {
                    self.stamps.send(sent)?;
                    break;
                }
                what.notice = Notice::Stale(clock.now_ns() - sample.t_capture_ns);
            }
        }
        self.process.counters.published += 1;
        Ok(())
    }
}

impl Output {
    /// Hands over the image drawn last, to the topic that fits its stamp.
    fn send(&self, stamp: FrameStamp, clock: &Clock, latest_ns: i64) -> Result<Option<FrameStamp>, BusError> {
        let canvas = self.renderer.canvas();
        let header = FrameHeader {
            stamp,
            width: canvas.width(),
            height: canvas.height(),
        };
        let port = if stamp.on_request == 1 { &self.held } else { &self.live };
        port.send(header, canvas.rgba(), clock, latest_ns)
    }
}

/// Where poses come from that are shown in the examination with the hash `shown`.
fn origin(replay: Option<&ReplayOf>, shown: &str) -> Origin {
    match replay.map(|replay| replay.volume_hash.as_deref()) {
        None => Origin::Tracker,
        Some(None) => Origin::RecordingOfUnknown,
        Some(Some(recorded)) if recorded == shown => Origin::Recording,
        Some(Some(_)) => Origin::RecordingOfAnother,
    }
}

/// What the stamp of an image takes from its pose; volume, view and times are the caller's to add.
fn stamp_of(sample: &ToolPose, what: &Rendered<'_>) -> FrameStamp {
    FrameStamp {
        seq: sample.seq,
        t_device_ns: sample.t_device_ns,
        t_capture_ns: sample.t_capture_ns,
        t_publish_ns: sample.t_publish_ns,
        registration_id: sample.registration_id,
        state: what.notice.state().code(),
        on_request: u32::from(what.notice == Notice::Held),
        replay: what.origin.code(),
        ..FrameStamp::default()
    }
}
