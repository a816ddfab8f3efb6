//! A rigid transform as it is written.

use serde::{Deserialize, Serialize};

/// A rigid transform.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RawRigid {
    /// Unit quaternion w, x, y, z.
    pub quaternion: [f64; 4],
    /// Translation, mm.
    pub translation_mm: [f64; 3],
}

impl Default for RawRigid {
    fn default() -> Self {
        Self {
            quaternion: [1.0, 0.0, 0.0, 0.0],
            translation_mm: [0.0; 3],
        }
    }
}
