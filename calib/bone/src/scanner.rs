//! What all places share, from the places themselves: the scanner's blur, the HU of cortex, the noise.
//!
//! Of a spread sample of places the sum of all costs is least over the two deviations of the blur, the HU of cortex and the blur's kurtosis,
//! beside the unknowns of each place, which are eliminated: the step is that of the Schur complement, and what is minimised is the marginal
//! likelihood by Laplace's method, which has half the logarithm of the determinant of each place's information. Without that, hundreds of
//! places that each take their best thickness out of the noise together draw the cortex towards what takes most (Neyman and Scott 1948). Where cortex is thinner than the blur its HU and its thickness are one number;
//! the HU of the thick places then hold for the thin ones, as Treece et al. 2010 (10.1016/j.media.2010.01.003) have it.

use nalgebra::{SMatrix, SVector};

use crate::model::Unknowns;
use crate::patch::Patch;
use crate::solve::{Fit, Layer, Noise, Priors, fit, information};
use crate::uneven::{Says, uneven};

/// Rounds of fitting places and what they share in turn.
const ROUNDS: usize = 60;
/// It ends where blur and cortex change by less, relative.
const SETTLED: f64 = 2e-3;
/// The largest step of a logarithm in a round.
const MOST_STEP: f64 = 0.25;
/// Places whose residuals are larger than so many times the middle one's tell nothing of what is shared.
const MOST_RESIDUAL: f64 = 3.0;
/// Deviation of the logarithm of a blur that was told, and of one that is only expected from the voxels.
const LOG_BLUR: [f64; 2] = [0.03, 0.25];
/// Cortex before anything was measured, HU: mean and deviation. Of two deviations it goes from 760 to 2230 HU, as its logarithm counts: from
/// porous bone and scanners that show all HU too low to the densest. Narrower it holds fast what voxels contradict where cortex is thin.
const CORTEX_HU: [f64; 2] = [1300.0, 350.0];
/// Excess kurtosis of the blur beforehand: the voxel's own box has some below 0, and sharp kernels have.
const KURTOSIS: [f64; 2] = [-0.1, 0.15];
/// How much its HU differ from place to place, relative: at first, at least and at most.
pub(crate) const CORTEX_SPREAD: [f64; 3] = [0.10, 0.02, 0.2];
/// The mean logarithm of the thickness, mm, before anything was measured, and its deviation.
const LOG_THICKNESS: [f64; 2] = [0.4, 1.0];
/// Deviation of the logarithm from place to place: at first, at least and at most. A spread that bone does not have costs a thick layer, whose
/// voxels tell its thickness, more likelihood than a thin bright one behind more blur: at 0.12 cortex that is the same everywhere came out thin.
const THICKNESS_SPREAD: [f64; 3] = [0.8, 0.04, 1.0];
/// What each place is given at least, as the sample need not have seen what it has: the cortex's relative deviation and that of the logarithm
/// of its thickness.
const LEAST_SPREAD: [f64; 2] = [0.07, 0.3];
/// What is wrong with the model is wrong alike at all places and does not average out: together they count as so many times fewer.
const TEMPER: f64 = 6.0;
/// No scanner's blur is a Gaussian: what is found of it is not surer than that, relative.
const LEAST_LOG_BLUR: f64 = 0.02;
/// The least noise, HU: rounding to whole ones, and what no model has.
const LEAST_NOISE_HU: f64 = 3.0;

/// The logarithms of the two blurs and of the cortex's HU, the blur's kurtosis, and the mean logarithm of the thickness.
pub(crate) type Apart = SVector<f64, 5>;
/// A matrix of those.
pub(crate) type Shared = SMatrix<f64, 5, 5>;

/// What all places share.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Scanner {
    /// Blur in the slice's plane and along its normal, deviations, mm.
    pub(crate) blur_mm: [f64; 2],
    pub(crate) cortex_hu: f64,
    /// Excess kurtosis of the blur.
    pub(crate) kurtosis: f64,
    /// How much the cortex's HU differ from place to place, relative.
    pub(crate) cortex_spread: f64,
    /// Mean of the logarithm of the thickness, mm, and its deviation from place to place.
    pub(crate) log_thickness: [f64; 2],
    pub(crate) noise: Noise,
    /// Covariance of the logarithms of the two blurs and of the cortex's HU, and of the kurtosis.
    pub(crate) covariance: Shared,
    /// Places that told of it.
    pub(crate) places: usize,
}

impl Scanner {
    /// Before anything was measured.
    pub(crate) fn expected(blur_mm: [f64; 2], is_told: bool) -> Self {
        let log_blur = LOG_BLUR[usize::from(!is_told)];
        let cortex = CORTEX_HU[1] / CORTEX_HU[0];
        Self {
            blur_mm,
            cortex_hu: CORTEX_HU[0],
            kurtosis: KURTOSIS[0],
            cortex_spread: CORTEX_SPREAD[0],
            log_thickness: [LOG_THICKNESS[0], THICKNESS_SPREAD[0]],
            noise: Noise {
                hu: 30.0,
                neighbours: [0.0; 3],
            },
            covariance: Shared::from_diagonal(
                &Apart::new(log_blur, log_blur, cortex, KURTOSIS[1], LOG_THICKNESS[1]).map(|d| d * d),
            ),
            places: 0,
        }
    }

    pub(crate) fn priors(&self) -> Priors {
        Priors {
            cortex_hu: [self.cortex_hu, self.cortex_spread * self.cortex_hu],
            inside_hu: [150.0, 250.0],
            tissue_hu: [30.0, 150.0],
            log_thickness: self.log_thickness,
            layer: Layer::CORTEX,
        }
    }

    /// What is known of a place that need not have been in the sample.
    pub(crate) fn wide_priors(&self) -> Priors {
        let mut wide = *self;
        wide.cortex_spread = wide.cortex_spread.max(LEAST_SPREAD[0]);
        wide.log_thickness[1] = wide.log_thickness[1].max(LEAST_SPREAD[1]);
        wide.priors()
    }

    /// The blur along a direction in which the plane has this share of the variance, by the logarithms of the two: mm.
    fn blur_by(patch: &Patch) -> [f64; 2] {
        let s = patch.place.blur_mm;
        [s * patch.plane_share, s * (1.0 - patch.plane_share)]
    }
}

/// What a place says of what is shared: its part of the reduced normal equations, and how its unknowns go with it.
struct Part {
    matrix: Shared,
    gradient: Apart,
}

/// How the unknowns of a place change with the logarithms of the two blurs and of the cortex's HU, and with the kurtosis.
pub(crate) fn by_shared(patch: &Patch, priors: &Priors, fit: &Fit, noise_hu: f64) -> Option<SMatrix<f64, 5, 5>> {
    let (cross, _, _) = cross(patch, priors, fit, noise_hu);
    let full = fit.information + SMatrix::from_diagonal(&prior_weights(priors));
    Some(-full.cholesky()?.solve(&cross))
}

fn prior_weights(priors: &Priors) -> Unknowns {
    let of = |[_, d]: [f64; 2]| 1.0 / (d * d);
    Unknowns::new(
        0.0,
        of(priors.log_thickness),
        of(priors.cortex_hu),
        of(priors.inside_hu),
        of(priors.tissue_hu),
    )
}

/// The mixed and the shared part of the information, and the gradient by what is shared.
fn cross(patch: &Patch, priors: &Priors, fit: &Fit, noise_hu: f64) -> (SMatrix<f64, 5, 5>, Shared, Apart) {
    let per = 1.0 / (noise_hu * noise_hu);
    let by = Scanner::blur_by(patch);
    let (mut mixed, mut own, mut gradient) = (SMatrix::<f64, 5, 5>::zeros(), Shared::zeros(), Apart::zeros());
    for sample in &patch.samples {
        let value = patch.place.value(&fit.at, sample.x);
        let row = Apart::new(
            value.by_blur * by[0],
            value.by_blur * by[1],
            0.0,
            value.by_kurtosis,
            0.0,
        );
        let weight = sample.weight * per;
        mixed.ger(weight, &value.by, &row, 1.0);
        own.ger(weight, &row, &row, 1.0);
        gradient += weight * (value.hu - sample.hu) * row;
    }
    // The cortex's mean comes in by each place's own prior.
    let [mean, deviation] = priors.cortex_hu;
    let weight = 1.0 / (deviation * deviation);
    mixed[(2, 2)] -= weight * mean;
    own[(2, 2)] += weight * mean * mean;
    gradient[2] -= weight * (fit.at[2] - mean) * mean;
    let [mean, deviation] = priors.log_thickness;
    let weight = 1.0 / (deviation * deviation);
    mixed[(1, 4)] -= weight;
    own[(4, 4)] += weight;
    gradient[4] -= weight * (fit.at[1] - mean);
    (mixed, own, gradient)
}

fn part(patch: &Patch, priors: &Priors, fit: &Fit, noise_hu: f64) -> Option<Part> {
    let (mixed, own, gradient) = cross(patch, priors, fit, noise_hu);
    let full = fit.information + SMatrix::from_diagonal(&prior_weights(priors));
    let solved = full.cholesky()?.solve(&mixed);
    Some(Part {
        matrix: own - mixed.transpose() * solved,
        gradient: gradient + by_determinant(patch, priors, fit, &-solved, noise_hu)?,
    })
}

/// Half the derivative of the logarithm of the determinant of a place's whole information over that of its priors, the place's unknowns going
/// along: by central differences.
fn by_determinant(patch: &Patch, priors: &Priors, fit: &Fit, go: &SMatrix<f64, 5, 5>, noise_hu: f64) -> Option<Apart> {
    let by = Scanner::blur_by(patch);
    let half_log = |k: usize, d: f64| {
        let mut moved = patch.place;
        let mut own = *priors;
        match k {
            0 | 1 => moved.blur_mm += by[k] * d,
            2 => own.cortex_hu = own.cortex_hu.map(|hu| hu * d.exp()),
            3 => moved.kurtosis += d,
            // The mean thickness comes in by the place's own alone.
            _ => {}
        }
        let at = fit.at + go.column(k) * d;
        let weights = prior_weights(&own);
        let full = information(patch, &moved, noise_hu, &at) + SMatrix::from_diagonal(&weights);
        // Without the position, of which nothing is known beforehand.
        let before: f64 = weights.iter().skip(1).map(|w| w.ln()).sum();
        Some(full.cholesky()?.l().diagonal().iter().map(|x| x.ln()).sum::<f64>() - 0.5 * before)
    };
    let d = 1e-3;
    let mut gradient = Apart::zeros();
    for k in 0..5 {
        gradient[k] = (half_log(k, d)? - half_log(k, -d)?) / (2.0 * d);
    }
    Some(gradient)
}

/// What is shared, from the patches that `patches` gives for a blur. `None` where fewer than `least` places tell of it.
pub(crate) fn measure(
    expected: Scanner,
    least: usize,
    mut patches: impl FnMut(([f64; 2], f64)) -> Vec<Patch>,
) -> Option<Scanner> {
    let mut scanner = expected;
    let prior = expected.covariance.try_inverse()?;
    let expected_logs = logs(&expected);
    let mut starts: Vec<Option<Unknowns>> = Vec::new();
    for round in 0..ROUNDS {
        let patches = patches((scanner.blur_mm, scanner.kurtosis));
        // Windows go with the blur, so that a place may come or go; all start anew then.
        if starts.len() != patches.len() || round < 2 {
            starts = vec![None; patches.len()];
        }
        let priors = scanner.priors();
        let noise = scanner.noise.hu;
        let fits: Vec<Option<Fit>> = patches
            .iter()
            .zip(&starts)
            .map(|(patch, start)| fit(patch, &priors, noise, *start))
            .collect();
        starts = fits.iter().map(|fit| fit.map(|fit| fit.at)).collect();
        let residuals: Vec<f64> = fits.iter().flatten().map(|fit| fit.residual_hu2).collect();
        if residuals.len() < least {
            return None;
        }
        let middle = ::fit::median(residuals);
        scanner.noise.hu = middle.sqrt().max(LEAST_NOISE_HU);
        let good: Vec<(&Patch, &Fit)> = patches
            .iter()
            .zip(&fits)
            .filter_map(|(patch, fit)| Some((patch, fit.as_ref()?)))
            .filter(|(_, fit)| fit.residual_hu2 < MOST_RESIDUAL * middle)
            .collect();
        scanner.noise.neighbours = correlations(&good);
        scanner.places = good.len();
        let (mut matrix, mut gradient) = (prior, prior * (logs(&scanner) - expected_logs));
        let repeated = TEMPER * repeated(&good);
        let spread = spread(&good, &priors);
        let mut said = Vec::with_capacity(good.len());
        for (patch, fit) in &good {
            if let Some(part) = part(patch, &priors, fit, noise) {
                // A voxel that is in several patches tells its tale once.
                matrix += part.matrix / repeated;
                gradient += part.gradient / repeated;
                // Both blurs by the same share are the blur along the normal by that share.
                said.push(Says {
                    normal: patch.normal,
                    information: part.matrix.fixed_view::<2, 2>(0, 0).sum() / repeated,
                    gradient: part.gradient.fixed_view::<2, 1>(0, 0).sum() / repeated,
                });
            }
        }
        let step = -matrix.cholesky()?.solve(&gradient);
        let step = step.map(|x| x.clamp(-MOST_STEP, MOST_STEP));
        scanner.blur_mm = [0, 1].map(|k| scanner.blur_mm[k] * step[k].exp());
        scanner.cortex_hu *= step[2].exp();
        scanner.kurtosis = (scanner.kurtosis + step[3]).clamp(-0.6, 0.6);
        scanner.log_thickness = [
            scanner.log_thickness[0] + step[4],
            spread[0].clamp(THICKNESS_SPREAD[1], THICKNESS_SPREAD[2]),
        ];
        scanner.cortex_spread = (spread[1] / priors.cortex_hu[0]).clamp(CORTEX_SPREAD[1], CORTEX_SPREAD[2]);
        // Correlated noise tells less: as many voxels less as go together.
        let together = scanner
            .noise
            .neighbours
            .iter()
            .map(|c| 1.0 + 2.0 * c.max(0.0))
            .product::<f64>();
        scanner.covariance = matrix.try_inverse()? * together
            + Shared::from_diagonal(&Apart::new(1.0, 1.0, 0.0, 0.0, 0.0))
                * (LEAST_LOG_BLUR.powi(2) + uneven(&said).powi(2));
        if round > 3 && step.amax() < SETTLED {
            break;
        }
    }
    Some(scanner)
}

/// Deviations from place to place of the logarithm of the thickness and of the cortex's HU: of what was found, and of what each place leaves
/// open (expectation and maximisation).
fn spread(good: &[(&Patch, &Fit)], priors: &Priors) -> [f64; 2] {
    let prior = SMatrix::from_diagonal(&prior_weights(priors));
    let (mut sums, mut count) = ([0.0; 2], 0.0_f64);
    for (_, fit) in good {
        let Some(whole) = (fit.information + prior).cholesky() else {
            continue;
        };
        let left = whole.inverse();
        sums[0] += (fit.at[1] - priors.log_thickness[0]).powi(2) + left[(1, 1)];
        sums[1] += (fit.at[2] - priors.cortex_hu[0]).powi(2) + left[(2, 2)];
        count += 1.0;
    }
    sums.map(|sum| (sum / count.max(1.0)).sqrt())
}

fn logs(scanner: &Scanner) -> Apart {
    Apart::new(
        scanner.blur_mm[0].ln(),
        scanner.blur_mm[1].ln(),
        scanner.cortex_hu.ln(),
        scanner.kurtosis,
        scanner.log_thickness[0],
    )
}

/// How often a voxel is in the patches, on average over what they hold.
fn repeated(good: &[(&Patch, &Fit)]) -> f64 {
    let mut all: Vec<[i32; 3]> = good
        .iter()
        .flat_map(|(patch, _)| patch.samples.iter().map(|s| s.index))
        .collect();
    let count = all.len() as f64;
    all.sort_unstable();
    all.dedup();
    (count / (all.len() as f64).max(1.0)).max(1.0)
}

/// Correlation of neighbouring voxels' residuals along each axis. The fit takes a few degrees of freedom from each patch, which makes
/// it a little less than it is.
fn correlations(good: &[(&Patch, &Fit)]) -> [f64; 3] {
    let (mut products, mut squares) = ([0.0; 3], [0.0; 3]);
    for (patch, fit) in good {
        let residuals: Vec<([i32; 3], f64)> = patch
            .samples
            .iter()
            .map(|s| (s.index, s.hu - patch.place.hu(&fit.at, s.x)))
            .collect();
        for (index, residual) in &residuals {
            for k in 0..3 {
                let mut next = *index;
                next[k] += 1;
                // Samples come in the order of their indices, slices first.
                let order = |i: &[i32; 3]| [i[2], i[1], i[0]];
                if let Ok(other) = residuals.binary_search_by_key(&order(&next), |(i, _)| order(i)) {
                    products[k] += residual * residuals[other].1;
                    squares[k] += 0.5 * (residual * residual + residuals[other].1.powi(2));
                }
            }
        }
    }
    [0, 1, 2].map(|k| {
        if squares[k] > 0.0 {
            (products[k] / squares[k]).clamp(0.0, 0.95)
        } else {
            0.0
        }
    })
}
