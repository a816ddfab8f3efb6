//! What a calibration found.

use geometry::motion::Pose;
use geometry::{Image, Point, Probe, Rigid, Uncertain, UncertainPoint, Vector};
use nalgebra::{Matrix3, SMatrix, Vector3};

use super::covariance;
use crate::error::ProbeError;
use crate::free::{self, Free};
use crate::known::KnownImage;
use crate::solve::{Ended, Solver, State};

/// The image in the probe's marker.
#[derive(Debug, Clone)]
pub struct ProbeCalibration {
    /// Place of the image, mm from the centre of its first pixel, with the covariance of its error in the convention of
    /// [`geometry::uncertain`]; that of the pixels' sizes is in [`Self::covariance`].
    pub probe_from_image: Uncertain<Probe, Image>,
    /// Size of a pixel along a row and along a column, mm.
    pub pixel_mm: [f64; 2],
    /// Covariance of (w, v) in `Probe` about its origin, and of the logarithms of both sizes: rad, mm, 1, 1.
    pub covariance: SMatrix<f64, 8, 8>,
    /// Lag of the poses, where it was free.
    pub lag: Option<Lag>,
    /// How the phantom moved within its error, where it was free.
    pub phantom: Option<Moved>,
    /// Linear error of the tracker's shifts by rows, in the reference's axes, where it was free.
    pub tracker: Option<[[f64; 3]; 3]>,
    /// Play found of each wire: of its front in two directions across it, then of its back, mm.
    pub play_mm: Vec<[f64; 4]>,
    /// Normal of the wall in the reference and its distance from the origin there, mm, where a wall was seen.
    pub wall: Option<([f64; 3], f64)>,
    /// Each point, in the order of frames and points.
    pub points: Vec<PointResult>,
    /// Root mean square distance of the points with a weight above 0.5, mm.
    pub rms_mm: f64,
    /// Mean distance of these, mm: the measure that PLUS publishes.
    pub mean_mm: f64,
    /// Root of the mean square of residuals over what the noise told makes of them; where above 1 the covariance has
    /// grown with its
    /// square.
    pub noise_ratio: f64,
    /// By how much more neighbouring frames vary together than independent ones would; the covariance has grown with
    /// it.
    pub frame_correlation: f64,
    /// Share of the points that have a weight above 0.5.
    pub share_kept: f64,
    /// Frames with points.
    pub frames: usize,
    /// Whether the last round of weights changed nothing any more.
    pub is_settled: bool,
    /// Least and largest column and row at which points were seen, pixels.
    pub seen_px: [[f64; 2]; 2],
    pub(crate) inside: Inside,
}

/// How the fit left it: frames of the same phantom are judged from here.
#[derive(Debug, Clone)]
pub(crate) struct Inside {
    pub(crate) state: State,
    pub(crate) middle: [f64; 2],
    pub(crate) centre: Vector3<f64>,
    /// Covariance of the eight about the middle of the image.
    pub(crate) about_middle: SMatrix<f64, 8, 8>,
    radius_mm: f64,
    cost: f64,
}

/// A lag of the poses: the pose that goes with an image of time t is the one of time t + lag.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lag {
    /// s.
    pub lag_s: f64,
    /// Its standard deviation, s.
    pub sigma_s: f64,
}

/// A motion of the phantom after its given place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moved {
    /// Rotation vector, rad, in the phantom's axes about its origin.
    pub turn: [f64; 3],
    /// mm.
    pub shift_mm: [f64; 3],
    /// Its square in its given covariance over 6: some 1 where that covariance is right, and 16 where it moved by
    /// four deviations.
    pub ratio: f64,
}

/// One point's part.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointResult {
    /// Number of its frame.
    pub frame: u32,
    /// Its wire, from 0.
    pub wire: usize,
    /// Distance from its wire or wall, mm.
    pub distance_mm: f64,
    /// What it counts, 0 to 1.
    pub weight: f64,
}

pub(super) fn of(solver: &Solver<'_>, ended: Ended) -> Result<ProbeCalibration, ProbeError> {
    let data = solver.data;
    let poses = data.poses(ended.state.lag)?;
    let seen_px = seen(solver);
    let size = ended.state.size;
    let half = [0, 1].map(|k| 0.5 * (seen_px[1][k] - seen_px[0][k]) * size[k]);
    let radius_mm = half[0].hypot(half[1]).max(1.0);
    let found = covariance::of(solver, &ended, &poses)?;
    let mut points = Vec::with_capacity(ended.weights.len());
    let mut weights = ended.weights.iter();
    for (i, frame) in data.frames.iter().enumerate() {
        for (mark, weight) in frame.marks.iter().zip(&mut weights) {
            points.push(PointResult {
                frame: frame.number,
                wire: mark.wire,
                distance_mm: solver.row(&ended.state, &poses, i, mark).residual.norm(),
                weight: *weight,
            });
        }
    }
    let kept: Vec<f64> = points
        .iter()
        .filter(|p| p.weight > 0.5)
        .map(|p| p.distance_mm)
        .collect();
    let count = kept.len().max(1) as f64;
    let about_middle: SMatrix<f64, 8, 8> = found.all.fixed_view::<8, 8>(0, 0).into_owned();
    let (probe_from_image, covariance) = at_origin(&ended.state, data.middle, &about_middle)?;
    let cost = solver
        .squares(&ended.state, &poses)
        .iter()
        .map(|s| bounded(s / ended.scale))
        .sum();
    let layout = solver.layout;
    let state = &ended.state;
    Ok(ProbeCalibration {
        probe_from_image,
        pixel_mm: size,
        covariance,
        lag: layout.lag.map(|at| Lag {
            lag_s: state.lag,
            sigma_s: found.all[(at, at)].max(0.0).sqrt(),
        }),
        phantom: layout.phantom.map(|_| moved(solver, state)),
        tracker: layout
            .tracker
            .map(|_| [0, 1, 2].map(|i| [0, 1, 2].map(|j| state.tracker[(i, j)]))),
        play_mm: if layout.play.is_some() {
            state.play.clone()
        } else {
            Vec::new()
        },
        wall: layout.wall.map(|_| (state.wall.normal.into(), state.wall.distance)),
        rms_mm: (kept.iter().map(|d| d * d).sum::<f64>() / count).sqrt(),
        mean_mm: kept.iter().sum::<f64>() / count,
        noise_ratio: found.noise_ratio,
        frame_correlation: found.frame_correlation,
        share_kept: kept.len() as f64 / points.len().max(1) as f64,
        frames: data.frames.len(),
        is_settled: ended.is_settled,
        seen_px,
        points,
        inside: Inside {
            middle: data.middle,
            centre: data.centre,
            about_middle,
            radius_mm,
            cost,
            state: ended.state,
        },
    })
}

/// Geman and McClure's cost: bounded, so that gross errors of one start do not hide what another explains.
fn bounded(square: f64) -> f64 {
    9.0 * square / (9.0 + square)
}

fn moved(solver: &Solver<'_>, state: &State) -> Moved {
    let m = &state.phantom;
    Moved {
        turn: [m[0], m[1], m[2]],
        shift_mm: [m[3], m[4], m[5]],
        ratio: m.dot(&(solver.phantom_prior * m)) / 6.0,
    }
}

fn seen(solver: &Solver<'_>) -> [[f64; 2]; 2] {
    let mut seen = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
    for mark in solver.data.frames.iter().flat_map(|f| &f.marks) {
        let [low, high] = &mut seen;
        for ((low, high), px) in low.iter_mut().zip(high).zip(mark.px) {
            (*low, *high) = (low.min(px), high.max(px));
        }
    }
    seen
}

/// From the middle of the image to its first pixel, and to the convention of [`geometry::uncertain`].
fn at_origin(
    state: &State,
    middle: [f64; 2],
    about: &SMatrix<f64, 8, 8>,
) -> Result<(Uncertain<Probe, Image>, SMatrix<f64, 8, 8>), ProbeError> {
    let Pose { turn, shift } = state.image;
    let axes: Matrix3<f64> = turn.matrix().into();
    let back = axes * Vector3::new(middle[0] * state.size[0], middle[1] * state.size[1], 0.0);
    let t = shift - back;
    // v = v_c - w x c, and a size that grows moves the first pixel away from the middle, which the fit holds.
    let mut carry = SMatrix::<f64, 8, 8>::identity();
    carry.fixed_view_mut::<3, 3>(3, 0).copy_from(&shift.cross_matrix());
    for (k, (from, size)) in middle.into_iter().zip(state.size).enumerate() {
        let by = -axes.column(k) * from * size;
        carry.fixed_view_mut::<3, 1>(3, 6 + k).copy_from(&by);
    }
    let covariance = carry * about * carry.transpose();
    let covariance = (covariance + covariance.transpose()) * 0.5;
    let transform = Rigid::from_parts(turn, Vector::new(t.x, t.y, t.z));
    let pose = covariance.fixed_view::<6, 6>(0, 0).into_owned();
    let uncertain = Uncertain::new(transform, pose).map_err(|error| ProbeError::Open {
        what: format!("their covariance is none: {error}"),
    })?;
    Ok((uncertain, covariance))
}

impl ProbeCalibration {
    /// The place of a pixel in the probe's marker, with the covariance of the calibration's error there, mm^2.
    pub fn place(&self, px: [f64; 2]) -> UncertainPoint<Probe> {
        let transform = self.probe_from_image.transform();
        let local = Point::<Image>::new(px[0] * self.pixel_mm[0], px[1] * self.pixel_mm[1], 0.0);
        let place = transform * local;
        let axes: Matrix3<f64> = transform.rotation().matrix().into();
        let mut by = SMatrix::<f64, 3, 8>::zeros();
        by.fixed_view_mut::<3, 3>(0, 0)
            .copy_from(&-Vector3::from(place.mm()).cross_matrix());
        by.fixed_view_mut::<3, 3>(0, 3).copy_from(&Matrix3::identity());
        for (k, mm) in [local.mm()[0], local.mm()[1]].into_iter().enumerate() {
            by.fixed_view_mut::<3, 1>(0, 6 + k).copy_from(&(axes.column(k) * mm));
        }
        let covariance = by * self.covariance * by.transpose();
        UncertainPoint::new(place, (covariance + covariance.transpose()) * 0.5)
            // A covariance carried through is one: rounding alone can fail it, and then the place alone would
            // promise too much.
            .unwrap_or_else(|_| {
                let radius = Matrix3::identity() * covariance.trace().abs();
                UncertainPoint::new(place, radius).unwrap_or_else(|_| UncertainPoint::from(place))
            })
    }

    /// What a check takes of it, and a file holds.
    pub fn known(&self) -> KnownImage {
        KnownImage {
            probe_from_image: self.probe_from_image.transform(),
            pixel_mm: self.pixel_mm,
            covariance: self.covariance,
            lag_s: self.lag.map_or(0.0, |lag| lag.lag_s),
            tracker: self.tracker.map(|rows| (rows, self.inside.centre.into())),
        }
    }

    /// The largest root mean square error of the calibration over the four corners of where points were seen, mm.
    pub fn worst_mm(&self) -> f64 {
        let [low, high] = self.seen_px;
        let corners = [low, [high[0], low[1]], [low[0], high[1]], high];
        let error = |px: [f64; 2]| self.place(px).covariance().trace().max(0.0).sqrt();
        corners.into_iter().map(error).fold(0.0, f64::max)
    }

    /// Motions of the image that the frames hold least, by what they do over the part of it in which points were
    /// seen; the largest first.
    pub fn free(&self) -> Vec<Free> {
        let inside = &self.inside;
        free::of(&inside.about_middle, &inside.state.image.matrix(), inside.radius_mm)
    }

    /// How well the points are explained, to choose between minima: more is better.
    pub(super) fn merit(&self) -> f64 {
        -self.inside.cost
    }
}
