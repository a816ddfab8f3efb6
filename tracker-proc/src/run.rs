//! The tracker's process: one sample after the other, on time.

use bus::clock;
use bus::message::{ProcessState, ToolPose, Tracked};
use bus::port::{Publisher, VolumeSubscriber};
use bus::process::{Membership, Process};
use bus::topic::GROUND_TRUTH;
use geometry::{Ct, Point, Rigid, Tool, Tracker, VolumeGrid};
use scene::{Simulation, TrackerSource};

use crate::chain::{Found, Smoothing};
use crate::follow::{follow_emitters, follow_markers, follow_recorded_room, follow_room, follow_sequence};
use crate::gesture::{Gesture, aim};
use crate::output::{LOOK_UP, OVER, Output, catch_up_ns, volume};
use crate::run_error::RunError;
use crate::simulated::{Measured, Simulated};
use crate::simulated_time::SimulatedTime;

/// Publishes poses until asked to stop, or until the time is over that the run navigates for; `start_ns` is the moment of sample 0
/// on the run's clock, `None` the one that the pilot says. In simulated time a tracker goes on behind `after_ns`.
///
/// # Errors
/// Each variant of [`RunError`].
pub(crate) fn run(membership: &Membership, start_ns: Option<i64>, after_ns: Option<i64>) -> Result<(), RunError> {
    let mut process = Process::join("tracker", membership)?;
    let output = Output::open(&process, start_ns, after_ns)?;
    match process.scene.tracker.source.clone() {
        // In a replay the frames of a room come out of the recording.
        TrackerSource::OperatingRoom(room) if process.session.is_replay() => {
            follow_recorded_room(&mut process, &output, &room)
        }
        TrackerSource::OperatingRoom(room) => follow_room(&mut process, &output, &room),
        TrackerSource::Emitters(source) => follow_emitters(&mut process, &output, &source),
        TrackerSource::Markers(source) => follow_markers(&mut process, &output, &source),
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
