//! What lies around a bead, as a random field: tissue that goes on from voxel to voxel, and noise that does not.
//!
//! A scanner sees the ball instead of what would be in its place, so that with the ball's share f of a voxel
//!
//! ```text
//! I(x) = f(x) M + (1 - f(x)) (b + g(x)) + e(x),    cov(g(x), g(y)) = s^2 k(|x - y|),    cov(e) = n^2 I + (0.005 signal)^2
//! k(d) = (1 + a + a^2 / 3) exp(-a),    a = sqrt(5) d / 2 mm
//! ```
//!
//! M is the metal, b the ground's mean, s and n deviations in HU. k is Matern's covariance of order 5/2 (Rasmussen and
//! Williams 2006, 4.17): twice differentiable, as the edge of a bone is behind a scanner's blur. Of polynomials, and of
//! orders 1/2, 3/2, 5/2 and infinite with lengths of 1 to 20 mm, this was among the two best within 3 mm of bone, at 80 places
//! in a chest. s and n are those of the greatest restricted likelihood (Patterson and Thompson 1971), the ball's
//! numbers being unknown: in even tissue s is small, and the ground is nearly a constant.

use nalgebra::{DMatrix, DVector, Dyn, Vector3, linalg::Cholesky};

/// Length of the covariance, mm.
const LENGTH_MM: f64 = 2.0;
/// Least and greatest deviations that are tried, HU.
const RANGE_HU: [f64; 2] = [0.3, 3000.0];
/// Factors by which the deviations are varied, one after the other.
const SEARCH_FACTORS: [f64; 3] = [4.0, 2.0, 1.4];
/// The most evaluations of the likelihood.
const MAX_TRIALS: usize = 60;
/// Variance by rounding to whole HU.
const ROUNDING_VARIANCE_HU2: f64 = 1.0 / 12.0;
/// The model's own error as a share of the ball's signal: no scanner's blur is a Gaussian.
pub(super) const MODEL_ERROR: f64 = 0.005;

/// What the ground under a bead is taken for when its centre is refined.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Ground {
    /// One value everywhere.
    Constant,
    /// A plane.
    Sloping,
    /// A polynomial of the second degree.
    Quadratic,
    /// A random field with a length of 2 mm: the least error of the four wherever the ground is not even.
    #[default]
    Correlated,
}

impl Ground {
    /// The number of the mean's coefficients.
    pub(super) fn coefficients(self) -> usize {
        match self {
            Self::Constant | Self::Correlated => 1,
            Self::Sloping => 4,
            Self::Quadratic => 10,
        }
    }
}

/// Deviations of the ground, HU.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Spread {
    /// Of what goes on from voxel to voxel.
    pub(super) smooth_hu: f64,
    /// Of what is new in each.
    pub(super) noise_hu: f64,
}

/// A voxel and what the ball has of it.
#[derive(Debug, Clone, Copy)]
pub(super) struct VoxelShare {
    pub(super) place: Vector3<f64>,
    /// f: 1 within the ball, 0 far from it.
    pub(super) share: f64,
    /// f times the metal's HU over the ground.
    pub(super) signal: f64,
}

impl Spread {
    /// Covariance of the ground at two voxels, HU^2.
    pub(super) fn between(&self, one: &VoxelShare, other: &VoxelShare) -> f64 {
        let a = 5.0_f64.sqrt() * (one.place - other.place).norm() / LENGTH_MM;
        let visible = (1.0 - one.share) * (1.0 - other.share);
        self.smooth_hu * self.smooth_hu * visible * (1.0 + a + a * a / 3.0) * (-a).exp()
    }

    /// Variance at a voxel of what is independent of all others, HU^2.
    pub(super) fn alone(&self, seen: &VoxelShare) -> f64 {
        let own = MODEL_ERROR * seen.signal;
        self.noise_hu * self.noise_hu + ROUNDING_VARIANCE_HU2 + own * own
    }

    /// The voxels' covariance, factored. `None` where rounding leaves it no factor.
    pub(super) fn factor(&self, all: &[VoxelShare]) -> Option<Cholesky<f64, Dyn>> {
        let mut matrix = DMatrix::zeros(all.len(), all.len());
        for (j, one) in all.iter().enumerate() {
            matrix[(j, j)] = self.alone(one);
            if self.smooth_hu > 0.0 {
                // The factorization reads the lower triangle alone.
                (j..all.len()).for_each(|i| matrix[(i, j)] += self.between(&all[i], one));
            }
        }
        matrix.cholesky()
    }
}

/// A linear problem with a normal prior: residuals, derivatives by the unknowns, the prior's inverse variances, and how
/// far its middle lies from where the problem was linearised.
pub(super) struct Linear {
    pub(super) residuals: DVector<f64>,
    pub(super) derivatives: DMatrix<f64>,
    pub(super) prior_weight: DVector<f64>,
    pub(super) prior_offset: DVector<f64>,
}

impl Linear {
    /// The normal equations with the residuals' covariance given by its factor, and the residuals' squares by it.
    pub(super) fn normal(&self, factor: &Cholesky<f64, Dyn>) -> Option<(DMatrix<f64>, DVector<f64>, f64)> {
        // Above the diagonal it holds what is left of the matrix, which a solution by the lower triangle does not read.
        let lower = factor.l_dirty();
        let (mut by, mut residuals) = (self.derivatives.clone(), self.residuals.clone());
        let solved = lower.solve_lower_triangular_mut(&mut by) && lower.solve_lower_triangular_mut(&mut residuals);
        let mut matrix = by.tr_mul(&by);
        for (i, weight) in self.prior_weight.iter().enumerate() {
            matrix[(i, i)] += weight;
        }
        let vector = by.tr_mul(&residuals) + self.prior_weight.component_mul(&self.prior_offset);
        solved.then(|| (matrix, vector, residuals.norm_squared()))
    }

    /// How unlikely the prior takes the point where the problem was linearised: squares of its deviations.
    pub(super) fn prior(&self) -> f64 {
        let squares = self.prior_offset.component_mul(&self.prior_offset);
        self.prior_weight.dot(&squares)
    }

    /// Minus twice the logarithm of the restricted likelihood, but for a constant.
    pub(super) fn unlikelihood(&self, spread: &Spread, all: &[VoxelShare]) -> f64 {
        let value = || {
            let factor = spread.factor(all)?;
            let (matrix, vector, squares) = self.normal(&factor)?;
            // Its determinant is what the ball's unknown numbers cost: they are integrated out, which makes the
            // likelihood a restricted one.
            let inner = matrix.cholesky()?;
            let explained = vector.dot(&inner.solve(&vector));
            Some(logarithm(&factor) + logarithm(&inner) + squares - explained)
        };
        // What cannot be factored is not likely.
        value().filter(|v| v.is_finite()).unwrap_or(f64::INFINITY)
    }

    /// As [`Linear::unlikelihood`] at the point itself, with the covariance of the voxels times the likeliest factor: so that
    /// what the deviations' search leaves does not count. `None` where the covariance has no factor.
    pub(super) fn scaled_unlikelihood(&self, spread: &Spread, all: &[VoxelShare]) -> Option<f64> {
        let factor = spread.factor(all)?;
        let (matrix, _, squares) = self.normal(&factor)?;
        let n = all.len() as f64;
        let scale = squares / (n - self.prior_weight.len() as f64).max(1.0);
        let prior = DMatrix::from_diagonal(&self.prior_weight);
        let inner = ((matrix - &prior) / scale + prior).cholesky()?;
        let value = logarithm(&factor) + n * scale.ln() + logarithm(&inner) + squares / scale + self.prior();
        value.is_finite().then_some(value)
    }

    /// The likeliest deviations of the ground; without its smooth part for polynomials. By a search along the two
    /// logarithms, at most 60 factorizations.
    pub(super) fn likeliest(&self, all: &[VoxelShare], start: Spread, ground: Ground) -> Spread {
        let mut best = Spread {
            smooth_hu: if ground == Ground::Correlated {
                start.smooth_hu
            } else {
                0.0
            },
            ..start
        };
        let mut least = self.unlikelihood(&best, all);
        let mut trials = 1;
        // Coordinate search in logarithms: each look is a factorization, so that derivatives would cost more than they save.
        for factor in SEARCH_FACTORS {
            loop {
                let before = least;
                for next in neighbours(&best, factor) {
                    // The bound of the time: the deviations need no more digits than the residuals that they weigh.
                    if trials == MAX_TRIALS {
                        return best;
                    }
                    trials += 1;
                    let found = self.unlikelihood(&next, all);
                    if found < least {
                        (best, least) = (next, found);
                    }
                }
                if least == before {
                    break;
                }
            }
        }
        best
    }
}

/// Logarithm of the determinant.
fn logarithm(factor: &Cholesky<f64, Dyn>) -> f64 {
    2.0 * factor.l_dirty().diagonal().iter().map(|d| d.ln()).sum::<f64>()
}

fn neighbours(spread: &Spread, factor: f64) -> impl Iterator<Item = Spread> + use<> {
    let [low, high] = RANGE_HU;
    let Spread { smooth_hu, noise_hu } = *spread;
    let vary = move |smooth: f64, noise: f64| Spread {
        // Nothing stays nothing.
        smooth_hu: if smooth_hu > 0.0 {
            (smooth_hu * smooth).clamp(low, high)
        } else {
            0.0
        },
        noise_hu: (noise_hu * noise).clamp(low, high),
    };
    let pairs = [(factor, 1.0), (1.0 / factor, 1.0), (1.0, factor), (1.0, 1.0 / factor)];
    let all = pairs.map(|(smooth, noise)| vary(smooth, noise));
    let same = *spread;
    all.into_iter().filter(move |next| *next != same)
}
