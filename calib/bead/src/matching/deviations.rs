//! The errors of pairs, by touch: what is given and what each touch states.

use nalgebra::Matrix3;

use super::{AGREE_DEVIATIONS, Errors, Refused, Stated};
use calib::registration::{Noise, PairError};

/// The error of a pair of each touch with any bead.
pub(super) struct Deviations {
    /// The largest deviation along any axis, by touch, mm.
    sigmas_mm: Vec<f64>,
    /// Empty where nothing is stated.
    errors: Vec<PairError>,
    even: Noise,
}

impl Deviations {
    /// Of so many touches.
    pub(super) fn new(touches: usize, stated: &[Stated], given: &Errors) -> Result<Self, Refused> {
        let even = given.noise();
        if stated.is_empty() {
            return Ok(Self {
                sigmas_mm: vec![even.sigma_mm; touches],
                errors: Vec::new(),
                even,
            });
        }
        if stated.len() != touches {
            let found = stated.len();
            return Err(Refused::StatedCount { found, touches });
        }
        // The hand's error is each touch's own, and alike in all directions.
        let added = Matrix3::identity() * even.sigma_mm.powi(2);
        let mut errors = Vec::new();
        for (touch, stated) in stated.iter().enumerate() {
            if !is_good(stated) {
                return Err(Refused::Stated { touch });
            }
            errors.push(PairError {
                own: stated.own + added,
                shared: stated.shared,
            });
        }
        // By the longest axis: a gate by a mean would refuse pairs whose error lies along it.
        let sigma = |error: &PairError| error.covariance().symmetric_eigenvalues().max().sqrt();
        Ok(Self {
            sigmas_mm: errors.iter().map(sigma).collect(),
            errors,
            even,
        })
    }

    /// The largest deviation of any pair, mm.
    pub(super) fn largest_mm(&self) -> f64 {
        self.sigmas_mm.iter().copied().fold(0.0, f64::max)
    }

    /// The greatest difference that is none of the distances between two touches and between two beads, mm.
    pub(super) fn distance_mm(&self, a: usize, b: usize) -> f64 {
        AGREE_DEVIATIONS * self.sigmas_mm[a].hypot(self.sigmas_mm[b])
    }

    /// The largest of these.
    pub(super) fn largest_distance_mm(&self) -> f64 {
        AGREE_DEVIATIONS * self.largest_mm().hypot(self.largest_mm())
    }

    /// Solutions that place all touched points no farther apart than this are one, mm.
    pub(super) fn alike_mm(&self) -> f64 {
        AGREE_DEVIATIONS * self.even.sigma_mm.hypot(self.even.sigma_mm)
    }

    /// The errors of pairs with these touches; `None` where nothing is stated.
    pub(super) fn of_pairs(&self, touches: impl Iterator<Item = usize>) -> Option<Vec<PairError>> {
        (!self.errors.is_empty()).then(|| touches.map(|touch| self.errors[touch]).collect())
    }

    /// The noise of a pair: root mean square along an axis.
    pub(super) fn noise(&self, pairs: Option<&[PairError]>) -> Noise {
        let Some(pairs) = pairs else { return self.even };
        // Reports tell one length; what is decided is decided by the covariances.
        let trace = pairs.iter().map(|error| error.covariance().trace()).sum::<f64>();
        Noise {
            sigma_mm: (trace / (3.0 * pairs.len() as f64)).sqrt(),
        }
    }
}

/// Whether the own part is a covariance, but for what rounding has left below zero: a millionth of the whole, which it is the
/// difference to in files of seven digits at least.
fn is_good(stated: &Stated) -> bool {
    let own = &stated.own;
    let most = 1e-6 * (own + stated.shared * stated.shared.transpose()).amax();
    let finite = own.iter().chain(stated.shared.iter()).all(|x| x.is_finite());
    finite && (own - own.transpose()).amax() <= most && own.symmetric_eigenvalues().min() >= -most
}
