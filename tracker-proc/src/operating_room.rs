//! The simulated operating room: what a localizer would deliver of the emitters on a tool and on a patient, with the truth.
//!
//! A pure function of the frame's number and the seed, so that a restarted process goes on where the script is, and the same
//! seed gives the same frames. The frames go through the same chain as those of a real localizer ([`crate::chain`]), and with
//! every imperfection switched off the chain gives the truth back.
//!
//! The tube goes through the patient's skin and moves with the patient: the gesture is `ct_from_tool`, in the CT's frame,
//! wherever breathing and bumps have moved that. With `rest_from_moved` the patient's motion since the registration,
//!
//! ```text
//! tracker_from_ct        = (ct_from_tracker)^-1 * rest_from_moved(t)
//! tracker_from_marker    = tracker_from_ct * ct_from_tool(t) * (marker_from_tool)^-1
//! tracker_from_reference = tracker_from_ct * ct_from_reference
//! ```
//!
//! A marker on the patient sees the motion; without one it is an error at the tip, as it is in a real room.

mod bodies;
mod delivery;
mod hand;
mod links;
mod motion;
mod played;
mod posed;
mod practice;
mod script;
mod sensing;
mod sight;

#[cfg(test)]
mod tests;

use bus::message::{EmitterFrame, EmitterSight, Practice};
use calib::pose::{Body, BodyError, LocalizerError, Sighting};
use geometry::uncertain::CovarianceError;
use geometry::{Ct, Marker, Point, Reference, Rigid, Tool, Tracker};
use scene::operating_room::Room;

pub(crate) use bodies::body;
pub use delivery::Arrival;
use delivery::Delivery;
pub(crate) use links::{about, calibration, chain_of, gates, is_noiseless, weights};
pub use played::{Played, PlayedError};
pub use posed::{Fitted, PosedFrame, PosedRoom, PosedRoomError};
pub use practice::Practised;
pub use script::{Script, ScriptError};
use sensing::{Named, Sensing};
use sight::Capsule;

/// The draws of one frame begin here for the emitters of the tool and for those of the patient: three for each emitter. Those
/// of [`delivery`] come after them.
const TOOL_DRAWS: u64 = 0;
const REFERENCE_DRAWS: u64 = 200;

/// A simulated operating room.
#[derive(Debug, Clone)]
pub struct OperatingRoom {
    script: Script,
    room: Room,
    marker: Body<Marker>,
    reference: Option<(Body<Reference>, Rigid<Ct, Reference>)>,
    /// With the patient where it was registered.
    tracker_from_rest: Rigid<Tracker, Ct>,
    delivery: Delivery,
    seed: u64,
}

/// One frame of the localizer, and what is true at its capture.
#[derive(Debug, Clone, PartialEq)]
pub struct Frame {
    /// Its number.
    pub seq: u64,
    /// The capture on the localizer's own clock, ns.
    pub t_device_ns: i64,
    /// The capture in script time, ns.
    pub t_capture_ns: i64,
    /// The arrival in script time, ns; for a dropped frame, when it would have come.
    pub t_arrival_ns: i64,
    /// It never arrives.
    pub dropped: bool,
    /// The tool's emitters that are seen.
    pub tool: Vec<Sighting>,
    /// The patient's emitters that are seen.
    pub reference: Vec<Sighting>,
    /// Where the tool is in the moving patient.
    pub ct_from_tool: Rigid<Ct, Tool>,
    /// Where the tool's marker is.
    pub tracker_from_marker: Rigid<Tracker, Marker>,
    /// Where the patient's marker is, if it has one.
    pub tracker_from_reference: Option<Rigid<Tracker, Reference>>,
}

impl Frame {
    /// The frame as it goes over the bus, captured and handed over at these times of its clock, ns.
    pub fn message(&self, t_capture_ns: i64, t_publish_ns: i64) -> EmitterFrame {
        let sight = |sighting: &Sighting| EmitterSight {
            place_mm: sighting.place.mm(),
            emitter: sighting.emitter as u32,
            reserved: 0,
        };
        let mut message = EmitterFrame {
            seq: self.seq,
            t_device_ns: self.t_device_ns,
            t_capture_ns,
            t_publish_ns,
            ..EmitterFrame::EMPTY
        };
        // A marker of a scene has no more emitters than a frame holds.
        let _ = message.set(self.tool.iter().map(sight), self.reference.iter().map(sight));
        message
    }
}

/// Why there is no such room.
#[derive(Debug, thiserror::Error)]
pub enum RoomError {
    /// The tool's emitters are no marker.
    #[error("the tool's marker (tracker.room.marker): {0}")]
    Marker(BodyError),
    /// The patient's are none.
    #[error("the patient's marker (tracker.room.reference): {0}")]
    Reference(BodyError),
    /// Frames cannot come at such a rate.
    #[error("{rate_hz} frames a second; a number above 0 and up to {most} is needed")]
    Rate {
        /// The rate found.
        rate_hz: f64,
        /// The highest.
        most: f64,
    },
    /// The localizer's numbers are unusable.
    #[error(transparent)]
    Localizer(#[from] LocalizerError),
    /// The stated errors of the calibration or of the registration are unusable.
    #[error("the errors of the calibration and the registration: {0}")]
    Covariance(#[from] CovarianceError),
}

impl OperatingRoom {
    /// The room of a scene, with the patient registered at `ct_from_tracker` when the script begins.
    ///
    /// # Errors
    /// Each variant of [`RoomError`] but the last two.
    pub fn new(
        script: impl Into<Script>,
        room: &Room,
        ct_from_tracker: &Rigid<Ct, Tracker>,
        seed: u64,
        rate_hz: f64,
    ) -> Result<Self, RoomError> {
        let script = script.into();
        let reference = match &room.reference {
            Some(on) => Some((
                bodies::body(&on.shape).map_err(RoomError::Reference)?,
                on.ct_from_reference,
            )),
            None => None,
        };
        Ok(Self {
            delivery: Delivery::new(room.timing, seed, rate_hz, script.end_s())?,
            marker: bodies::body(&room.marker).map_err(RoomError::Marker)?,
            reference,
            tracker_from_rest: ct_from_tracker.inverse(),
            room: room.clone(),
            script,
            seed,
        })
    }

    /// From script time `t_s` on the hand does something else.
    ///
    /// # Errors
    /// In words, where the room has nothing to practise with.
    pub fn order(&mut self, practice: &Practice, t_s: f64) -> Result<(), String> {
        match &mut self.script {
            Script::Practised(hand) => {
                hand.order(practice, t_s);
                Ok(())
            }
            Script::Approach(_) | Script::Played(_) => Err("the scene has no [tracker.room.practice]".to_owned()),
        }
    }

    /// Script time at which frame `seq` is captured, ns.
    pub fn t_capture_ns(&self, seq: u64) -> i64 {
        self.delivery.capture_ns(seq)
    }

    /// The frames that arrive after script time `after_ns` and until `until_ns`, in the order of their arrival, which need not
    /// be that of their capture. `into` is emptied first; its memory is used again.
    ///
    /// Looks at every frame captured between the two times, and those that could be under way: the times of two wakes in a row
    /// are meant. A process that starts while the script is going on begins with `after_ns` as its first moment.
    pub fn arrivals(&self, after_ns: i64, until_ns: i64, into: &mut Vec<Arrival>) {
        self.delivery.arrivals(after_ns, until_ns, into);
    }

    /// The first frame to arrive after `after_ns` and until `until_ns`: what a process sleeps for.
    pub fn next_arrival(&self, after_ns: i64, until_ns: i64) -> Option<Arrival> {
        self.delivery.next_arrival(after_ns, until_ns)
    }

    /// How long a frame may be under way, ns.
    pub fn longest_delay_ns(&self) -> i64 {
        self.delivery.longest_ns()
    }

    /// Where the tool truly is at script time `t_s`.
    pub fn ct_from_tool(&self, t_s: f64) -> Rigid<Ct, Tool> {
        self.script.ct_from_tool(t_s)
    }

    /// Frame `seq`. The same for the same seed, always.
    pub fn frame(&self, seq: u64) -> Frame {
        let t_s = self.delivery.capture_ns(seq) as f64 / 1e9;
        self.frame_at(seq, self.script.ct_from_tool(t_s))
    }

    /// Frame `seq` of a tool that somebody else holds: the localizer, the patient and the noise are those of the room, and
    /// `ct_from_tool` takes the place of the script's pose.
    pub fn frame_at(&self, seq: u64, ct_from_tool: Rigid<Ct, Tool>) -> Frame {
        let t_capture_ns = self.delivery.capture_ns(seq);
        let t_s = t_capture_ns as f64 / 1e9;
        let tracker_from_ct = self.tracker_from_rest * motion::rest_from_moved(&self.room.patient, t_s);
        let tracker_from_tool = tracker_from_ct * ct_from_tool;
        let tracker_from_marker = tracker_from_tool * self.room.marker_from_tool.inverse();
        let hides = self.hides(tracker_from_tool, tracker_from_marker, t_s);
        let sensing = Sensing::new(&self.room.sensor, &hides, self.seed, seq);
        let tool = sensing.sightings(
            &self.marker,
            tracker_from_marker,
            self.room.marker.cone_rad,
            TOOL_DRAWS,
            Named::with(&self.room.faults, t_s),
        );
        let (tracker_from_reference, reference) = self.reference_frame(&sensing, tracker_from_ct);
        let (t_arrival_ns, dropped) = self.delivery.arrival(seq);
        Frame {
            seq,
            t_device_ns: self.delivery.device_ns(t_capture_ns),
            t_capture_ns,
            t_arrival_ns,
            dropped,
            tool,
            reference,
            ct_from_tool,
            tracker_from_marker,
            tracker_from_reference,
        }
    }

    /// Where the patient's marker is and what is seen of it.
    fn reference_frame(
        &self,
        sensing: &Sensing<'_>,
        tracker_from_ct: Rigid<Tracker, Ct>,
    ) -> (Option<Rigid<Tracker, Reference>>, Vec<Sighting>) {
        let (Some((body, ct_from_reference)), Some(on)) = (&self.reference, &self.room.reference) else {
            return (None, Vec::new());
        };
        let pose = tracker_from_ct * *ct_from_reference;
        let seen = sensing.sightings(body, pose, on.shape.cone_rad, REFERENCE_DRAWS, Named::Truly);
        (Some(pose), seen)
    }

    /// What stands in the way of the light: the handle, and the hand while it is there.
    fn hides(&self, tool: Rigid<Tracker, Tool>, marker: Rigid<Tracker, Marker>, t_s: f64) -> [Option<Capsule>; 2] {
        let handle = self.room.handle;
        let on_axis = |from_tip: f64| tool * Point::<Tool>::new(0.0, 0.0, -from_tip);
        let hand = self.room.hand.as_ref();
        let centre = hand.and_then(|hand| hand::place(hand, bodies::reach_mm(&self.marker), self.seed, t_s));
        [
            Capsule::new(on_axis(handle.from_mm), on_axis(handle.to_mm), handle.radius_mm),
            centre.and_then(|centre| {
                let centre = marker * centre;
                Capsule::new(centre, centre, hand?.radius_mm)
            }),
        ]
    }
}
