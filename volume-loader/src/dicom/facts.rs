//! What is known of a series once it was judged.

use geometry::{Affine, Ct, Voxel};
use serde_json::{Value, json};

use crate::source::Facts;

/// Statistics of the steps between slices along the line of their positions, mm.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Steps {
    /// The smallest.
    pub min_mm: f64,
    /// The median; of an even number of steps the upper of the middle two.
    pub median_mm: f64,
    /// The largest.
    pub max_mm: f64,
    /// The standard deviation from the mean.
    pub std_mm: f64,
}

impl Steps {
    /// Of the steps between ascending places; zeros where there are fewer than two.
    pub(crate) fn of(places_mm: &[f64]) -> Self {
        let pairs = places_mm.iter().zip(places_mm.iter().skip(1));
        let mut steps: Vec<f64> = pairs.map(|(low, high)| high - low).collect();
        steps.sort_by(f64::total_cmp);
        let (Some(&min_mm), Some(&max_mm)) = (steps.first(), steps.last()) else {
            return Self::default();
        };
        let count = steps.len() as f64;
        let mean = steps.iter().sum::<f64>() / count;
        let variance = steps.iter().map(|step| (step - mean).powi(2)).sum::<f64>() / count;
        Self {
            min_mm,
            median_mm: steps[steps.len() / 2],
            max_mm,
            std_mm: variance.sqrt(),
        }
    }
}

/// A series as it will be loaded, for a person; nothing in it names a patient.
#[derive(Debug, Clone)]
pub struct SeriesFacts {
    /// Its number in the folder, from 1, and how many there are.
    pub number: [usize; 2],
    /// Modality, such as `CT`.
    pub modality: String,
    /// Voxels along each axis.
    pub dims: [u32; 3],
    /// LPS mm.
    pub ct_from_voxel: Affine<Ct, Voxel>,
    /// The plane and the direction of each axis in words.
    pub orientation: String,
    /// Angle between the line of positions and the slices' normal, degrees.
    pub tilt_deg: f64,
    /// What GantryDetectorTilt says, degrees.
    pub tilt_tag_deg: Option<f64>,
    /// The steps between the slices' positions.
    pub steps: Steps,
    /// The largest distance between a corner of a slice after its own header and after `ct_from_voxel`, mm; with
    /// [`Options::regrid`](super::Options::regrid), after the slice's own place along the line.
    pub worst_corner_mm: f64,
    /// The first pixel of each slice, in order, LPS mm.
    pub positions_mm: Vec<[f64; 3]>,
    /// The transfer syntax in words.
    pub codec: &'static str,
    /// ConvolutionKernel.
    pub kernel: Option<String>,
    /// SliceThickness, mm; reported, never used.
    pub thickness_mm: Option<f64>,
    /// HU of what was not measured.
    pub padding_hu: i16,
    /// Whether the files say so, or show it; otherwise it is the usual value.
    pub padding_known: bool,
    /// Slices of the grid that were interpolated, and slices that are a hole.
    pub regridded: Option<[usize; 2]>,
    /// What was doubtful.
    pub warnings: Vec<String>,
    /// Files of the folder that are not DICOM images.
    pub ignored: usize,
}

impl SeriesFacts {
    /// For `inspect`: what a summary of voxels does not know.
    pub(crate) fn told(&self) -> Facts {
        let extra = [
            ("series", json!(format!("{} of {}", self.number[0], self.number[1]))),
            ("modality", json!(self.modality)),
            ("codec", json!(self.codec)),
            ("kernel", json!(self.kernel)),
            ("slices_in_files", json!(self.positions_mm.len())),
            ("step_min_mm", json!(self.steps.min_mm)),
            ("step_median_mm", json!(self.steps.median_mm)),
            ("step_max_mm", json!(self.steps.max_mm)),
            ("step_deviation_mm", json!(self.steps.std_mm)),
            ("slice_thickness_mm", json!(self.thickness_mm)),
            ("tilt_by_positions_deg", json!(self.tilt_deg)),
            ("tilt_by_tag_deg", json!(self.tilt_tag_deg)),
            ("worst_corner_error_mm", json!(self.worst_corner_mm)),
            ("padding_known", json!(self.padding_known)),
            ("slices_interpolated", json!(self.regridded.map(|[between, _]| between))),
            ("slices_missing", json!(self.regridded.map(|[_, hole]| hole))),
            ("files_ignored", json!(self.ignored)),
        ];
        let said = extra.into_iter().filter(|(_, value)| *value != Value::Null);
        Facts {
            warnings: self.warnings.clone(),
            extra: said.map(|(name, value)| (name.to_owned(), value)).collect(),
        }
    }
}
