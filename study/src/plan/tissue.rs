//! `tissue`: the tube moves organs on its way.

use std::ops::RangeInclusive;
use std::path::Path;
use std::sync::Arc;

use geometry::{Ct, Point};
use phantom::Landmark;
use scene::{Scene, Target, TissueSpec, TrackerSource, VolumeSource};

use super::at::At;
use super::error::PlanError;
use super::raw::RawDials;

/// From the entry to what is aimed at, mm: longer than the tube is deep at the beginning; and so much of the tube is left outside that the hand can
/// still steer it about the entry.
const WAY_MM: RangeInclusive<f64> = 20.0..=120.0;

/// Organs that the tube moves: those of a run's scene, with its tube and its way.
#[derive(Debug, Clone, PartialEq)]
pub struct Tissue {
    /// The run's scene.
    pub scene: Arc<Scene>,
    /// What is aimed at.
    pub aimed: Landmark,
    /// Where the tube enters on its way there.
    pub entry: Point<Ct>,
    /// Of what errors are told.
    pub told: Landmark,
    /// States of the organs a second.
    pub rate_hz: f64,
    /// Of the scene and its scene of organs: what they were when the study was read.
    pub hash: [u8; 32],
}

/// The tissue of a stratum; nothing where it names no scene.
pub(super) fn tissue(at: &At<'_>, own: &RawDials, all: &RawDials) -> Result<Option<Tissue>, PlanError> {
    const KEY: &str = "tissue.scene";
    let (mine, general) = (&own.tissue, &all.tissue);
    let rate_hz = at.within("tissue.rate_hz", [mine.rate_hz, general.rate_hz], 20.0, 5.0..=60.0)?;
    let names = [&mine.aimed, &mine.told, &general.aimed, &general.told];
    let Some(name) = mine.scene.as_ref().or(general.scene.as_ref()) else {
        return match names.into_iter().flatten().next() {
            None => Ok(None),
            Some(name) => Err(at.wrong("tissue", name, "tissue.scene must say which scene has that target")),
        };
    };
    if own.targets.is_some() || all.targets.is_some() {
        return Err(at.wrong(
            "targets",
            name,
            "not beside tissue.scene, whose targets are named by tissue.aimed and tissue.told",
        ));
    }
    if own.breathing.mm.or(all.breathing.mm).is_some_and(|mm| mm > 0.0) {
        let why = "not beside tissue.scene: organs that breathe while the tube pushes them are not in the model";
        return Err(at.wrong("breathing.mm", name, why));
    }
    let path = at.path.parent().unwrap_or(Path::new("")).join(name);
    let scene = Scene::load(&path).map_err(|error| at.wrong(KEY, name, error.to_string()))?;
    let Some(spec) = &scene.tissue else {
        return Err(at.wrong(KEY, name, "a scene with a table [tissue] is needed"));
    };
    if !matches!(scene.volume.source, VolumeSource::Phantom { .. }) || scene.seed != phantom::DEFAULT_SEED {
        return Err(at.wrong(
            KEY,
            name,
            "a scene of the generated patient of seed 1 is needed: operations are of him",
        ));
    }
    let hash = hashed(&path, spec).map_err(|why| at.wrong(KEY, name, why))?;
    let aimed = mine.aimed.as_ref().or(general.aimed.as_ref());
    let aimed = named(at, "tissue.aimed", &scene, aimed)?;
    let told = match mine.told.as_ref().or(general.told.as_ref()) {
        Some(told) => named(at, "tissue.told", &scene, Some(told))?,
        None => aimed.clone(),
    };
    let long = |entry: &Point<Ct>| WAY_MM.contains(&entry.distance(aimed.centre));
    let entry = entry(&scene).filter(long).ok_or_else(|| {
        at.wrong(
            KEY,
            name,
            "the scene must say where the tube enters, 20 to 120 mm before what is aimed at: tracker.approach.entry_ct_mm",
        )
    })?;
    Ok(Some(Tissue {
        scene: Arc::new(scene),
        aimed,
        entry,
        told,
        rate_hz,
        hash,
    }))
}

/// The target of this name; without one that which the scene has chosen, else its first.
fn named(at: &At<'_>, key: &str, scene: &Scene, name: Option<&String>) -> Result<Landmark, PlanError> {
    let chosen = name.or(scene.guide.as_ref());
    let found = scene
        .targets
        .iter()
        .find(|target| chosen.is_none_or(|name| *name == target.name));
    let known: Vec<&str> = scene.targets.iter().map(|target| target.name.as_str()).collect();
    let landmark = |target: &Target| Landmark {
        name: target.name.replace(' ', "-"),
        centre: target.centre,
        diameter_mm: target.diameter_mm,
    };
    found
        .map(landmark)
        .ok_or_else(|| at.wrong(key, chosen, format!("a target of the scene: {}", known.join(", "))))
}

fn entry(scene: &Scene) -> Option<Point<Ct>> {
    match &scene.tracker.source {
        TrackerSource::Simulated(simulation) => simulation.approach.entry,
        _ => None,
    }
}

/// Of both files, and of which is which.
fn hashed(path: &Path, spec: &TissueSpec) -> Result<[u8; 32], String> {
    let mut hash = blake3::Hasher::new();
    for path in [path, &spec.organs] {
        let text = scene::file::read_text(path, super::MAX_BYTES).map_err(|error| error.to_string())?;
        hash.update(&(text.len() as u64).to_le_bytes());
        hash.update(text.as_bytes());
    }
    Ok(*hash.finalize().as_bytes())
}
