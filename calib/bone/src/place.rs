//! A place of the bone's surface, with what is known of it.

use nalgebra::Vector3;

use crate::contrast::Contrast;
use crate::patch::Lost;

/// What is seen of cortex.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sight {
    /// Cortex.
    Cortex,
    /// Neither cortex nor that there is none.
    Unseen,
    /// No cortex: contrast medium explains what is there.
    Bare,
}

/// A place of the bone's surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// Where, mm (left, posterior, superior).
    pub mm: Vector3<f64>,
    /// Outwards, of length 1.
    pub normal: Vector3<f64>,
    /// How far outside the smoothed surface of the threshold it lies, mm; mostly below 0.
    pub outer_mm: f64,
    /// Deviation along the normal, mm, that this place has for itself; neighbours less than two voxels away share voxels and most of it.
    pub deviation_mm: f64,
    /// Deviation along the normal, mm, by what all places share: the scanner's blur and the cortex's HU.
    pub shared_mm: f64,
    /// Thickness of the cortex that fits, mm.
    pub thickness_mm: f64,
    /// Deviation of its logarithm: where it is large, the thickness is what was expected.
    pub thickness_log_deviation: f64,
    /// HU of the cortex.
    pub cortex_hu: f64,
    /// HU behind it.
    pub inside_hu: f64,
    /// HU before it.
    pub tissue_hu: f64,
    /// What contrast medium would explain instead of cortex.
    pub contrast: Contrast,
    /// What the places around it, and it, say of cortex.
    pub sight: Sight,
}

impl Place {
    /// Deviation along the normal, mm, of all that is known.
    pub fn total_mm(&self) -> f64 {
        self.deviation_mm.hypot(self.shared_mm)
    }
}

/// A place, or why it is lost.
pub(crate) type State = Result<Place, Lost>;
