//! The files that a scene names: whether they are there, are files, and can be read.

use std::fs::{self, File};
use std::path::Path;

use scene::Scene;
use scene::raw::Source;

/// What is wrong with the files of a scene, each with the key that names it.
pub(super) fn faults(source: &Source, _scene: &Scene) -> Vec<String> {
    let tracker = &source.scene.tracker;
    let gesture = tracker.room.as_ref().and_then(|room| room.gesture.as_ref());
    let named = [
        ("tracker.room.gesture.file", gesture.map(|g| g.file.as_str())),
        (
            "tracker.sequence.file",
            tracker.sequence.as_ref().map(|s| s.file.as_str()),
        ),
        (
            "tracker.calibration.file",
            tracker.calibration.as_ref().map(|l| l.file.as_str()),
        ),
        (
            "tracker.registration.file",
            tracker.registration.as_ref().map(|l| l.file.as_str()),
        ),
    ];
    let named = named
        .into_iter()
        .filter_map(|(key, file)| Some((key, Path::new(file?))));
    named.filter_map(|(key, file)| fault(key, file)).collect()
}

fn fault(key: &str, path: &Path) -> Option<String> {
    // Asked for before opening: opening a pipe would wait for its writer.
    let why = match fs::metadata(path) {
        Err(error) => error.to_string(),
        Ok(facts) if !facts.is_file() => "it is not a file".to_owned(),
        Ok(_) => File::open(path).err()?.to_string(),
    };
    Some(format!("{key} {}: {why}", path.display()))
}
