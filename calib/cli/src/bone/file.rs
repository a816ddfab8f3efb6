//! `bone.json`: what a surface rests on, and which CT that is.

use bone::Bone;
use serde::{Deserialize, Serialize};

use super::BoneArgs;
use super::labels::Labelled;
use crate::VolumeRecord;
use crate::beads::Volume;
use crate::calibration::now;
use crate::register::file::Units;

/// The value of `format`.
pub const BONE_FORMAT: &str = "trocar-bone";
/// The value of `version`. It rises when a key changes its meaning or goes; new keys leave it.
pub const BONE_VERSION: u32 = 1;

/// The file's content. Lengths are mm.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BoneFile {
    /// [`BONE_FORMAT`].
    pub format: String,
    /// [`BONE_VERSION`].
    pub version: u32,
    /// The program that wrote it, and its version.
    pub program: String,
    /// When, RFC 3339 in UTC.
    pub date: String,
    /// The units of lengths and angles.
    pub units: Units,
    /// The axes of the surface's coordinates: `LPS`.
    pub frame: String,
    /// The volume's identity, as everywhere.
    pub ct_hash: String,
    /// What was read.
    pub volume: VolumeRecord,
    /// What is doubtful about it, a sentence each.
    #[serde(default)]
    pub warnings: Vec<String>,
    /// The name of the surface's file, which lies beside this one; `null` where none was written.
    pub surface_file: Option<String>,
    /// BLAKE3 of the surface's bytes: as PLY where none was written.
    pub surface_blake3: String,
    /// Root mean square deviation of a corner along its normal that it has for itself.
    pub surface_sigma_mm: f64,
    /// Root mean square deviation that all corners share: the scanner's blur and the HU of cortex. The prior of a registration's offset.
    pub surface_shared_sigma_mm: f64,
    /// Half of the corners have a smaller deviation, of all that is known.
    pub median_deviation_mm: f64,
    /// 95 % of the corners have a smaller deviation, of all that is known.
    pub deviation_95_mm: f64,
    /// Which bone, in words.
    pub region: String,
    /// Labels that were kept out, in words.
    pub kept_out: Vec<String>,
    /// The threshold of the topology, HU.
    pub threshold_hu: f64,
    /// The least HU of metal.
    pub metal_hu: i16,
    /// Voxels of metal about the bone.
    pub metal_voxels: u64,
    /// What was found of the scanner.
    pub scanner: BoneScannerRecord,
    /// Volume of what is above the threshold, ml, and mean of it, HU.
    pub body_ml: f64,
    /// Mean of it, HU.
    pub body_mean_hu: f64,
    /// Corners of the surface.
    pub corners: usize,
    /// Triangles of the surface.
    pub triangles: usize,
    /// Corners of the threshold's surface.
    pub threshold_corners: usize,
    /// Those without a position, by their reason.
    pub lost: Vec<LostRecord>,
    /// Area of the threshold's surface, mm^2.
    pub threshold_area_mm2: f64,
    /// Area of the surface, mm^2.
    pub area_mm2: f64,
    /// Triangles of cavities, left out.
    pub inner_triangles: usize,
    /// Share of the fitted corners without cortex that is seen, those that were left out with it.
    pub without_cortex: f64,
    /// Most HU of contrast medium.
    #[serde(default)]
    pub contrast_hu: Option<f64>,
    /// Corners where cortex is not seen and yet may be: in the file, and of no triangle.
    #[serde(default)]
    pub unseen_corners: usize,
    /// The triangles that they would have.
    #[serde(default)]
    pub unseen_triangles: usize,
    /// Area of those, mm^2.
    #[serde(default)]
    pub unseen_area_mm2: f64,
    /// What was left out as contrast medium explains it, the largest first.
    #[serde(default)]
    pub left_out: Vec<LeftOutRecord>,
}

/// A piece without cortex that was left out.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LeftOutRecord {
    /// Triangles.
    pub triangles: usize,
    /// Area, mm^2.
    pub area_mm2: f64,
    /// Mean of its corners: left, posterior, superior, mm.
    pub centre_mm: [f64; 3],
    /// HU behind its surface.
    pub hu: f64,
}

/// What was found of the scanner.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BoneScannerRecord {
    /// Blur in the slices' plane and across it, deviations.
    pub blur_mm: [f64; 2],
    /// Its own deviation, relative.
    pub blur_relative_sigma: [f64; 2],
    /// Whether it was told.
    pub is_blur_told: bool,
    /// Excess kurtosis of the blur, and its deviation.
    pub kurtosis: [f64; 2],
    /// HU of cortex, and deviation of their mean.
    pub cortex_hu: [f64; 2],
    /// Deviation of a voxel, HU, what the model leaves included.
    pub noise_hu: f64,
    /// Correlation of neighbouring voxels along each axis.
    pub noise_neighbours: [f64; 3],
    /// Places that told of it.
    pub places: usize,
}

/// Corners without a position.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LostRecord {
    /// Why, in words.
    pub reason: String,
    /// How many.
    pub corners: usize,
}

impl BoneFile {
    pub(super) fn new(
        args: &BoneArgs,
        (volume, warnings): (&Volume, Vec<String>),
        labelled: Option<&Labelled>,
        bone: &Bone,
        (surface_file, surface): (Option<String>, &[u8]),
    ) -> Self {
        let grid = &volume.0.grid;
        let scanner = &bone.scanner;
        let lost = bone.lost.iter().map(|(why, corners)| LostRecord {
            reason: why.words().to_owned(),
            corners: *corners,
        });
        let left_out = bone.bare.iter().map(|piece| LeftOutRecord {
            triangles: piece.triangles,
            area_mm2: piece.area_mm2,
            centre_mm: piece.centre_mm,
            hu: piece.hu,
        });
        Self {
            format: BONE_FORMAT.to_owned(),
            version: BONE_VERSION,
            program: concat!("calib ", env!("CARGO_PKG_VERSION")).to_owned(),
            date: now(),
            units: Units {
                length: "mm".to_owned(),
                angle: "rad".to_owned(),
            },
            frame: "LPS".to_owned(),
            ct_hash: volume.0.hash.to_string(),
            volume: VolumeRecord {
                path: args.volume.to_string_lossy().into_owned(),
                dims: grid.dims(),
                spacing_mm: grid.spacing_mm(),
            },
            warnings,
            surface_file,
            surface_blake3: blake3::hash(surface).to_string(),
            surface_sigma_mm: bone.deviation_rms_mm(),
            surface_shared_sigma_mm: bone.shared_rms_mm(),
            median_deviation_mm: bone.quantile_mm(0.5),
            deviation_95_mm: bone.quantile_mm(0.95),
            region: args.region.words(labelled),
            kept_out: labelled.map_or_else(Vec::new, |map| map.kept_out.clone()),
            threshold_hu: args.threshold_hu.0,
            metal_hu: args.metal_hu,
            metal_voxels: bone.metal_voxels,
            scanner: BoneScannerRecord {
                blur_mm: scanner.blur_mm,
                blur_relative_sigma: scanner.blur_relative,
                is_blur_told: scanner.is_told,
                kurtosis: scanner.kurtosis,
                cortex_hu: scanner.cortex_hu,
                noise_hu: scanner.noise_hu,
                noise_neighbours: scanner.noise_neighbours,
                places: scanner.places,
            },
            body_ml: bone.body.volume_ml,
            body_mean_hu: bone.body.mean_hu,
            corners: bone.places.len(),
            triangles: bone.triangles.len(),
            threshold_corners: bone.threshold_corners,
            lost: lost.collect(),
            threshold_area_mm2: bone.area_mm2[0],
            area_mm2: bone.area_mm2[1],
            inner_triangles: bone.inner_triangles,
            without_cortex: bone.without_cortex,
            contrast_hu: Some(args.contrast_hu),
            unseen_corners: bone.places.len() - bone.heard().count(),
            unseen_triangles: bone.unseen.len(),
            unseen_area_mm2: bone.area_mm2[2],
            left_out: left_out.collect(),
        }
    }
}
