//! `[tissue]`: organs that the tube moves, shown where a model has them.

use std::path::PathBuf;
use std::time::Duration;

use serde::{Deserialize, Serialize};

use super::values::{Checked, invalid, number};
use super::volume::hash;

/// `[tissue]`
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RawTissue {
    /// A scene of organs in space, as `simulate run` takes it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub organs: Option<String>,
    /// The only scene of organs that is taken: BLAKE3 of the file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub organs_hash: Option<String>,
    /// The only label map of it that is taken: BLAKE3 of its geometry and voxels.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub labels_hash: Option<String>,
    /// Free forces over the forces of contact at which a state is settled.
    pub tolerance: f64,
    /// Steps for a pose at most.
    pub most_steps: usize,
    /// New second derivatives are asked for once the tube has gone so far, mm.
    pub refresh_mm: f64,
    /// States later that they are taken up.
    pub delay: usize,
    /// Without a state of a pose for so long after its capture, images show the CT as it was taken.
    pub late_ms: f64,
    /// Organs are cut in pieces of at most this size for images, mm.
    pub piece_mm: f64,
    /// What uncertain numbers of the organs do to targets is found of each so many-th settled state.
    pub error_every: usize,
}

impl Default for RawTissue {
    fn default() -> Self {
        Self {
            organs: None,
            organs_hash: None,
            labels_hash: None,
            tolerance: 1e-3,
            most_steps: 12,
            refresh_mm: 1.0,
            delay: 2,
            late_ms: 50.0,
            piece_mm: 5.0,
            error_every: 2,
        }
    }
}

/// Organs that the tube moves.
#[derive(Debug, Clone, PartialEq)]
pub struct TissueSpec {
    /// The scene of organs in space.
    pub organs: PathBuf,
    /// The only such file that is taken, by its BLAKE3; `None`: any.
    pub organs_hash: Option<String>,
    /// The only label map of it that is taken; `None`: any.
    pub labels_hash: Option<String>,
    /// Free forces over the forces of contact at which a state is settled.
    pub tolerance: f64,
    /// Steps for a pose at most.
    pub most_steps: usize,
    /// New second derivatives are asked for once the tube has gone so far, mm.
    pub refresh_mm: f64,
    /// States later that they are taken up.
    pub delay: usize,
    /// Without a state of a pose for so long after its capture, images show the CT as it was taken.
    pub late: Duration,
    /// Organs are cut in pieces of at most this size for images, mm.
    pub piece_mm: f64,
    /// What uncertain numbers of the organs do to targets is found of each so many-th settled state.
    pub error_every: usize,
}

/// `stale_ms` is the age at which an image says that its pose is old.
pub(super) fn checked(raw: Option<&RawTissue>, stale_ms: f64) -> Checked<Option<TissueSpec>> {
    raw.map(|raw| spec(raw, stale_ms)).transpose()
}

fn spec(raw: &RawTissue, stale_ms: f64) -> Checked<TissueSpec> {
    let Some(organs) = &raw.organs else {
        let allowed = "the path of a scene of organs in space, as `simulate run` takes it";
        return Err(invalid("tissue", "no key organs", allowed));
    };
    if !(1..=1000).contains(&raw.most_steps) {
        return Err(invalid("tissue.most_steps", raw.most_steps, "1 to 1000"));
    }
    if !(1..=1000).contains(&raw.error_every) {
        return Err(invalid("tissue.error_every", raw.error_every, "1 to 1000 states"));
    }
    if raw.delay > 1000 {
        return Err(invalid("tissue.delay", raw.delay, "0 to 1000 states"));
    }
    // An image stands until the next, which may wait as long: together no longer than poses are young.
    let allowed = "ms, at most half of limits.stale_ms";
    let late_ms = number("tissue.late_ms", raw.late_ms, 1.0..=0.5 * stale_ms, allowed)?;
    Ok(TissueSpec {
        organs: PathBuf::from(organs),
        organs_hash: hash("tissue.organs_hash", raw.organs_hash.as_deref())?,
        labels_hash: hash("tissue.labels_hash", raw.labels_hash.as_deref())?,
        tolerance: number(
            "tissue.tolerance",
            raw.tolerance,
            1e-10..=0.1,
            "of the forces of contact",
        )?,
        most_steps: raw.most_steps,
        refresh_mm: number("tissue.refresh_mm", raw.refresh_mm, 0.01..=100.0, "mm")?,
        delay: raw.delay,
        late: Duration::from_secs_f64(late_ms / 1e3),
        piece_mm: number("tissue.piece_mm", raw.piece_mm, 0.1..=50.0, "mm")?,
        error_every: raw.error_every,
    })
}

#[cfg(test)]
mod tests {
    use crate::Scene;
    use std::path::{Path, PathBuf};

    fn parsed(text: &str) -> Result<Option<super::TissueSpec>, String> {
        let scene = Scene::parse(text, Path::new("folder/s.toml"));
        scene.map(|scene| scene.tissue).map_err(|error| error.to_string())
    }

    #[test]
    fn a_scene_without_the_table_has_none_and_one_with_it_names_its_organs() {
        assert_eq!(parsed(""), Ok(None));
        let spec = parsed("[tissue]\norgans = \"kidney.toml\"").unwrap().unwrap();
        assert_eq!(spec.organs, PathBuf::from("folder/kidney.toml"));
        assert_eq!((spec.most_steps, spec.delay), (12, 2));
    }

    #[test]
    fn numbers_out_of_range_are_named() {
        for (keys, words) in [
            ("", "key tissue: found no key organs"),
            ("organs = \"k\"\ntolerance = 0.0", "key tissue.tolerance: found 0"),
            ("organs = \"k\"\ntolerance = nan", "key tissue.tolerance: found NaN"),
            ("organs = \"k\"\nmost_steps = 0", "key tissue.most_steps: found 0"),
            ("organs = \"k\"\nlate_ms = -1.0", "key tissue.late_ms: found -1"),
            ("organs = \"k\"\npiece_mm = inf", "key tissue.piece_mm: found inf"),
            ("organs = \"k\"\nerror_every = 0", "key tissue.error_every: found 0"),
            (
                "organs = \"k\"\norgans_hash = \"f\"",
                "key tissue.organs_hash: found \"f\"",
            ),
            ("organs = \"k\"\ndelay = 2000", "key tissue.delay: found 2000"),
            (
                "organs = \"k\"\nlate_ms = 51.0",
                "allowed: 1 to 50 ms, at most half of limits.stale_ms",
            ),
            ("organ = \"k\"", "unknown field `organ`"),
        ] {
            let error = parsed(&format!("[tissue]\n{keys}")).unwrap_err();
            assert!(error.contains(words), "{keys}: {error}");
        }
    }
}
