//! Why the tracker ended.

use bus::BusError;
use bus::process::JoinError;
use geometry::uncertain::CovarianceError;

use crate::follow::PlayError;
use crate::gesture::GestureError;
use crate::markers::MarkersError;
use crate::operating_room::{RoomError, ScriptError};
use crate::probe::ProbeError;

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
    /// Its ultrasound probe.
    #[error(transparent)]
    Probe(#[from] ProbeError),
    /// The noise of a marker's pose is no covariance.
    #[error("tracker.markers.noise_mm and noise_deg: {0}")]
    Noise(CovarianceError),
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
