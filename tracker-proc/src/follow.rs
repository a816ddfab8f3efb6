//! The tracker's process in a simulated operating room: each frame of the localizer through the chain, as it arrives.

use bus::clock;
use bus::message::{Lost, ProcessState, ToolPose, Tracked};
use bus::process::Process;
use bus::scene::operating_room::Room;
use calib::pose::Lost as BodyLost;
use geometry::{Ct, Point, Tool, VolumeGrid};

use crate::chain::{Chain, Event, Found, Reason, Stamps, Status};
use crate::operating_room::{Arrival, Frame, OperatingRoom, Script};
use crate::run::{CATCH_UP, LOOK_UP, Output, RunError, volume};

/// The state between two frames.
struct Following<'a> {
    room: OperatingRoom,
    chain: Chain,
    grid: VolumeGrid,
    stamps: Stamps,
    status: Status,
    last_frame_ns: i64,
    output: &'a Output,
}

/// Publishes what the chain makes of the frames until asked to stop.
///
/// # Errors
/// Each variant of [`RunError`] but `External`.
pub(crate) fn follow(process: &mut Process, output: &Output, room: &Room) -> Result<(), RunError> {
    let Some(mut following) = Following::new(process, output, room)? else {
        return Ok(());
    };
    let mut arrivals: Vec<Arrival> = Vec::new();
    let mut after = process.clock().now_ns() - output.start_ns;
    while !process.stop.is_set() {
        let now = process.clock().now_ns() - output.start_ns;
        after = after.max(now - clock::ns(CATCH_UP));
        following.room.arrivals(after, now, &mut arrivals);
        for arrival in &arrivals {
            following.frame(&following.room.frame(arrival.seq), process)?;
        }
        following.silence(now, clock::ns(process.scene.limits.stale));
        process.beat(ProcessState::Ready, following.status.words())?;
        after = now;
        let look_up = now + clock::ns(LOOK_UP);
        let next = following.room.next_arrival(now, look_up);
        let until = next.map_or(look_up, |arrival| arrival.t_arrival_ns);
        process.clock().sleep_until(output.start_ns + until);
    }
    process.beat(ProcessState::Stopping, "asked to stop")?;
    Ok(())
}

impl<'a> Following<'a> {
    /// `None` where the process was stopped while it waited for the volume.
    fn new(process: &mut Process, output: &'a Output, room: &Room) -> Result<Option<Self>, RunError> {
        let Some(volume) = volume(process)? else {
            return Ok(None);
        };
        let (scene, grid) = (&process.scene, *volume.grid());
        let script = Script::of_room(room, &scene.targets, Some(&grid))?;
        // The point of the patient that counts: what the surgeon aims at.
        let region = scene.targets.first().map_or(grid.centre(), |target| target.centre);
        let tracker = &scene.tracker;
        let room = OperatingRoom::new(script, room, &tracker.ct_from_tracker, scene.seed, tracker.rate_hz)?;
        Ok(Some(Self {
            chain: room.chain(region)?,
            room,
            grid,
            stamps: Stamps::default(),
            // The scene's room is calibrated and registered.
            status: Status::START.step(Event::Calibrated).step(Event::Registered),
            last_frame_ns: i64::MIN,
            output,
        }))
    }

    /// One frame: a pose, or the reason why there is none. A frame that cannot be believed is left out and counted.
    fn frame(&mut self, frame: &Frame, process: &mut Process) -> Result<(), RunError> {
        let now_ns = process.clock().now_ns();
        let captured_ns = self.output.start_ns + frame.t_capture_ns;
        if let Err(error) = self.stamps.admit(frame.t_device_ns, captured_ns, now_ns) {
            process.counters.refused += 1;
            if process.counters.refused == 1 {
                eprintln!(
                    "tracker: frame {} is left out: {error}; such frames are counted as refused",
                    frame.seq
                );
            }
            return Ok(());
        }
        self.last_frame_ns = now_ns - self.output.start_ns;
        let found = self.chain.solve(&frame.tool, &frame.reference);
        self.status = self.status.step(Event::Frame(outcome(&found, &self.grid)));
        let mut pose = self.message(frame, now_ns);
        match &found {
            Ok(found) => {
                pose.set(Tracked::Valid(found.ct_from_tool.transform()));
                pose.covariance = found.ct_from_tool.upper();
                pose.fre_rms_mm = found.fre_rms_mm;
            }
            Err(reason) => pose.set(Tracked::Lost(lost(reason))),
        }
        let mut truth = self.message(frame, now_ns);
        truth.set(Tracked::Valid(frame.ct_from_tool));
        self.output.poses.send(pose)?;
        self.output.truths.send(truth)?;
        process.counters.published += 1;
        process.counters.lost += u64::from(found.is_err());
        Ok(())
    }

    fn message(&self, frame: &Frame, now_ns: i64) -> ToolPose {
        ToolPose {
            seq: frame.seq,
            t_device_ns: frame.t_device_ns,
            t_capture_ns: self.output.start_ns + frame.t_capture_ns,
            t_publish_ns: now_ns,
            registration_id: self.output.registration_id,
            // At most 32 emitters.
            visible: frame.tool.len() as u32,
            ..ToolPose::EMPTY
        }
    }

    /// No frame for longer than the scene's limit.
    fn silence(&mut self, now: i64, limit_ns: i64) {
        if now.saturating_sub(self.last_frame_ns) > limit_ns {
            self.status = self.status.step(Event::Silence);
        }
    }
}

/// What a frame came to.
fn outcome(found: &Result<Found, Reason>, grid: &VolumeGrid) -> Status {
    match found {
        Ok(found) if holds(grid, found.ct_from_tool.transform() * Point::<Tool>::new(0.0, 0.0, 0.0)) => {
            Status::Tracking
        }
        Ok(_) => Status::Outside,
        Err(Reason::Reference(_) | Reason::NoReference) => Status::ReferenceLost,
        Err(Reason::Tool(BodyLost::NotSeen)) => Status::NotSeen,
        Err(Reason::Tool(BodyLost::TooFew { .. })) => Status::TooFew,
        Err(Reason::Tool(BodyLost::Geometry { .. })) => Status::Geometry,
        Err(Reason::Tool(BodyLost::Residual { .. } | BodyLost::Malformed { .. })) => Status::Residual,
    }
}

/// The reason as it goes over the bus.
fn lost(reason: &Reason) -> Lost {
    match reason {
        Reason::Reference(_) | Reason::NoReference => Lost::Reference,
        Reason::Tool(BodyLost::NotSeen) => Lost::NotSeen,
        Reason::Tool(BodyLost::TooFew { .. }) => Lost::TooFew,
        Reason::Tool(BodyLost::Geometry { .. }) => Lost::Geometry,
        Reason::Tool(BodyLost::Residual { .. }) => Lost::Residual,
        Reason::Tool(BodyLost::Malformed { .. }) => Lost::Refused,
    }
}

/// Whether the volume's cells hold a point.
fn holds(grid: &VolumeGrid, p: Point<Ct>) -> bool {
    let voxel = (grid.voxel_from_ct() * p).mm();
    let inside = |(v, n): (f64, u32)| (-0.5..=f64::from(n) - 0.5).contains(&v);
    voxel.into_iter().zip(grid.dims()).all(inside)
}
