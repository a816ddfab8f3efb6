//! Voxels that nothing measured: beyond the field of reconstruction, between slices that are missing, where the file had no number.
//!
//! Files seldom say which these are. Below [`LOWEST_HU`] nothing is measured. What has the padding's value or air's and less is no
//! measurement where a block of 3 x 3 x 3 voxels has one value: a scanner's noise of `s` HU leaves a block of `n` voxels alike with the
//! probability `(2 pi s^2)^(-(n - 1) / 2) / sqrt(n)`, which for 27 voxels is below 1e-10 from 1 HU on; and air that a scanner holds to its
//! least value is as good as none beside bone. What is the padding's value alone stands where no blur lets air stand: a full step of tissue
//! away within one voxel.

use crate::fill::{dilated, for_each, neighbours};
use crate::voxels::Crop;

/// No scanner measures less, HU: air at -1000 and five deviations of a noise of 40.
const LOWEST_HU: i16 = -1200;
/// Air, HU: of one value throughout it is no measurement.
const AIR_HU: i16 = -1000;
/// Air's last step to what lies beside it is smaller, HU: of a blur of half a voxel, whose last step of 1000 HU is a sixth.
const STEP_HU: i16 = 600;

/// What nothing measured is 1, and so are the voxels that share a face, an edge or a corner with it: where a volume was resampled they are
/// mixed with it.
pub(crate) fn gaps(crop: &Crop, padding_hu: Option<i16>) -> Vec<u8> {
    let is_suspect = |hu: i16| hu <= AIR_HU || Some(hu) == padding_hu;
    let around = around();
    let mut flat = vec![0; crop.hu.len()];
    let mut gaps = flat.clone();
    for_each(crop, |at, place| {
        let hu = crop.hu[at];
        let is_alone = || {
            let beside = neighbours(crop, place).map(|other| crop.hu[other]).max();
            Some(hu) == padding_hu && hu <= AIR_HU && beside.is_some_and(|most| most.saturating_sub(hu) >= STEP_HU)
        };
        gaps[at] = u8::from(hu < LOWEST_HU || is_alone());
        if is_suspect(hu) && within(crop, place, &around).all(|other| crop.hu[other] == hu) {
            flat[at] = 1;
        }
    });
    for_each(crop, |at, place| {
        // The rim of a block of one value is of it as well.
        let is_rim = || within(crop, place, &around).any(|other| flat[other] == 1 && crop.hu[other] == crop.hu[at]);
        if flat[at] == 1 || (is_suspect(crop.hu[at]) && is_rim()) {
            gaps[at] = 1;
        }
    });
    dilated(crop, &gaps, 1, &around)
}

/// The steps to the 26 voxels around one.
fn around() -> Vec<[i32; 3]> {
    let steps = (0..27).map(|i| [i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1]);
    steps.filter(|step| *step != [0; 3]).collect()
}

fn within<'a>(crop: &'a Crop, place: [usize; 3], steps: &'a [[i32; 3]]) -> impl Iterator<Item = usize> + 'a {
    steps.iter().filter_map(move |step| {
        let to = [0, 1, 2].map(|k| place[k] as i64 + i64::from(step[k]));
        let is_in = (0..3).all(|k| to[k] >= 0 && to[k] < crop.dims[k] as i64);
        is_in.then(|| crop.offset(to.map(|k| k as usize)))
    })
}
