//! The label map that names the bone.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use bus::volume::LabelMap;
use guidance::safety::{GridMatch, LabelNames};
use scene::VolumeSpec;

use super::error::BoneError;
use super::readers::Readers;
use crate::beads::Volume;

/// Other labels whose mean is more than this share of the threshold may be bone, or vessels with contrast medium: they are kept out.
const BRIGHT: f64 = 0.6;
/// Labels that are named where one is not found.
const NAMED: usize = 40;

/// A label map on the CT's voxels.
pub(super) struct Labelled {
    map: LabelMap,
    /// The CT's voxel that its first lies on.
    first: [u32; 3],
    label: i16,
    others: Vec<i16>,
    pub(super) path: PathBuf,
    /// The bone, in words.
    pub(super) name: String,
    /// The labels that are kept out, in words.
    pub(super) kept_out: Vec<String>,
}

/// HU of a label's voxels.
#[derive(Debug, Clone, Copy, Default)]
struct Sum {
    hu: i64,
    voxels: i64,
}

impl Labelled {
    pub(super) fn read(
        path: &Path,
        (asked, excluded): (&str, &[String]),
        (volume, spec): (&Volume, &VolumeSpec),
        hands: &Readers,
        threshold_hu: f64,
    ) -> Result<Self, BoneError> {
        let fail = |source| BoneError::Labels {
            path: path.to_owned(),
            source,
        };
        let map = (hands.labels)(path, spec).map_err(fail)?;
        let names = (hands.label_names)(path).map_err(fail)?;
        let first = match map.lies_on(&volume.0.grid) {
            GridMatch::Same => [0; 3],
            GridMatch::Part { first, .. } => first,
            other => {
                return Err(BoneError::OtherGrid {
                    path: path.to_owned(),
                    found: in_words(other),
                });
            }
        };
        let sums = sums(&map, volume, first);
        let find = |asked: &str| find(asked, &names, &sums);
        let unknown = |asked: &str| BoneError::NoLabel {
            path: path.to_owned(),
            asked: asked.to_owned(),
            known: known(&names, &sums),
        };
        let label = find(asked).ok_or_else(|| unknown(asked))?;
        let mut others = Vec::new();
        for name in excluded {
            others.push(find(name).ok_or_else(|| unknown(name))?);
        }
        let is_bright = |sum: &Sum| sum.hu as f64 >= BRIGHT * threshold_hu * sum.voxels as f64;
        others.extend(
            sums.iter()
                .filter(|(other, sum)| **other != label && is_bright(sum))
                .map(|(other, _)| *other),
        );
        others.sort_unstable();
        others.dedup();
        Ok(Self {
            first,
            label,
            path: path.to_owned(),
            name: names.words(label),
            kept_out: others.iter().map(|other| names.words(*other)).collect(),
            others,
            map,
        })
    }

    /// The label of a voxel of the CT; 0 beside the map.
    fn at(&self, voxel: [u32; 3]) -> i16 {
        let dims = self.map.volume.grid.dims();
        let mut there = [0; 3];
        for k in 0..3 {
            match voxel[k].checked_sub(self.first[k]) {
                Some(at) if at < dims[k] => there[k] = at,
                _ => return 0,
            }
        }
        self.map.volume.view().at(there)
    }

    pub(super) fn is_in(&self, voxel: [u32; 3]) -> bool {
        self.at(voxel) == self.label
    }

    pub(super) fn is_other(&self, voxel: [u32; 3]) -> bool {
        let label = self.at(voxel);
        label != 0 && self.others.binary_search(&label).is_ok()
    }
}

/// How a map lies that is not on the CT's voxels.
fn in_words(found: GridMatch) -> String {
    match found {
        GridMatch::Moved { by_mm: [x, y, z] } => {
            format!("it is moved by {x:.2}, {y:.2}, {z:.2} mm (left, posterior, superior)")
        }
        _ => "its voxels are others in number, size or direction".to_owned(),
    }
}

fn sums(map: &LabelMap, volume: &Volume, first: [u32; 3]) -> BTreeMap<i16, Sum> {
    let mut sums: BTreeMap<i16, Sum> = BTreeMap::new();
    let [nx, ny, nz] = map.volume.grid.dims();
    let (labels, hu) = (map.volume.view(), volume.0.view());
    for z in 0..nz {
        for y in 0..ny {
            for x in 0..nx {
                let label = labels.at([x, y, z]);
                if label != 0 {
                    let sum = sums.entry(label).or_default();
                    sum.hu += i64::from(hu.at([x + first[0], y + first[1], z + first[2]]));
                    sum.voxels += 1;
                }
            }
        }
    }
    sums
}

/// A label that is there, by its number or its name.
fn find(asked: &str, names: &LabelNames, sums: &BTreeMap<i16, Sum>) -> Option<i16> {
    let number = asked.parse::<i16>().ok().filter(|label| sums.contains_key(label));
    number.or_else(|| sums.keys().copied().find(|label| names.get(*label) == Some(asked)))
}

fn known(names: &LabelNames, sums: &BTreeMap<i16, Sum>) -> String {
    let words: Vec<String> = sums.keys().take(NAMED).map(|label| names.words(*label)).collect();
    let more = sums.len().saturating_sub(NAMED);
    let more = if more > 0 {
        format!(" and {more} more")
    } else {
        String::new()
    };
    words.join(", ") + &more
}
