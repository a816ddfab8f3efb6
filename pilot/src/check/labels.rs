//! The label map that ways are measured against and that an overview shows: whether it can be read, and what is doubtful about it.

use std::path::Path;

use bus::volume::LabelMap;
use scene::{Scene, VolumeSpec};

use super::Checked;
use super::place::Examination;

/// Reads a label map of an examination; the number is the generated patient's seed.
pub(crate) type LoadLabels = fn(&Path, &VolumeSpec, u64) -> Result<LabelMap, Box<dyn std::error::Error + Send + Sync>>;

/// What planning says of it too, with the same words.
pub(super) fn look_at(scene: &Scene, examination: &Examination, load: LoadLabels) -> Checked {
    let Some(path) = &scene.plan.labels else {
        return Checked::default();
    };
    let labels = match load(path, &scene.volume, scene.seed) {
        Ok(labels) => labels,
        Err(why) => {
            return Checked {
                faults: vec![format!("plan.labels {}: {why}", path.display())],
                ..Checked::default()
            };
        }
    };
    let place = examination.lies_under(&labels);
    let place = place.is_doubtful().then(|| place.to_string());
    let doubts = place.into_iter().chain(labels.doubts);
    Checked {
        lines: doubts.map(|words| format!("warning: the label map: {words}")).collect(),
        ..Checked::default()
    }
}
