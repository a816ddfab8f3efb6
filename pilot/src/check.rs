//! `pilot check`: what a scene would start, and what would keep it from working, before anything is started.

mod files;
mod labels;
mod organs;
mod place;
mod targets;

use std::path::Path;

use bus::run::{RunContext, run_dir, shm_free_bytes};
use scene::Scene;
use scene::localizer::LocalizerSpec;
use scene::raw::Source;

use crate::plan::{Poses, add_gateway, add_steps, plan};
pub(crate) use labels::LoadLabels;
pub use organs::Depth;
pub(crate) use organs::LookAtOrgans;
use place::Examination;

/// Below this side an image is too small for its words: they are drawn over one another, px.
const WORDS_PX: u32 = 192;
/// What must be free in shared memory beside the voxels, bytes: see docs/examinations.md.
const SPARE_BYTES: u64 = 64 << 20;

/// What was found.
#[derive(Debug, Default, PartialEq, Eq)]
pub(crate) struct Checked {
    /// What would be started and shown.
    pub(crate) lines: Vec<String>,
    /// What keeps the scene from working, each with what to do.
    pub(crate) faults: Vec<String>,
}

/// Reads the tank that a simulated probe images, where a scene has one.
pub(crate) type LookAtTank = fn(&Scene) -> Result<(), Box<dyn std::error::Error + Send + Sync>>;

/// Looks at everything that a scene names; `is_quick` leaves out the meshing of organs.
pub(crate) fn check(
    source: &Source,
    scene: &Scene,
    is_quick: bool,
    (look, tank, load): (LookAtOrgans, LookAtTank, LoadLabels),
) -> Checked {
    let mut lines = lines(source, scene);
    let mut faults = files::faults(source, scene);
    faults.extend(tank(scene).err().map(|why| format!("tracker.room.probe.tank: {why}")));
    faults.extend(targets::faults(scene));
    let examination = Examination::of(source, scene);
    if scene.tissue.is_some() {
        let depth = match (&examination, files::labels_of_organs(scene)) {
            (Ok(_), None) if is_quick => Depth::Map,
            (Ok(_), None) => Depth::Meshes,
            _ => Depth::Text,
        };
        let found = organs::look_at(scene, depth, look);
        lines.extend(found.lines);
        faults.extend(found.faults);
    }
    match &examination {
        Ok(examination) => {
            faults.extend(place::faults(scene, examination));
            faults.extend(memory(examination));
            lines.extend(examination.doubts());
            let found = labels::look_at(scene, examination, load);
            lines.extend(found.lines);
            faults.extend(found.faults);
        }
        Err(why) => faults.push(why.clone()),
    }
    let folder = run_dir("default").and_then(|dir| RunContext::new(&dir, 0));
    faults.extend(folder.err().map(|error| error.to_string()));
    Checked { lines, faults }
}

/// What keeps a scene from working and is known without reading an examination.
pub(crate) fn cheap_faults(source: &Source, scene: &Scene) -> Vec<String> {
    let generated = Examination::generated(source, scene).and_then(Result::ok);
    let outside = generated.iter().flat_map(|it| place::faults(scene, it));
    targets::faults(scene).into_iter().chain(outside).collect()
}

/// Voxels take 2 bytes each. Where the system does not say how much is free, the loader finds out.
fn memory(examination: &Examination) -> Option<String> {
    let needed = examination
        .loaded_voxels()?
        .saturating_mul(2)
        .saturating_add(SPARE_BYTES);
    let free = shm_free_bytes().ok()?;
    let mib = |bytes: u64| bytes.div_ceil(1 << 20);
    (free < needed).then(|| {
        format!(
            "shared memory: the examination needs {} MiB of /dev/shm and {} MiB are free. Free some, load a part of it \
             ([volume.region]) or fewer voxels (volume.downsample)",
            mib(needed),
            free >> 20
        )
    })
}

fn lines(source: &Source, scene: &Scene) -> Vec<String> {
    let mut lines = vec![format!("volume: {}", source.scene.volume.source)];
    lines.push(format!(
        "registration {:016x}, seed {}",
        scene.registration_id(),
        scene.seed
    ));
    let mut planned = plan(scene, "session.mcap", Poses::Tracked);
    add_steps(&mut planned, scene, Path::new(""));
    add_gateway(&mut planned, scene);
    for process in planned {
        let views = process.views.iter().map(|&v| scene.views[v].name.as_str());
        lines.push(
            format!("starts {:<20} {}", process.name, views.collect::<Vec<_>>().join(" "))
                .trim_end()
                .to_owned(),
        );
    }
    for target in &scene.targets {
        lines.push(format!("target {:<20} {}", target.name, target.centre.in_words(1)));
    }
    if let Some(why) = scene.localizer.as_ref().and_then(LocalizerSpec::why_no_sweep) {
        lines.push(format!(
            "warning: `pilot calibrate sweep` refuses the images of this scene: {why}"
        ));
    }
    for view in &scene.views {
        let shorter = view.size[0].min(view.size[1]);
        if shorter < WORDS_PX {
            lines.push(format!(
                "note: view {}: {shorter} pixels are too few for the words on an image; from {WORDS_PX} a side on they can be read",
                view.name
            ));
        }
    }
    lines
}

#[cfg(test)]
mod tests;
