//! The whole search: the steps of the crate's documentation, one after the other.

use geometry::{Ct, Point};
use nalgebra::{Matrix3, Vector3};

use super::accept::{accept_refit, check_metal_and_centre, check_model, deserves_refit};
use super::fit::{Expected, Fitted, Sample, fit};
use super::initial_height::height;
use super::kernel::{Kernel, Response, moved};
use super::optics::Optics;
use super::profile::Blur;
use super::profiles::average_over_profiles;
use super::refine::{Refined, refine};
use super::seeds::seeds;
use super::{Reason, Refused, Search, Voxels};

/// HU of air: on the skin a bead's surroundings may be that dark.
const AIR_HU: f64 = -1000.0;
/// The least contrast by which a bead can be told from bone at all, HU.
const LEAST_CONTRAST_HU: f64 = 300.0;
/// The greatest least contrast that is asked of a bead, HU: half of what 12 bits hold.
const MOST_CONTRAST_HU: f64 = 1500.0;
/// Share of the least contrast by which a voxel must be brighter than the darkest of the shell's six probes, before the
/// detector's sums are formed.
const PROBE_CONTRAST: f64 = 0.7;
/// The most contrast that a voxel of the shell may have, as a share of the spot's own.
const MOST_AROUND: f64 = 0.6;
/// The least share of the shell's voxels that must lie in the volume.
const LEAST_WITHIN: f64 = 0.5;
/// Standard deviations of the priors of the logarithms of blur and of the metal's HU.
const LOG_BLUR_SIGMA: f64 = 0.3;
const LOG_METAL_SIGMA: f64 = 1.0;
/// The same of the blur along the normal where a slice is taken for a mean over its thickness: what was averaged are thin
/// slices of unknown blur.
const LOG_AVERAGED_BLUR_SIGMA: f64 = 0.6;
/// Standard error of the centre because the blur is not Gaussian, in steps between voxels: a box-shaped slice of 3 mm shifts
/// the centre by 0.02 mm.
const MODEL_ERROR_VOXELS: f64 = 0.005;
/// The most spots that are fitted again on a random field, some tenths of a second each; no patient wears so many beads.
const MAX_REFINED: usize = 512;
/// The most rejected spots that are reported.
const MAX_REJECTED: usize = 256;

/// A metal bead.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bead {
    /// Its centre, mm.
    pub centre: Point<Ct>,
    /// Covariance of the centre, mm^2: by the covariance of the ground, whose deviations are the likeliest
    /// ([`Search::ground`]), and 0.5 % of a voxel because the blur is not Gaussian.
    pub covariance: Matrix3<f64>,
    /// Its centre as a continuous voxel index.
    pub voxel: [f64; 3],
    /// Radius, and deviation of it, mm: near the middle of the range that was asked for where the voxels do not tell.
    pub radius_mm: [f64; 2],
    /// Blur: deviation in the slice's plane and along its normal, mm.
    pub blur_mm: [f64; 2],
    /// HU over the surroundings, before blur and clipping.
    pub metal_hu: f64,
    /// HU of the surroundings.
    pub ground_hu: f64,
    /// Brightest voxel over the surroundings, HU.
    pub contrast_hu: f64,
    /// The detector's contrast to noise (5.3).
    pub chi: f64,
    /// Root mean square residual of the model where the ball shines, HU.
    pub residual_hu: f64,
    /// Voxels at the clipping value.
    pub clipped: usize,
}

impl Bead {
    /// Root mean square error of the centre that the covariance predicts, mm.
    pub fn error_rms_mm(&self) -> f64 {
        self.covariance.trace().max(0.0).sqrt()
    }
}

/// A bright spot that was not taken for a bead.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rejected {
    /// Where it is, to about half a voxel, mm.
    pub place: Point<Ct>,
    /// Brightest voxel over its surroundings, HU.
    pub contrast_hu: f64,
    /// Why.
    pub reason: Reason,
}

/// What a search found.
#[derive(Debug, Clone, PartialEq)]
pub struct Found {
    /// Ascending by slice, row, column.
    pub beads: Vec<Bead>,
    /// Bright spots that are no beads, of the greatest contrast first; at most 256.
    pub rejected: Vec<Rejected>,
    /// Local maxima that stand out from what is around them, and were looked at.
    pub spots: usize,
    /// Least HU over the surroundings that was asked for.
    pub least_contrast_hu: f64,
    /// Where the scanner clips, HU.
    pub clip_hu: Option<i16>,
}

/// A spot that the detector accepts.
#[derive(Debug, Clone, Copy)]
struct Candidate {
    voxel: [u32; 3],
    place: Vector3<f64>,
    response: Response,
}

/// Finds the metal beads of a volume. Time is bounded by the volume's size and by the number of bright spots.
///
/// # Errors
/// [`Refused`]. No bead is no error.
pub fn find(voxels: &dyn Voxels, search: &Search) -> Result<Found, Refused> {
    check(search)?;
    let finder = Finder::new(voxels, search)?;
    let stands_out = |at| {
        finder
            .kernel
            .stands_out(voxels, at, PROBE_CONTRAST * finder.least_contrast)
    };
    let seeds = seeds(voxels, AIR_HU + finder.least_contrast, stands_out)?;
    // A clipping value that the search names takes precedence over the one that the voxels suggest.
    let clip_hu = search.clip_hu.or(seeds.clip_hu);
    let mut rejected = Vec::new();
    let candidates = finder.candidates(&seeds.voxels, &mut rejected);
    let mut beads: Vec<Bead> = Vec::new();
    for (candidate, model) in candidates.iter().zip(finder.models(&candidates, clip_hu)) {
        match model.and_then(|fitted| check_metal_and_centre(&fitted, search, &finder.optics).map(|()| fitted)) {
            Ok(fitted) => beads.push(finder.bead(candidate, &fitted)),
            Err(reason) => rejected.push(finder.rejected(candidate, reason)),
        }
    }
    // In the order of the volume, not in that of finding: results can be compared line by line.
    beads.sort_by(|a, b| order(&a.voxel).total_cmp(&order(&b.voxel)));
    rejected.sort_by(|a, b| b.contrast_hu.total_cmp(&a.contrast_hu));
    // The brightest are kept: they are what a person may have taken for a bead.
    rejected.truncate(MAX_REJECTED);
    Ok(Found {
        beads,
        rejected,
        spots: seeds.voxels.len(),
        least_contrast_hu: finder.least_contrast,
        clip_hu,
    })
}

/// Slices first, then rows, then columns, each of at most 16384.
fn order([x, y, z]: &[f64; 3]) -> f64 {
    (z * 16_384.0 + y) * 16_384.0 + x
}

struct Finder<'a> {
    voxels: &'a dyn Voxels,
    search: &'a Search,
    optics: Optics,
    kernel: Kernel,
    least_contrast: f64,
}

impl<'a> Finder<'a> {
    fn new(voxels: &'a dyn Voxels, search: &'a Search) -> Result<Self, Refused> {
        let optics = Optics::of(voxels.grid())?;
        let least_hu = search.metal_hu * optics.least_share(search);
        if 0.5 * least_hu < LEAST_CONTRAST_HU {
            return Err(Refused::TooCoarse {
                radius_mm: search.radius_mm[0],
                metal_hu: search.metal_hu,
                least_hu,
                needed_hu: 2.0 * LEAST_CONTRAST_HU,
                spacing_mm: voxels.grid().spacing_mm(),
            });
        }
        Ok(Self {
            voxels,
            search,
            kernel: Kernel::new(&optics, search)?,
            optics,
            least_contrast: (0.5 * least_hu).min(MOST_CONTRAST_HU),
        })
    }

    /// The spots that the detector accepts, each once, the best first.
    fn candidates(&self, seeds: &[[u32; 3]], rejected: &mut Vec<Rejected>) -> Vec<Candidate> {
        let mut all: Vec<Candidate> = seeds.iter().filter_map(|seed| self.centred(*seed)).collect();
        all.sort_by(|a, b| {
            b.response
                .contrast_to_noise
                .total_cmp(&a.response.contrast_to_noise)
                .then(a.voxel.cmp(&b.voxel))
        });
        let mut kept: Vec<Candidate> = Vec::new();
        let apart = self.search.radius_mm[1]
            .max(self.optics.step_mm[0])
            .max(self.optics.step_mm[1]);
        for candidate in all {
            if kept.iter().any(|other| (other.place - candidate.place).norm() <= apart) {
                continue;
            }
            match self.detector_rejection(&candidate.response) {
                None => kept.push(candidate),
                Some(reason) => rejected.push(self.rejected(&candidate, reason)),
            }
        }
        kept
    }

    /// The spot's middle by the centroid of what is brighter than half its contrast; `None` where it is too dim.
    fn centred(&self, seed: [u32; 3]) -> Option<Candidate> {
        let (mut voxel, mut place) = (seed, seed.map(f64::from));
        let mut response = self.kernel.response(self.voxels, voxel)?;
        for _ in 0..4 {
            if response.contrast() < self.least_contrast {
                return None;
            }
            let level = response.ground_hu + 0.5 * response.contrast();
            let centre = self.kernel.centroid(self.voxels, voxel, level)?;
            place = centre;
            let next = centre.map(|c| c.round() as u32);
            if next == voxel {
                break;
            }
            voxel = next;
            response = self.kernel.response(self.voxels, voxel)?;
        }
        let bright = response.contrast() >= self.least_contrast;
        bright.then(|| Candidate {
            voxel,
            place: self.optics.place(place),
            response,
        })
    }

    /// Why the detector refuses a spot; `None` where it accepts it.
    fn detector_rejection(&self, response: &Response) -> Option<Reason> {
        if response.contrast_to_noise < self.search.least_chi {
            return Some(Reason::Chi {
                found: response.contrast_to_noise,
                needed: self.search.least_chi,
            });
        }
        let (within, all) = (response.ring_inside, self.kernel.ring_voxels());
        if (within as f64) < LEAST_WITHIN * all as f64 {
            return Some(Reason::AtBorder { within, all });
        }
        let share = (response.ring_peak_hu - response.ground_hu) / response.contrast();
        (share > MOST_AROUND).then_some(Reason::NotAlone {
            share,
            most: MOST_AROUND,
        })
    }

    fn rejected(&self, candidate: &Candidate, reason: Reason) -> Rejected {
        let p = candidate.place;
        Rejected {
            place: Point::new(p.x, p.y, p.z),
            contrast_hu: candidate.response.contrast(),
            reason,
        }
    }

    /// What fits the candidates, whatever the profile of the slices.
    fn models(&self, candidates: &[Candidate], clip_hu: Option<i16>) -> Vec<Result<Fitted, Reason>> {
        let profiles = self.optics.profiles(self.search.radius());
        let with = |blur: Blur| self.with_profile(candidates, blur, clip_hu);
        average_over_profiles(profiles.into_iter().map(with).collect())
    }

    /// What fits them with a given profile. At most 512 are fitted again on a random field.
    fn with_profile(&self, candidates: &[Candidate], blur: Blur, clip_hu: Option<i16>) -> Vec<Result<Fitted, Reason>> {
        let mut refits_left = MAX_REFINED;
        let mut model = |candidate: &Candidate| {
            let samples = self.samples(candidate, &self.optics.axes(), clip_hu);
            let mut expected = self.expected(blur, &candidate.response);
            // In thick slices the fit has several minima along the axis: it begins with the likeliest height.
            if self.optics.is_thick() {
                expected.height_mm = height(&samples, &blur, self.optics.step_mm[1]);
            }
            let fitted = fit(&samples, &expected);
            let accepted = match &fitted {
                Some(fitted) => check_model(fitted, self.search, &self.optics),
                None => Err(Reason::NoFit),
            };
            // A refusal for a reason that a better background cannot change is final.
            let refit = accepted.as_ref().err().is_none_or(deserves_refit);
            if !refit || refits_left == 0 {
                return accepted.and(fitted.ok_or(Reason::NoFit));
            }
            // A refit costs a factorisation as large as the window: their number is bounded, whatever the volume holds.
            refits_left -= 1;
            let refined = refine(&samples, &expected, clip_hu, self.search.ground).filter(|r| self.is_near(r));
            match (accepted, refined) {
                (Ok(()), refined) => refined.and_then(|r| r.fitted()).or(fitted).ok_or(Reason::NoFit),
                (Err(reason), refined) => refined
                    .and_then(|r| accept_refit(&r, self.search, &self.optics))
                    .ok_or(reason),
            }
        };
        candidates.iter().map(&mut model).collect()
    }

    /// Whether a refined centre is still at its spot, and known well enough to say so: neither its distance from the spot nor
    /// its deviation is more than the greatest radius, or the step between slices.
    fn is_near(&self, refined: &Refined) -> bool {
        let most = self.search.radius_mm[1].max(self.optics.step_mm[1]);
        refined.centre().norm() <= most && refined.deviation_mm() <= most
    }

    fn bead(&self, candidate: &Candidate, fitted: &Fitted) -> Bead {
        let axes = self.optics.axes();
        let place = candidate.place + axes * fitted.centre;
        let voxel = self.optics.index(self.voxels.grid(), place);
        let radius = fitted.blur.radius_mm;
        Bead {
            centre: Point::new(place.x, place.y, place.z),
            covariance: axes * (fitted.covariance + self.model_error()) * axes.transpose(),
            voxel,
            radius_mm: [radius, radius * fitted.radius_deviation],
            blur_mm: [fitted.blur.plane_mm, fitted.blur.profile_mm()],
            metal_hu: fitted.metal_hu,
            ground_hu: fitted.ground_hu,
            contrast_hu: candidate.response.contrast(),
            chi: candidate.response.contrast_to_noise,
            residual_hu: fitted.residual_hu,
            clipped: fitted.clipped,
        }
    }

    /// The covariance of the centre's error because the blur is not Gaussian, in the axes of [`Optics::axes`], mm^2.
    fn model_error(&self) -> Matrix3<f64> {
        let [plane, axial] = self.optics.step_mm.map(|step| (MODEL_ERROR_VOXELS * step).powi(2));
        Matrix3::from_diagonal(&Vector3::new(plane, plane, axial))
    }

    fn samples(&self, candidate: &Candidate, axes: &Matrix3<f64>, clip_hu: Option<i16>) -> Vec<Sample> {
        let sample = |offset: &[i32; 3]| {
            let place = moved(self.voxels, candidate.voxel, *offset)?;
            let value = self.voxels.at(place);
            let d = self.optics.place(place.map(f64::from)) - candidate.place;
            Some(Sample {
                place: axes.transpose() * d,
                hu: f64::from(value),
                clipped: clip_hu.is_some_and(|clip| value >= clip),
            })
        };
        self.kernel.all.iter().filter_map(sample).collect()
    }

    fn expected(&self, blur: Blur, response: &Response) -> Expected {
        let [low, high] = self.search.radius_mm;
        // The range of radii is taken for two deviations of the logarithm to either side of its middle.
        let log_radius_sigma = 0.25 * (high / low).ln();
        let averaged = blur.slice_mm > 0.0;
        let axial = if averaged {
            LOG_AVERAGED_BLUR_SIGMA
        } else {
            LOG_BLUR_SIGMA
        };
        Expected {
            blur,
            // The search names the least HU, and most metals have more: the prior's middle is twice the least, which lies
            // within the prior's deviation, a factor of e either way.
            metal_hu: 2.0 * self.search.metal_hu,
            height_mm: 0.0,
            // A range of one radius would give its prior an infinite weight.
            deviations: [log_radius_sigma.max(0.02), LOG_BLUR_SIGMA, axial, LOG_METAL_SIGMA],
            noise_hu: response.ground_deviation_hu,
            ground_hu: response.ground_hu,
            contrast_hu: response.contrast(),
        }
    }
}

/// Refuses thresholds that no bead could have.
fn check(search: &Search) -> Result<(), Refused> {
    let [low, high] = search.radius_mm;
    // A NaN is in no range.
    let sound = low > 0.0 && high >= low && high <= Search::MAX_RADIUS_MM;
    if !sound {
        return Err(Refused::Radius(search.radius_mm));
    }
    if !(Search::LEAST_METAL_HU..=1e6).contains(&search.metal_hu) {
        return Err(Refused::Metal(search.metal_hu));
    }
    Ok(())
}
