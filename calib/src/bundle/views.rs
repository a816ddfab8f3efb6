//! What the localizer saw, checked, and its noise.

use geometry::{Point, Tracker};
use nalgebra::{Matrix3, Vector3};

use super::Refused;

/// One frame of the localizer: the emitters seen, by their number, and where.
pub type View = Vec<(usize, Point<Tracker>)>;

/// The noise of a sighting, in the localizer's axes, mm.
#[derive(Debug, Clone, PartialEq)]
pub enum Localizer {
    /// The same standard deviation along every axis.
    Isotropic {
        /// Standard deviation per axis, mm.
        sigma_mm: f64,
    },
    /// A localizer that looks along its z axis.
    Depth {
        /// Standard deviation along x and y, mm.
        across_mm: f64,
        /// Standard deviation along z, mm.
        depth_mm: f64,
    },
    /// A covariance for each sighting, in the order of the views, mm^2.
    Each(Vec<Vec<Matrix3<f64>>>),
}

impl Localizer {
    /// The covariance of sighting `i` of view `view`, mm^2.
    fn covariance(&self, view: usize, i: usize) -> Matrix3<f64> {
        let diagonal = |x: f64, z: f64| Matrix3::from_diagonal(&Vector3::new(x * x, x * x, z * z));
        match self {
            Self::Isotropic { sigma_mm } => diagonal(*sigma_mm, *sigma_mm),
            Self::Depth { across_mm, depth_mm } => diagonal(*across_mm, *depth_mm),
            Self::Each(list) => list[view][i],
        }
    }

    fn check(&self, views: &[View]) -> Result<(), Refused> {
        let Self::Each(list) = self else {
            return Ok(());
        };
        let unmatched = |view: usize| {
            let (found, sightings) = (list.get(view).map_or(0, Vec::len), views[view].len());
            (found != sightings).then_some(Refused::Unmatched { view, found, sightings })
        };
        (0..views.len()).find_map(unmatched).map_or(Ok(()), Err)
    }
}

/// One emitter in one view.
#[derive(Debug, Clone)]
pub(super) struct Sighting {
    pub(super) emitter: usize,
    /// About the view's centre, in the localizer's axes, mm.
    pub(super) place: Vector3<f64>,
    /// Inverse covariance, 1/mm^2.
    pub(super) information: Matrix3<f64>,
}

/// A view whose emitters stand off a line, so that it gives a pose.
#[derive(Debug, Clone)]
pub(super) struct Station {
    pub(super) view: usize,
    /// Mean of the emitters seen, mm.
    pub(super) centre: Vector3<f64>,
    pub(super) sightings: Vec<Sighting>,
}

/// All usable views, and the size of the noise.
pub(super) struct Data {
    pub(super) stations: Vec<Station>,
    /// Number of emitters of the marker.
    pub(super) emitters: usize,
    /// Root mean square of the deviations per axis, mm.
    pub(super) sigma_mm: f64,
    /// Largest deviation along any axis, mm.
    pub(super) worst_sigma_mm: f64,
}

/// The root mean square distance of points from their best line must be this many deviations.
// The turn about the line then deviates by at most 1 / (10 sqrt(3)) rad, 3.3 degrees, for three emitters or more.
const LEAST_WIDTH: f64 = 10.0;

impl Data {
    /// Checks the views and keeps those that give a pose.
    pub(super) fn new(views: &[View], emitters: usize, noise: &Localizer) -> Result<Self, Refused> {
        check(views, emitters)?;
        noise.check(views)?;
        let mut data = Self {
            stations: Vec::new(),
            emitters,
            sigma_mm: 0.0,
            worst_sigma_mm: 0.0,
        };
        let (mut total, mut count) = (0.0, 0.0);
        for (view, list) in views.iter().enumerate() {
            let station = data.station(view, list, noise)?;
            for i in 0..list.len() {
                total += noise.covariance(view, i).trace() / 3.0;
                count += 1.0;
            }
            data.stations.push(station);
        }
        data.sigma_mm = (total / count).sqrt();
        data.keep_wide(views.len())?;
        Ok(data)
    }

    fn station(&mut self, view: usize, list: &View, noise: &Localizer) -> Result<Station, Refused> {
        let places: Vec<Vector3<f64>> = list.iter().map(|(_, p)| Vector3::from(p.mm())).collect();
        let centre = places.iter().sum::<Vector3<f64>>() / places.len().max(1) as f64;
        let mut sightings = Vec::with_capacity(list.len());
        for (i, (emitter, _)) in list.iter().enumerate() {
            let covariance = noise.covariance(view, i);
            // A Cholesky factor is made from the lower triangle alone: asymmetry has to be looked for.
            // `amax` passes over a NaN, which may stand in the upper triangle only.
            let even = covariance.iter().all(|x| x.is_finite())
                && (covariance - covariance.transpose()).amax() <= 1e-12 * covariance.amax();
            let factor = covariance.cholesky().filter(|_| even);
            // Variances below some 1e-308 have no finite inverse.
            let information = factor.map(|f| f.inverse()).filter(|m| m.iter().all(|x| x.is_finite()));
            let emitter = *emitter;
            let information = information.ok_or(Refused::BadNoise { view, emitter })?;
            self.worst_sigma_mm = self.worst_sigma_mm.max(covariance.symmetric_eigenvalues().max().sqrt());
            sightings.push(Sighting {
                emitter,
                // About the view's centre: metres of distance would cost digits in every residual.
                place: places[i] - centre,
                information,
            });
        }
        Ok(Station {
            view,
            centre,
            sightings,
        })
    }

    /// All sightings of the stations.
    pub(super) fn sightings(&self) -> usize {
        self.stations.iter().map(|s| s.sightings.len()).sum()
    }

    /// The least width of a set of emitters that gives a pose, mm.
    pub(super) fn least_width_mm(&self) -> f64 {
        LEAST_WIDTH * self.worst_sigma_mm
    }

    fn keep_wide(&mut self, views: usize) -> Result<(), Refused> {
        let needed_mm = self.least_width_mm();
        let width = |s: &Station| width_mm(&s.sightings.iter().map(|x| x.place).collect::<Vec<_>>());
        let widest_mm = self.stations.iter().map(width).fold(0.0, f64::max);
        self.stations.retain(|s| width(s) >= needed_mm);
        if self.stations.is_empty() {
            return Err(Refused::Collinear {
                views,
                widest_mm,
                needed_mm,
            });
        }
        Ok(())
    }
}

fn check(views: &[View], emitters: usize) -> Result<(), Refused> {
    for (view, list) in views.iter().enumerate() {
        let mut seen = vec![false; emitters];
        for (emitter, place) in list {
            let (emitter, found) = (*emitter, place.mm());
            if emitter >= emitters {
                return Err(Refused::NoSuchEmitter {
                    view,
                    emitter,
                    emitters,
                });
            }
            if std::mem::replace(&mut seen[emitter], true) {
                return Err(Refused::Twice { view, emitter });
            }
            if found.iter().any(|x| !x.is_finite()) {
                return Err(Refused::NotFinite { view, emitter, found });
            }
        }
    }
    Ok(())
}

/// Root mean square distance of points from their best line, mm; 0 for fewer than three.
pub(super) fn width_mm(points: &[Vector3<f64>]) -> f64 {
    if points.len() < 3 {
        return 0.0;
    }
    let n = points.len() as f64;
    let centre = points.iter().sum::<Vector3<f64>>() / n;
    let outer = |p: &Vector3<f64>| (p - centre) * (p - centre).transpose();
    let spread = points.iter().map(outer).sum::<Matrix3<f64>>() / n;
    let values = spread.symmetric_eigenvalues();
    // The two lesser moments; rounding may leave their sum below zero for points on a line.
    (values.sum() - values.max()).max(0.0).sqrt()
}
