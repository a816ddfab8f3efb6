//! From what the user asked for to one scene in which nothing is left open.

pub(crate) mod tied;

use std::path::{Path, PathBuf};

use phantom::Phantom;
use scene::plan::RawPlan;
use scene::raw::{self, RawTarget, Source};
use scene::{RawVolume, Scene, SceneError};

use crate::planning::{FollowError, follow};

/// The scene that runs when none is named: see the file itself.
pub(crate) const EMBEDDED: &str = include_str!("../../config/demo.toml");

/// What the command line says beside the scene file.
#[derive(Debug, Clone, Default)]
pub(crate) struct Overrides {
    /// Another examination.
    pub(crate) volume: Option<String>,
    /// Which series of its folder.
    pub(crate) series: Option<u32>,
    /// Interpolate its slices to even places.
    pub(crate) regrid: bool,
    /// Another seed.
    pub(crate) seed: Option<u64>,
    /// A plan is made: the one that the scene follows, which may be this one, is not asked for.
    pub(crate) is_planning: bool,
}

/// Why there is no scene.
#[derive(Debug, thiserror::Error)]
pub(crate) enum ResolveError {
    #[error(transparent)]
    Scene(#[from] SceneError),
    #[error(transparent)]
    Plan(#[from] FollowError),
    #[error(
        "--volume {volume} replaces the examination of scene {scene}, but its {what} belongs to that one and would \
         point at other anatomy, or name another patient, here. Write a scene for this examination, or use one without them, such as config/demo.toml"
    )]
    Misplaced {
        volume: String,
        scene: PathBuf,
        what: &'static str,
    },
    #[error(
        "--volume {0}: there is no such file; give the path of a CT (a folder with a DICOM series, or a file), or `phantom`"
    )]
    NoVolume(String),
}

/// The scene at `path`, or the shipped one of that name.
fn shipped(path: &Path) -> PathBuf {
    let Some(shipped) = scene::shipped::instead_of(path) else {
        return path.to_owned();
    };
    bus::stderr_line!("pilot: {}: the shipped scene {}", path.display(), shipped.display());
    shipped
}

/// The raw scene with everything filled in, and the same checked.
pub(crate) fn resolve(file: Option<&Path>, overrides: &Overrides) -> Result<(Source, Scene), ResolveError> {
    let mut source = match file {
        Some(path) => raw::load(&shipped(path))?,
        None => raw::parse(EMBEDDED, Path::new("(embedded demo.toml)"))?,
    };
    // As written, before anything is changed: errors then point at the file's own lines.
    Scene::from_raw(&source)?;
    if let (true, Some(plan)) = (overrides.is_planning, source.scene.plan.as_mut()) {
        (plan.file, plan.id) = (None, None);
    }
    if let Some(volume) = &overrides.volume {
        replace_volume(&mut source, volume, overrides)?;
    }
    if let Some(seed) = overrides.seed {
        source.scene.seed = seed;
    }
    follow(&mut source)?;
    add_phantom_landmarks(&mut source);
    make_paths_absolute(&mut source);
    let scene = Scene::from_raw(&source)?;
    Ok((source, scene))
}

/// The scene at `path` as a run of it has it: with its plan's targets, or the generated patient's.
///
/// # Errors
/// Why there would be no run.
pub fn scene_of_run(path: &Path) -> Result<Scene, Box<dyn std::error::Error + Send + Sync>> {
    Ok(resolve(Some(path), &Overrides::default())?.1)
}

/// Where the examination of `--volume` lies. The children run in this folder too, but the file in the run's folder must
/// not depend on it.
pub(crate) fn volume_path(volume: &str) -> Result<String, ResolveError> {
    if volume == "phantom" {
        return Ok(volume.to_owned());
    }
    let path = std::path::absolute(volume).ok().filter(|path| path.exists());
    let path = path.ok_or_else(|| ResolveError::NoVolume(volume.to_owned()))?;
    Ok(path.to_string_lossy().into_owned())
}

fn replace_volume(source: &mut Source, volume: &str, overrides: &Overrides) -> Result<(), ResolveError> {
    let misplaced = |what| ResolveError::Misplaced {
        volume: volume.to_owned(),
        scene: source.path.clone(),
        what,
    };
    if source.scene.targets.is_some() {
        return Err(misplaced("[[targets]]"));
    }
    if source.scene.tracker.approach.entry_ct_mm.is_some() {
        return Err(misplaced("[tracker.approach] entry_ct_mm"));
    }
    if source.scene.volume.region.is_some() {
        return Err(misplaced("[volume.region] corners"));
    }
    if source.scene.identity.is_some() {
        return Err(misplaced("[identity]"));
    }
    if source
        .scene
        .plan
        .as_ref()
        .is_some_and(|plan| *plan != RawPlan::default())
    {
        return Err(misplaced("[plan]"));
    }
    if source.scene.volume.hash.is_some() {
        return Err(misplaced("[volume] hash"));
    }
    // Of the generated patient, as the scene lists no targets: it goes with that patient.
    source.scene.guide.target = None;
    source.scene.volume = RawVolume {
        source: volume_path(volume)?,
        series: overrides.series,
        regrid: overrides.regrid,
        spacing_mm: source.scene.volume.spacing_mm,
        ..RawVolume::default()
    };
    Ok(())
}

/// The processes read the scene from the run's folder, which must not change what its paths mean.
fn make_paths_absolute(source: &mut Source) {
    let scene = &mut source.scene;
    let tracker = &mut scene.tracker;
    let volume = (scene.volume.source != "phantom").then_some(&mut scene.volume.source);
    let room = tracker.room.as_mut();
    let (gesture, probe) = room.map(|room| (room.gesture.as_mut(), room.probe.as_mut())).unzip();
    let tank = probe.flatten().and_then(|probe| probe.tank.as_mut());
    let files = [
        volume,
        gesture.flatten().map(|gesture| &mut gesture.file),
        tank.map(|tank| &mut tank.file),
        tracker.sequence.as_mut().map(|sequence| &mut sequence.file),
        tracker.calibration.as_mut().map(|link| &mut link.file),
        tracker.registration.as_mut().map(|link| &mut link.file),
        scene.plan.as_mut().and_then(|plan| plan.labels.as_mut()),
        scene.tissue.as_mut().and_then(|tissue| tissue.organs.as_mut()),
    ];
    let steps = scene.steps.as_mut();
    let steps = steps.map(|steps| [steps.drawing.as_mut(), steps.beads.as_mut()]);
    let roms = scene.localizer.iter_mut().flat_map(|localizer| &mut localizer.tools);
    let others = steps
        .into_iter()
        .flatten()
        .flatten()
        .chain(roms.map(|tool| &mut tool.rom));
    for file in files.into_iter().flatten().chain(others) {
        // Fails for an empty path, which was refused before.
        if let Ok(path) = std::path::absolute(&*file) {
            *file = path.to_string_lossy().into_owned();
        }
    }
}

/// The generated patient knows its lymph nodes and a way to one of them; a scene that names none gets these.
fn add_phantom_landmarks(source: &mut Source) {
    if source.scene.volume.source != "phantom" || source.scene.targets.is_some() {
        return;
    }
    let patient = Phantom::new(source.scene.seed);
    let way = patient.approach();
    let target = |landmark: &phantom::Landmark| RawTarget {
        name: landmark.name.clone(),
        ct_mm: landmark.centre.mm(),
        diameter_mm: landmark.diameter_mm,
        entry_ct_mm: (landmark.name == way.target).then(|| way.entry.mm()),
        stop_mm: 0.0,
    };
    source.scene.targets = Some(patient.targets().iter().map(target).collect());
    let approach = &mut source.scene.tracker.approach;
    if approach.target.is_none() && approach.entry_ct_mm.is_none() {
        approach.target = Some(way.target);
        approach.entry_ct_mm = Some(way.entry.mm());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_embedded_scene_gets_the_patients_lymph_nodes() {
        let (_, scene) = resolve(None, &Overrides::default()).unwrap();
        assert!(scene.targets.len() >= 3);
        let chosen = scene
            .targets
            .iter()
            .find(|target| Some(&target.name) == scene.guide.as_ref());
        assert!(chosen.is_some_and(|chosen| chosen.entry.is_some()));
        assert!(scene.recording.is_some());
        assert_eq!(scene.views.len(), 7);
    }

    /// `pilot run scenes/s.toml` looked for the scene's files in the run's folder.
    #[test]
    fn files_of_a_scene_named_by_a_relative_path_are_found_from_the_runs_folder() {
        let tmp = tempfile::tempdir_in(".").unwrap();
        let path = Path::new(tmp.path().file_name().unwrap()).join("s.toml");
        let text = "[tracker]\nsource = \"sequence\"\n[tracker.sequence]\nfile = \"a.mha\"\n\
                    [tracker.calibration]\nfile = \"t.json\"\n[tracker.registration]\nfile = \"r.json\"";
        std::fs::write(&path, text).unwrap();
        let (source, _) = resolve(Some(&path), &Overrides::default()).unwrap();
        let tracker = &source.scene.tracker;
        let files = [
            &tracker.sequence.as_ref().unwrap().file,
            &tracker.calibration.as_ref().unwrap().file,
            &tracker.registration.as_ref().unwrap().file,
        ];
        let folder = std::path::absolute(path.parent().unwrap()).unwrap();
        for (file, name) in files.into_iter().zip(["a.mha", "t.json", "r.json"]) {
            assert_eq!(Path::new(file), folder.join(name));
        }
        assert_eq!(source.scene.volume.source, "phantom");
    }

    /// `pilot run s.toml` looked for the localizer's tool definitions, and for the drawing of the steps, in the run's folder.
    #[test]
    fn tool_definitions_of_a_scene_named_by_a_relative_path_are_found_from_the_runs_folder() {
        let tmp = tempfile::tempdir_in(".").unwrap();
        let path = Path::new(tmp.path().file_name().unwrap()).join("s.toml");
        let text = "[tracker]\nsource = \"markers\"\n[tracker.markers]\nmarker = \"ball\"\nnoise_mm = 0.1\nnoise_deg = 0.1\n\
                    [localizer]\nkind = \"ndi\"\naddress = \"127.0.0.1:1\"\n\
                    [[localizer.tools]]\nname = \"ball\"\nrom = \"a.rom\"\n\
                    [tracker.calibration]\nfile = \"t.json\"\n[steps]\ncalibrate = \"base\"\ndrawing = \"d.json\"\n";
        std::fs::write(&path, text).unwrap();
        let (source, _) = resolve(Some(&path), &Overrides::default()).unwrap();
        let folder = std::path::absolute(path.parent().unwrap()).unwrap();
        let rom = &source.scene.localizer.as_ref().unwrap().tools[0].rom;
        assert_eq!(Path::new(rom), folder.join("a.rom"));
        let drawing = source.scene.steps.as_ref().unwrap().drawing.as_ref();
        assert_eq!(Path::new(drawing.unwrap()), folder.join("d.json"));
    }

    #[test]
    fn a_file_has_no_targets_of_its_own() {
        let overrides = Overrides {
            volume: Some("/etc/hostname".to_owned()),
            seed: None,
            ..Overrides::default()
        };
        let (_, scene) = resolve(None, &overrides).unwrap();
        assert!(scene.targets.is_empty());
        // What the demonstration chooses is another patient's.
        assert_eq!(scene.guide, None);
        let none = Overrides {
            volume: Some("/no/such/file".to_owned()),
            seed: None,
            ..Overrides::default()
        };
        assert!(matches!(resolve(None, &none), Err(ResolveError::NoVolume(_))));
    }

    #[test]
    fn a_choice_that_the_generated_patient_has_not_is_refused_with_its_line() {
        let tmp = tempfile::tempdir().unwrap();
        let path = tmp.path().join("s.toml");
        std::fs::write(&path, "[guide]\ntarget = \"para-aortic\"").unwrap();
        let refused = resolve(Some(&path), &Overrides::default()).unwrap_err().to_string();
        assert!(
            refused.contains("line 2, column 10, key guide.target") && refused.contains("para-aortic-left, pre-aortic"),
            "{refused}"
        );
    }

    #[test]
    fn targets_of_another_patient_are_refused() {
        let tmp = tempfile::tempdir().unwrap();
        let path = tmp.path().join("s.toml");
        let overrides = Overrides {
            volume: Some("/etc/hostname".to_owned()),
            seed: None,
            ..Overrides::default()
        };
        for text in [
            "[[targets]]\nname = \"n\"\nct_mm = [0, 0, 0]",
            "[identity]\nname = \"SECRET\"",
        ] {
            std::fs::write(&path, text).unwrap();
            let error = resolve(Some(&path), &overrides).unwrap_err();
            assert!(matches!(error, ResolveError::Misplaced { .. }));
            assert!(!error.to_string().contains("SECRET"), "{error}");
        }
    }
}
