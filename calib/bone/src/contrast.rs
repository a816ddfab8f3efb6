//! Whether contrast medium explains what is taken for cortex.
//!
//! Cortex is one layer between tissue and inside; a vessel's blood, or an organ with contrast medium, is another: of at most the HU that contrast gives,
//! not thinner than a vessel, with anything behind it, bone too. Both are fitted to the same voxels by the same model ([`crate::model`]), and the
//! costs are compared. A mere step from tissue to contrast medium is fitted by a layer of cortex that goes to nothing, as well as by the other; that
//! cortex is not as thin as that is known of the places of this bone.

use crate::patch::Patch;
use crate::solve::{Fit, Layer, Noise, Priors, fit, squares};

/// No thinner vessel is told from cortex, mm.
const LEAST_VESSEL_MM: f64 = 2.5;
/// Thickness of a vessel, mm, and deviation of its logarithm.
const VESSEL_MM: [f64; 2] = [6.0, 0.8];
/// HU of contrast medium as shares of the most, mean and deviation.
const SHARES: [f64; 2] = [0.65, 0.35];
/// What is behind it is as bright where it differs by less than this share.
const SAME: f64 = 0.15;
/// HU behind it: more contrast medium, tissue or bone.
const BEHIND_HU: [f64; 2] = [200.0, 300.0];

/// The layer of contrast medium that explains a place best, beside its cortex.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contrast {
    /// HU of that layer.
    pub hu: f64,
    /// Its thickness, mm; infinite where what is behind it is as bright, to 15 %.
    pub mm: f64,
    /// By how much cortex explains the voxels better: difference of the logarithms of the likelihoods, with as many voxels less as go together.
    pub by_voxels: f64,
    /// The same, with what is known of cortex and of vessels beforehand.
    pub by_all: f64,
}

impl Contrast {
    /// Of a CT without contrast medium.
    const NONE: Self = Self {
        hu: 0.0,
        mm: 0.0,
        by_voxels: f64::INFINITY,
        by_all: f64::INFINITY,
    };
}

/// Compares cortex, as it was fitted, with contrast medium of at most `most_hu`; of 0 there is none.
pub(crate) fn contrast(patch: &Patch, priors: &Priors, noise: &Noise, bone: &Fit, most_hu: f64) -> Contrast {
    if most_hu <= 0.0 {
        return Contrast::NONE;
    }
    let vessel = Priors {
        cortex_hu: SHARES.map(|share| share * most_hu),
        inside_hu: BEHIND_HU,
        log_thickness: [VESSEL_MM[0].ln(), VESSEL_MM[1]],
        layer: Layer {
            tried_mm: [3.0, 5.0, 9.0],
            thickness_mm: [LEAST_VESSEL_MM, 15.0],
            most_hu,
        },
        ..*priors
    };
    let Some(other) = fit(patch, &vessel, noise.hu, None) else {
        // Nothing is told of either.
        return Contrast {
            hu: most_hu,
            mm: 0.0,
            by_voxels: 0.0,
            by_all: 0.0,
        };
    };
    // The noise that was measured is not all: what the model leaves counts too.
    let worse = (bone.residual_hu2 / (noise.hu * noise.hu)).max(1.0);
    // Correlated noise tells less: as many voxels less as go together.
    let together: f64 = noise.neighbours.iter().map(|c| 1.0 + 2.0 * c.max(0.0)).product();
    let squares = squares(patch, &other.at) - squares(patch, &bone.at);
    let by_voxels = 0.5 * squares / (noise.hu * noise.hu * worse * together);
    // A filled organ has no far wall: its layer is as thick as can be.
    let is_filled = (other.at[3] - other.at[2]).abs() < SAME * other.at[2];
    let known = 0.5 * (vessel.squares(&other.at) - priors.squares(&bone.at));
    Contrast {
        hu: other.at[2],
        mm: if is_filled { f64::INFINITY } else { other.at[1].exp() },
        by_voxels,
        by_all: by_voxels + known,
    }
}
