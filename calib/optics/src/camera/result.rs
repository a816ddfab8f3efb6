//! A calibrated camera with all that is known of its error.

use geometry::motion::Pose;
use geometry::{Rigid, Vector};
use nalgebra::{DMatrix, Matrix3, Matrix6, SMatrix, Vector2};

use super::apart::view_ratio;
use super::choice::Chosen;
use super::coverage::Coverage;
use super::error::CameraRefused;
use super::model::{Camera, CameraFrame, GridFrame, PARAMETERS};
use super::normal::{HELD, Reduced, Square, loosest};
use super::paraboloid::SHARED;
use super::plate::Plate;
use super::predict::predicted;
use super::state::State;
use super::view::{ImageSize, Options, Station, View};

/// A focal length or a principal point is free where its deviation is beyond this share of the focal length.
const MAX_FOCAL_DEVIATION: f64 = 0.5;

/// What was left of one disc.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Residual {
    /// Seen less predicted, pixels.
    pub off: Vector2<f64>,
    /// Whether the disc took part.
    pub used: bool,
}

/// One view of a calibrated camera.
#[derive(Debug, Clone)]
pub struct Posed {
    /// The grid's place: `camera_from_grid`.
    pub pose: Rigid<CameraFrame, GridFrame>,
    /// Covariance of (rotation vector, translation) in the camera's frame, radians and mm: the true pose is
    /// `p -> exp(w) (R p + t) + v`.
    pub covariance: Matrix6<f64>,
    /// Each disc's residual, in the order of the view.
    pub residuals: Vec<Residual>,
    /// Root mean square length of the residuals of the discs that took part, pixels: divides by the discs.
    pub rms_px: f64,
    /// The angle between the grid's normal and the camera's axis, radians.
    pub tilt_rad: f64,
}

/// A calibrated camera.
#[derive(Debug, Clone)]
pub struct Calibrated {
    /// The camera.
    pub camera: Camera,
    /// Covariance of its numbers in the order of [`super::NAMES`]; zero for those that were held.
    pub covariance: SMatrix<f64, PARAMETERS, PARAMETERS>,
    /// The plate's bend, and its field, where they were adjusted.
    pub plate: Option<Plate>,
    /// The views.
    pub views: Vec<Posed>,
    /// Root mean square length of all residuals that took part, pixels: divides by the discs.
    pub rms_px: f64,
    /// The residuals' size in units of the deviations given: the root of chi-square over its degrees of freedom. Where it
    /// is above 1, all covariances here are those of the deviations given times its square.
    pub noise_ratio: f64,
    /// How different what each view says of focal lengths and principal point is, in units of the deviations given: the root of
    /// what chi-square would fall by if each view had its own, over how many more numbers these are. About the noise ratio
    /// where the views are of one camera and the lens is as modelled; above it, not.
    pub view_ratio: f64,
    /// Two a disc that took part, less the unknowns, and less the numbers of a field that the views fix.
    pub degrees_of_freedom: usize,
    /// What the views cover.
    pub coverage: Coverage,
    /// Steps of the last adjustment.
    pub steps: usize,
}

impl Calibrated {
    /// Standard deviations of the camera's numbers, in the order of [`super::NAMES`]; 0 for those that were held.
    pub fn sigmas(&self) -> [f64; PARAMETERS] {
        std::array::from_fn(|k| self.covariance[(k, k)].max(0.0).sqrt())
    }

    /// Discs that took part and discs that were left out.
    pub fn counts(&self) -> [usize; 2] {
        let all = self.views.iter().flat_map(|v| &v.residuals);
        all.fold([0, 0], |[used, out], r| {
            [used + usize::from(r.used), out + usize::from(!r.used)]
        })
    }

    pub(super) fn of(
        chosen: &Chosen,
        stations: &[Station],
        views: &[View],
        size: ImageSize,
        options: &Options,
    ) -> Result<Self, CameraRefused> {
        let (settled, free) = (&chosen.settled, options.shared());
        let camera = settled.state.camera;
        let covariance = match &chosen.field {
            Some(field) => field.shared(&free),
            None => covariance(chosen, &free)?,
        };
        let used = chosen.kept.iter().flatten().filter(|k| **k).count();
        let unknowns = 6 * stations.len() + free.iter().filter(|f| **f).count();
        // A field with a prior takes fewer degrees of freedom than it has coefficients: as many as the data decide.
        let fixed = chosen.field.as_ref().map_or(0.0, |f| f.effective_parameters.ceil());
        let degrees_of_freedom = (2 * used).saturating_sub(unknowns + fixed as usize);
        let noise_ratio = (settled.cost / degrees_of_freedom.max(1) as f64).sqrt();
        // Residuals larger than the noise given enlarge every covariance; smaller ones do not shrink it.
        let scale = noise_ratio.max(1.0).powi(2);
        weak(&camera, &(covariance * scale), &free)?;
        let mut posed = Vec::with_capacity(stations.len());
        for (i, station) in stations.iter().enumerate() {
            let view = Reported {
                station,
                state: &settled.state,
                pose: settled.state.poses[i],
                kept: &chosen.kept[i],
            };
            // Outside it the lens folds, and a point would have two images.
            view.in_domain(i)?;
            let own = pose_covariance(chosen, i, &covariance).unwrap_or_default() * scale;
            posed.push(view.posed(about_origin(&own, &view.pose.shift)));
        }
        let squares = posed.iter().flat_map(|v| &v.residuals).filter(|r| r.used);
        let sum: f64 = squares.map(|r| r.off.norm_squared()).sum();
        let normals: Vec<_> = settled.state.poses.iter().map(|p| normal(&p.matrix())).collect();
        let pixels: Vec<_> = views.iter().flat_map(|v| &v.sightings).map(|s| s.pixel).collect();
        Ok(Self {
            camera,
            covariance: covariance.fixed_view::<PARAMETERS, PARAMETERS>(0, 0) * scale,
            plate: free[PARAMETERS].then(|| {
                let own = covariance.fixed_view::<3, 3>(PARAMETERS, PARAMETERS) * scale;
                Plate::new(views, settled.state.bend, own).with(chosen.field.as_ref(), views, scale)
            }),
            views: posed,
            rms_px: (sum / used.max(1) as f64).sqrt(),
            noise_ratio,
            view_ratio: view_ratio(&settled.normals),
            degrees_of_freedom,
            coverage: Coverage::of(&normals, &pixels, size),
            steps: settled.steps,
        })
    }
}

/// The normal of the grid's plane, away from the camera.
fn normal(turn: &Matrix3<f64>) -> nalgebra::Vector3<f64> {
    let n = turn.column(2).into_owned();
    if n.z < 0.0 { -n } else { n }
}

/// `S^-1`, zero for the numbers that were held.
fn covariance(chosen: &Chosen, free: &[bool; SHARED]) -> Result<Square, CameraRefused> {
    let free_number = |parameter| chosen.settled.state.free_number(parameter);
    let reduced = Reduced::of(&chosen.settled.normals, free, 0.0).ok_or_else(|| free_number(0))?;
    let all: Vec<f64> = reduced.matrix.iter().copied().collect();
    let (least, parameter) = loosest(&DMatrix::from_vec(SHARED, SHARED, all));
    let held = least > HELD;
    if !held {
        return Err(free_number(parameter));
    }
    let mut covariance = reduced.matrix.cholesky().ok_or_else(|| free_number(0))?.inverse();
    for k in (0..SHARED).filter(|k| !free[*k]) {
        covariance[(k, k)] = 0.0;
    }
    Ok((covariance + covariance.transpose()) * 0.5)
}

/// Refuses focal lengths and principal points whose deviation is half a focal length.
fn weak(camera: &Camera, covariance: &Square, free: &[bool; SHARED]) -> Result<(), CameraRefused> {
    let numbers = camera.numbers();
    for parameter in (0..4).filter(|k| free[*k]) {
        let sigma = covariance[(parameter, parameter)].sqrt();
        let known = sigma <= MAX_FOCAL_DEVIATION * camera.focal.min();
        if !known {
            let value = numbers[parameter];
            return Err(CameraRefused::Weak {
                parameter,
                value,
                sigma,
            });
        }
    }
    Ok(())
}

/// `H^-1 + H^-1 E^T C E H^-1` for the pose about the view's middle.
fn pose_covariance(chosen: &Chosen, view: usize, camera: &Square) -> Option<Matrix6<f64>> {
    if let Some(field) = &chosen.field {
        return Some(field.pose(view));
    }
    let normal = &chosen.settled.normals[view];
    let inverse = normal.inverse(0.0)?;
    let carried = inverse * normal.mixed.transpose();
    Some(inverse + carried * camera * carried.transpose())
}

/// That about the camera's origin from that about the view's middle at `shift`.
fn about_origin(own: &Matrix6<f64>, shift: &nalgebra::Vector3<f64>) -> Matrix6<f64> {
    // R p + t moves by w x (R p) + v about the middle, by w x (R p + t) + v' about the origin: v' = v - w x t.
    let mut to_origin = Matrix6::identity();
    to_origin.fixed_view_mut::<3, 3>(3, 0).copy_from(&shift.cross_matrix());
    let moved = to_origin * own * to_origin.transpose();
    (moved + moved.transpose()) * 0.5
}

/// One view being reported.
struct Reported<'a> {
    state: &'a State,
    station: &'a Station,
    pose: Pose,
    kept: &'a [bool],
}

impl Reported<'_> {
    /// Refuses where the lens folds among the discs.
    fn in_domain(&self, view: usize) -> Result<(), CameraRefused> {
        let (eye, limit) = (self.state.eye(&self.pose), self.state.camera.lens.limit());
        for s in &self.station.sightings {
            let at = eye.at(s);
            let tangent = at.xy().norm() / at.z;
            let within = tangent <= limit;
            if !within {
                let disc = s.disc;
                return Err(CameraRefused::Folded {
                    view,
                    disc,
                    tangent,
                    limit,
                });
            }
        }
        Ok(())
    }

    fn posed(&self, covariance: Matrix6<f64>) -> Posed {
        let eye = self.state.eye(&self.pose);
        let turn = eye.turn;
        let both = self.station.sightings.iter().zip(self.kept);
        let residual = |(s, used): (&super::view::Ready, &bool)| Residual {
            off: s.pixel - predicted(s, &eye),
            used: *used,
        };
        let residuals: Vec<Residual> = both.map(residual).collect();
        let used = || residuals.iter().filter(|r| r.used);
        let sum: f64 = used().map(|r| r.off.norm_squared()).sum();
        let centre = nalgebra::Vector3::new(self.station.centre.x, self.station.centre.y, 0.0);
        let t = self.pose.shift - turn * centre;
        Posed {
            pose: Rigid::from_parts(self.pose.turn, Vector::new(t.x, t.y, t.z)),
            covariance,
            rms_px: (sum / used().count().max(1) as f64).sqrt(),
            residuals,
            tilt_rad: normal(&turn).z.clamp(-1.0, 1.0).acos(),
        }
    }
}
