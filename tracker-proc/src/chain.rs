//! The thesis's chain M -> B -> L -> C: from the emitters that a localizer sees to the tool in the patient, with the error
//! that all links together make at the tip.
//!
//! ```text
//! ct_from_tool = ct_from_tracker *                              tracker_from_marker * marker_from_tool     (fixed localizer)
//! ct_from_tool = ct_from_reference * (tracker_from_reference)^-1 * tracker_from_marker * marker_from_tool  (reference marker)
//! ```
//!
//! `tracker_from_marker` and `tracker_from_reference` follow from each sample ([`calib::pose`]); `marker_from_tool` is a
//! calibration and the first link a registration, each with its covariance. The errors of the links are independent, so
//! their covariances add along the chain ([`geometry::uncertain`]); those of the calibration and the registration stay the same from
//! sample to sample, and the prediction counts them in full. Nothing is allocated per sample.

mod smoothing;
mod stamps;
mod status;

#[cfg(test)]
mod tests;

use bus::message::Lost;
use calib::pose::{Body, Gates, Localizer, Lost as BodyLost, Sighting, radius_95_mm, solve};
use geometry::{Ct, Marker, Point, Reference, Tool, Tracker, Uncertain};

pub use smoothing::Smoothing;
pub use stamps::{StampError, Stamps};
pub use status::{Event, Status, diagram};

/// Where the patient is: what a registration gives.
#[derive(Debug, Clone, Copy)]
pub enum Registration {
    /// The localizer must not move.
    Fixed(Uncertain<Ct, Tracker>),
    /// A marker on the patient: localizer and patient may move.
    Referenced(Uncertain<Ct, Reference>),
}

/// The constants of the chain: a calibration and a registration.
#[derive(Debug, Clone, Copy)]
pub struct Links {
    /// The tool's calibration.
    pub marker_from_tool: Uncertain<Marker, Tool>,
    /// The patient's registration.
    pub registration: Registration,
}

impl Links {
    /// `ct_from_tool` from the poses of the markers: the tool's, and the patient's where the registration rests on it.
    ///
    /// # Errors
    /// [`Reason::NoReference`], and those of `reference`.
    pub fn ct_from_tool(
        &self,
        tracker_from_marker: Uncertain<Tracker, Marker>,
        reference: impl FnOnce(Uncertain<Ct, Reference>) -> Result<Uncertain<Tracker, Reference>, Reason>,
    ) -> Result<Uncertain<Ct, Tool>, Reason> {
        let tracker_from_tool = tracker_from_marker * self.marker_from_tool;
        Ok(match self.registration {
            Registration::Fixed(ct_from_tracker) => ct_from_tracker * tracker_from_tool,
            Registration::Referenced(ct_from_reference) => {
                ct_from_reference * reference(ct_from_reference)?.inverse() * tracker_from_tool
            }
        })
    }
}

/// Everything that does not change from sample to sample.
#[derive(Debug, Clone)]
pub struct Chain {
    /// The marker on the tool.
    pub marker: Body<Marker>,
    /// The marker on the patient, where the registration rests on one.
    pub reference: Option<Body<Reference>>,
    /// The tool's calibration.
    pub marker_from_tool: Uncertain<Marker, Tool>,
    /// The patient's registration.
    pub registration: Registration,
    /// The localizer's noise.
    pub localizer: Localizer,
    /// When a pose of the tool's marker is refused.
    pub gates: Gates,
    /// When one of the patient's is.
    pub reference_gates: Gates,
    /// Where in the patient errors of the reference count: a target, or the volume's middle.
    pub region: Point<Ct>,
}

/// The tool in the patient.
#[derive(Debug, Clone, Copy)]
pub struct Found {
    /// The pose with the covariance of all links.
    pub ct_from_tool: Uncertain<Ct, Tool>,
    /// Predicted error at the tip, 95 %, mm: emitters, calibrations and registration together.
    pub tip_95_mm: f64,
    /// Root mean square residual of the tool's emitters, mm.
    pub fre_rms_mm: f64,
    /// Emitters of the tool used.
    pub used: usize,
    /// Emitters of the tool seen and left out.
    pub outliers: usize,
}

/// Why there is no pose.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum Reason {
    /// The tool's marker.
    #[error("tool: {0}")]
    Tool(BodyLost),
    /// The patient's marker.
    #[error("reference on the patient: {0}")]
    Reference(BodyLost),
    /// A localizer that makes the poses of its markers has none of the tool's, and says why.
    #[error("tool: {}", .0.words())]
    Stated(Lost),
    /// The registration rests on a reference marker, and the scene has none.
    #[error("the registration rests on a reference marker, and none is described")]
    NoReference,
}

impl Reason {
    /// The reason as it goes over the bus.
    pub fn lost(&self) -> Lost {
        match self {
            Self::Tool(BodyLost::Malformed { .. }) | Self::Reference(BodyLost::Malformed { .. }) => Lost::Refused,
            Self::Reference(_) | Self::NoReference => Lost::Reference,
            Self::Stated(lost) => *lost,
            Self::Tool(BodyLost::NotSeen) => Lost::NotSeen,
            Self::Tool(BodyLost::TooFew { .. }) => Lost::TooFew,
            Self::Tool(BodyLost::Geometry { .. }) => Lost::Geometry,
            Self::Tool(BodyLost::Residual { .. }) => Lost::Residual,
        }
    }
}

impl Chain {
    /// The constants that the chain was made with.
    pub fn links(&self) -> Links {
        Links {
            marker_from_tool: self.marker_from_tool,
            registration: self.registration,
        }
    }

    /// One sample: the emitters of the tool's marker and of the patient's that were seen.
    ///
    /// # Errors
    /// Each variant of [`Reason`].
    pub fn solve(&self, tool: &[Sighting], reference: &[Sighting]) -> Result<Found, Reason> {
        self.solve_with(&self.links(), tool, reference)
    }

    /// The same with other constants.
    ///
    /// # Errors
    /// Each variant of [`Reason`].
    pub fn solve_with(&self, links: &Links, tool: &[Sighting], reference: &[Sighting]) -> Result<Found, Reason> {
        let tip = links.marker_from_tool.transform() * Point::<Tool>::new(0.0, 0.0, 0.0);
        let seen = solve(&self.marker, tip, tool, &self.localizer, &self.gates).map_err(Reason::Tool)?;
        let ct_from_tool = links.ct_from_tool(seen.transform, |ct_from_reference| {
            self.tracker_from_reference(ct_from_reference, reference)
        })?;
        Ok(Found {
            fre_rms_mm: seen.fre_rms_mm,
            used: seen.used,
            outliers: seen.outliers,
            ..Found::of(ct_from_tool)
        })
    }

    fn tracker_from_reference(
        &self,
        ct_from_reference: Uncertain<Ct, Reference>,
        seen: &[Sighting],
    ) -> Result<Uncertain<Tracker, Reference>, Reason> {
        let body = self.reference.as_ref().ok_or(Reason::NoReference)?;
        let region = ct_from_reference.transform().inverse() * self.region;
        let pose = solve(body, region, seen, &self.localizer, &self.reference_gates).map_err(Reason::Reference)?;
        Ok(pose.transform)
    }
}

impl Found {
    /// A pose with the error that its covariance predicts at the tip; no emitters.
    pub fn of(ct_from_tool: Uncertain<Ct, Tool>) -> Self {
        let at_tip = (ct_from_tool * Point::<Tool>::new(0.0, 0.0, 0.0)).covariance();
        Self {
            ct_from_tool,
            tip_95_mm: radius_95_mm(&at_tip),
            fre_rms_mm: 0.0,
            used: 0,
            outliers: 0,
        }
    }
}
