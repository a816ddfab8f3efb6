//! The tool in its seat: `marker_from_tool`, the constant that the calibration base is for.

use geometry::{Base, Frame, Marker, Reference, Tool, Tracker, Uncertain};

use super::{Refused, mean};

/// The tool in the frame of the marker it carries.
#[derive(Debug, Clone, Copy)]
pub struct Seated {
    /// With the covariance of the frames' mean, of the base's place and of the seat.
    pub marker_from_tool: Uncertain<Marker, Tool>,
    /// Frames that took part.
    pub frames: usize,
    /// The frames' scatter in units of their covariances; NaN for a single frame.
    pub ratio: f64,
    /// The frame furthest from the mean, deviations.
    pub worst: f64,
}

/// The base's reference marker as seen from the tool's marker, in one frame of the localizer. The errors of both poses
/// are taken as independent.
pub fn seen_from_marker(
    tracker_from_marker: &Uncertain<Tracker, Marker>,
    tracker_from_reference: &Uncertain<Tracker, Reference>,
) -> Uncertain<Marker, Reference> {
    tracker_from_marker.inverse() * *tracker_from_reference
}

/// `marker_from_tool = mean(marker_from_f) f_from_base base_from_tool`, the tool sitting in the base as drawn.
///
/// `F` is the [`Reference`] marker on the base, with frames by [`seen_from_marker`]; or the [`Tracker`] where the base
/// stood still, with frames `tracker_from_marker.inverse()`. The frames' noise is averaged; the error of the base's place
/// and that of the seat are common to all frames and enter once.
///
/// # Errors
/// Those of [`mean()`].
pub fn seated<F: Frame>(
    marker_from_f: &[Uncertain<Marker, F>],
    f_from_base: &Uncertain<F, Base>,
    base_from_tool: &Uncertain<Base, Tool>,
    gate: f64,
) -> Result<Seated, Refused> {
    let found = mean(marker_from_f, gate)?;
    Ok(Seated {
        marker_from_tool: found.mean * *f_from_base * *base_from_tool,
        frames: marker_from_f.len(),
        ratio: found.ratio,
        worst: found.deviations.iter().copied().fold(0.0, f64::max),
    })
}
