//! Points of the bone's surface as they were measured, with all that is known of their errors.

mod cloud;
mod error;

use geometry::{Direction, Frame, Point, Rigid};
use nalgebra::{Matrix3, Matrix3x6, Matrix6, Vector3};

pub(crate) use cloud::Cloud;
pub use error::PointsError;

/// The least number of points: one more than unknowns of a pose.
pub const LEAST_POINTS: usize = 7;
/// The most points.
pub const MOST_POINTS: usize = 20_000;

/// One measured point of the surface, in `F`, mm.
#[derive(Debug, PartialEq)]
pub struct SurfacePoint<F: Frame> {
    /// Where it is.
    pub place: Point<F>,
    /// Covariance of its own error, mm^2: what this point has and no other one.
    pub covariance_mm2: Matrix3<f64>,
    /// Of a point that was seen by ultrasound: its beam.
    pub beam: Option<Beam<F>>,
}

/// How a point was seen.
#[derive(Debug, PartialEq)]
pub struct Beam<F: Frame> {
    /// The way that the sound went, into the body.
    pub direction: Direction<F>,
    /// How deep the point lies along it by the probe's nominal speed of sound, mm, where that is known.
    pub depth_mm: Option<f64>,
}

// By hand, since a frame is a name and need not be copied itself.
impl<F: Frame> Clone for SurfacePoint<F> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<F: Frame> Copy for SurfacePoint<F> {}
impl<F: Frame> Clone for Beam<F> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<F: Frame> Copy for Beam<F> {}

/// The deviations of a point in an ultrasound image, mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BeamNoise {
    /// Along the beam.
    pub axial_mm: f64,
    /// Across it, in the image.
    pub lateral_mm: f64,
    /// Across the image.
    pub elevation_mm: f64,
}

impl<F: Frame> SurfacePoint<F> {
    /// A touched point with the same deviation in every direction.
    pub fn touched(place: Point<F>, sigma_mm: f64) -> Self {
        Self {
            place,
            covariance_mm2: Matrix3::identity() * (sigma_mm * sigma_mm),
            beam: None,
        }
    }

    /// A point in an ultrasound image; `across` is any direction in the image that is not the beam's.
    pub fn seen(place: Point<F>, beam: Beam<F>, across: Direction<F>, noise: BeamNoise) -> Self {
        let axial = Vector3::from(beam.direction.components());
        let across = Vector3::from(across.components());
        // A direction along the beam leaves the other two open: NaN, which is refused with the point's number.
        let elevation = axial
            .cross(&across)
            .try_normalize(1e-9)
            .unwrap_or(Vector3::repeat(f64::NAN));
        let lateral = elevation.cross(&axial);
        let part = |axis: Vector3<f64>, sigma: f64| axis * axis.transpose() * (sigma * sigma);
        Self {
            place,
            covariance_mm2: part(axial, noise.axial_mm)
                + part(lateral, noise.lateral_mm)
                + part(elevation, noise.elevation_mm),
            beam: Some(beam),
        }
    }
}

/// An error that all points have in common, as that of a probe's or a pointer's calibration: more points do not make it less.
#[derive(Debug, Clone, PartialEq)]
pub struct SharedError {
    /// Covariance of six numbers, of whatever unit.
    pub covariance: Matrix6<f64>,
    /// For each point by how much it moves, mm in its own frame, for one unit of each.
    pub levers: Vec<Matrix3x6<f64>>,
}

impl SharedError {
    /// That of points which were measured by a tool (a probe, a pointer) whose calibration has the small motion (w, v) in the tool's
    /// frame as its error, of this covariance: `poses` of the tool as each point was taken, `places` of the points in it.
    ///
    /// The lists are one entry a point; the shorter one rules, and [`Points::new`] refuses what is too short.
    pub fn of_tool<F: Frame, T: Frame>(covariance: Matrix6<f64>, poses: &[Rigid<F, T>], places: &[Point<T>]) -> Self {
        let lever = |(pose, place): (&Rigid<F, T>, &Point<T>)| {
            let turn: Matrix3<f64> = pose.rotation().matrix().into();
            let mut lever = Matrix3x6::zeros();
            // The point goes to p + w x p + v in the tool, and the pose carries that along.
            let turned = -turn * Vector3::from(place.mm()).cross_matrix();
            lever.fixed_view_mut::<3, 3>(0, 0).copy_from(&turned);
            lever.fixed_view_mut::<3, 3>(0, 3).copy_from(&turn);
            lever
        };
        Self {
            covariance,
            levers: poses.iter().zip(places).map(lever).collect(),
        }
    }
}

/// Points that were checked.
#[derive(Debug, Clone)]
pub struct Points<F: Frame> {
    points: Vec<SurfacePoint<F>>,
    shared: Option<SharedError>,
    pub(crate) cloud: Cloud,
}

impl<F: Frame> Points<F> {
    /// Checks points. Such as lie nearer to one another than `held_mm` were measured by a probe that was held still, and count as one
    /// together; 0 lets each of them count.
    ///
    /// # Errors
    /// Each variant of [`PointsError`].
    pub fn new(points: &[SurfacePoint<F>], shared: Option<SharedError>, held_mm: f64) -> Result<Self, PointsError> {
        error::check(points, shared.as_ref(), held_mm)?;
        let cloud = Cloud::new(points, held_mm);
        error::check_cloud(&cloud)?;
        Ok(Self {
            points: points.to_vec(),
            shared,
            cloud,
        })
    }

    /// The points.
    pub fn points(&self) -> &[SurfacePoint<F>] {
        &self.points
    }

    /// The error that they share.
    pub fn shared(&self) -> Option<&SharedError> {
        self.shared.as_ref()
    }

    /// How many there are when such as were taken by a probe held still count as one.
    pub fn effective(&self) -> f64 {
        self.cloud.votes.iter().sum()
    }
}
