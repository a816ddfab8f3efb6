//! The model fitted to the voxels about a place: damped least squares, with what is known of cortex, inside and tissue beforehand.

use nalgebra::{Matrix3, SMatrix, Vector3};

use crate::model::{Place, Unknowns};
use crate::patch::Patch;

pub(crate) type Information = SMatrix<f64, 5, 5>;

/// Steps of the damped iteration at most.
const MOST_STEPS: usize = 25;
/// It ends where a step changes the cost by less.
const SETTLED: f64 = 1e-5;
/// Positions tried at the start, in deviations of the blur.
const POSITIONS: [f64; 6] = [0.6, 0.0, -0.6, -1.2, -1.8, -2.4];

/// Voxels farther apart along an axis have no noise in common.
const FARTHEST: i32 = 3;

/// What is known of each place beforehand: mean and deviation, HU; of the thickness its logarithm.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Priors {
    pub(crate) cortex_hu: [f64; 2],
    pub(crate) inside_hu: [f64; 2],
    pub(crate) tissue_hu: [f64; 2],
    pub(crate) log_thickness: [f64; 2],
    pub(crate) layer: Layer,
}

/// What the layer between tissue and inside may be.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Layer {
    /// Thicknesses tried at the start, mm.
    pub(crate) tried_mm: [f64; 3],
    /// Range of the thickness, mm.
    pub(crate) thickness_mm: [f64; 2],
    /// Most HU.
    pub(crate) most_hu: f64,
}

impl Layer {
    /// Cortex.
    pub(crate) const CORTEX: Self = Self {
        tried_mm: [0.6, 1.5, 3.5],
        thickness_mm: [0.1, 15.0],
        most_hu: f64::INFINITY,
    };

    fn held(&self, mut at: Unknowns) -> Unknowns {
        at[1] = at[1].clamp(self.thickness_mm[0].ln(), self.thickness_mm[1].ln());
        at[2] = at[2].min(self.most_hu);
        at
    }
}

impl Priors {
    fn mean(&self) -> Unknowns {
        Unknowns::new(
            0.0,
            self.log_thickness[0],
            self.cortex_hu[0],
            self.inside_hu[0],
            self.tissue_hu[0],
        )
    }

    /// Squares of what is off from what is known, in its deviations.
    pub(crate) fn squares(&self, at: &Unknowns) -> f64 {
        let off = at - self.mean();
        off.component_mul(&off).dot(&self.weights())
    }

    /// One over variances. The position has none.
    fn weights(&self) -> Unknowns {
        let of = |[_, deviation]: [f64; 2]| 1.0 / (deviation * deviation);
        Unknowns::new(
            0.0,
            of(self.log_thickness),
            of(self.cortex_hu),
            of(self.inside_hu),
            of(self.tissue_hu),
        )
    }
}

/// The noise of the CT.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Noise {
    /// Deviation of a voxel, HU.
    pub(crate) hu: f64,
    /// Correlation of neighbouring voxels along each axis.
    pub(crate) neighbours: [f64; 3],
}

impl Noise {
    /// Of voxels that lie 0 to [`FARTHEST`] apart along each axis: a Gaussian of the distance, which is what a scanner's kernel makes of
    /// white noise. Of distance 1 it is the measured one, of d its power d^2.
    fn table(&self) -> [[f64; FARTHEST as usize + 1]; 3] {
        self.neighbours.map(|c| {
            let of = |d: i32| {
                if c > 0.02 {
                    c.powi(d * d)
                } else {
                    f64::from(u8::from(d == 0))
                }
            };
            std::array::from_fn(|d| of(d as i32))
        })
    }
}

/// What fits a place.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Fit {
    pub(crate) at: Unknowns,
    /// Half the sum of squares, priors included.
    pub(crate) cost: f64,
    /// Weighted mean square of the residuals, HU^2, by the degrees of freedom.
    pub(crate) residual_hu2: f64,
    /// Of the voxels, of noise of `noise.hu`.
    pub(crate) information: Information,
}

/// Fits a patch; from `start`, or from the best of a few places.
pub(crate) fn fit(patch: &Patch, priors: &Priors, noise_hu: f64, start: Option<Unknowns>) -> Option<Fit> {
    if let Some(start) = start {
        return descend(patch, priors, noise_hu, start);
    }
    // A thin bright layer and a thick dark one are two minima: each has its own start.
    let starts = starts(patch, priors, noise_hu);
    let fits = starts
        .into_iter()
        .filter_map(|start| descend(patch, priors, noise_hu, start));
    fits.min_by(|a, b| a.cost.total_cmp(&b.cost))
}

/// The best start of each of two thicknesses: with position and thickness held the model is linear.
fn starts(patch: &Patch, priors: &Priors, noise_hu: f64) -> Vec<Unknowns> {
    let mut best: Vec<(f64, Unknowns)> = Vec::new();
    for thickness in priors.layer.tried_mm {
        let tried = POSITIONS.iter().filter_map(|p| {
            let outer = p * patch.place.blur_mm;
            linear(patch, priors, noise_hu, outer, thickness)
        });
        best.extend(tried.min_by(|a, b| a.0.total_cmp(&b.0)));
    }
    best.sort_by(|a, b| a.0.total_cmp(&b.0));
    best.truncate(2);
    best.into_iter().map(|(_, at)| at).collect()
}

fn linear(patch: &Patch, priors: &Priors, noise_hu: f64, outer: f64, thickness: f64) -> Option<(f64, Unknowns)> {
    let per = 1.0 / (noise_hu * noise_hu);
    let (mean, weights) = (priors.mean(), priors.weights());
    let mut matrix = Matrix3::from_diagonal(&Vector3::new(weights[2], weights[3], weights[4]));
    let mut right = Vector3::new(weights[2] * mean[2], weights[3] * mean[3], weights[4] * mean[4]);
    for sample in &patch.samples {
        let row = Vector3::from(patch.place.shares(outer, thickness, sample.x));
        matrix += sample.weight * per * row * row.transpose();
        right += sample.weight * per * sample.hu * row;
    }
    let hu = matrix.cholesky()?.solve(&right);
    let at = priors
        .layer
        .held(Unknowns::new(outer, thickness.ln(), hu[0], hu[1], hu[2]));
    Some((cost(patch, priors, noise_hu, &at), at))
}

/// Weighted squares of the residuals, HU^2.
pub(crate) fn squares(patch: &Patch, at: &Unknowns) -> f64 {
    let square = |s: &crate::patch::Sample| s.weight * (s.hu - patch.place.hu(at, s.x)).powi(2);
    patch.samples.iter().map(square).sum()
}

fn cost(patch: &Patch, priors: &Priors, noise_hu: f64, at: &Unknowns) -> f64 {
    0.5 * (squares(patch, at) / (noise_hu * noise_hu) + priors.squares(at))
}

/// Normal equations of the voxels and of the priors: information, gradient.
fn normal_equations(patch: &Patch, noise_hu: f64, at: &Unknowns) -> (Information, Unknowns) {
    let per = 1.0 / (noise_hu * noise_hu);
    let (mut information, mut gradient) = (Information::zeros(), Unknowns::zeros());
    for sample in &patch.samples {
        let value = patch.place.value(at, sample.x);
        let weight = sample.weight * per;
        information.ger(weight, &value.by, &value.by, 1.0);
        gradient += weight * (value.hu - sample.hu) * value.by;
    }
    (information, gradient)
}

/// The information of a patch's voxels as another blur would have it.
pub(crate) fn information(patch: &Patch, place: &Place, noise_hu: f64, at: &Unknowns) -> Information {
    let per = 1.0 / (noise_hu * noise_hu);
    let mut sum = Information::zeros();
    for sample in &patch.samples {
        let by = place.value(at, sample.x).by;
        sum.ger(sample.weight * per, &by, &by, 1.0);
    }
    sum
}

fn descend(patch: &Patch, priors: &Priors, noise_hu: f64, start: Unknowns) -> Option<Fit> {
    let (mean, weights) = (priors.mean(), priors.weights());
    let prior = Information::from_diagonal(&weights);
    let mut at = start;
    let mut now = cost(patch, priors, noise_hu, &at);
    let mut damping = 1e-3;
    // Levenberg and Marquardt by hand: five unknowns a place and a hundred thousand places, nothing may be allocated in between.
    for _ in 0..MOST_STEPS {
        let (information, gradient) = normal_equations(patch, noise_hu, &at);
        let gradient = gradient + weights.component_mul(&(at - mean));
        let full = information + prior;
        let settled = loop {
            let mut damped = full;
            (0..5).for_each(|k| damped[(k, k)] *= 1.0 + damping);
            let step = damped.cholesky()?.solve(&gradient);
            let next = priors.layer.held(at - step);
            let then = cost(patch, priors, noise_hu, &next);
            if then <= now {
                let is_settled = now - then < SETTLED;
                (at, now) = (next, then);
                damping = (damping * 0.2).max(1e-9);
                break is_settled;
            }
            damping *= 8.0;
            if damping > 1e6 {
                break true;
            }
        };
        if settled {
            break;
        }
    }
    let (information, _) = normal_equations(patch, noise_hu, &at);
    let squares = squares(patch, &at);
    let weight: f64 = patch.samples.iter().map(|s| s.weight).sum();
    at.iter().all(|x| x.is_finite()).then(|| Fit {
        at,
        cost: now,
        // About three of the five are told by the voxels alone.
        residual_hu2: squares / (weight - 3.0).max(1.0),
        information,
    })
}

/// Covariance of the unknowns by the noise, with its correlation from voxel to voxel, and by the priors.
pub(crate) fn covariance(patch: &Patch, priors: &Priors, noise: &Noise, fit: &Fit) -> Option<Information> {
    let prior = Information::from_diagonal(&priors.weights());
    let inverse = (fit.information + prior).cholesky()?.inverse();
    let per = 1.0 / (noise.hu * noise.hu);
    let rows: Vec<(Unknowns, [i32; 3])> = patch
        .samples
        .iter()
        .map(|s| {
            (
                patch.place.value(&fit.at, s.x).by * (s.weight * per * noise.hu),
                s.index,
            )
        })
        .collect();
    // Of estimates (H)^-1 J' W e the covariance is H^-1 (J' W R W J + prior) H^-1, R being that of the noise.
    let mut middle = prior;
    let table = noise.table();
    for (i, (row, index)) in rows.iter().enumerate() {
        middle.ger(1.0, row, row, 1.0);
        for (other, place) in &rows[..i] {
            let apart = [0, 1, 2].map(|k| (index[k] - place[k]).abs());
            if apart[0].max(apart[1]).max(apart[2]) > FARTHEST {
                continue;
            }
            let correlation = (0..3).map(|k| table[k][apart[k] as usize]).product::<f64>();
            if correlation > 1e-3 {
                middle.ger(correlation, row, other, 1.0);
                middle.ger(correlation, other, row, 1.0);
            }
        }
    }
    Some(inverse * middle * inverse)
}
