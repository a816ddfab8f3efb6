//! The detector: mean and deviation inside a ball and in a shell around it (5.1 to 5.3), in mm and in three dimensions.

use nalgebra::Vector3;

use super::optics::Optics;
use super::{Refused, Search, Voxels};

/// The most voxels of a neighbourhood; a bead of 2 mm in voxels of 0.2 mm has 40 000.
const MAX_VOXELS: usize = 60_000;
/// Deviations of the blur between the ball's surface and the shell: there a ball has faded to 1 or 2 %.
const FADE_DEVIATIONS: f64 = 2.2;
/// Deviations between the ball's surface and where half of its contrast is found at the most.
const HALF_CONTRAST_DEVIATIONS: f64 = 1.2;
/// HU: what a step of the values adds to the deviations, so that the contrast to noise is finite on flat ground.
const QUANTUM_HU: f64 = 1.0;

/// Offsets from the voxel in the middle, in mm all round whatever the voxels' shape.
#[derive(Debug, Clone)]
pub(super) struct Kernel {
    /// I of (5.2): within the least radius.
    inner: Vec<[i32; 3]>,
    /// Where a bead is brighter than half its contrast, and nothing beyond its blur.
    core: Vec<[i32; 3]>,
    /// E of (5.2): around the greatest radius and its blur.
    ring: Vec<[i32; 3]>,
    /// The nearest voxel of the shell along each axis, either way.
    probes: Vec<[i32; 3]>,
    /// All of these and what lies between: what the model is fitted to.
    pub(super) all: Vec<[i32; 3]>,
}

/// What the detector sees at a voxel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Response {
    /// (5.3), positive for a bright object.
    pub(super) contrast_to_noise: f64,
    /// Mean of the shell, HU.
    pub(super) ground_hu: f64,
    /// Deviation in the shell, HU.
    pub(super) ground_deviation_hu: f64,
    /// The brightest voxel within, HU.
    pub(super) peak_hu: f64,
    /// The brightest voxel of the shell, HU.
    pub(super) ring_peak_hu: f64,
    /// Voxels of the shell in the volume.
    pub(super) ring_inside: usize,
}

impl Response {
    /// Peak over ground, HU.
    pub(super) fn contrast(&self) -> f64 {
        self.peak_hu - self.ground_hu
    }
}

impl Kernel {
    pub(super) fn new(optics: &Optics, search: &Search) -> Result<Self, Refused> {
        let [low, high] = search.radius_mm;
        let [plane, axial] = optics.sigma_mm;
        let [step, slice] = optics.step_mm;
        let near = [high + FADE_DEVIATIONS * plane, high + FADE_DEVIATIONS * axial];
        // More than a voxel thick, so that the shell has voxels all round; half a millimetre at least, where voxels are
        // fine.
        let far = [near[0] + (1.5 * step).max(0.5), near[1] + (1.2 * slice).max(0.5)];
        let half = [
            high + HALF_CONTRAST_DEVIATIONS * plane,
            high + HALF_CONTRAST_DEVIATIONS * axial,
        ];
        let mut kernel = Self {
            inner: Vec::new(),
            core: Vec::new(),
            ring: Vec::new(),
            probes: Vec::new(),
            all: Vec::new(),
        };
        let reach = reach(optics, far[0].max(far[1]));
        for offset in offsets(reach) {
            let d = optics.steps * Vector3::from(offset.map(f64::from));
            let (rho, z) = optics.cylinder(&d);
            let within = |[a, b]: [f64; 2]| (rho / a).powi(2) + (z / b).powi(2) <= 1.0;
            if !within(far) {
                continue;
            }
            // Before anything of that size is allocated: spacings come from files.
            if kernel.all.len() == MAX_VOXELS {
                return Err(Refused::TooFine {
                    radius_mm: high,
                    voxels: reach.iter().map(|r| 2 * *r as usize + 1).product(),
                    limit: MAX_VOXELS,
                });
            }
            kernel.all.push(offset);
            // A voxel always stands for a ball smaller than itself.
            if d.norm() <= low || offset == [0; 3] {
                kernel.inner.push(offset);
            }
            if within(half) {
                kernel.core.push(offset);
            }
            // Between the ball's faded rim and this shell nothing is taken: it is neither metal nor ground.
            if !within(near) {
                kernel.ring.push(offset);
            }
        }
        kernel.probes = probes(&kernel.ring);
        Ok(kernel)
    }

    /// Whether a voxel is brighter by `contrast` than the darkest of the probes: a cheap look before the sums.
    pub(super) fn stands_out(&self, voxels: &dyn Voxels, at: [u32; 3], contrast: f64) -> bool {
        let places = self.probes.iter().filter_map(|offset| moved(voxels, at, *offset));
        let darkest = places.map(|place| voxels.at(place)).min();
        // Without a probe in the volume nothing speaks against the voxel: the sums decide.
        darkest.is_none_or(|dark| f64::from(voxels.at(at)) - f64::from(dark) >= contrast)
    }

    /// The number of voxels of the shell.
    pub(super) fn ring_voxels(&self) -> usize {
        self.ring.len()
    }

    /// The detector's value at a voxel of the volume; of the shell only what lies within it counts (5.1). `None` where
    /// that is nothing.
    pub(super) fn response(&self, voxels: &dyn Voxels, at: [u32; 3]) -> Option<Response> {
        let (inner, ring) = (Sums::of(voxels, at, &self.inner), Sums::of(voxels, at, &self.ring));
        if ring.count == 0 {
            return None;
        }
        let ([inside, within], [ground, around]) = (inner.mean_and_deviation(), ring.mean_and_deviation());
        Some(Response {
            contrast_to_noise: (inside - ground) / (within + 0.5 * around + QUANTUM_HU),
            ground_hu: ground,
            ground_deviation_hu: around,
            peak_hu: f64::from(inner.peak),
            ring_peak_hu: f64::from(ring.peak),
            ring_inside: ring.count as usize,
        })
    }

    /// The centre of what is brighter than `level` near a voxel, as a continuous voxel index, weighted by what is over the
    /// level. `None` where nothing is.
    pub(super) fn centroid(&self, voxels: &dyn Voxels, at: [u32; 3], level: f64) -> Option<[f64; 3]> {
        let (mut sum, mut total) = ([0.0; 3], 0.0);
        for place in self.core.iter().filter_map(|offset| moved(voxels, at, *offset)) {
            let over = f64::from(voxels.at(place)) - level;
            if over > 0.0 {
                total += over;
                (0..3).for_each(|axis| sum[axis] += over * f64::from(place[axis]));
            }
        }
        (total > 0.0).then(|| sum.map(|s| s / total))
    }
}

/// The voxel at an offset, where it is in the volume.
pub(super) fn moved(voxels: &dyn Voxels, at: [u32; 3], offset: [i32; 3]) -> Option<[u32; 3]> {
    let dims = voxels.grid().dims();
    let mut place = [0; 3];
    for axis in 0..3 {
        place[axis] = at[axis].checked_add_signed(offset[axis]).filter(|i| *i < dims[axis])?;
    }
    Some(place)
}

/// How many voxels along each axis hold a ball of this radius: the radius over the distance of the planes of voxels.
fn reach(optics: &Optics, radius_mm: f64) -> [i32; 3] {
    let inverse = optics.steps.try_inverse().unwrap_or_default();
    // A grid's least step is 1e-3 mm and its cell 0.17 of a box: at most some 10 000.
    std::array::from_fn(|axis| (radius_mm * inverse.row(axis).norm()).ceil().min(1e5) as i32)
}

fn probes(ring: &[[i32; 3]]) -> Vec<[i32; 3]> {
    let nearest = |axis: usize, sign: i32| {
        let along = |o: &&[i32; 3]| o[axis] * sign > 0 && (0..3).all(|a| a == axis || o[a] == 0);
        ring.iter().filter(along).min_by_key(|o| o[axis].abs()).copied()
    };
    (0..3)
        .flat_map(|axis| [-1, 1].into_iter().filter_map(move |sign| nearest(axis, sign)))
        .collect()
}

fn offsets([x, y, z]: [i32; 3]) -> impl Iterator<Item = [i32; 3]> {
    (-z..=z).flat_map(move |k| (-y..=y).flat_map(move |j| (-x..=x).map(move |i| [i, j, k])))
}

/// Exact sums.
struct Sums {
    count: i64,
    sum: i64,
    squares: i64,
    peak: i16,
}

impl Sums {
    fn of(voxels: &dyn Voxels, at: [u32; 3], offsets: &[[i32; 3]]) -> Self {
        let mut sums = Self {
            count: 0,
            sum: 0,
            squares: 0,
            peak: i16::MIN,
        };
        for place in offsets.iter().filter_map(|offset| moved(voxels, at, *offset)) {
            let value = voxels.at(place);
            sums.peak = sums.peak.max(value);
            let value = i64::from(value);
            sums.count += 1;
            sums.sum += value;
            sums.squares += value * value;
        }
        sums
    }

    /// (5.1). `n^2 sigma^2 = n S[v^2] - S[v]^2` is formed exactly: at most 60 000^2 x 2^30.
    fn mean_and_deviation(&self) -> [f64; 2] {
        if self.count == 0 {
            return [0.0; 2];
        }
        let n = self.count as f64;
        let spread = i128::from(self.count) * i128::from(self.squares) - i128::from(self.sum) * i128::from(self.sum);
        [self.sum as f64 / n, (spread as f64).sqrt() / n]
    }
}
