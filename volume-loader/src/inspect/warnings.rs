//! What is doubtful about a volume, in sentences for a person.

use bus::volume::VolumeView;

use super::statistics::distinct_padding;
use super::{Changed, Handedness, Place, Summary};

/// Tilts and slants above this are said, degrees: a gantry's and a scanner's rounding are below.
const ANGLE_DEGREES: f64 = 0.05;
/// Slices so much farther apart than pixels lose what lies between.
const ANISOTROPY: f64 = 4.0;
/// Air is below this, HU; a volume that has nothing below has none, or is not HU.
const AIR_BELOW_HU: i16 = -500;

/// Every sentence that holds.
pub(super) fn of(summary: &Summary) -> Vec<String> {
    let range = summary.hu.as_ref().map(|hu| [hu.min, hu.max]);
    let changes = changes(&summary.changed, summary.voxels, &summary.marks);
    let all = [place(&summary.place), values(range), changes];
    all.into_iter().flatten().collect()
}

/// The same of a volume in memory.
pub(crate) fn of_volume(view: &VolumeView<'_>, changed: &Changed, marks: &str) -> Vec<String> {
    let [columns, rows, slices] = view.grid.dims();
    let (padding, mut range) = (distinct_padding(view.padding_hu), None);
    let mut slice = vec![0; columns as usize * rows as usize];
    for z in 0..slices {
        view.slice(z, &mut slice);
        for &hu in slice.iter().filter(|hu| Some(**hu) != padding) {
            range = Some(range.map_or([hu; 2], |[min, max]: [i16; 2]| [min.min(hu), max.max(hu)]));
        }
    }
    let changes = changes(changed, view.grid.voxels(), marks);
    let all = [place(&Place::of(view.grid)), values(range), changes];
    all.into_iter().flatten().collect()
}

fn place(place: &Place) -> Vec<String> {
    let mut said = Vec::new();
    if place.tilt_degrees > ANGLE_DEGREES {
        said.push(format!(
            "slices are shifted against one another: the third axis is {:.2} degrees off their normal, as with a tilted gantry",
            place.tilt_degrees
        ));
    }
    if place.slant_degrees > ANGLE_DEGREES {
        said.push(format!(
            "rows and columns are {:.3} degrees off a right angle",
            place.slant_degrees
        ));
    }
    if place.handedness == Handedness::LeftHanded {
        said.push(
            "the voxel axes are left-handed: one of them is mirrored, which is sound as long as every reader keeps it"
                .to_owned(),
        );
    }
    let [x, y, z] = place.spacing_mm;
    let (least, most) = (x.min(y).min(z), x.max(y).max(z));
    if most / least > ANISOTROPY {
        said.push(format!(
            "voxels are {most:.3} mm long and {least:.3} mm wide: planes across the slices are coarse"
        ));
    }
    if place.dims.contains(&1) {
        said.push("the volume is one voxel thin: only one plane can be cut from it".to_owned());
    }
    said
}

fn values(range: Option<[i16; 2]>) -> Vec<String> {
    let Some([min, max]) = range else {
        return vec!["every voxel is padding: nothing was measured".to_owned()];
    };
    let mut said = Vec::new();
    if min == max {
        said.push(format!("every voxel holds {min} HU"));
    } else if min > AIR_BELOW_HU {
        said.push(format!(
            "no voxel is below {AIR_BELOW_HU} HU (the least is {min}): there is no air, or the numbers are not HU"
        ));
    }
    said
}

fn changes(changed: &Changed, voxels: u64, marks: &str) -> Vec<String> {
    let counts = [
        (changed.clamped_low, "below -32768 HU and are held to it"),
        (changed.clamped_high, "above 32767 HU and are held to it"),
        (changed.not_finite, "not numbers and became padding"),
        (changed.rounded, "fractions and were rounded"),
    ];
    let counts = counts.into_iter().filter(|(count, _)| *count > 0);
    let mut said: Vec<String> = counts
        .map(|(count, what)| format!("{count} of {voxels} voxels were {what}"))
        .collect();
    if !marks.is_empty() {
        said.push(format!("these are not the scanner's voxels, or not all: {marks}"));
    }
    said
}
