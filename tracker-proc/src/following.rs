//! The markers of a scene, whether a localizer sees their emitters or makes their poses: as who has frames of either kind follows them.

use bus::message::{EmitterFrame, MarkerFrame};
use geometry::{Marker, Tool, Uncertain};
use scene::Scene;

use crate::markers::{Markers, MarkersError, Seen};
use crate::posed_markers::PosedMarkers;

/// A frame that the scene's source does not deliver.
const ANOTHER: &str = "a frame of another kind than the scene's localizer delivers";

/// The markers of a scene as the tracker follows them.
#[derive(Debug, Clone)]
pub enum Following {
    /// By emitters that a localizer sees.
    Emitters(Box<Markers>),
    /// By poses that a localizer makes.
    Posed(Box<PosedMarkers>),
}

impl Following {
    /// Those of a scene.
    ///
    /// # Errors
    /// [`MarkersError`].
    pub fn of(scene: &Scene) -> Result<Self, MarkersError> {
        Ok(match PosedMarkers::of(scene)? {
            Some(markers) => Self::Posed(Box::new(markers)),
            None => Self::Emitters(Box::new(Markers::of(scene)?)),
        })
    }

    /// Whether there is one on the patient.
    pub fn has_reference(&self) -> bool {
        match self {
            Self::Emitters(markers) => markers.has_reference(),
            Self::Posed(markers) => markers.has_reference(),
        }
    }

    /// Where the marker sits on the tool.
    ///
    /// # Errors
    /// In words, why that is not known.
    pub fn marker_from_tool(&self) -> Result<Uncertain<Marker, Tool>, String> {
        match self {
            Self::Emitters(markers) => markers.marker_from_tool(),
            Self::Posed(markers) => markers.marker_from_tool(),
        }
    }

    /// Where the markers are in a frame of emitters that came at `now_ns` on the run's clock.
    ///
    /// # Errors
    /// In words, why there is no pose; of a localizer that makes poses itself there is none.
    pub fn see_emitters(&mut self, frame: &EmitterFrame, now_ns: i64) -> Result<Seen, String> {
        match self {
            Self::Emitters(markers) => markers.see(frame, now_ns),
            Self::Posed(_) => Err(ANOTHER.to_owned()),
        }
    }

    /// The same in a frame of poses.
    ///
    /// # Errors
    /// In words, why there is no pose; of a localizer that sees emitters there is none.
    pub fn see_markers(&mut self, frame: &MarkerFrame, now_ns: i64) -> Result<Seen, String> {
        match self {
            Self::Posed(markers) => markers.see(frame, now_ns),
            Self::Emitters(_) => Err(ANOTHER.to_owned()),
        }
    }
}
