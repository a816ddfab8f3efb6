//! How far points of images lie from wires that the calibration has not seen.

use geometry::{Phantom, Probe, Reference, Uncertain};
use nalgebra::{SMatrix, Vector3};

use crate::calibration::calibrate;
use crate::error::ProbeError;
use crate::known::KnownImage;
use crate::seen::{Seen, marked};
use crate::solve::{Data, Layout, Options, Solver, State};
use crate::target::Wires;
use crate::track::Track;

/// Points of a check.
#[derive(Debug, Clone, PartialEq)]
pub struct Checked {
    /// Distance of each point from its wire, mm, in the order of frames and points.
    pub distances_mm: Vec<f64>,
    /// Signed residual of each, in two directions across its wire, mm.
    pub residuals_mm: Vec<[f64; 2]>,
    /// Mean of the distances, mm.
    pub mean_mm: f64,
    /// Their root mean square, mm.
    pub rms_mm: f64,
    /// The largest, mm.
    pub most_mm: f64,
    /// Root of the mean square of the residuals over what noise, pose and calibration say of them together: some 1
    /// where these are
    /// right.
    pub ratio: f64,
    /// Mean residual of all points that belong to one wire, the largest over the wires, mm: what stays where noise
    /// averages out.
    pub bias_mm: f64,
}

/// Judges frames by a calibration: the distances of their points from the wires, nothing being fitted and no point
/// left out. The wires may
/// be others than those of the calibration, in another place: an independent wire, or two that cross
/// ([`Wires::to_check`]).
///
/// # Errors
/// [`ProbeError`] of the frames.
pub fn check(
    image: &KnownImage,
    frames: &[Seen],
    wires: &Wires,
    reference_from_phantom: &Uncertain<Reference, Phantom>,
    track: Option<&Track<Reference, Probe>>,
    options: &Options,
) -> Result<Checked, ProbeError> {
    let judge = Judge {
        state: &image.state(),
        about: &image.about_first(),
        middle: [0.0; 2],
        centre: image.tracker.map_or([0.0; 3], |(_, about)| about).into(),
    };
    judge.judged(frames, wires, reference_from_phantom, track, options)
}

/// What frames are judged by.
struct Judge<'a> {
    state: &'a State,
    /// Covariance of the eight about `middle`.
    about: &'a SMatrix<f64, 8, 8>,
    middle: [f64; 2],
    centre: Vector3<f64>,
}

impl Judge<'_> {
    fn judged(
        &self,
        frames: &[Seen],
        wires: &Wires,
        reference_from_phantom: &Uncertain<Reference, Phantom>,
        track: Option<&Track<Reference, Probe>>,
        options: &Options,
    ) -> Result<Checked, ProbeError> {
        options.check()?;
        frames.iter().try_for_each(|frame| marked(frame, wires.all().len()))?;
        let placed = reference_from_phantom.inverse();
        let transform = placed.transform();
        let given = (transform.rotation().matrix().into(), transform.translation_mm().into());
        let mut data = Data::new(frames, track, &wires.lines, given);
        if data.frames.is_empty() {
            return Err(ProbeError::TooFewFrames { found: 0, needed: 1 });
        }
        (data.middle, data.centre) = (self.middle, self.centre);
        let solver = Solver {
            data: &data,
            options,
            layout: Layout::new(
                &options.priors,
                placed.covariance().amax() > 0.0,
                wires.all().len(),
                false,
            ),
            phantom_prior: nalgebra::Matrix6::zeros(),
        };
        let poses = data.poses(self.state.lag)?;
        let (mut residuals, mut squares) = (Vec::new(), 0.0);
        let mut by_wire = vec![(nalgebra::Vector2::zeros(), 0.0); wires.all().len()];
        for (i, frame) in data.frames.iter().enumerate() {
            for mark in &frame.marks {
                let row = solver.row(self.state, &poses, i, mark);
                residuals.push([row.residual.x, row.residual.y]);
                squares += solver.square(self.about, &row, &placed.covariance());
                by_wire[mark.wire].0 += row.residual;
                by_wire[mark.wire].1 += 1.0;
            }
        }
        let distances_mm: Vec<f64> = residuals.iter().map(|r| r[0].hypot(r[1])).collect();
        let count = distances_mm.len() as f64;
        Ok(Checked {
            mean_mm: distances_mm.iter().sum::<f64>() / count,
            rms_mm: (distances_mm.iter().map(|d| d * d).sum::<f64>() / count).sqrt(),
            most_mm: distances_mm.iter().copied().fold(0.0, f64::max),
            ratio: (squares / (2.0 * count)).sqrt(),
            bias_mm: by_wire
                .iter()
                .filter(|w| w.1 > 0.0)
                .map(|(r, n)| r.norm() / n)
                .fold(0.0, f64::max),
            distances_mm,
            residuals_mm: residuals,
        })
    }
}

/// A calibration of one half judged on the other, both ways.
#[derive(Debug, Clone, PartialEq)]
pub struct CrossValidated {
    /// Mean distance of the points of the half that was judged, mm: of the second by the first, of the first by the
    /// second.
    pub mean_mm: [f64; 2],
    /// Mean distance of the same half's own points in its fit, mm.
    pub own_mm: [f64; 2],
}

/// Fits one half of the frames and judges the other, both ways: the phantom's motion and its wires' play are those
/// of the fit. `is_first` says which half a frame of this index is of.
///
/// # Errors
/// [`ProbeError`] of a half.
pub fn cross_validate(
    frames: &[Seen],
    wires: &Wires,
    reference_from_phantom: &Uncertain<Reference, Phantom>,
    track: Option<&Track<Reference, Probe>>,
    options: &Options,
    is_first: impl Fn(usize) -> bool,
) -> Result<CrossValidated, ProbeError> {
    let half = |first: bool| -> Vec<Seen> {
        let of = frames.iter().enumerate().filter(|(i, _)| is_first(*i) == first);
        of.map(|(_, frame)| frame.clone()).collect()
    };
    let halves = [half(true), half(false)];
    let (mut mean_mm, mut own_mm) = ([0.0; 2], [0.0; 2]);
    for k in 0..2 {
        let found = calibrate(&halves[k], wires, reference_from_phantom, track, options)?;
        own_mm[k] = found.mean_mm;
        let judge = Judge {
            state: &found.inside.state,
            about: &found.inside.about_middle,
            middle: found.inside.middle,
            centre: found.inside.centre,
        };
        let judged = judge.judged(&halves[1 - k], wires, reference_from_phantom, track, options)?;
        mean_mm[k] = judged.mean_mm;
    }
    Ok(CrossValidated { mean_mm, own_mm })
}
