//! What the run said of itself at its end: the attached `report.json`, as far as a person reads it.

use std::collections::BTreeMap;
use std::path::Path;

use bus::message::TissueShown;
use serde::{Deserialize, Serialize};

use super::short::short;
use crate::write::beside::MAX_BYTES;

/// The name of the attached file.
pub(super) const NAME: &str = "report.json";

/// Keys that are not there are left out: reports of other versions have others.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub(super) struct RunReport {
    pub(super) trocar_version: Option<String>,
    pub(super) run: Option<String>,
    pub(super) scene: Option<String>,
    pub(super) duration_s: Option<f64>,
    pub(super) simulated_time: bool,
    pub(super) volume: Option<Volume>,
    pub(super) replay: Option<Replay>,
    pub(super) poses: Option<Poses>,
    pub(super) accuracy: Option<Accuracy>,
    pub(super) tissue: Option<Tissue>,
    pub(super) latency_ms: BTreeMap<String, Latency>,
    pub(super) views: Vec<View>,
    pub(super) restarts: Vec<Restart>,
    pub(super) held: Vec<String>,
    pub(super) recording: Vec<String>,
    pub(super) problems: Vec<String>,
    pub(super) notes: Vec<String>,
}

/// The examination.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub(super) struct Volume {
    pub(super) hash: String,
    pub(super) dims: [u32; 3],
    pub(super) ct_from_voxel: [[f64; 4]; 3],
    pub(super) marks: String,
}

/// What was replayed.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub(super) struct Replay {
    pub(super) recording: String,
    pub(super) same_volume: bool,
}

/// Samples that came to the pilot.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub(super) struct Poses {
    pub(super) published: u64,
    pub(super) lost: u64,
    pub(super) refused: u64,
    pub(super) missing: u64,
    pub(super) counted_anew: u64,
    pub(super) registration_changes: u64,
}

/// How well the tool was followed.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub(super) struct Accuracy {
    pub(super) outside_share: Option<f64>,
    pub(super) poses_with_outliers: u64,
}

/// What images showed of organs that the tube moves.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub(super) struct Tissue {
    /// First images of poses, by [`bus::message::TissueShown::word`].
    pub(super) images: BTreeMap<String, u64>,
    pub(super) unmarked: u64,
    pub(super) covered_twice: u64,
    /// First images of poses that the model refused, by its words.
    pub(super) refused_because: BTreeMap<String, u64>,
}

/// One stage of a pose's way to the pixels, ms.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub(super) struct Latency {
    pub(super) p50: f64,
    pub(super) p95: f64,
    pub(super) p99: f64,
    pub(super) max: f64,
    pub(super) count: u64,
}

/// One view.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub(super) struct View {
    pub(super) name: String,
    pub(super) rendered: u64,
    pub(super) dropped: u64,
    pub(super) unflagged_old: u64,
}

/// A process that ended and was started again.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub(super) struct Restart {
    pub(super) process: String,
    pub(super) cause: String,
    pub(super) at_s: f64,
    pub(super) live_again_s: Option<f64>,
}

impl RunReport {
    /// The report in the bytes of the file; paths are left at their last names, as folders are called after patients.
    ///
    /// # Errors
    /// Why it cannot be read, in words.
    pub(super) fn parse(bytes: &[u8]) -> Result<Self, String> {
        if bytes.len() as u64 > MAX_BYTES {
            return Err(format!("it has {} bytes, at most {MAX_BYTES} are read", bytes.len()));
        }
        let told = |error: serde_json::Error| short(&error.to_string());
        // An object, whatever else could pass for one.
        let keys: serde_json::Map<String, serde_json::Value> = serde_json::from_slice(bytes).map_err(told)?;
        // Whatever has none of a key's facts would say that nothing was wrong.
        if let Some(key) = ["trocar_version", "problems"]
            .iter()
            .find(|key| !keys.contains_key(**key))
        {
            return Err(format!("it is no report of a run: it has no {key:?}"));
        }
        let mut report: Self = serde_json::from_value(keys.into()).map_err(told)?;
        report.run = report.run.map(|name| short(&name));
        report.scene = report.scene.map(|path| last_name(&path));
        if let Some(replay) = &mut report.replay {
            replay.recording = last_name(&replay.recording);
        }
        report.recording = report.recording.iter().map(|path| last_name(path)).collect();
        if let Some(tissue) = &mut report.tissue {
            let reasons = std::mem::take(&mut tissue.refused_because).into_iter();
            tissue.refused_because = reasons.map(|(why, n)| (short(&why), n)).collect();
            // Words that no image has say nothing that could be counted.
            tissue
                .images
                .retain(|word, _| TissueShown::ALL.iter().any(|shown| shown.word() == word));
        }
        for words in report.problems.iter_mut().chain(&mut report.notes) {
            *words = short(words);
        }
        Ok(report)
    }

    /// Why it is not of the run that a recording's record `run` is of; `None` where nothing says so.
    pub(super) fn of_another(&self, run: &BTreeMap<String, String>) -> Option<String> {
        // What was replayed has another name, and may be another part of its examination.
        if self.replay.is_some() {
            return None;
        }
        let hash = self.volume.as_ref().map(|volume| &volume.hash);
        [
            ("run", self.run.as_ref(), run.get("name")),
            ("examination", hash, run.get("volume_hash")),
        ]
        .into_iter()
        .find_map(|(what, stated, found)| {
            let (stated, found) = (stated?, found?);
            (stated != found).then(|| format!("it is of {what} {}, and the recording of {found}", short(stated)))
        })
    }
}

impl Volume {
    /// The distance of neighbouring voxels along each axis, mm.
    pub(super) fn spacing_mm(&self) -> [f64; 3] {
        let row = &self.ct_from_voxel;
        std::array::from_fn(|axis| row[0][axis].hypot(row[1][axis]).hypot(row[2][axis]))
    }
}

/// The name of a file without its folder.
pub(super) fn last_name(path: &str) -> String {
    let name = Path::new(path).file_name().unwrap_or_default();
    short(&name.to_string_lossy())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_there_is_left_out_and_folders_are_not_told() {
        let text = r#"{"trocar_version": "0.2.0", "scene": "/data/SMITH^JOHN/scene.toml", "later": [1], "problems": ["p"],
            "volume": {"dims": [4, 5, 6], "ct_from_voxel": [[0, 2, 0, 1], [1.5, 0, 0, 2], [0, 0, -3, 3]]}}"#;
        let report = RunReport::parse(text.as_bytes()).unwrap();
        assert_eq!(report.scene.as_deref(), Some("scene.toml"));
        assert_eq!((report.problems.len(), report.poses), (1, None));
        assert_eq!(report.volume.unwrap().spacing_mm(), [1.5, 2.0, 3.0]);
        for bad in [
            &b"{"[..],
            b"[]",
            b"\xff",
            br#"{"trocar_version": "0.2.0", "problems": 3}"#,
            b"{}",
            br#"{"problems": []}"#,
            br#"{"trocar_version": "0.2.0"}"#,
            "[".repeat(9999).as_bytes(),
        ] {
            assert!(RunReport::parse(bad).is_err());
        }
    }
}
