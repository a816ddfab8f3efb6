//! Points without their frame, as the fit goes over them.

use geometry::Frame;
use nalgebra::{Matrix3, Vector3};

use super::SurfacePoint;

/// Points about their centre.
#[derive(Debug, Clone)]
pub(crate) struct Cloud {
    /// The mean of all places, mm.
    pub(crate) centre: Vector3<f64>,
    /// Root mean square distance from it, mm.
    pub(crate) radius_mm: f64,
    /// Places relative to it.
    pub(crate) places: Vec<Vector3<f64>>,
    /// Beam times depth, mm: by how much a place moves against it for a depth scale of 1. Zero where no depth is known.
    pub(crate) deep: Vec<Vector3<f64>>,
    /// Beams; zero where there is none.
    pub(crate) beams: Vec<Vector3<f64>>,
    pub(crate) covariances: Vec<Matrix3<f64>>,
    /// Roots of the covariances: their axes, each as long as its deviation, mm.
    pub(crate) roots: Vec<Matrix3<f64>>,
    /// Root of the mean variance over the three axes, mm.
    pub(crate) sigmas: Vec<f64>,
    /// What each point counts, 0 to 1: the reciprocal of how many were taken at its place.
    pub(crate) votes: Vec<f64>,
    /// Points no further apart than this were taken at one place, mm.
    held_mm: f64,
    /// All points in an order without any: the first n of them are a fair sample.
    pub(crate) order: Vec<u32>,
}

impl Cloud {
    pub(super) fn new<F: Frame>(points: &[SurfacePoint<F>], held_mm: f64) -> Self {
        let places: Vec<Vector3<f64>> = points.iter().map(|p| Vector3::from(p.place.mm())).collect();
        let votes = votes(&places, held_mm);
        // About the middle, so that a tracker two metres away costs neither digits nor a lever between turn and shift.
        let total: f64 = votes.iter().sum();
        let weighted = places.iter().zip(&votes).map(|(p, vote)| p * *vote);
        let centre = weighted.sum::<Vector3<f64>>() / total;
        let places: Vec<Vector3<f64>> = places.iter().map(|p| p - centre).collect();
        let square: f64 = places.iter().zip(&votes).map(|(p, vote)| vote * p.norm_squared()).sum();
        let beams: Vec<Vector3<f64>> = points
            .iter()
            .map(|p| {
                p.beam
                    .map_or(Vector3::zeros(), |beam| beam.direction.components().into())
            })
            .collect();
        let depth = |p: &SurfacePoint<F>| p.beam.and_then(|beam| beam.depth_mm).unwrap_or(0.0);
        Self {
            centre,
            radius_mm: (square / total).sqrt(),
            deep: beams.iter().zip(points).map(|(beam, p)| beam * depth(p)).collect(),
            roots: points.iter().map(|p| root(&p.covariance_mm2)).collect(),
            covariances: points.iter().map(|p| p.covariance_mm2).collect(),
            sigmas: points.iter().map(|p| (p.covariance_mm2.trace() / 3.0).sqrt()).collect(),
            order: shuffled(places.len()),
            places,
            beams,
            votes,
            held_mm,
        }
    }

    pub(crate) fn len(&self) -> usize {
        self.places.len()
    }

    /// Each two points that were taken at one place, once.
    pub(crate) fn pairs(&self, each: impl FnMut(usize, usize)) {
        pairs(&self.places, self.held_mm, each);
    }

    /// The first `n` points of [`Cloud::order`], as a cloud of its own about the same centre.
    pub(crate) fn thinned(&self, n: usize) -> Self {
        let chosen: Vec<usize> = self.order.iter().take(n).map(|i| *i as usize).collect();
        self.of(&chosen)
    }

    /// Some points, as a cloud of its own about the same centre.
    pub(crate) fn of(&self, chosen: &[usize]) -> Self {
        fn of<T: Clone>(all: &[T], chosen: &[usize]) -> Vec<T> {
            chosen.iter().map(|i| all[*i].clone()).collect()
        }
        Self {
            centre: self.centre,
            radius_mm: self.radius_mm,
            places: of(&self.places, chosen),
            deep: of(&self.deep, chosen),
            beams: of(&self.beams, chosen),
            covariances: of(&self.covariances, chosen),
            roots: of(&self.roots, chosen),
            sigmas: of(&self.sigmas, chosen),
            votes: of(&self.votes, chosen),
            held_mm: self.held_mm,
            order: shuffled(chosen.len()),
        }
    }
}

/// The axes of a covariance, each as long as its deviation.
fn root(covariance: &Matrix3<f64>) -> Matrix3<f64> {
    let eigen = covariance.symmetric_eigen();
    eigen.eigenvectors * Matrix3::from_diagonal(&eigen.eigenvalues.map(|v| v.max(0.0).sqrt()))
}

/// One over the number of points within `held_mm` of each, itself with them.
fn votes(places: &[Vector3<f64>], held_mm: f64) -> Vec<f64> {
    let mut near = vec![1_usize; places.len()];
    pairs(places, held_mm, |i, j| {
        near[i] += 1;
        near[j] += 1;
    });
    near.into_iter().map(|near| 1.0 / near as f64).collect()
}

/// Each two points no further apart than `held_mm`, once.
fn pairs(places: &[Vector3<f64>], held_mm: f64, mut each: impl FnMut(usize, usize)) {
    if held_mm <= 0.0 {
        return;
    }
    // In the order of x only those that follow within that length can be near.
    let mut order: Vec<usize> = (0..places.len()).collect();
    order.sort_unstable_by(|i, j| places[*i].x.total_cmp(&places[*j].x).then(i.cmp(j)));
    for (k, i) in order.iter().enumerate() {
        for j in &order[k + 1..] {
            if places[*j].x - places[*i].x > held_mm {
                break;
            }
            if (places[*j] - places[*i]).norm() <= held_mm {
                each(*i, *j);
            }
        }
    }
}

/// An order that has nothing to do with place: a part of it has as many gross errors as the whole, which the points that lie furthest
/// apart would not.
fn shuffled(n: usize) -> Vec<u32> {
    let mut order: Vec<u32> = (0..n as u32).collect();
    order.sort_by_key(|i| chance::mix(u64::from(*i)));
    order
}
