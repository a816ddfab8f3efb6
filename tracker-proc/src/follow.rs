//! The tracker's process where a chain makes the poses: what each frame comes to, whoever delivers it.
//!
//! [`room`] simulates the localizer, [`emitters`] and [`markers`] take its frames from the bus ([`listening`]), [`sequence`] plays
//! poses of markers from a file. All admit frames by the same stamps, step the same status machine, take calibration and registration from the same
//! files ([`links`]) and publish alike.

mod emitters;
mod filed;
mod link_files;
mod links;
mod listening;
mod markers;
mod play_error;
mod posed;
mod room;
mod sequence;
mod standing;
mod watch;

use bus::clock;
use bus::message::{Lost, ToolPose, Tracked};
use bus::process::Process;
use calib::pose::{Lost as BodyLost, Sighting};
use geometry::{Ct, Point, Rigid, Tool, VolumeGrid};
use scene::Scene;

use crate::chain::{Event, Found, Links, Reason, Smoothing, Stamps, Status};
use crate::output::{Output, volume};
use crate::run_error::RunError;
use link_files::Expected;
use links::{Constants, Looked};
use standing::Standing;

pub(crate) use emitters::{follow as follow_emitters, follow_recorded_room};
pub use filed::{FiledError, chain_of_files};
pub(crate) use link_files::calibration_of;
pub(crate) use markers::follow as follow_markers;
pub use play_error::PlayError;
pub(crate) use posed::uncertain as posed_uncertain;
pub(crate) use room::follow as follow_room;
pub(crate) use sequence::follow as follow_sequence;

/// What is known of a frame beside the emitters. Times on the session's clock but for the device's.
#[derive(Debug, Clone, Copy)]
struct Stamp {
    seq: u64,
    t_device_ns: i64,
    t_capture_ns: i64,
    /// By which frames stand in order: each passes once, and none after a later one.
    t_order_ns: i64,
    /// Emitters of the tool that were seen, or 1 where a localizer has the pose of its marker.
    visible: u32,
}

/// The state between two frames.
struct Follower<'a> {
    output: &'a Output,
    grid: VolumeGrid,
    constants: Constants,
    stamps: Stamps,
    status: Status,
    smoothing: Option<Smoothing>,
    /// When a frame was admitted last, on the session's clock.
    last_frame_ns: i64,
    /// Of the tool and of the reference.
    standing: [Standing; 2],
    noiseless: bool,
}

/// How a source describes itself to the follower.
struct Source {
    /// The scene's own constants.
    own: Links,
    /// Whether the errors of these are stated.
    own_errors_known: bool,
    /// Whether the errors of what is measured are known.
    errors_known: bool,
    /// Whether a marker on the patient is described.
    has_reference: bool,
    /// Whether a marker at rest may give the same numbers again and again.
    noiseless: bool,
}

/// What a source needs of the volume.
struct Examination {
    grid: VolumeGrid,
    hash: String,
}

/// The volume, waited for; `None` where the process was stopped in the meantime.
fn examination(process: &mut Process) -> Result<Option<Examination>, RunError> {
    let volumes = process.volumes()?;
    let volume = volume(process, &volumes)?;
    Ok(volume.map(|volume| Examination {
        grid: *volume.grid(),
        hash: volume.hash().to_string(),
    }))
}

impl<'a> Follower<'a> {
    fn new(process: &Process, output: &'a Output, source: Source, examination: Examination) -> Self {
        let tracker = &process.scene.tracker;
        let expected = Expected {
            tool: process.scene.tool.name.clone(),
            ct_hash: examination.hash,
            has_reference: source.has_reference,
            target: region(&process.scene, &examination.grid),
        };
        let mut follower = Self {
            standing: Default::default(),
            noiseless: source.noiseless,
            output,
            grid: examination.grid,
            constants: Constants::new(&tracker.links, source, expected, output.registration_id),
            stamps: Stamps::default(),
            status: Status::START,
            smoothing: tracker.smoothing.map(|tau| Smoothing::new(tau.as_secs_f64())),
            last_frame_ns: i64::MIN,
        };
        follower.step_by(Looked {
            calibration: true,
            registration: true,
        });
        follower
    }

    /// Looks after the files of the constants, once a second, and notes silence.
    fn tend(&mut self, process: &Process) {
        // Files are those of this machine, now, also where a replay stands still.
        let looked = self.constants.look(process.clock().now_ns());
        self.step_by(looked);
        if self.silent_ns(process) > clock::ns(process.scene.limits.stale) {
            self.status = self.status.step(Event::Silence);
        }
    }

    /// For how long no frame has come.
    fn silent_ns(&self, process: &Process) -> i64 {
        process.session.clock().now_ns().saturating_sub(self.last_frame_ns)
    }

    /// A replay goes on from another place: its times may be earlier, and what was before is no neighbour.
    fn went_elsewhere(&mut self) {
        self.stamps.forget();
        self.standing.iter_mut().for_each(Standing::forget);
        self.smoothing.iter_mut().for_each(Smoothing::reset);
    }

    /// Whether a marker has stood still for longer than a measurement can: `places` are the numbers measured of the tool and of
    /// the reference.
    fn is_frozen<I>(&mut self, places: [I; 2], stamp: &Stamp, process: &Process) -> bool
    where
        I: Iterator<Item = f64> + Clone,
    {
        let limit_ns = clock::ns(process.scene.limits.frozen);
        let stands_ns = standing::longest_ns(&mut self.standing, places, stamp.t_capture_ns);
        stands_ns > limit_ns && !self.noiseless
    }

    /// The events of what was found in the files. What was replaced by another is first taken back.
    fn step_by(&mut self, looked: Looked) {
        if looked.calibration {
            self.status = self.status.step(Event::CalibrationWithdrawn);
        }
        if looked.registration {
            self.status = self.status.step(Event::RegistrationWithdrawn);
        }
        if looked.calibration || looked.registration {
            self.smoothing.iter_mut().for_each(Smoothing::reset);
        }
        if self.constants.lost().is_none_or(|lost| lost == Lost::NotRegistered) {
            self.status = self.status.step(Event::Calibrated);
        }
        if self.constants.lost().is_none() {
            self.status = self.status.step(Event::Registered);
        }
    }

    /// What the operator reads of it.
    fn words(&self) -> String {
        let words = self.status.words();
        match (self.constants.reason(), self.constants.warning()) {
            (Some(reason), _) => format!("{words}: {reason}"),
            (None, Some(warning)) => format!("{words}: {warning}"),
            (None, None) => words.to_owned(),
        }
    }

    /// Whether a frame is to be believed; one that is not is left out and counted.
    fn admit(&mut self, stamp: &Stamp, process: &mut Process) -> bool {
        // Asked here, as the clock of a replay passes a silence at once.
        if self.silent_ns(process) > clock::ns(process.scene.limits.silent) {
            self.stamps.forget();
        }
        let now_ns = process.session.clock().now_ns();
        match self.stamps.admit(stamp.t_order_ns, stamp.t_capture_ns, now_ns) {
            Ok(()) => {
                self.last_frame_ns = now_ns;
                true
            }
            Err(error) => {
                refuse(process, stamp.seq, &error.to_string());
                false
            }
        }
    }

    /// One frame that was admitted: publishes its pose, or the reason why there is none. `places` as for
    /// [`Follower::is_frozen`].
    fn frame<I: Iterator<Item = f64> + Clone>(
        &mut self,
        stamp: &Stamp,
        places: [I; 2],
        process: &mut Process,
        solve: impl FnOnce(&Links) -> Result<Found, Reason>,
    ) -> Result<(), RunError> {
        let mut pose = self.message(stamp);
        let tracked = match self.constants.lost() {
            Some(lost) => Err(lost),
            None if self.is_frozen(places, stamp, process) => Err(Lost::Frozen),
            None => self.solved(&mut pose, process, solve),
        };
        if tracked.is_err() {
            self.smoothing.iter_mut().for_each(Smoothing::reset);
        }
        pose.set(tracked.map_or_else(Tracked::Lost, Tracked::Valid));
        pose.t_publish_ns = process.session.clock().now_ns();
        self.output.poses.send(pose)?;
        process.counters.published += 1;
        process.counters.lost += u64::from(tracked.is_err());
        Ok(())
    }

    /// The pose as it is shown; fills in how good it is.
    fn solved(
        &mut self,
        pose: &mut ToolPose,
        process: &mut Process,
        solve: impl FnOnce(&Links) -> Result<Found, Reason>,
    ) -> Result<Rigid<Ct, Tool>, Lost> {
        let found = solve(&self.constants.links());
        let shown = found
            .as_ref()
            .map(|found| self.smoothed(pose, found.ct_from_tool.transform()));
        let outside = shown.is_ok_and(|shown| !self.grid.holds(shown * Point::<Tool>::new(0.0, 0.0, 0.0)));
        self.status = self.status.step(Event::Frame(outcome(&found, outside)));
        let found = found.map_err(|reason| {
            if let Reason::Tool(error @ BodyLost::Malformed { .. })
            | Reason::Reference(error @ BodyLost::Malformed { .. }) = reason
            {
                refuse(process, pose.seq, &error.to_string());
            }
            reason.lost()
        })?;
        pose.fre_rms_mm = found.fre_rms_mm;
        // At most 32 emitters.
        pose.used = found.used as u32;
        pose.flags |= if outside { ToolPose::OUTSIDE } else { 0 };
        if self.constants.errors_known() {
            pose.covariance = found.ct_from_tool.upper();
            pose.tip_mm = found.tip_95_mm;
            pose.flags |= ToolPose::TIP_KNOWN;
        }
        Ok(shown.unwrap_or(found.ct_from_tool.transform()))
    }

    fn smoothed(&mut self, pose: &mut ToolPose, measured: Rigid<Ct, Tool>) -> Rigid<Ct, Tool> {
        match &mut self.smoothing {
            Some(smoothing) => {
                pose.delay_ns = clock::seconds(smoothing.delay_s());
                smoothing.smooth(pose.t_capture_ns, measured)
            }
            None => measured,
        }
    }

    fn message(&self, stamp: &Stamp) -> ToolPose {
        ToolPose {
            seq: stamp.seq,
            t_device_ns: stamp.t_device_ns,
            t_capture_ns: stamp.t_capture_ns,
            registration_id: self.constants.registration_id(),
            visible: stamp.visible,
            flags: if self.noiseless { ToolPose::NOISELESS } else { 0 },
            ..ToolPose::EMPTY
        }
    }
}

/// The numbers measured of a marker's emitters.
fn numbers(sightings: &[Sighting]) -> impl Iterator<Item = f64> + Clone + '_ {
    let of = |sighting: &Sighting| {
        let [x, y, z] = sighting.place.mm();
        [sighting.emitter as f64, x, y, z]
    };
    sightings.iter().flat_map(of)
}

/// Counts a frame that cannot be believed; the first is told.
fn refuse(process: &mut Process, seq: u64, why: &str) {
    process.counters.refused += 1;
    if process.counters.refused == 1 {
        bus::stderr_line!("tracker: frame {seq} is refused: {why}; further ones are only counted");
    }
}

/// What a frame came to.
fn outcome(found: &Result<Found, Reason>, outside: bool) -> Status {
    match found {
        Ok(_) if outside => Status::Outside,
        Ok(_) => Status::Tracking,
        Err(Reason::Reference(_) | Reason::NoReference) => Status::ReferenceLost,
        Err(Reason::Stated(Lost::OutOfVolume)) => Status::OutOfVolume,
        Err(Reason::Stated(Lost::Interference)) => Status::Interference,
        Err(Reason::Stated(Lost::Disconnected)) => Status::Disconnected,
        Err(Reason::Stated(Lost::TooFew)) => Status::TooFew,
        Err(Reason::Stated(Lost::Residual)) => Status::Residual,
        Err(Reason::Stated(Lost::Refused)) => Status::Refused,
        Err(Reason::Tool(BodyLost::NotSeen) | Reason::Stated(_)) => Status::NotSeen,
        Err(Reason::Tool(BodyLost::TooFew { .. })) => Status::TooFew,
        Err(Reason::Tool(BodyLost::Geometry { .. })) => Status::Geometry,
        Err(Reason::Tool(BodyLost::Residual { .. })) => Status::Residual,
        Err(Reason::Tool(BodyLost::Malformed { .. })) => Status::Refused,
    }
}

/// The point of the patient that counts: what the surgeon aims at, or the volume's middle.
fn region(scene: &Scene, grid: &VolumeGrid) -> Point<Ct> {
    scene.targets.first().map_or(grid.centre(), |target| target.centre)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A pose that the localizer's driver did not believe was told as emitters that do not fit, where there are none.
    #[test]
    fn a_pose_that_was_refused_is_told_as_that() {
        for lost in Lost::ALL {
            let status = outcome(&Err(Reason::Stated(lost)), false);
            assert_eq!(status == Status::Refused, lost == Lost::Refused, "{lost:?}");
        }
        assert_eq!(outcome(&Err(Reason::Stated(Lost::Residual)), false), Status::Residual);
        assert_eq!(Status::Refused.words(), "pose refused");
    }
}
