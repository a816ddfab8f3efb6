//! `[volume]`: where the examination comes from, and how much of it is loaded.

use std::path::{Path, PathBuf};

use geometry::{Ct, Point};
use serde::{Deserialize, Serialize};

use super::Target;
use super::values::{Checked, invalid, number, point};

/// Largest number of voxels along an axis that become one.
const MAX_DOWNSAMPLE: u32 = 16;
/// A margin around the targets, mm.
const MARGIN_MM: std::ops::RangeInclusive<f64> = 0.0..=1000.0;

/// `[volume]` as it is written.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RawVolume {
    /// `phantom`, or the path of a file or of a folder with a DICOM series.
    pub source: String,
    /// Phantom only: voxel spacing, mm.
    pub spacing_mm: f64,
    /// DICOM only: which series of the folder, from 1 in the order that the loader lists; needed where there are several.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub series: Option<u32>,
    /// DICOM only: slices at uneven places are interpolated to even ones instead of refused.
    pub regrid: bool,
    /// Files that tell no side from the other: their axes are taken as left, posterior, superior instead of refused.
    pub assume_lps: bool,
    /// How many voxels along each axis become one.
    pub downsample: [u32; 3],
    /// The only examination that may be loaded, by its hash; absent: whichever lies there.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hash: Option<String>,
    /// The part to load; absent: all of it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub region: Option<RawRegion>,
}

/// `[volume.region]` as it is written: one of the three.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RawRegion {
    /// This far around the targets and the planned path, mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub margin_mm: Option<f64>,
    /// Two opposite corners of a box along the patient's axes, LPS mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub box_mm: Option<[[f64; 3]; 2]>,
    /// First voxel and the one behind the last, along the examination's own axes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub box_voxels: Option<[[u32; 3]; 2]>,
}

impl Default for RawVolume {
    fn default() -> Self {
        Self {
            source: GENERATED.to_owned(),
            spacing_mm: 1.5,
            series: None,
            regrid: false,
            assume_lps: false,
            downsample: [1; 3],
            hash: None,
            region: None,
        }
    }
}

/// What is loaded, checked.
#[derive(Debug, Clone, PartialEq)]
pub struct VolumeSpec {
    /// Where the examination comes from.
    pub source: VolumeSource,
    /// The part to load; `None`: all of it.
    pub region: Option<Region>,
    /// How many voxels along each axis become one; 1 to 16.
    pub downsample: [u32; 3],
    /// The only examination that may be loaded: 64 hexadecimal digits, lower case.
    pub hash: Option<String>,
}

/// Where the examination comes from.
#[derive(Debug, Clone, PartialEq)]
pub enum VolumeSource {
    /// The generated patient, sampled at this spacing; its anatomy follows the scene's seed.
    Phantom {
        /// Voxel spacing, mm.
        spacing_mm: f64,
    },
    /// A file or a folder.
    File(FileSpec),
}

/// An examination on disk, and what may be done where it is doubtful.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct FileSpec {
    /// A file, or a folder with a DICOM series.
    pub path: PathBuf,
    /// Which series of a folder, from 1; `None`: the only one.
    pub series: Option<u32>,
    /// Interpolate slices at uneven places to even ones instead of refusing them.
    pub regrid: bool,
    /// Take the axes of files without orientation as left, posterior, superior instead of refusing them.
    pub assume_lps: bool,
}

/// A part of an examination.
#[derive(Debug, Clone, PartialEq)]
pub enum Region {
    /// The box along the patient's axes that holds the points and this margin around them.
    Around {
        /// Targets and the planned path's ends.
        points: Vec<Point<Ct>>,
        /// How far around them, mm.
        margin_mm: f64,
    },
    /// A box along the patient's axes: two opposite corners.
    BoxMm([Point<Ct>; 2]),
    /// Voxels from the first up to, and not with, the second, along the examination's own axes.
    BoxVoxels([[u32; 3]; 2]),
}

/// In place of a path, with no folder: the generated patient.
pub const GENERATED: &str = "phantom";

/// Whether a path is the word [`GENERATED`]. Whoever joins paths with a folder leaves the word as it is ([`labels_beside`]): a file of
/// that name, `./phantom` or `ct/phantom`, is a file like any other, and missing where it is not there.
pub fn is_generated(path: &Path) -> bool {
    path.as_os_str() == GENERATED
}

/// The label map that a file names: a relative path means relative to that file, and the word [`GENERATED`] stays.
pub fn labels_beside(file: &Path, labels: &Path) -> PathBuf {
    match is_generated(labels) {
        true => labels.to_owned(),
        false => file.parent().unwrap_or_else(|| Path::new("")).join(labels),
    }
}

impl RawVolume {
    /// Checked as a scene without targets would be.
    ///
    /// # Errors
    /// The key, what was found and what is allowed, in words.
    pub fn checked(&self) -> Result<VolumeSpec, String> {
        checked(self, &[], None).map_err(|invalid| invalid.to_string())
    }
}

impl VolumeSpec {
    /// All of a file or folder, with nothing allowed that is doubtful; the path `phantom` is the generated patient.
    pub fn of_path(path: PathBuf) -> Self {
        let source = match is_generated(&path) {
            true => VolumeSource::Phantom {
                spacing_mm: RawVolume::default().spacing_mm,
            },
            false => VolumeSource::File(FileSpec {
                path,
                ..FileSpec::default()
            }),
        };
        Self {
            source,
            region: None,
            downsample: [1; 3],
            hash: None,
        }
    }
}

/// `entry` is the planned path's beginning; its end is one of the targets.
pub(super) fn checked(raw: &RawVolume, targets: &[Target], entry: Option<[f64; 3]>) -> Checked<VolumeSpec> {
    if raw.downsample.iter().any(|&n| n == 0 || n > MAX_DOWNSAMPLE) {
        let allowed = format!("three whole numbers from 1 to {MAX_DOWNSAMPLE}");
        return Err(invalid("volume.downsample", format!("{:?}", raw.downsample), allowed));
    }
    Ok(VolumeSpec {
        source: source(raw)?,
        region: match &raw.region {
            Some(region) => Some(self::region(region, raw.source == GENERATED, targets, entry)?),
            None => None,
        },
        downsample: raw.downsample,
        hash: hash("volume.hash", raw.hash.as_deref())?,
    })
}

/// A BLAKE3 as people write it, in lower case.
pub(super) fn hash(key: &'static str, text: Option<&str>) -> Checked<Option<String>> {
    let is_hash = |text: &str| text.len() == 64 && text.bytes().all(|b| b.is_ascii_hexdigit());
    match text {
        Some(text) if !is_hash(text) => Err(invalid(key, format!("{text:?}"), "64 hexadecimal digits")),
        text => Ok(text.map(str::to_ascii_lowercase)),
    }
}

fn source(raw: &RawVolume) -> Checked<VolumeSource> {
    if raw.source.is_empty() {
        return Err(invalid("volume.source", "\"\"", "\"phantom\" or the path of a CT"));
    }
    if raw.series == Some(0) {
        return Err(invalid(
            "volume.series",
            0,
            "1 for the first series of the folder, and so on",
        ));
    }
    if raw.source != GENERATED {
        return Ok(VolumeSource::File(FileSpec {
            path: PathBuf::from(&raw.source),
            series: raw.series,
            regrid: raw.regrid,
            assume_lps: raw.assume_lps,
        }));
    }
    Ok(VolumeSource::Phantom {
        spacing_mm: number("volume.spacing_mm", raw.spacing_mm, 0.4..=20.0, "mm")?,
    })
}

fn region(raw: &RawRegion, phantom: bool, targets: &[Target], entry: Option<[f64; 3]>) -> Checked<Region> {
    const ONE: &str = "exactly one of margin_mm, box_mm, box_voxels";
    match (raw.margin_mm, raw.box_mm, raw.box_voxels) {
        (Some(margin), None, None) => around(margin, phantom, targets, entry),
        (None, Some([a, b]), None) => Ok(Region::BoxMm([
            point("volume.region.box_mm", a)?,
            point("volume.region.box_mm", b)?,
        ])),
        (None, None, Some([first, end])) => {
            if (0..3).any(|a| first[a] >= end[a]) {
                let allowed = "the first voxel, then one behind the last, larger along each axis";
                return Err(invalid(
                    "volume.region.box_voxels",
                    format!("{first:?}, {end:?}"),
                    allowed,
                ));
            }
            Ok(Region::BoxVoxels([first, end]))
        }
        (None, None, None) => Err(invalid("volume.region", "none of them", ONE)),
        _ => Err(invalid("volume.region", "several of them", ONE)),
    }
}

fn around(margin: f64, phantom: bool, targets: &[Target], entry: Option<[f64; 3]>) -> Checked<Region> {
    let margin_mm = number("volume.region.margin_mm", margin, MARGIN_MM, "mm")?;
    // The generated patient's own targets are filled in before its scene reaches a loader.
    if targets.is_empty() && !phantom {
        let allowed = "targets to put the margin around: name some under [[targets]]";
        return Err(invalid("volume.region.margin_mm", "no targets", allowed));
    }
    let mut points: Vec<Point<Ct>> = targets.iter().map(|target| target.centre).collect();
    if let Some(entry) = entry {
        points.push(point("tracker.approach.entry_ct_mm", entry)?);
    }
    Ok(Region::Around { points, margin_mm })
}
