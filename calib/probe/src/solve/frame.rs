//! What the fit is given: frames with their poses at some lag, and points.

use geometry::{Probe, Reference, Rigid};
use nalgebra::{Matrix3, Vector3};

use crate::error::ProbeError;
use crate::seen::Seen;
use crate::target::Line;
use crate::track::Track;

/// Half a step of the difference that gives the pose's speed, s.
const SPEED_S: f64 = 1e-3;

/// The frames of a fit.
#[derive(Debug)]
pub(crate) struct Data<'a> {
    pub(crate) frames: Vec<&'a Seen>,
    pub(crate) track: Option<&'a Track<Reference, Probe>>,
    /// Middle of all pixels.
    pub(crate) middle: [f64; 2],
    /// Mean of the poses' shifts: what a linear error of the tracker is about.
    pub(crate) centre: Vector3<f64>,
    /// The wires; none where the points lie on a wall.
    pub(crate) lines: &'a [Line],
    /// The phantom's given place.
    pub(crate) phantom_from_reference: (Matrix3<f64>, Vector3<f64>),
}

/// Poses at one lag.
#[derive(Debug, Clone)]
pub(crate) struct Poses {
    pub(crate) each: Vec<Posed>,
}

/// One pose, and how it changes with the lag.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Posed {
    pub(crate) turn: Matrix3<f64>,
    pub(crate) shift: Vector3<f64>,
    /// Per s.
    pub(crate) turn_speed: Matrix3<f64>,
    /// mm/s.
    pub(crate) shift_speed: Vector3<f64>,
}

pub(crate) fn parts<A, B>(pose: &Rigid<A, B>) -> (Matrix3<f64>, Vector3<f64>) {
    (pose.rotation().matrix().into(), pose.translation_mm().into())
}

impl<'a> Data<'a> {
    pub(crate) fn new(
        frames: &'a [Seen],
        track: Option<&'a Track<Reference, Probe>>,
        lines: &'a [Line],
        phantom_from_reference: (Matrix3<f64>, Vector3<f64>),
    ) -> Self {
        let frames: Vec<&Seen> = frames.iter().filter(|f| !f.marks.is_empty()).collect();
        let (mut sum, mut count) = ([0.0; 2], 0.0);
        for mark in frames.iter().flat_map(|f| &f.marks) {
            sum = [sum[0] + mark.px[0], sum[1] + mark.px[1]];
            count += 1.0;
        }
        let shifts = frames
            .iter()
            .map(|f| Vector3::from(f.reference_from_probe.translation_mm()));
        let centre = shifts.sum::<Vector3<f64>>() / frames.len().max(1) as f64;
        Self {
            centre,
            frames,
            track,
            middle: sum.map(|s| s / f64::max(count, 1.0)),
            lines,
            phantom_from_reference,
        }
    }

    /// The poses of all frames at a lag, s.
    pub(crate) fn poses(&self, lag: f64) -> Result<Poses, ProbeError> {
        let each = self.frames.iter().map(|frame| self.pose(frame, lag));
        Ok(Poses {
            each: each.collect::<Result<_, _>>()?,
        })
    }

    fn pose(&self, frame: &Seen, lag: f64) -> Result<Posed, ProbeError> {
        let (Some(track), Some(t_s)) = (self.track, frame.t_s) else {
            let (turn, shift) = parts(&frame.reference_from_probe);
            return Ok(Posed {
                turn,
                shift,
                turn_speed: Matrix3::zeros(),
                shift_speed: Vector3::zeros(),
            });
        };
        let (first_s, last_s) = track.span_s();
        let off = || ProbeError::OffTrack {
            frame: frame.number,
            t_s,
            first_s,
            last_s,
        };
        let at = |t: f64| track.at(t).map(|pose| parts(&pose)).ok_or_else(off);
        let (now, before, after) = (at(t_s + lag)?, at(t_s + lag - SPEED_S)?, at(t_s + lag + SPEED_S)?);
        let per = 0.5 / SPEED_S;
        Ok(Posed {
            turn: now.0,
            shift: now.1,
            turn_speed: (after.0 - before.0) * per,
            shift_speed: (after.1 - before.1) * per,
        })
    }
}
