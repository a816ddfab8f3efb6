//! Checks of points, and why they are refused.

use geometry::Frame;
use nalgebra::{Matrix3, Matrix6};

use super::{Cloud, LEAST_POINTS, MOST_POINTS, SharedError, SurfacePoint};

/// Why points are refused. Indices count from 0.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PointsError {
    /// Too few or too many.
    #[error("{found} points; {LEAST_POINTS} to {MOST_POINTS} are taken")]
    Count {
        /// How many there are.
        found: usize,
    },
    /// A coordinate, a depth or an entry of a covariance is NaN or infinite, or a direction across the beam is along it.
    #[error("point {point}: its {what} holds a number that is not finite")]
    NotFinite {
        /// The first such point.
        point: usize,
        /// What holds it.
        what: &'static str,
    },
    /// A covariance is none: asymmetric, or with a variance that is not above 0.
    #[error(
        "point {point}: its covariance is not symmetric positive definite: every deviation must be above 0 mm, \
         for an error that is not known to be there is none that can be weighed"
    )]
    Covariance {
        /// The first such point.
        point: usize,
    },
    /// A depth is below 0 mm.
    #[error("point {point}: its depth is {found} mm; at least 0 is allowed")]
    Depth {
        /// The first such point.
        point: usize,
        /// What was found, mm.
        found: f64,
    },
    /// The shared error has not one lever a point, or its covariance is none.
    #[error("the error that all points share: {found}, expected {expected}")]
    Shared {
        /// What was found.
        found: String,
        /// What is needed.
        expected: String,
    },
    /// The distance within which points count as one is not a number of at least 0.
    #[error("points within {found} mm of one another count as one: 0 to 10 mm is allowed")]
    Held {
        /// What was given, mm.
        found: f64,
    },
    /// Too few once such as were taken by a probe that was held still count as one.
    #[error(
        "the points are {effective:.1} places, as a probe held still counts once; at least {LEAST_POINTS} are needed"
    )]
    HeldStill {
        /// How many places they are.
        effective: f64,
    },
    /// So close together that they are in metres, or of one place.
    #[error("the points' mean square radius is {radius_mm:.4} mm: are they in metres?")]
    TooClose {
        /// Root mean square radius, mm.
        radius_mm: f64,
    },
}

/// The least root mean square radius of points, mm: below it their noise is as large as their layout.
const LEAST_RADIUS_MM: f64 = 2.0;

pub(super) fn check<F: Frame>(
    points: &[SurfacePoint<F>],
    shared: Option<&SharedError>,
    held_mm: f64,
) -> Result<(), PointsError> {
    if !(LEAST_POINTS..=MOST_POINTS).contains(&points.len()) {
        return Err(PointsError::Count { found: points.len() });
    }
    if !(0.0..=10.0).contains(&held_mm) {
        return Err(PointsError::Held { found: held_mm });
    }
    for (point, p) in points.iter().enumerate() {
        let not_finite = |what| Err(PointsError::NotFinite { point, what });
        if p.place.mm().iter().any(|x| !x.is_finite()) {
            return not_finite("place");
        }
        if p.covariance_mm2.iter().any(|x| !x.is_finite()) {
            return not_finite("covariance");
        }
        // Deviations of 0 would make one point outweigh all others.
        let c = &p.covariance_mm2;
        let is_even = (c - c.transpose()).amax() <= 1e-9 * c.amax();
        if !is_even || !is_definite(c) {
            return Err(PointsError::Covariance { point });
        }
        match p.beam.and_then(|beam| beam.depth_mm) {
            Some(depth) if !depth.is_finite() => return not_finite("depth"),
            Some(depth) if depth < 0.0 => return Err(PointsError::Depth { point, found: depth }),
            _ => {}
        }
    }
    shared.map_or(Ok(()), |shared| check_shared(shared, points.len()))
}

/// Whether the least deviation is above a thousandth of the greatest, below which it is rounding.
fn is_definite(c: &Matrix3<f64>) -> bool {
    let values = c.symmetric_eigenvalues();
    values.min() > 1e-6 * values.max() && values.max() > 0.0
}

fn check_shared(shared: &SharedError, points: usize) -> Result<(), PointsError> {
    let refused = |found: String, expected: String| Err(PointsError::Shared { found, expected });
    if shared.levers.len() != points {
        return refused(
            format!("{} levers", shared.levers.len()),
            format!("{points}, one a point"),
        );
    }
    let numbers = shared.levers.iter().flat_map(|lever| lever.iter());
    if numbers.chain(shared.covariance.iter()).any(|x| !x.is_finite()) {
        return refused("a number that is not finite".into(), "finite numbers".into());
    }
    let c: &Matrix6<f64> = &shared.covariance;
    let is_even = (c - c.transpose()).amax() <= 1e-9 * c.amax();
    // Semidefinite is enough: a calibration may be exact in some direction.
    let least = c.symmetric_eigenvalues().min();
    if !is_even || least < -1e-9 * c.amax() {
        return refused(
            format!("a covariance whose least eigenvalue is {least:e}"),
            "a symmetric one without negative eigenvalues".into(),
        );
    }
    Ok(())
}

pub(super) fn check_cloud(cloud: &Cloud) -> Result<(), PointsError> {
    if cloud.radius_mm < LEAST_RADIUS_MM {
        return Err(PointsError::TooClose {
            radius_mm: cloud.radius_mm,
        });
    }
    let effective: f64 = cloud.votes.iter().sum();
    if effective < LEAST_POINTS as f64 {
        return Err(PointsError::HeldStill { effective });
    }
    Ok(())
}
