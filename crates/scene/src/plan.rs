//! `[plan]`: the plan that a run follows, and what its ways are measured against.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use super::values::{Checked, invalid, number};
use super::volume::hash;

/// `[plan]`
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RawPlan {
    /// A plan that `pilot plan` made: its targets are the scene's, and the examination must be the plan's.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
    /// The id of the plan that is followed; absent: whichever stands in the file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub id: Option<String>,
    /// A label map: which structure lies where.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub labels: Option<String>,
    /// The only label map that is shown: BLAKE3 of its geometry and voxels.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub labels_hash: Option<String>,
    /// The error of navigation that distances to structures are lessened by, mm; absent: it is not known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error_mm: Option<f64>,
}

/// The plan that a run follows, and what its ways are measured against.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PlanSpec {
    /// The plan's file.
    pub file: Option<PathBuf>,
    /// The label map's file.
    pub labels: Option<PathBuf>,
    /// The only label map that is shown; `None`: any.
    pub labels_hash: Option<String>,
    /// The error of navigation, mm; `None`: not known.
    pub error_mm: Option<f64>,
}

pub(super) fn checked(raw: Option<&RawPlan>) -> Checked<PlanSpec> {
    let Some(raw) = raw else { return Ok(PlanSpec::default()) };
    let path = |key: &str, path: &Option<String>| match path.as_deref() {
        Some("") => Err(invalid(format!("plan.{key}"), "\"\"", "the path of a file")),
        path => Ok(path.map(PathBuf::from)),
    };
    let error = |mm| number("plan.error_mm", mm, 0.0..=100.0, "mm");
    Ok(PlanSpec {
        file: path("file", &raw.file)?,
        labels: path("labels", &raw.labels)?,
        labels_hash: hash("plan.labels_hash", raw.labels_hash.as_deref())?,
        error_mm: raw.error_mm.map(error).transpose()?,
    })
}

#[cfg(test)]
mod tests {
    use crate::Scene;
    use std::path::Path;

    #[test]
    fn files_are_relative_to_the_scene_and_numbers_are_lengths() {
        let of = |text: &str| Scene::parse(text, Path::new("folder/s.toml")).map_err(|error| error.to_string());
        let scene = of("[plan]\nfile = \"p.json\"\nlabels = \"/l.nii.gz\"\nerror_mm = 2.5").unwrap();
        assert_eq!(scene.plan.file.as_deref(), Some(Path::new("folder/p.json")));
        assert_eq!(scene.plan.labels.as_deref(), Some(Path::new("/l.nii.gz")));
        assert_eq!((scene.plan.error_mm, of("").unwrap().plan.error_mm), (Some(2.5), None));
        for (text, said) in [
            (
                "[plan]\nerror_mm = -1",
                "line 2, column 12, key plan.error_mm: found -1; allowed: 0 to 100 mm",
            ),
            ("[plan]\nerror_mm = nan", "key plan.error_mm: found NaN"),
            (
                "[plan]\nlabels_hash = \"00ff\"",
                "key plan.labels_hash: found \"00ff\"; allowed: 64 hexadecimal digits",
            ),
            ("[plan]\nfiles = \"p\"", "unknown field `files`"),
            (
                "[volume]\nhash = \"00ff\"",
                "key volume.hash: found \"00ff\"; allowed: 64 hexadecimal digits",
            ),
        ] {
            let found = of(text).unwrap_err();
            assert!(found.contains(said), "{text}: {found}");
        }
        let upper = "AB".repeat(32);
        let scene = of(&format!("[volume]\nhash = \"{upper}\"")).unwrap();
        assert_eq!(scene.volume.hash.as_deref(), Some(upper.to_lowercase().as_str()));
    }
}
