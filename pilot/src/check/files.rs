//! The files that a scene names: whether they are there, are files, and can be read.

use std::fs::{self, File};
use std::io::Read;
use std::path::Path;

use scene::raw::Source;
use scene::{Scene, VolumeSource};
use serde::Deserialize;

use crate::resolve::tied;

/// The tracker reads no longer one, bytes.
const MAX_BYTES: u64 = 16 << 20;

/// What is wrong with the files of a scene, each with the key that names it.
pub(super) fn faults(source: &Source, scene: &Scene) -> Vec<String> {
    let tracker = &source.scene.tracker;
    let gesture = tracker.room.as_ref().and_then(|room| room.gesture.as_ref());
    let probe = tracker.room.as_ref().and_then(|room| room.probe.as_ref());
    let tank = probe.and_then(|probe| probe.tank.as_ref());
    let steps = source.scene.steps.as_ref();
    let named = [
        ("steps.drawing", steps.and_then(|steps| steps.drawing.as_deref())),
        ("steps.beads", steps.and_then(|steps| steps.beads.as_deref())),
        ("tracker.room.gesture.file", gesture.map(|g| g.file.as_str())),
        ("tracker.room.probe.tank.file", tank.map(|tank| tank.file.as_str())),
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
    // What is made while the run goes on need not be there before.
    let steps = scene.steps.as_ref();
    let is_made = |key: &str| match key {
        "tracker.calibration.file" => steps.is_some_and(|steps| steps.calibrate.is_some()),
        "tracker.registration.file" => steps.is_some_and(|steps| steps.register.is_some()),
        _ => false,
    };
    let named = named.filter(|(key, file)| !is_made(key) || file.exists());
    let mut faults: Vec<String> = named.filter_map(|(key, file)| fault(key, file)).collect();
    if !is_made("tracker.registration.file") {
        faults.extend(of_another_patient(scene));
    }
    faults.extend(labels_of_organs(scene));
    faults
}

/// The generated patient's labels go with that patient alone, and a map that is not there is no map.
pub(super) fn labels_of_organs(scene: &Scene) -> Option<String> {
    let organs = &scene.tissue.as_ref()?.organs;
    let labels = tied::labels_of_organs(organs)?;
    let why = match &scene.volume.source {
        VolumeSource::Phantom { .. } if scene::is_generated(&labels) => return None,
        VolumeSource::File(file) if scene::is_generated(&labels) => format!(
            "found the generated patient's, and the examination is {}: expected a label map of that examination",
            file.path.display()
        ),
        _ => fs::metadata(&labels).err()?.to_string(),
    };
    Some(format!(
        "tissue.organs {}: space.labels {}: {why}",
        organs.display(),
        labels.display()
    ))
}

/// A registration from another frame than that of the scene's marker on the patient, or of its localizer, is refused by the tracker, and one that
/// is not of the marker that the scene names. What is no registration at all is found there.
fn of_another_patient(scene: &Scene) -> Option<String> {
    #[derive(Deserialize)]
    struct Registration {
        from: String,
        marker: Option<String>,
    }
    let link = &scene.tracker.links.registration.as_ref()?.file;
    let path = &link.path;
    // Opening a pipe would wait for its writer.
    fs::metadata(path).ok().filter(fs::Metadata::is_file)?;
    let mut text = String::new();
    let file = File::open(path).ok()?;
    file.take(MAX_BYTES).read_to_string(&mut text).ok()?;
    let Registration { from, marker } = serde_json::from_str(&text).ok()?;
    let told = |text: &str| text.chars().take(64).collect::<String>();
    if let Some(asked) = link.marker.as_deref().filter(|asked| marker.as_deref() != Some(asked)) {
        return Some(format!(
            "tracker.registration.file {}: found a registration of {}, expected one of the marker {asked:?} (tracker.registration.marker)",
            path.display(),
            marker.map_or("no named marker".to_owned(), |marker| format!(
                "the marker {:?}",
                told(&marker)
            ))
        ));
    }
    let expected = match scene.tracker.source.has_reference() {
        true => "reference",
        false => "tracker",
    };
    (from != expected).then(|| {
        format!(
            "tracker.registration.file {}: found a registration from {:?}, expected one from {expected}: {}",
            path.display(),
            told(&from),
            match expected {
                "reference" => "the scene has a marker on the patient, whose motion would not be followed",
                _ => "the scene has no marker on the patient",
            }
        )
    })
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
