//! The tracker's process: one sample after the other, on time.

use std::cell::Cell;
use std::time::Duration;

use bus::BusError;
use bus::clock;
use bus::message::{ProcessState, ToolPose, Tracked};
use bus::port::{Publisher, SharedVolume, VolumeSubscriber};
use bus::process::{JoinError, Membership, Process};
use bus::topic::{GROUND_TRUTH, TOOL_POSE};
use geometry::{Ct, Point, Rigid, Tool, Tracker, VolumeGrid};
use scene::{Scene, Simulation, TrackerSource};

use crate::chain::{Found, Smoothing};
use crate::follow::{PlayError, follow_emitters, follow_recorded_room, follow_room, follow_sequence};
use crate::gesture::{Gesture, GestureError, aim};
use crate::markers::MarkersError;
use crate::operating_room::{RoomError, ScriptError};
use crate::simulated::{Measured, Simulated};
use crate::simulated_time::SimulatedTime;

/// The process looks up at least this often, to be stopped and to give signs of life.
pub(crate) const LOOK_UP: Duration = Duration::from_millis(20);
/// A process that was held up publishes what it missed up to half the age at which an image is old; older samples are left out,
/// as a gap in the sequence numbers.
pub(crate) fn catch_up_ns(scene: &Scene) -> i64 {
    clock::ns(scene.limits.stale) / 2
}

/// The last sample of the time that the run navigates for has gone out.
pub(crate) const OVER: &str = "the time is over";

/// Between two looks whether the navigation has begun.
const BEGINNING: Duration = Duration::from_millis(5);

/// Why the tracker ended.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// It could not join the run.
    #[error(transparent)]
    Join(#[from] JoinError),
    /// The bus failed.
    #[error(transparent)]
    Bus(#[from] BusError),
    /// The gesture cannot be played.
    #[error(transparent)]
    Gesture(#[from] GestureError),
    /// The simulated operating room cannot be set up.
    #[error(transparent)]
    Room(#[from] RoomError),
    /// Its gesture cannot be played.
    #[error(transparent)]
    Script(#[from] ScriptError),
    /// The scene's markers or localizer are unusable.
    #[error(transparent)]
    Markers(#[from] MarkersError),
    /// The sequence cannot be played.
    #[error(transparent)]
    Play(#[from] PlayError),
    /// A replay whose poses cannot be made again.
    #[error("no pose can be made of the recorded emitters: {0}")]
    NoLinks(String),
    /// Poses come from elsewhere.
    #[error(
        "the scene says tracker.source = \"external\": another program publishes the poses, and no tracker is to be started"
    )]
    External,
}

/// Publishes poses until asked to stop, or until the time is over that the run navigates for; `start_ns` is the moment of sample 0
/// on the run's clock, `None` the one that the pilot says. In simulated time a tracker goes on behind `after_ns`.
///
/// # Errors
/// Each variant of [`RunError`].
pub(crate) fn run(membership: &Membership, start_ns: Option<i64>, after_ns: Option<i64>) -> Result<(), RunError> {
    let mut process = Process::join("tracker", membership)?;
    let output = Output {
        poses: Publisher::open(&process.bus, &TOOL_POSE, "")?,
        registration_id: process.scene.registration_id(),
        start_ns: Cell::new(start_ns),
        after_ns,
    };
    match process.scene.tracker.source.clone() {
        // In a replay the frames of a room come out of the recording.
        TrackerSource::OperatingRoom(room) if process.session.is_replay() => {
            follow_recorded_room(&mut process, &output, &room)
        }
        TrackerSource::OperatingRoom(room) => follow_room(&mut process, &output, &room),
        TrackerSource::Emitters(source) => follow_emitters(&mut process, &output, &source),
        TrackerSource::Sequence(source) => follow_sequence(&mut process, &output, &source),
        TrackerSource::Simulated(simulation) => simulate(&mut process, output, simulation),
        TrackerSource::External => Err(RunError::External),
    }
}

/// Publishes the samples of the simulated localizer until asked to stop.
fn simulate(process: &mut Process, output: Output, simulation: Simulation) -> Result<(), RunError> {
    let volumes = process.volumes()?;
    let Some((simulated, grid)) = simulated(process, &volumes, simulation)? else {
        return Ok(());
    };
    let tracker = &process.scene.tracker;
    let mut samples = Samples {
        truths: Publisher::open(&process.bus, &GROUND_TRUTH, "")?,
        volumes,
        grid,
        smoothing: tracker.smoothing.map(|tau| Smoothing::new(tau.as_secs_f64())),
        ct_from_tracker: tracker.ct_from_tracker,
        output,
        simulated,
    };
    let Some(start) = samples.output.start(process)? else {
        return Ok(());
    };
    if process.run.simulated_time {
        return simulate_in_simulated_time(process, samples, start.at_ns);
    }
    let start_ns = start.at_ns;
    // A process that starts while the script is going on begins with the next sample: those before it may have been
    // published by its predecessor.
    let due = |samples: &Samples, t_ns| samples.simulated.due(t_ns);
    let catch_up = catch_up_ns(&process.scene);
    let mut next = match start.is_first {
        true => 0,
        false => due(&samples, process.clock().now_ns() - start_ns).map_or(0, |seq| seq + 1),
    };
    while !process.stop.is_set() {
        let is_over = process.run.is_beyond(samples.simulated.t_device_ns(next));
        match is_over {
            true => process.beat(ProcessState::Stopping, OVER)?,
            false => process.beat(ProcessState::Ready, "")?,
        }
        if is_over {
            std::thread::sleep(LOOK_UP);
            continue;
        }
        let now = process.clock().now_ns() - start_ns;
        next = next.max(due(&samples, now - catch_up).map_or(0, |seq| seq + 1));
        if process.run.is_beyond(samples.simulated.t_device_ns(next)) {
            continue;
        }
        if due(&samples, now).is_some_and(|due| due >= next) {
            samples.publish(next, process)?;
            next += 1;
        } else {
            let due_ns = start_ns + samples.simulated.t_device_ns(next);
            let look_up = process.clock().now_ns() + clock::ns(LOOK_UP);
            process.clock().sleep_until(due_ns.min(look_up));
        }
    }
    process.beat(ProcessState::Stopping, "asked to stop")?;
    Ok(())
}

/// The same in simulated time.
fn simulate_in_simulated_time(process: &mut Process, mut samples: Samples, start_ns: i64) -> Result<(), RunError> {
    let mut time = SimulatedTime::open(process, &samples.output)?;
    let mut seq = 0;
    while !process.run.is_beyond(samples.simulated.t_device_ns(seq)) {
        let at_ns = start_ns + samples.simulated.t_device_ns(seq);
        if !SimulatedTime::is_past(&samples.output, at_ns) {
            time.expect(process, seq, at_ns, at_ns)?;
            samples.publish(seq, process)?;
            if !time.wait(process, &samples.output, seq)? {
                break;
            }
        }
        seq += 1;
    }
    Ok(time.end(process, &samples.output)?)
}

/// The simulated localizer, and the volume's grid where it had to be waited for; `None` where the process was stopped meanwhile.
fn simulated(
    process: &mut Process,
    volumes: &VolumeSubscriber,
    simulation: Simulation,
) -> Result<Option<(Simulated, Option<VolumeGrid>)>, RunError> {
    let scene = process.scene.clone();
    let approach = &simulation.approach;
    let target = aim(approach, &scene.targets).map(|t| t.centre);
    let (gesture, grid) = if let (Some(target), Some(_)) = (target, approach.entry) {
        (Gesture::new(approach, target, None)?, None)
    } else {
        let Some(volume) = volume(process, volumes)? else {
            return Ok(None);
        };
        let grid = *volume.grid();
        let target = target.unwrap_or_else(|| grid.centre());
        (Gesture::new(approach, target, Some(&grid))?, Some(grid))
    };
    let simulated = Simulated::new(
        gesture,
        simulation,
        &scene.tracker.ct_from_tracker,
        scene.seed,
        scene.tracker.rate_hz,
    );
    Ok(Some((simulated, grid)))
}

/// The volume, waited for; `None` where the process was stopped in the meantime.
pub(crate) fn volume(process: &mut Process, volumes: &VolumeSubscriber) -> Result<Option<SharedVolume>, RunError> {
    loop {
        if process.stop.is_set() {
            return Ok(None);
        }
        process.beat(ProcessState::Starting, "waiting for the volume")?;
        match volumes.poll()? {
            Some(volume) => return Ok(Some(volume)),
            None => std::thread::sleep(LOOK_UP),
        }
    }
}

/// Where poses go.
pub(crate) struct Output {
    pub(crate) poses: Publisher<ToolPose>,
    /// Of the scene's own numbers.
    pub(crate) registration_id: u64,
    start_ns: Cell<Option<i64>>,
    /// In simulated time: what was due until then has been published by a tracker before this one.
    pub(crate) after_ns: Option<i64>,
}

/// When sample 0 is due.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Start {
    pub(crate) at_ns: i64,
    /// Whether no tracker of the run has published before.
    pub(crate) is_first: bool,
}

impl Output {
    /// Waits until the pilot says when the navigation begins, unless that was said when this process was started; `None` where
    /// it was stopped meanwhile.
    pub(crate) fn start(&self, process: &mut Process) -> Result<Option<Start>, RunError> {
        if let Some(at_ns) = self.start_ns.get() {
            let is_first = false;
            return Ok(Some(Start { at_ns, is_first }));
        }
        while !process.stop.is_set() {
            process.beat(ProcessState::Ready, "")?;
            if let Some(at_ns) = process.run.began_ns() {
                self.start_ns.set(Some(at_ns));
                let is_first = true;
                return Ok(Some(Start { at_ns, is_first }));
            }
            std::thread::sleep(BEGINNING);
        }
        Ok(None)
    }

    /// Whether a frame captured at `t_capture_ns` is beyond the time that the run navigates for.
    pub(crate) fn is_beyond(&self, process: &Process, t_capture_ns: i64) -> bool {
        if process.run.duration_ns.is_none() {
            return false;
        }
        if self.start_ns.get().is_none() {
            self.start_ns.set(process.run.began_ns());
        }
        let start_ns = self.start_ns.get();
        start_ns.is_some_and(|start_ns| process.run.is_beyond(t_capture_ns.saturating_sub(start_ns)))
    }

    /// When sample 0 was due, ns on the run's clock.
    pub(crate) fn start_ns(&self) -> i64 {
        self.start_ns.get().unwrap_or(0)
    }
}

/// The samples of the simulated localizer.
struct Samples {
    simulated: Simulated,
    output: Output,
    truths: Publisher<ToolPose>,
    volumes: VolumeSubscriber,
    /// The volume, as soon as it is there: no sample waits for it.
    grid: Option<VolumeGrid>,
    smoothing: Option<Smoothing>,
    ct_from_tracker: Rigid<Ct, Tracker>,
}

impl Samples {
    fn publish(&mut self, seq: u64, process: &mut Process) -> Result<(), RunError> {
        if self.grid.is_none() {
            self.grid = self.volumes.poll()?.map(|volume| *volume.grid());
        }
        let measured = self.simulated.sample(seq);
        let mut pose = self.message(seq, &measured);
        let tracked = measured.tracked(&self.ct_from_tracker);
        match tracked {
            Tracked::Valid(at) => self.valid(&mut pose, at),
            Tracked::Lost(_) => {
                self.smoothing.iter_mut().for_each(Smoothing::reset);
                pose.set(tracked);
            }
        }
        let mut truth = self.message(seq, &measured);
        truth.set(Tracked::Valid(measured.truth));
        pose.t_publish_ns = process.session.clock().now_ns();
        truth.t_publish_ns = pose.t_publish_ns;
        self.output.poses.send(pose)?;
        self.truths.send(truth)?;
        process.counters.published += 1;
        process.counters.lost += u64::from(measured.tracker_from_tool.is_err());
        Ok(())
    }

    /// The pose as it is shown, and how good it is.
    fn valid(&mut self, pose: &mut ToolPose, measured: Rigid<Ct, Tool>) {
        let shown = match &mut self.smoothing {
            Some(smoothing) => {
                pose.delay_ns = clock::seconds(smoothing.delay_s());
                smoothing.smooth(pose.t_capture_ns, measured)
            }
            None => measured,
        };
        pose.set(Tracked::Valid(shown));
        let tip = shown * Point::<Tool>::new(0.0, 0.0, 0.0);
        if self.grid.is_some_and(|grid| !grid.holds(tip)) {
            pose.flags |= ToolPose::OUTSIDE;
        }
        // Without, where the scene's noise is beyond what a covariance can hold.
        if let Ok(uncertain) = self.simulated.uncertain(measured) {
            let found = Found::of(uncertain);
            pose.covariance = uncertain.upper();
            pose.tip_mm = found.tip_95_mm;
            pose.flags |= ToolPose::TIP_KNOWN;
        }
    }

    fn message(&self, seq: u64, measured: &Measured) -> ToolPose {
        ToolPose {
            seq,
            t_device_ns: measured.t_device_ns,
            t_capture_ns: self.output.start_ns() + measured.t_device_ns,
            registration_id: self.output.registration_id,
            flags: if self.simulated.is_noiseless() {
                ToolPose::NOISELESS
            } else {
                0
            },
            ..ToolPose::EMPTY
        }
    }
}
