//! The room before a localizer that makes the poses of its markers itself: of each frame's emitters the pose that they fit, or
//! why none follows. No calibration, no registration: those are for who follows the poses.

use bus::message::Lost;
use calib::pose::{Body, Gates, Localizer, Lost as BodyLost, Sighting, solve};
use geometry::{Frame as GeometryFrame, Marker, Point, Reference, Rigid, Tracker, VolumeGrid};
use scene::operating_room::Sensor;
use scene::{Scene, TrackerSource};

use super::links::{gates, weights};
use super::{Arrival, Frame, OperatingRoom, RoomError, Script, ScriptError};

/// A room whose localizer makes poses.
#[derive(Debug, Clone)]
pub struct PosedRoom {
    room: OperatingRoom,
    localizer: Localizer,
    gates: Gates,
    reference_gates: Gates,
    arrivals: Vec<Arrival>,
}

/// What the localizer makes of one marker in one frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fitted<M: GeometryFrame> {
    /// Where the marker is.
    pub tracker_from_marker: Rigid<Tracker, M>,
    /// Root mean square distance of its emitters from it, mm.
    pub error_mm: f64,
}

/// One frame: what is true and what was seen, and the poses made of that.
#[derive(Debug, Clone, PartialEq)]
pub struct PosedFrame {
    /// The emitters and the truth.
    pub frame: Frame,
    /// The tool's marker, or why there is no pose of it.
    pub tool: Result<Fitted<Marker>, Lost>,
    /// The patient's, where there is one.
    pub reference: Option<Result<Fitted<Reference>, Lost>>,
}

/// Why a scene has no such room.
#[derive(Debug, thiserror::Error)]
pub enum PosedRoomError {
    /// Nothing is simulated there.
    #[error(
        "the scene has another tracker.source than \"operating-room\"; what a simulated device sees is such a room"
    )]
    NoRoom,
    /// Its gesture.
    #[error(transparent)]
    Script(#[from] ScriptError),
    /// The room.
    #[error(transparent)]
    Room(#[from] RoomError),
}

impl PosedRoom {
    /// The room of a scene, as the tracker plays it to a run of the same scene; `grid` is that of the scene's volume, as in
    /// [`Script::of_room`].
    ///
    /// # Errors
    /// [`PosedRoomError`].
    pub fn of(scene: &Scene, grid: Option<&VolumeGrid>) -> Result<Self, PosedRoomError> {
        let (tracker, seed) = (&scene.tracker, scene.seed);
        let TrackerSource::OperatingRoom(spec) = &tracker.source else {
            return Err(PosedRoomError::NoRoom);
        };
        let script = Script::of_room(spec, &scene.targets, grid)?;
        // How far a tip is thrown is the business of who follows the pose; the localizer knows no tip.
        let of_localizer = |gates: Gates| Gates {
            max_tip_mm: f64::INFINITY,
            ..gates
        };
        Ok(Self {
            room: OperatingRoom::new(script, spec, &tracker.ct_from_tracker, seed, tracker.rate_hz)?,
            localizer: weights(&spec.sensor).checked().map_err(RoomError::from)?,
            gates: of_localizer(gates(&spec.gates)),
            reference_gates: of_localizer(gates(&spec.reference_gates)),
            arrivals: Vec::new(),
        })
    }

    /// The room itself.
    pub fn room(&self) -> &OperatingRoom {
        &self.room
    }

    /// Places of the emitters of the tool's marker, and of the patient's if there is one, each in its own frame, mm.
    pub fn emitters_mm(&self) -> (Vec<[f64; 3]>, Option<Vec<[f64; 3]>>) {
        let reference = self.room.reference.as_ref().map(|(body, _)| places_mm(body));
        (places_mm(&self.room.marker), reference)
    }

    /// The number of the newest frame of those that arrive after script time `after_ns` and until `until_ns`.
    pub fn newest(&mut self, after_ns: i64, until_ns: i64) -> Option<u64> {
        self.room.arrivals(after_ns, until_ns, &mut self.arrivals);
        self.arrivals.iter().map(|arrival| arrival.seq).max()
    }

    /// Frame `seq`. The same for the same seed, always.
    pub fn frame(&self, seq: u64) -> PosedFrame {
        let frame = self.room.frame(seq);
        let (sensor, localizer) = (&self.room.room.sensor, &self.localizer);
        let reference = self.room.reference.as_ref().zip(frame.tracker_from_reference);
        PosedFrame {
            tool: fitted(&self.room.marker, &frame.tool, localizer, &self.gates)
                .map_err(|why| lost(why, frame.tracker_from_marker, sensor)),
            reference: reference.map(|((body, _), truth)| {
                fitted(body, &frame.reference, localizer, &self.reference_gates).map_err(|why| lost(why, truth, sensor))
            }),
            frame,
        }
    }
}

fn places_mm<F: GeometryFrame>(body: &Body<F>) -> Vec<[f64; 3]> {
    body.emitters().iter().map(|emitter| emitter.place.mm()).collect()
}

fn fitted<F: GeometryFrame>(
    body: &Body<F>,
    seen: &[Sighting],
    localizer: &Localizer,
    gates: &Gates,
) -> Result<Fitted<F>, BodyLost> {
    let pose = solve(body, Point::new(0.0, 0.0, 0.0), seen, localizer, gates)?;
    Ok(Fitted {
        tracker_from_marker: pose.transform.transform(),
        error_mm: pose.fre_rms_mm,
    })
}

/// The reason in the localizer's words. A marker that is truly out of its view is lost for that.
fn lost<F: GeometryFrame>(why: BodyLost, truth: Rigid<Tracker, F>, sensor: &Sensor) -> Lost {
    match why {
        BodyLost::NotSeen | BodyLost::TooFew { .. } if !is_in_view(truth * Point::new(0.0, 0.0, 0.0), sensor) => {
            Lost::OutOfVolume
        }
        BodyLost::NotSeen => Lost::NotSeen,
        // Emitters that lie so that no pose follows are too few that are of use.
        BodyLost::TooFew { .. } | BodyLost::Geometry { .. } => Lost::TooFew,
        BodyLost::Residual { .. } => Lost::Residual,
        // A fault of the scene has given an emitter a number that the marker does not have.
        BodyLost::Malformed { .. } => Lost::Refused,
    }
}

fn is_in_view(place: Point<Tracker>, sensor: &Sensor) -> bool {
    let [x, y, z] = place.mm();
    let distance_mm = x.hypot(y).hypot(z);
    let off_axis_rad = x.hypot(y).atan2(z);
    (sensor.nearest_mm..=sensor.farthest_mm).contains(&distance_mm) && off_axis_rad <= sensor.view_rad
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn room(more: &str) -> PosedRoom {
        let text = format!("[volume]\nsource = \"phantom\"\n[tracker]\nsource = \"operating-room\"\n{more}");
        let scene = Scene::parse(&text, Path::new("s.toml")).unwrap();
        PosedRoom::of(&scene, None).unwrap()
    }

    #[test]
    fn poses_are_those_of_the_room_within_the_noise_of_its_emitters() {
        let room = room("[tracker.room.reference]\n");
        let (mut square, mut count) = (0.0, 0);
        for seq in 0..600 {
            let posed = room.frame(seq);
            let Ok(tool) = posed.tool else { continue };
            let truth = posed.frame.tracker_from_marker;
            let origin = Point::<Marker>::new(0.0, 0.0, 0.0);
            square += (tool.tracker_from_marker * origin).distance(truth * origin).powi(2);
            count += 1;
            let turn = (tool.tracker_from_marker * truth.inverse()).angle();
            // Emitters of 0.15 mm at 50 mm from the middle: 0.15 / 50 for one of them, and seven deviations.
            assert!(turn < 7.0 * 0.15 / 50.0, "{seq}: {turn}");
            assert!(tool.error_mm > 0.0 && tool.error_mm < 0.5, "{seq}");
        }
        let rms_mm = (square / f64::from(count)).sqrt();
        // Noise of one emitter is 0.2 mm in all; of five or more the middle has less, and not nothing.
        assert!(
            count > 300 && (0.01..0.2).contains(&rms_mm),
            "{count} poses, {rms_mm} mm"
        );
    }

    #[test]
    fn without_a_pose_the_reason_is_the_room_s() {
        let whys = |more: &str| {
            let room = room(more);
            let mut whys: Vec<Lost> = (0..300).filter_map(|seq| room.frame(seq).tool.err()).collect();
            whys.dedup();
            whys
        };
        assert!(whys("[tracker.room.localizer]\nview_deg = 1.0\n").contains(&Lost::OutOfVolume));
        assert_eq!(
            whys("[tracker.room.localizer]\nnearest_mm = 100.0\nfarthest_mm = 200.0\n"),
            [Lost::OutOfVolume]
        );
        // A handle that hides everything.
        assert_eq!(
            whys("[tracker.room.handle]\nfrom_mm = 0.0\nto_mm = 400.0\nradius_mm = 200.0\n"),
            [Lost::NotSeen]
        );
        assert_eq!(whys("[tracker.room.gates]\nmin_emitters = 24\n"), [Lost::TooFew]);
        assert_eq!(
            whys("[tracker.room.gates]\nmax_fre_mm = 0.001\noutlier_sigmas = 1e3\n"),
            [Lost::Residual]
        );
    }
}
