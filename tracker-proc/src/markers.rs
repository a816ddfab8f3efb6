//! Where the markers of a scene are, frame by frame: the part of the chain that needs neither calibration nor registration,
//! and which these are made from.

use bus::message::{EmitterFrame, EmitterSight};
use calib::pose::{Body, BodyError, Gates, Localizer, LocalizerError, Sighting, solve};
use geometry::{Ct, Marker, Point, Reference, Rigid, Tool, Tracker, Uncertain};
use scene::operating_room::{ReferenceMarker, Room};
use scene::tracking::EmitterSource;
use scene::{Scene, TrackerSource};

use crate::chain::{Reason, Stamps};
use crate::follow::calibration_of;
use crate::operating_room::{RoomError, body, calibration, gates, weights};

/// The markers of a scene, the localizer that sees them, and when a pose is refused.
#[derive(Debug, Clone)]
pub struct Markers {
    pub(crate) marker: Body<Marker>,
    pub(crate) reference: Option<Body<Reference>>,
    pub(crate) localizer: Localizer,
    pub(crate) gates: Gates,
    pub(crate) reference_gates: Gates,
    /// Where the marker sits on the tool, as the tracker has it: of the file that the scene names, or of the scene.
    marker_from_tool: Result<Uncertain<Marker, Tool>, String>,
    /// Roughly the tip, which an error counts at.
    tip: Point<Marker>,
    /// Where on the patient errors of its marker count.
    region: Point<Reference>,
    stamps: Stamps,
}

/// The markers in the localizer's frame, with the covariances that follow from the emitters' noise.
#[derive(Debug, Clone, Copy)]
pub struct Seen {
    /// The tool's.
    pub marker: Uncertain<Tracker, Marker>,
    /// The patient's, where the scene has one.
    pub reference: Option<Uncertain<Tracker, Reference>>,
}

/// Why the markers of a scene cannot be followed.
#[derive(Debug, thiserror::Error)]
pub enum MarkersError {
    /// The tool's emitters are no marker.
    #[error("the tool's marker (tracker.emitters.marker): {0}")]
    Marker(BodyError),
    /// The patient's are none.
    #[error("the patient's marker (tracker.emitters.reference): {0}")]
    Reference(BodyError),
    /// The localizer's noise is unusable.
    #[error("tracker.emitters.localizer: {0}")]
    Localizer(#[from] LocalizerError),
    /// The simulated room is unusable.
    #[error(transparent)]
    Room(#[from] RoomError),
    /// Nothing says how sure the poses are that a localizer makes.
    #[error(
        "tracker.markers.noise_mm and noise_deg say nothing of how sure the localizer's poses are, and what is made of them is weighted by that; \
         give both, above 0"
    )]
    NoNoise,
    /// There are no emitters to follow.
    #[error("the scene says tracker.source = {0:?}, and then there are no emitters")]
    NoEmitters(&'static str),
}

impl Markers {
    /// Those of a scene whose localizer delivers emitters.
    ///
    /// # Errors
    /// Each variant of [`MarkersError`].
    pub fn of(scene: &Scene) -> Result<Self, MarkersError> {
        let mut markers = match &scene.tracker.source {
            TrackerSource::Emitters(spec) => Self::of_emitters(spec)?,
            TrackerSource::OperatingRoom(room) => Self::of_room(room, scene.seed)?,
            TrackerSource::Simulated(_) => return Err(MarkersError::NoEmitters("simulated")),
            TrackerSource::Markers(_) => return Err(MarkersError::NoEmitters("markers")),
            TrackerSource::Sequence(_) => return Err(MarkersError::NoEmitters("sequence")),
            TrackerSource::External => return Err(MarkersError::NoEmitters("external")),
        };
        if let Some(link) = &scene.tracker.links.calibration {
            markers.marker_from_tool = calibration_of(link, &scene.tool.name);
        }
        if let (Some(target), Some(at)) = (scene.targets.first(), place(scene)) {
            markers.region = at.inverse() * target.centre;
        }
        Ok(markers)
    }

    /// Those of a localizer that is another program.
    pub(crate) fn of_emitters(spec: &EmitterSource) -> Result<Self, MarkersError> {
        let n = spec.noise;
        let localizer = Localizer {
            eye: ORIGIN,
            across_mm: n.across_mm,
            depth_mm: n.depth_mm,
            at_mm: n.at_mm,
            growth_across: n.growth_across,
            growth_depth: n.growth_depth,
            step_mm: n.quantisation_mm,
        };
        Ok(Self {
            marker: body(&spec.marker).map_err(MarkersError::Marker)?,
            reference: reference(spec.reference.as_ref()).map_err(MarkersError::Reference)?,
            localizer: localizer.checked()?,
            gates: gates(&spec.gates),
            reference_gates: gates(&spec.reference_gates),
            marker_from_tool: Ok(spec.marker_from_tool.into()),
            tip: spec.marker_from_tool * Point::<Tool>::new(0.0, 0.0, 0.0),
            region: Point::new(0.0, 0.0, 0.0),
            stamps: Stamps::default(),
        })
    }

    fn of_room(room: &Room, seed: u64) -> Result<Self, RoomError> {
        Ok(Self {
            marker: body(&room.marker).map_err(RoomError::Marker)?,
            reference: reference(room.reference.as_ref()).map_err(RoomError::Reference)?,
            localizer: weights(&room.sensor).checked()?,
            gates: gates(&room.gates),
            reference_gates: gates(&room.reference_gates),
            marker_from_tool: Ok(calibration(room, seed)?),
            tip: room.marker_from_tool * Point::<Tool>::new(0.0, 0.0, 0.0),
            region: Point::new(0.0, 0.0, 0.0),
            stamps: Stamps::default(),
        })
    }

    /// Whether there is a marker on the patient.
    pub fn has_reference(&self) -> bool {
        self.reference.is_some()
    }

    /// The tool's calibration in use.
    ///
    /// # Errors
    /// Why the file that the scene names is not used, in words.
    pub fn marker_from_tool(&self) -> Result<Uncertain<Marker, Tool>, String> {
        self.marker_from_tool.clone()
    }

    /// One frame, where it is `now_ns` on the run's clock. Frames pass once and in order, as they do in the tracker.
    ///
    /// # Errors
    /// Why there is no pose, in words.
    pub fn see(&mut self, frame: &EmitterFrame, now_ns: i64) -> Result<Seen, String> {
        let words = |error: &dyn std::error::Error| error.to_string();
        let (tool, patient) = (frame.tool(), frame.reference());
        let (tool, patient) = (tool.map_err(|e| words(&e))?, patient.map_err(|e| words(&e))?);
        self.stamps
            .admit(frame.t_device_ns, frame.t_capture_ns, now_ns)
            .map_err(|e| words(&e))?;
        let mut sights = Vec::with_capacity(EmitterFrame::MOST);
        taken(tool, &mut sights);
        let marker = solve(&self.marker, self.tip, &sights, &self.localizer, &self.gates);
        let marker = marker.map_err(|lost| Reason::Tool(lost).to_string())?.transform;
        let reference = self.reference.as_ref().map(|body| {
            taken(patient, &mut sights);
            solve(body, self.region, &sights, &self.localizer, &self.reference_gates)
        });
        let reference = reference.transpose();
        let reference = reference.map_err(|lost| Reason::Reference(lost).to_string())?;
        Ok(Seen {
            marker,
            reference: reference.map(|pose| pose.transform),
        })
    }
}

const ORIGIN: Point<Tracker> = Point::new(0.0, 0.0, 0.0);

fn reference(on: Option<&ReferenceMarker>) -> Result<Option<Body<Reference>>, BodyError> {
    on.map(|on| body(&on.shape)).transpose()
}

/// Where the scene says that the marker on the patient sits.
fn place(scene: &Scene) -> Option<Rigid<Ct, Reference>> {
    let reference = match &scene.tracker.source {
        TrackerSource::OperatingRoom(room) => &room.reference,
        TrackerSource::Emitters(spec) => &spec.reference,
        _ => &None,
    };
    reference.as_ref().map(|on| on.ct_from_reference)
}

/// The sights as the chain takes them; it refuses what is not finite and emitters that the marker does not have.
pub(crate) fn taken(sights: &[EmitterSight], into: &mut Vec<Sighting>) {
    into.clear();
    into.extend(sights.iter().map(|sight| {
        let [x, y, z] = sight.place_mm;
        Sighting {
            emitter: sight.emitter as usize,
            place: Point::new(x, y, z),
        }
    }));
}
