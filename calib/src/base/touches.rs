//! Touches as they come, and what is asked of them.

use geometry::{Frame, Point};
use nalgebra::{Matrix3, Vector3};

use super::{Feature, Refused};

/// Touches made one after the other on one feature, in the localizer's frame or that of the base's reference marker.
#[derive(Debug, Clone, PartialEq)]
pub struct Group<F: Frame> {
    /// The feature, where it is known.
    pub feature: Option<Feature>,
    /// The centre of the tip's ball at each touch.
    pub touches: Vec<Point<F>>,
    /// Covariance of each touch, mm^2, in the axes of `F`; empty where all have the noise of [`Options::sigma_mm`].
    pub covariances: Vec<Matrix3<f64>>,
    /// What three normal numbers of deviation 1, the same for all touches of all groups, move each touch by, mm: a column for
    /// each, in the axes of `F`. It is in the covariances too. Empty where touches share nothing.
    pub shared: Vec<Matrix3<f64>>,
}

impl<F: Frame> Group<F> {
    /// Touches on a feature that is known.
    pub const fn of(feature: Feature, touches: Vec<Point<F>>) -> Self {
        Self {
            feature: Some(feature),
            touches,
            covariances: Vec::new(),
            shared: Vec::new(),
        }
    }

    /// Touches on a feature that is to be found.
    pub const fn unlabelled(touches: Vec<Point<F>>) -> Self {
        Self {
            feature: None,
            touches,
            covariances: Vec::new(),
            shared: Vec::new(),
        }
    }

    /// The same touches with a covariance each, mm^2: a localizer sees worse along its line of sight than across it.
    pub fn with_covariances(self, covariances: Vec<Matrix3<f64>>) -> Self {
        Self { covariances, ..self }
    }

    /// The same touches with what they share, as the error of the tip's calibration: [`Group::shared`].
    pub fn with_shared(self, shared: Vec<Matrix3<f64>>) -> Self {
        Self { shared, ..self }
    }

    /// The covariance of a touch.
    fn covariance(&self, touch: usize, sigma_mm: f64) -> Matrix3<f64> {
        let even = Matrix3::identity() * (sigma_mm * sigma_mm);
        self.covariances.get(touch).copied().unwrap_or(even)
    }
}

/// How the base is located.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Standard deviation of the tip's place along each axis, mm; for touches with a covariance of their own the unit in
    /// which they are counted, of no influence.
    pub sigma_mm: f64,
    /// Radius of the tip's ball, mm; 0 for a sharp tip.
    pub tip_radius_mm: f64,
    /// Touches further off than this many deviations, each of its own, are left out.
    pub gate: f64,
    /// The largest share of the touches that may be left out.
    pub most_rejected: f64,
    /// The largest residuals accepted, in units of the noise given: above, the touches are on something else.
    pub max_noise_ratio: f64,
    /// The largest ratio of the largest deviation to the least; turns are counted at the touches' radius.
    pub max_condition: f64,
}

impl Options {
    /// The usual choices for a pointer's noise: a sharp tip, a gate of six deviations, a fifth left out, residuals of
    /// twice the noise, condition 100.
    pub const fn new(sigma_mm: f64) -> Self {
        Self {
            sigma_mm,
            tip_radius_mm: 0.0,
            gate: 6.0,
            most_rejected: 0.2,
            max_noise_ratio: 2.0,
            max_condition: 100.0,
        }
    }

    /// The gate, mm.
    pub(super) fn limit_mm(&self) -> f64 {
        self.gate * self.sigma_mm
    }

    pub(super) fn check(&self) -> Result<(), Refused> {
        let positive = [
            ("the noise", self.sigma_mm),
            ("the gate", self.gate),
            ("the largest residual", self.max_noise_ratio),
            ("the largest condition", self.max_condition),
        ];
        let bad = positive.into_iter().find(|(_, x)| !(x.is_finite() && *x > 0.0));
        let least = [
            ("the tip's radius", self.tip_radius_mm),
            ("the share left out", self.most_rejected),
        ];
        let bad = bad.or_else(|| least.into_iter().find(|(_, x)| !(x.is_finite() && *x >= 0.0)));
        bad.map_or(Ok(()), |(what, found)| Err(Refused::BadOption { what, found }))
    }
}

/// More groups are not sorted out.
// Unlabelled groups are assigned by trying all: 4^7 = 16384 assignments at most.
const MAX_GROUPS: usize = 7;

/// Refuses groups that cannot be used.
pub(super) fn check<F: Frame>(groups: &[Group<F>]) -> Result<(), Refused> {
    if groups.len() < 4 || groups.len() > MAX_GROUPS {
        return Err(Refused::GroupCount {
            found: groups.len(),
            most: MAX_GROUPS,
        });
    }
    for (group, g) in groups.iter().enumerate() {
        if let Some(Feature::Groove(groove @ 3..)) = g.feature {
            return Err(Refused::NoSuchGroove { group, groove });
        }
        // What a group without a label lies on is not known yet: two touches are the fewest for any feature.
        let needed = g.feature.map_or(2, Feature::needed);
        let found = g.touches.len();
        if found < needed {
            return Err(Refused::TooFew { group, found, needed });
        }
        let bad = |p: &Point<F>| p.mm().iter().any(|x| !x.is_finite());
        if let Some(touch) = g.touches.iter().position(bad) {
            let found = g.touches[touch].mm();
            return Err(Refused::NotFinite { group, touch, found });
        }
        check_noise(group, g)?;
    }
    Ok(())
}

/// Refuses covariances that are none.
fn check_noise<F: Frame>(group: usize, g: &Group<F>) -> Result<(), Refused> {
    let (found, touches) = (g.covariances.len(), g.touches.len());
    if found != 0 && found != touches {
        return Err(Refused::Unmatched { group, found, touches });
    }
    check_shared(group, g)?;
    // A Cholesky factor is made from the lower triangle alone: asymmetry has to be looked for.
    let even = |c: &Matrix3<f64>| (c - c.transpose()).amax() <= 1e-12 * c.amax();
    let good = |c: &Matrix3<f64>| c.iter().all(|x| x.is_finite()) && even(c) && c.cholesky().is_some();
    match g.covariances.iter().position(|c| !good(c)) {
        Some(touch) => Err(Refused::BadNoise { group, touch }),
        None => Ok(()),
    }
}

/// Refuses what touches share where it is more than their covariances, to the seven digits that files have at least.
fn check_shared<F: Frame>(group: usize, g: &Group<F>) -> Result<(), Refused> {
    let (found, touches) = (g.shared.len(), g.touches.len());
    if found != 0 && (found != touches || g.covariances.len() != touches) {
        return Err(Refused::Unmatched { group, found, touches });
    }
    // A part that is larger than the whole would make the errors of their own less than none.
    let within = |(c, u): (&Matrix3<f64>, &Matrix3<f64>)| {
        let rest = c - u * u.transpose();
        rest.iter().all(|x| x.is_finite()) && rest.symmetric_eigenvalues().min() >= -1e-6 * c.amax()
    };
    match g.covariances.iter().zip(&g.shared).position(|both| !within(both)) {
        Some(touch) => Err(Refused::BadNoise { group, touch }),
        None => Ok(()),
    }
}

/// The touches' covariances in units of the noise given; `None` for touches of that noise.
pub(super) fn noise<F: Frame>(groups: &[Group<F>], sigma_mm: f64) -> Vec<Vec<Option<Matrix3<f64>>>> {
    let of = |g: &Group<F>, touch: usize| {
        let scaled = g.covariance(touch, sigma_mm) / (sigma_mm * sigma_mm);
        (!g.covariances.is_empty()).then_some(scaled)
    };
    let group = |g: &Group<F>| (0..g.touches.len()).map(|i| of(g, i)).collect();
    groups.iter().map(group).collect()
}

/// The largest deviation of a touch along any axis, in units of the noise given; at least 1.
pub(super) fn widest(noise: &[Vec<Option<Matrix3<f64>>>]) -> f64 {
    let each = noise.iter().flatten().flatten();
    let largest = each.map(|c| c.symmetric_eigenvalues().max());
    // Of variances; the noise given has the variance 1.
    largest.fold(1.0, f64::max).sqrt()
}

/// The mean of all touches, and the touches about it.
pub(super) fn centred<F: Frame>(groups: &[Group<F>]) -> (Vector3<f64>, Vec<Vec<Vector3<f64>>>) {
    let of = |g: &Group<F>| g.touches.iter().map(|p| Vector3::from(p.mm())).collect::<Vec<_>>();
    let places: Vec<Vec<Vector3<f64>>> = groups.iter().map(of).collect();
    let count = places.iter().map(Vec::len).sum::<usize>() as f64;
    let centre = places.iter().flatten().sum::<Vector3<f64>>() / count;
    let about = places.iter().map(|g| g.iter().map(|p| p - centre).collect());
    (centre, about.collect())
}
