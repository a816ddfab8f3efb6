//! Where to touch next: the places of the bone at which a few points more would make the error at the targets least.

use geometry::{Frame, Point};
use nalgebra::{Matrix3, SMatrix, SVector, Vector3};

use crate::Surface;
use crate::register::SurfaceRegistration;
use crate::tree::Triangle;

type Vector8 = SVector<f64, 8>;
type Matrix8 = SMatrix<f64, 8, 8>;

/// A place of the bone that is worth touching.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Next {
    /// The place, mm, in the bone's frame.
    pub place_mm: [f64; 3],
    /// Outward normal there: where a tool comes from.
    pub normal: [f64; 3],
    /// Root mean square error predicted over the targets once it was touched, mm.
    pub tre_mm: f64,
}

/// What is to be touched.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Touches {
    /// So many points at one place.
    pub points: f64,
    /// Deviation of each along the bone's normal, mm.
    pub sigma_mm: f64,
    /// Places are told only so far from one another, mm.
    pub apart_mm: f64,
    /// At most so many of them.
    pub places: usize,
}

/// The places at which `touches` would make the mean square error over the targets least, the best first. Each is reckoned alone, as if
/// nothing else were touched; whether a tool reaches it is not known.
///
/// With `P` the covariance of (turn, shift, depth scale, offset) about the middle of the points, a point at `p` with the normal `n` has the
/// gradient `h = ((p - c) x n, n, 0, -1)`; `m` of them of deviation `s` take `P h h' P / (s^2 / m + h' P h)` off `P` (Kalman).
pub fn next<To: Frame, From: Frame>(
    surface: &Surface<To>,
    found: &SurfaceRegistration<To, From>,
    targets: &[Point<To>],
    touches: &Touches,
) -> Vec<Next> {
    let targets: Vec<Vector3<f64>> = targets.iter().map(|target| Vector3::from(target.mm())).collect();
    let before = Before::new(&found.covariance_about_points(), &found.centre, &targets);
    let variance = touches.sigma_mm * touches.sigma_mm / touches.points;
    let mut all: Vec<Next> = surface
        .tree
        .triangles()
        .filter_map(|triangle| before.after(triangle, variance))
        .collect();
    // Stable, so that equals keep the order of the triangles: the same input gives the same places.
    all.sort_by(|a, b| a.tre_mm.total_cmp(&b.tre_mm));
    let mut chosen: Vec<Next> = Vec::new();
    for one in all {
        let far =
            |other: &Next| (Vector3::from(other.place_mm) - Vector3::from(one.place_mm)).norm() >= touches.apart_mm;
        if chosen.len() < touches.places && chosen.iter().all(far) {
            chosen.push(one);
        }
    }
    chosen
}

/// What is known before anything more is touched.
struct Before {
    covariance: Matrix8,
    /// `M` with the mean square error over the targets `tr(M P)`, between two covariances: `P M P`.
    between: Matrix8,
    square_mm2: f64,
    centre: Vector3<f64>,
}

impl Before {
    fn new(covariance: &Matrix8, centre: &Vector3<f64>, targets: &[Vector3<f64>]) -> Self {
        let mut measure = Matrix8::zeros();
        for target in targets {
            let mut way = SMatrix::<f64, 3, 8>::zeros();
            way.fixed_view_mut::<3, 3>(0, 0)
                .copy_from(&-(target - centre).cross_matrix());
            way.fixed_view_mut::<3, 3>(0, 3).copy_from(&Matrix3::identity());
            measure += way.transpose() * way / targets.len() as f64;
        }
        Self {
            covariance: *covariance,
            between: covariance * measure * covariance,
            square_mm2: (measure * covariance).trace(),
            centre: *centre,
        }
    }

    /// What touching the middle of a triangle would leave; `None` of one without a normal.
    fn after(&self, t: &Triangle, variance: f64) -> Option<Next> {
        let place = (t.a + t.b + t.c) / 3.0;
        let normal = (t.b - t.a).cross(&(t.c - t.a)).try_normalize(0.0)?;
        let turn = (place - self.centre).cross(&normal);
        let h = Vector8::from([turn.x, turn.y, turn.z, normal.x, normal.y, normal.z, 0.0, -1.0]);
        let taken = h.dot(&(self.between * h)) / (variance + h.dot(&(self.covariance * h)));
        Some(Next {
            place_mm: place.into(),
            normal: normal.into(),
            tre_mm: (self.square_mm2 - taken).max(0.0).sqrt(),
        })
    }
}
