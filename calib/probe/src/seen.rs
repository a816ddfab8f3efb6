//! Points that were seen in tracked images, and their checks.

use geometry::Probe;
use geometry::{Reference, Rigid};
use nalgebra::Vector3;

use crate::error::ProbeError;

/// The fewest frames of a calibration.
pub const LEAST_FRAMES: usize = 3;
/// The most points of one.
pub const MOST_POINTS: usize = 200_000;
/// The fewest points: as many equations as unknowns, and half as many again, so that there are residuals.
pub(crate) const LEAST_POINTS: usize = 12;

/// A point of an image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mark {
    /// Which wire it is of, from 0; 0 where it is of a wall.
    pub wire: usize,
    /// Column and row, pixels: whole numbers are centres.
    pub px: [f64; 2],
}

/// An image with the probe's pose and the points that were found in it.
#[derive(Debug, Clone, PartialEq)]
pub struct Seen {
    /// Its number, for reports.
    pub number: u32,
    /// When it was taken, s, on the clock of the track.
    pub t_s: Option<f64>,
    /// The pose that goes with it: used where there is no track.
    pub reference_from_probe: Rigid<Reference, Probe>,
    /// The points.
    pub marks: Vec<Mark>,
}

/// A turn and a way below which all frames are one picture.
const ONE_TURN_RAD: f64 = 0.005;
const ONE_SHIFT_MM: f64 = 0.5;

/// Checks frames that are about to be fitted, `wires` being how many there are.
pub(crate) fn checked(frames: &[Seen], wires: usize) -> Result<(), ProbeError> {
    let with = frames.iter().filter(|f| !f.marks.is_empty()).count();
    if with < LEAST_FRAMES {
        return Err(ProbeError::TooFewFrames {
            found: with,
            needed: LEAST_FRAMES,
        });
    }
    let points = frames.iter().map(|f| f.marks.len()).sum();
    if !(LEAST_POINTS..=MOST_POINTS).contains(&points) {
        return Err(ProbeError::PointCount {
            found: points,
            needed: LEAST_POINTS,
            most: MOST_POINTS,
        });
    }
    frames.iter().try_for_each(|frame| marked(frame, wires))?;
    moves(frames)
}

pub(crate) fn marked(frame: &Seen, wires: usize) -> Result<(), ProbeError> {
    for (point, mark) in frame.marks.iter().enumerate() {
        let [u, v] = mark.px;
        // A NaN is below nothing.
        if !(u.abs() <= 1e5 && v.abs() <= 1e5) {
            let frame = frame.number;
            return Err(ProbeError::BadPixel { frame, point, u, v });
        }
        if mark.wire >= wires {
            return Err(ProbeError::NoSuchWire {
                frame: frame.number,
                point,
                found: mark.wire,
                wires,
            });
        }
    }
    Ok(())
}

/// Refuses frames that are one picture taken many times: they would look like many.
fn moves(frames: &[Seen]) -> Result<(), ProbeError> {
    let mut used = frames.iter().filter(|f| !f.marks.is_empty());
    let Some(first) = used.next() else { return Ok(()) };
    let first = first.reference_from_probe;
    let (mut turn, mut shift) = (0.0, 0.0);
    for frame in used {
        let pose = frame.reference_from_probe;
        turn = f64::max(turn, (pose.rotation() * first.rotation().inverse()).angle());
        let way = Vector3::from(pose.translation_mm()) - Vector3::from(first.translation_mm());
        shift = f64::max(shift, way.norm());
    }
    if turn < ONE_TURN_RAD && shift < ONE_SHIFT_MM {
        return Err(ProbeError::OnePose {
            frames: frames.len(),
            turn_deg: turn.to_degrees(),
            shift_mm: shift,
        });
    }
    Ok(())
}
