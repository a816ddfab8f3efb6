//! A pose of the device as one of the house.

use geometry::checked::{self, DoorError};
use geometry::{Marker, Rigid, Tracker};
use ndi::Pose;

/// Single precision is off a length of 1 by less.
pub(super) const UNIT_TOLERANCE: f64 = 1e-3;

/// `tracker_from_marker`, mm.
///
/// # Errors
/// Numbers that are no rotation within [`UNIT_TOLERANCE`], or not finite.
pub(super) fn rigid(pose: &Pose) -> Result<Rigid<Tracker, Marker>, DoorError> {
    checked::rigid(pose.q, pose.t_mm, UNIT_TOLERANCE)
}
