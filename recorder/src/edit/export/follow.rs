//! Where the markers of a scene are, as the tracker follows them: the program that starts the recorder brings it along, as the tracker is
//! no library of it.

use bus::message::{EmitterFrame, MarkerFrame};
use geometry::{Marker, Reference, Rigid, Tracker};
use scene::Scene;

/// The markers in the localizer's frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Seen {
    /// The tool's.
    pub marker: Rigid<Tracker, Marker>,
    /// The one on the patient, where the scene has one.
    pub reference: Option<Rigid<Tracker, Reference>>,
}

/// One frame of a localizer.
#[derive(Debug, Clone, Copy)]
pub enum Delivered<'a> {
    /// The emitters that it saw.
    Emitters(&'a EmitterFrame),
    /// The poses that it made.
    Markers(&'a MarkerFrame),
}

/// Makes poses of a localizer's frames, which pass once and in order.
pub trait Follow {
    /// Where the markers are in a frame that came at `now_ns` on the run's clock.
    ///
    /// # Errors
    /// Why there is no pose, in words.
    fn see(&mut self, frame: Delivered<'_>, now_ns: i64) -> Result<Seen, String>;
}

/// Makes a [`Follow`] of a scene.
pub type FollowMarkers = fn(&Scene) -> Result<Box<dyn Follow>, Box<dyn std::error::Error + Send + Sync>>;
