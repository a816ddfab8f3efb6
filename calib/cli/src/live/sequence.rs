//! `calib touch --from-sequence`: the points at which a recorded tip stood still.

use std::path::{Path, PathBuf};

use geometry::{Marker, Point, Rigid, Tool, Tracker, Uncertain, Vector};
use nalgebra::{Matrix3, Matrix6};

use super::dwell::{Sample, Still, stretches, window_s};
use super::{Listened, LiveError, MostMotion, Touched, touched};
use crate::poses::{PosesError, Timed, timed};

/// The share of a drift that a mean may be off by, of the largest distance between the means of three thirds: evenly over 3/2 of it.
const DRIFT: f64 = 1.5 / 3.464_101_615_137_755;
/// Stretches that are told of.
const TOLD: usize = 10;

/// Why a sequence gave no touches.
#[derive(Debug, thiserror::Error)]
pub(crate) enum DwellError {
    #[error(transparent)]
    Poses(#[from] PosesError),
    #[error("touches of {path}: frame {frame} has no Timestamp: how long the tip stands still is not known")]
    NoTime { path: PathBuf, frame: u32 },
    #[error(
        "touches of {path}: the poses come every {step_s:.2} s; to see the tip stand still for {asked_s} s, at least 8 are needed in that \
         time: give a longer --dwell-s"
    )]
    TooSlow { path: PathBuf, step_s: f64, asked_s: f64 },
    #[error(
        "touches of {path}: the tip nowhere stands still for {asked_s} s below {most_mm_s} mm/s, in {poses} poses of {frames} frames{told}. \
         Touch again, or look at --dwell-s, --max-speed-mm-s and --tip"
    )]
    None {
        path: PathBuf,
        asked_s: f64,
        most_mm_s: f64,
        poses: usize,
        frames: usize,
        told: String,
    },
    #[error("touches of {path}: {found} points were touched, and --dwells says {asked}:{told}")]
    Count {
        path: PathBuf,
        found: usize,
        asked: usize,
        told: String,
    },
    #[error("--from-sequence: give --transform, from the marker on the pointer, or from its tip, to what stands still")]
    NoTransform,
}

/// What is asked.
pub(super) struct Asked<'a> {
    pub(super) path: &'a Path,
    pub(super) transform: &'a str,
    pub(super) name: &'a str,
    pub(super) still: Still,
    pub(super) most: MostMotion,
    pub(super) dwells: Option<usize>,
}

/// A touched point, when, and what it is called.
pub(super) struct Dwelt {
    pub(super) name: String,
    pub(super) from_s: f64,
    pub(super) to_s: f64,
    pub(super) touch: Touched,
}

/// The touched points, and the stretches that are none, in words.
pub(super) fn dwelt(asked: &Asked<'_>, tip: &Uncertain<Marker, Tool>) -> Result<(Vec<Dwelt>, Vec<String>), DwellError> {
    let (frames, samples) = samples(asked, tip)?;
    let (path, least_s) = (asked.path.to_owned(), asked.still.least_s);
    let window = window_s(&samples);
    if 2.0 * window > least_s {
        let (step_s, asked_s) = (window / 4.5, least_s);
        return Err(DwellError::TooSlow { path, step_s, asked_s });
    }
    let (mut found, mut other) = (Vec::new(), Vec::new());
    for stretch in stretches(&samples, asked.still) {
        let some = &samples[stretch];
        let [from_s, to_s] = [some[0].t_s, some[some.len() - 1].t_s];
        let name = format!("{}-{}", asked.name, found.len() + 1);
        match one(&name, some, tip, asked.most) {
            Ok(touch) => found.push(Dwelt {
                name,
                from_s,
                to_s,
                touch,
            }),
            Err(why) => other.push(format!("{from_s:.2} to {to_s:.2} s: {why}")),
        }
    }
    let told = || {
        let touches = found
            .iter()
            .map(|d| format!("{:.2} to {:.2} s: {}", d.from_s, d.to_s, d.name));
        let all = touches.chain(other.iter().cloned()).take(TOLD);
        all.map(|line| format!("\n  {line}")).collect::<String>()
    };
    match asked.dwells {
        _ if found.is_empty() => Err(DwellError::None {
            path,
            asked_s: least_s,
            most_mm_s: asked.still.most_mm_s,
            poses: samples.len(),
            frames,
            told: told(),
        }),
        Some(dwells) if dwells != found.len() => Err(DwellError::Count {
            path,
            found: found.len(),
            asked: dwells,
            told: told(),
        }),
        _ => Ok((found, other)),
    }
}

/// The poses that are measurements: not a repeat of the one before, and later than it.
fn samples(asked: &Asked<'_>, tip: &Uncertain<Marker, Tool>) -> Result<(usize, Vec<Sample>), DwellError> {
    let at = tip.transform() * Point::<Tool>::new(0.0, 0.0, 0.0);
    let frames = timed(asked.path, asked.transform)?;
    let mut samples: Vec<Sample> = Vec::new();
    for (frame, Timed { number, t_s, pose }) in frames.iter().enumerate() {
        let t_s = t_s.ok_or_else(|| DwellError::NoTime {
            path: asked.path.to_owned(),
            frame: *number,
        })?;
        let last = samples.last();
        // A tracker that has nothing new, or stands, sends what it sent.
        let new = |pose: &&Rigid<Tracker, Marker>| last.is_none_or(|l| l.pose != **pose && l.t_s < t_s);
        if let Some(pose) = pose.as_ref().filter(new) {
            samples.push(Sample {
                frame,
                t_s,
                tip: *pose * at,
                pose: *pose,
            });
        }
    }
    Ok((frames.len(), samples))
}

/// The touch of one stretch. A sequence says nothing of the noise of its poses: that is how they differ from one to the next; and the
/// drift that is left is in the error.
fn one(name: &str, some: &[Sample], tip: &Uncertain<Marker, Tool>, most: MostMotion) -> Result<Touched, LiveError> {
    let steps = some.windows(2).map(|w| w[0].tip.distance(w[1].tip).powi(2));
    let variance = steps.sum::<f64>() / (6.0 * (some.len() - 1).max(1) as f64);
    let mut covariance = Matrix6::zeros();
    (3..6).for_each(|k| covariance[(k, k)] = variance);
    let poses: Result<Vec<_>, _> = some
        .iter()
        .map(|s| Uncertain::from_covariance_about(s.pose * Point::<Marker>::new(0.0, 0.0, 0.0), s.pose, covariance))
        .collect();
    let mut heard = Listened::default();
    heard.frames = some[some.len() - 1].frame - some[0].frame + 1;
    heard.poses = poses?;
    let seconds = some[some.len() - 1].t_s - some[0].t_s;
    let mut touch = touched(name, &heard, tip, most, seconds)?;
    if touch.rms_mm > most.0 {
        return Err(LiveError::Moved {
            name: name.to_owned(),
            moved_mm: touch.rms_mm,
            most_mm: most.0,
        });
    }
    let drift = (DRIFT * touch.moved_mm).powi(2) / 3.0;
    let covariance = touch.place.covariance() + Matrix3::identity() * drift;
    touch.place = geometry::UncertainPoint::new(touch.place.point(), covariance)?;
    Ok(touch)
}

/// The tip that a transform from the tip itself has: its origin, whose calibration is the recording's and not known here.
pub(super) fn own_tip() -> Result<Uncertain<Marker, Tool>, LiveError> {
    let at = Rigid::from_parts(Rigid::<Marker, Tool>::identity().rotation(), Vector::new(0.0, 0.0, 0.0));
    Ok(Uncertain::new(at, Matrix6::zeros())?)
}

#[cfg(test)]
#[path = "sequence_tests.rs"]
mod tests;
