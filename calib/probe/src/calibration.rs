//! A calibration of the probe's image with all that is known of its error.

mod covariance;
mod result;

use geometry::{Phantom, Probe, Reference, Uncertain};
use nalgebra::Matrix6;

use crate::error::ProbeError;
use crate::linear;
use crate::seen::{Seen, checked};
use crate::solve::{Data, Layout, Options, Solver, State};
use crate::target::Wires;
use crate::track::Track;

pub use result::{Lag, Moved, PointResult, ProbeCalibration};

/// The image's place in the probe's marker, from points of a phantom's wires in tracked images.
///
/// `reference_from_phantom` is the place of the phantom with the covariance of its error; that error is one for all
/// frames, so more
/// frames do not make it less. Where it is not 0, the phantom may move within it. With a `track` the frames' poses
/// are taken from it
/// at their times, else each frame's own; the lag is found where [`crate::Priors::lag_s`] is above 0.
///
/// # Errors
/// [`ProbeError`].
pub fn calibrate(
    frames: &[Seen],
    wires: &Wires,
    reference_from_phantom: &Uncertain<Reference, Phantom>,
    track: Option<&Track<Reference, Probe>>,
    options: &Options,
) -> Result<ProbeCalibration, ProbeError> {
    options.check()?;
    checked(frames, wires.lines.len())?;
    timed(frames, track, options)?;
    let placed = reference_from_phantom.inverse();
    let transform = placed.transform();
    let given = (transform.rotation().matrix().into(), transform.translation_mm().into());
    let data = Data::new(frames, track, &wires.lines, given);
    let covariance = placed.covariance();
    let is_free = covariance.amax() > 0.0;
    let solver = Solver {
        data: &data,
        options,
        layout: Layout::new(&options.priors, is_free, wires.lines.len(), false),
        phantom_prior: information(&covariance),
    };
    let start = linear::by_wires(&data)?;
    finish(&solver, start)
}

/// The same from a flat wall that stands still in the reference and is seen as a line in each image: at least two
/// points of a frame,
/// better more. Where the wall is, is found with it. `wire` of each mark is 0.
///
/// # Errors
/// [`ProbeError`].
pub fn calibrate_by_wall(
    frames: &[Seen],
    track: Option<&Track<Reference, Probe>>,
    options: &Options,
) -> Result<ProbeCalibration, ProbeError> {
    options.check()?;
    checked(frames, 1)?;
    timed(frames, track, options)?;
    let data = Data::new(
        frames,
        track,
        &[],
        (nalgebra::Matrix3::identity(), nalgebra::Vector3::zeros()),
    );
    let solver = Solver {
        data: &data,
        options,
        layout: Layout::new(&options.priors, false, 0, true),
        phantom_prior: Matrix6::zeros(),
    };
    let starts = linear::by_wall(&data)?;
    best(&solver, starts)
}

/// The lowest of the minima below some starts.
fn best(solver: &Solver<'_>, starts: Vec<State>) -> Result<ProbeCalibration, ProbeError> {
    let mut found: Option<ProbeCalibration> = None;
    let mut failed = ProbeError::Nowhere;
    for start in starts {
        match finish(solver, start) {
            Ok(next) if found.as_ref().is_none_or(|best| next.merit() > best.merit()) => found = Some(next),
            Ok(_) => {}
            Err(error) => failed = error,
        }
    }
    found.ok_or(failed)
}

fn finish(solver: &Solver<'_>, mut start: State) -> Result<ProbeCalibration, ProbeError> {
    if let Some((sizes, _)) = solver.options.priors.pixel_mm {
        start.size = sizes;
    }
    let ended = solver.run(start)?;
    let [u, v] = ended.state.size;
    if !(0.005..=2.0).contains(&u) || !(0.005..=2.0).contains(&v) {
        return Err(ProbeError::PixelSize { u, v });
    }
    result::of(solver, ended)
}

/// A lag moves along a track, and every frame needs a time on it.
fn timed(frames: &[Seen], track: Option<&Track<Reference, Probe>>, options: &Options) -> Result<(), ProbeError> {
    let has_times = frames.iter().all(|f| f.t_s.is_some() || f.marks.is_empty());
    if options.priors.lag_s > 0.0 && (track.is_none() || !has_times) {
        return Err(ProbeError::NoTrack);
    }
    match track {
        Some(track) if options.priors.lag_s > 0.0 && !track.is_mean() => Err(ProbeError::NoWindow),
        _ => Ok(()),
    }
}

/// The inverse of a covariance; directions without any error are held to a millionth.
fn information(covariance: &Matrix6<f64>) -> Matrix6<f64> {
    let eigen = covariance.symmetric_eigen();
    let inverse = eigen.eigenvalues.map(|v| 1.0 / v.max(1e-12));
    eigen.eigenvectors * Matrix6::from_diagonal(&inverse) * eigen.eigenvectors.transpose()
}
