//! `beads.json`: the beads of a CT, and which CT that is.

use std::path::Path;

use bead::matching::MAX_BEADS;
use bead::{Bead, Found, Rejected, Search};
use serde::{Deserialize, Serialize};

use super::error::BeadsError;
use super::volume::Volume;
use crate::calibration::now;
use crate::input_files::source::Source;
use crate::register::file::Units;

/// The value of `format`.
pub const BEADS_FORMAT: &str = "trocar-beads";
/// The value of `version`. It rises when a key changes its meaning or goes; new keys leave it.
pub const BEADS_VERSION: u32 = 1;

/// The file's content. Places are in the CT's patient frame: left, posterior, superior, mm.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BeadsFile {
    /// [`BEADS_FORMAT`].
    pub format: String,
    /// [`BEADS_VERSION`].
    pub version: u32,
    /// The program that wrote it, and its version.
    pub program: String,
    /// When, RFC 3339 in UTC.
    pub date: String,
    /// The units of lengths and angles.
    pub units: Units,
    /// The volume's identity, as everywhere.
    pub ct_hash: String,
    /// What was read.
    pub volume: VolumeRecord,
    /// What is doubtful about it, a sentence each.
    #[serde(default)]
    pub warnings: Vec<String>,
    /// What was looked for.
    pub search: SearchRecord,
    /// The beads; a bead's number is its place here, from 1.
    pub beads: Vec<BeadRecord>,
    /// Bright spots that are no beads, of the greatest contrast first.
    pub rejected: Vec<RejectedRecord>,
}

/// The volume that was read.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct VolumeRecord {
    /// As given.
    pub path: String,
    /// Voxels along each axis.
    pub dims: [u32; 3],
    /// Lengths of the steps between them, mm.
    pub spacing_mm: [f64; 3],
}

/// What was looked for.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SearchRecord {
    /// Least and greatest radius.
    pub radius_mm: [f64; 2],
    /// Least HU of the metal over its surroundings.
    pub metal_hu: f64,
    /// Least HU over its surroundings that a bead's brightest voxel must have.
    pub least_contrast_hu: f64,
    /// Least value of the detector.
    pub least_chi: f64,
    /// Where the scanner clips; `null` where it does not.
    pub clip_hu: Option<i16>,
}

/// A bead.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BeadRecord {
    /// Its centre.
    pub centre_mm: [f64; 3],
    /// Covariance of the centre, the upper triangle by rows.
    pub covariance_upper_mm2: [f64; 6],
    /// Root mean square error of the centre by that.
    pub error_rms_mm: f64,
    /// Its centre as a continuous voxel index.
    pub voxel: [f64; 3],
    /// Radius that fits.
    pub radius_mm: f64,
    /// Deviation of the radius.
    pub radius_sigma_mm: f64,
    /// Blur: deviation in the slice's plane and along its normal.
    pub blur_mm: [f64; 2],
    /// HU over the surroundings before blur and clipping.
    pub metal_hu: f64,
    /// HU of the surroundings.
    pub ground_hu: f64,
    /// Brightest voxel over the surroundings, HU.
    pub contrast_hu: f64,
    /// The detector's value.
    pub chi: f64,
    /// Root mean square residual of the model, HU.
    pub residual_hu: f64,
    /// Voxels at the clipping value.
    pub clipped: usize,
}

/// A bright spot that is no bead.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RejectedRecord {
    /// Where, to about half a voxel.
    pub place_mm: [f64; 3],
    /// Brightest voxel over the surroundings, HU.
    pub contrast_hu: f64,
    /// Why, in words.
    pub reason: String,
}

impl From<&Bead> for BeadRecord {
    fn from(bead: &Bead) -> Self {
        let c = &bead.covariance;
        Self {
            centre_mm: bead.centre.mm(),
            covariance_upper_mm2: [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)].map(|place| c[place]),
            error_rms_mm: bead.error_rms_mm(),
            voxel: bead.voxel,
            radius_mm: bead.radius_mm[0],
            radius_sigma_mm: bead.radius_mm[1],
            blur_mm: bead.blur_mm,
            metal_hu: bead.metal_hu,
            ground_hu: bead.ground_hu,
            contrast_hu: bead.contrast_hu,
            chi: bead.chi,
            residual_hu: bead.residual_hu,
            clipped: bead.clipped,
        }
    }
}

impl From<&Rejected> for RejectedRecord {
    fn from(spot: &Rejected) -> Self {
        Self {
            place_mm: spot.place.mm(),
            contrast_hu: spot.contrast_hu,
            reason: spot.reason.to_string(),
        }
    }
}

impl BeadsFile {
    pub(super) fn new((path, volume, warnings): (&Path, &Volume, Vec<String>), search: &Search, found: &Found) -> Self {
        let grid = &volume.0.grid;
        Self {
            format: BEADS_FORMAT.to_owned(),
            version: BEADS_VERSION,
            program: concat!("calib ", env!("CARGO_PKG_VERSION")).to_owned(),
            date: now(),
            units: Units {
                length: "mm".to_owned(),
                angle: "rad".to_owned(),
            },
            ct_hash: volume.0.hash.to_string(),
            volume: VolumeRecord {
                path: path.to_string_lossy().into_owned(),
                dims: grid.dims(),
                spacing_mm: grid.spacing_mm(),
            },
            warnings,
            search: SearchRecord {
                radius_mm: search.radius_mm,
                metal_hu: search.metal_hu,
                least_contrast_hu: found.least_contrast_hu,
                least_chi: search.least_chi,
                clip_hu: found.clip_hu,
            },
            beads: found.beads.iter().map(BeadRecord::from).collect(),
            rejected: found.rejected.iter().map(RejectedRecord::from).collect(),
        }
    }

    /// Reads such a file and what it was read from.
    pub(crate) fn read(path: &Path) -> Result<(Self, Source), BeadsError> {
        let source = Source::read_whole(path)?;
        let file: Self = serde_json::from_str(&source.text).map_err(|source| BeadsError::Json {
            path: path.to_owned(),
            source,
        })?;
        match file.wrong() {
            None => Ok((file, source)),
            Some(what) => Err(BeadsError::BadBeads {
                path: path.to_owned(),
                what,
            }),
        }
    }

    fn wrong(&self) -> Option<String> {
        let Self { format, version, .. } = self;
        if (format.as_str(), *version) != (BEADS_FORMAT, BEADS_VERSION) {
            return Some(format!(
                "found format {format:?}, version {version}; expected {BEADS_FORMAT:?}, {BEADS_VERSION}"
            ));
        }
        let count = self.beads.len();
        if count > MAX_BEADS {
            return Some(format!("it has {count} beads, at most {MAX_BEADS} are matched"));
        }
        let bad = self.ct_hash.len() != 64 || !self.ct_hash.bytes().all(|b| b.is_ascii_hexdigit());
        bad.then(|| {
            format!(
                "ct_hash has {} characters; expected 64 hexadecimal ones",
                self.ct_hash.len()
            )
        })
    }
}
