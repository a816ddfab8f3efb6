//! The summary of an examination.

use serde::Serialize;

use super::{Histogram, HuRange, Padding, Place};
use crate::source::Conversion;

/// What an examination is; as JSON it has these names.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Summary {
    /// One line: the format, and what was doubtful about it.
    pub format: String,
    /// Where the voxels lie.
    #[serde(flatten)]
    pub place: Place,
    /// How many voxels there are.
    pub voxels: u64,
    /// The HU of what was measured; `None` where all is padding.
    pub hu: Option<HuRange>,
    /// What was not measured.
    pub padding: Padding,
    /// How often which HU is there.
    pub histogram: Histogram,
    /// Voxels that were changed on their way to 16 bits.
    pub changed: Changed,
    /// What every image of this volume says, in capitals; empty where there is nothing to say.
    pub marks: String,
    /// The volume's identity, as images and recordings carry it: 64 hexadecimal digits.
    pub hash: String,
    /// What is doubtful, a sentence each.
    pub warnings: Vec<String>,
    /// Facts of the format.
    pub extra: serde_json::Map<String, serde_json::Value>,
}

/// How many voxels were changed on their way to 16 bits: [`Conversion`].
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct Changed {
    /// Held to -32768 HU.
    pub clamped_low: u64,
    /// Held to 32767 HU.
    pub clamped_high: u64,
    /// Not numbers, replaced by the padding.
    pub not_finite: u64,
    /// Rounded to a whole number of HU.
    pub rounded: u64,
}

impl From<Conversion> for Changed {
    fn from(conversion: Conversion) -> Self {
        let Conversion {
            clamped_low,
            clamped_high,
            not_finite,
            rounded,
        } = conversion;
        Self {
            clamped_low,
            clamped_high,
            not_finite,
            rounded,
        }
    }
}
