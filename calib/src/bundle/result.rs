//! A calibrated marker with all that is known of its error.

use geometry::rotation::Rotation;
use geometry::{Marker, Point, Rigid, Tracker, Vector};
use nalgebra::{DMatrix, Matrix3, Vector3};

use super::choice::Adjusted;
use super::schur::{condition, covariance};
use super::views::{Data, Sighting};
use super::vote::Vote;
use super::{Gauge, Refused};
use crate::gate::Reached;

/// The residuals of one emitter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EmitterResiduals {
    /// Sightings that took part.
    pub sightings: usize,
    /// Root mean square length of their residuals, mm: divides by the sightings.
    pub rms_mm: f64,
    /// The longest, mm.
    pub worst_mm: f64,
}

/// A sighting that was left out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rejected {
    /// Its view.
    pub view: usize,
    /// Its emitter.
    pub emitter: usize,
    /// Its distance from where the others put it, mm; `None` where its view has no pose without it.
    pub residual_mm: Option<f64>,
}

/// A marker's emitters with their covariance, and where the marker was in each view.
#[derive(Debug, Clone)]
pub struct Bundle {
    /// The emitters in the marker's frame; `None` for those that were left out as seen too seldom.
    pub emitters: Vec<Option<Point<Marker>>>,
    /// `tracker_from_marker` of each view; `None` for views that give no pose.
    pub poses: Vec<Option<Rigid<Tracker, Marker>>>,
    /// The residuals of each emitter; `None` as in `emitters`.
    pub residuals: Vec<Option<EmitterResiduals>>,
    /// Root mean square length of all residuals, mm: divides by the sightings.
    pub rms_mm: f64,
    /// The residuals' size in units of the noise given: the root of chi-square over its degrees of freedom. About 1
    /// where the noise given is right; where it is more, the covariance has its square in it. NaN without freedom.
    pub noise_ratio: f64,
    /// Standard deviation per axis that explains the residuals, mm: `noise_ratio` times that given.
    pub sigma_mm: f64,
    /// `3 sightings - 6 views - (3 emitters - 6)`.
    pub degrees_of_freedom: usize,
    /// Ratio of the largest deviation of any combination of places to the least.
    pub condition: f64,
    /// Sightings that were left out, by view.
    pub rejected: Vec<Rejected>,
    /// Steps of the adjustment.
    pub steps: usize,
    /// Where the adjustment began: the places that the chained views give, in the axes of the marker's frame.
    pub chained: Vec<Option<Point<Marker>>>,
    pub(super) columns: Vec<Option<usize>>,
    pub(super) covariance: DMatrix<f64>,
}

impl Bundle {
    /// Covariance of the places of two emitters, mm^2: `E[e_i e_j^T]`, in the axes of the marker's frame, with the noise
    /// given, or that which residuals show where it is more. `None` where one was left out.
    ///
    /// `e` is the error after the marker was laid best on the true one, all emitters alike: the frame itself is a
    /// definition and has no error.
    pub fn covariance_between(&self, i: usize, j: usize) -> Option<Matrix3<f64>> {
        let (i, j) = ((*self.columns.get(i)?)?, (*self.columns.get(j)?)?);
        Some(self.covariance.fixed_view::<3, 3>(3 * i, 3 * j).into_owned())
    }

    /// Covariance of the place of an emitter, mm^2; see [`Bundle::covariance_between`].
    pub fn covariance_of(&self, emitter: usize) -> Option<Matrix3<f64>> {
        self.covariance_between(emitter, emitter)
    }

    /// The covariance of all emitters kept, three rows each in their order, mm^2; see [`Bundle::covariance_between`].
    /// Singular: the six motions of the whole marker have no variance.
    pub const fn covariance(&self) -> &DMatrix<f64> {
        &self.covariance
    }

    /// Root mean square distance of the emitters from their true places to be expected after the marker was laid best
    /// on the true one, mm; see [`Bundle::covariance_between`].
    pub fn predicted_rms_mm(&self) -> f64 {
        (3.0 * self.covariance.trace() / self.covariance.nrows() as f64).sqrt()
    }

    /// What [`crate::gate::Gates`] judge.
    pub fn reached(&self) -> Reached {
        let count: usize = self.residuals.iter().flatten().map(|r| r.sightings).sum();
        Reached {
            rms_mm: Some(self.rms_mm),
            condition: Some(self.condition),
            noise_ratio: Some(self.noise_ratio),
            rejected: Some(self.rejected.len() as f64 / (count + self.rejected.len()) as f64),
            count: Some(count),
            ..Reached::default()
        }
    }

    pub(super) fn of(
        adjusted: &Adjusted,
        data: &Data,
        vote: &Vote,
        views: usize,
        gauge: &Gauge,
    ) -> Result<Self, Refused> {
        let (settled, problem) = (&adjusted.settled, &adjusted.problem);
        let name = |column: usize| adjusted.names[column];
        let condition = condition(&settled.matrix, &settled.gauge, name)?;
        // In the gauge of the body itself; only the choice of a frame for it follows.
        let covariance = covariance(&settled.matrix, &settled.gauge).ok_or(Refused::Weak {
            emitter: 0,
            condition,
            allowed: condition,
        })?;
        let body: Vec<Option<Vector3<f64>>> = problem
            .columns
            .iter()
            .map(|c| c.map(|c| settled.state.places[c]))
            .collect();
        let marker_from_body = gauge.choose(&body)?;
        let sightings: usize = problem.stations.iter().map(|s| s.sightings.len()).sum();
        // The six motions of the whole marker are no unknowns: they are the gauge.
        let unknowns = 6 * problem.stations.len() + 3 * settled.state.places.len() - 6;
        let degrees_of_freedom = (3 * sightings).saturating_sub(unknowns);
        // Without freedom residuals are zero whatever the noise, and say nothing of it.
        let free = (degrees_of_freedom > 0).then_some(degrees_of_freedom as f64);
        let noise_ratio = free.map_or(f64::NAN, |n| (problem.cost(&settled.state) / n).sqrt());
        let lengths = lengths(adjusted);
        let total = lengths.iter().flatten().map(|x| x * x).sum::<f64>();
        Ok(Self {
            emitters: places(&body, &marker_from_body),
            poses: poses(adjusted, views, &marker_from_body),
            residuals: lengths.iter().map(|list| summary(list)).collect(),
            rms_mm: (total / sightings as f64).sqrt(),
            noise_ratio,
            sigma_mm: noise_ratio * data.sigma_mm,
            degrees_of_freedom,
            condition,
            rejected: rejected(adjusted, data),
            steps: settled.steps,
            chained: places(&vote.places, &laid_on(&vote.places, &body, &marker_from_body)),
            columns: problem.columns.clone(),
            // Some hundred residuals tell the noise better than whoever gave it; without freedom there is only that.
            covariance: turned(&covariance, marker_from_body.rotation()) * noise_ratio.max(1.0).powi(2),
        })
    }
}

fn point<F>(p: &Vector3<f64>) -> Point<F> {
    Point::new(p.x, p.y, p.z)
}

fn places(body: &[Option<Vector3<f64>>], by: &Rigid<Marker, Tracker>) -> Vec<Option<Point<Marker>>> {
    body.iter().map(|p| p.map(|p| *by * point(&p))).collect()
}

/// The transform of the voted places: their axes are those of the adjustment but for the mean that was taken off.
fn laid_on(
    voted: &[Option<Vector3<f64>>],
    body: &[Option<Vector3<f64>>],
    by: &Rigid<Marker, Tracker>,
) -> Rigid<Marker, Tracker> {
    let both: Vec<Vector3<f64>> = voted.iter().zip(body).filter_map(|(v, b)| b.and(*v)).collect();
    let mean = both.iter().sum::<Vector3<f64>>() / both.len() as f64;
    let back = Rigid::from_parts(Rotation::IDENTITY, Vector::new(-mean.x, -mean.y, -mean.z));
    *by * back
}

fn poses(adjusted: &Adjusted, views: usize, by: &Rigid<Marker, Tracker>) -> Vec<Option<Rigid<Tracker, Marker>>> {
    let mut poses = vec![None; views];
    let both = adjusted.problem.stations.iter().zip(&adjusted.settled.state.poses);
    for (station, pose) in both {
        // Poses were fitted about the view's centre; a point of the marker goes by the body's axes to the localizer's.
        let shift = station.centre + pose.shift;
        let from_body: Rigid<Tracker, Tracker> = Rigid::from_parts(pose.turn, Vector::new(shift.x, shift.y, shift.z));
        poses[station.view] = Some(from_body * by.inverse());
    }
    poses
}

/// Lengths of the residuals by emitter, mm.
fn lengths(adjusted: &Adjusted) -> Vec<Vec<f64>> {
    let (problem, state) = (&adjusted.problem, &adjusted.settled.state);
    let mut lengths = vec![Vec::new(); problem.columns.len()];
    for (station, pose) in problem.stations.iter().zip(&state.poses) {
        let turn = pose.matrix();
        for s in &station.sightings {
            lengths[s.emitter].push(problem.residual(s, pose, &turn, state).norm());
        }
    }
    lengths
}

fn summary(lengths: &[f64]) -> Option<EmitterResiduals> {
    let squares = lengths.iter().map(|x| x * x).sum::<f64>();
    (!lengths.is_empty()).then(|| EmitterResiduals {
        sightings: lengths.len(),
        rms_mm: (squares / lengths.len() as f64).sqrt(),
        worst_mm: lengths.iter().copied().fold(0.0, f64::max),
    })
}

fn rejected(adjusted: &Adjusted, data: &Data) -> Vec<Rejected> {
    let (problem, state) = (&adjusted.problem, &adjusted.settled.state);
    let mut list = Vec::new();
    for (i, (station, kept)) in data.stations.iter().zip(&adjusted.kept).enumerate() {
        let pose = adjusted.origin.iter().position(|o| *o == i).map(|p| &state.poses[p]);
        let off = |s: &Sighting| {
            let pose = pose.filter(|_| problem.columns[s.emitter].is_some())?;
            Some(problem.residual(s, pose, &pose.matrix(), state).norm())
        };
        let out = station.sightings.iter().zip(kept).filter(|(_, kept)| !**kept);
        list.extend(out.map(|(s, _)| Rejected {
            view: station.view,
            emitter: s.emitter,
            residual_mm: off(s),
        }));
    }
    list
}

/// Every 3 x 3 block turned to other axes.
fn turned(covariance: &DMatrix<f64>, rotation: Rotation) -> DMatrix<f64> {
    let r = Matrix3::from(rotation.matrix());
    let mut turned = covariance.clone();
    for i in 0..covariance.nrows() / 3 {
        for j in 0..covariance.ncols() / 3 {
            let mut block = turned.fixed_view_mut::<3, 3>(3 * i, 3 * j);
            // E[(R e_i) (R e_j)^T] = R E[e_i e_j^T] R^T.
            let new = r * block.clone_owned() * r.transpose();
            block.copy_from(&new);
        }
    }
    turned
}
