//! From what the user asked for to a run in which nothing is left open.

use std::path::{Path, PathBuf};

use bus::clock;
use scene::raw::{self, Plane, RawView, Source};
use scene::{Scene, SceneError};

use super::Replay;
use super::args::{Pictured, ReplayArgs};
use super::facts::{self, Facts, FactsError};
use super::recompute::{Recompute, RecomputeError};
use crate::output;
use crate::planning::follow;
use crate::resolve::tied::{self, LoadLabels, Made, OtherFile};
use crate::resolve::{ResolveError, volume_path};
use crate::state::Options;

/// Why a recording is not replayed.
#[derive(Debug, thiserror::Error)]
pub(crate) enum PrepareError {
    #[error(transparent)]
    Facts(#[from] FactsError),
    #[error(transparent)]
    Scene(#[from] SceneError),
    #[error(transparent)]
    Resolve(#[from] ResolveError),
    #[error(transparent)]
    Tied(#[from] OtherFile),
    #[error(transparent)]
    Recompute(#[from] RecomputeError),
    #[error(
        "{recording} is not whole: {damage}. `recorder recover {recording}` makes a whole file of what is readable; with \
         `--force` that much of it ({poses} poses, {seconds:.2} s) is replayed as it is"
    )]
    Damaged {
        recording: String,
        damage: String,
        poses: u64,
        seconds: f64,
    },
    #[error("{0} has no scene attached: give one with `--scene SCENE.toml`")]
    NoScene(PathBuf),
    #[error(
        "{0} does not say in which examination it was made, so that nothing can tell whether it is the one that is shown. \
         With `--force` it is replayed all the same, and every image says so"
    )]
    NoVolume(PathBuf),
    #[error("--from {from_s} s: {recording} goes from 0 s to {last_s:.3} s")]
    Beyond {
        from_s: f64,
        recording: PathBuf,
        last_s: f64,
    },
    #[error("--from {from_s} s --to {to_s} s: the end lies before the beginning")]
    Backwards { from_s: f64, to_s: f64 },
    #[error(
        "--images: at speed {0} views leave out poses when they are busy; pictures of them on the way are taken at \
         `--speed max`, which waits for every view"
    )]
    PicturesOnTheWay(String),
    #[error(
        "--recompute-tissue --speed {0}: each pose waits for its state, so it goes as fast as the model does: leave --speed out"
    )]
    TissueSpeed(String),
    #[error(
        "{scene}: {why}, and {recording} says where organs were that the recorded scene's tool pushed. Give a scene with the recorded tool and \
         [tissue]"
    )]
    OtherTool {
        scene: PathBuf,
        why: &'static str,
        recording: PathBuf,
    },
    #[error(
        "{recording} lies in the output folder {out}, where what is left of an earlier replay is replaced. Name another \
         folder with `--out DIR`"
    )]
    InTheWay { recording: PathBuf, out: PathBuf },
    #[error(
        "output folder {0} holds a recorded session: its pictures would be replaced by those of the replay. Name another \
         folder with `--out DIR`"
    )]
    HoldsSession(PathBuf),
}

/// Reads the recording, and refuses what cannot be replayed before anything is started.
pub(crate) fn prepare(args: &ReplayArgs, load: LoadLabels) -> Result<(Options, Source, Scene), PrepareError> {
    let recording = std::path::absolute(&args.recording).unwrap_or_else(|_| args.recording.clone());
    if !output::recordings(&args.out, output::SESSION).is_empty() {
        return Err(PrepareError::HoldsSession(args.out.clone()));
    }
    let out = std::path::absolute(&args.out).unwrap_or_else(|_| args.out.clone());
    if recording.parent() == Some(&out) {
        return Err(PrepareError::InTheWay { recording, out });
    }
    if args.recompute_tissue && args.speed != "max" {
        return Err(PrepareError::TissueSpeed(args.speed.clone()));
    }
    let every = match args.images {
        Pictured::Last => None,
        Pictured::Every(_) if args.speed != "max" => return Err(PrepareError::PicturesOnTheWay(args.speed.clone())),
        Pictured::Every(n) => Some(n),
    };
    // What is left out on the way is told then; poses that are made again leave nothing out.
    let facts = facts::ask(&recording, args.recompute || args.recompute_tissue)?;
    let span_ns = span(&facts, &recording, [args.from, args.to])?;
    if !args.force {
        whole(&facts, &recording)?;
    }
    let (mut source, scene, recompute) = scene(args, &facts, &recording)?;
    let unknown_files = same_files((&mut source, &scene), (args, &recording), load)?;
    let replay = Replay {
        recording,
        speed: args.speed.clone(),
        span_ns,
        looping: args.looping,
        force: args.force,
        every,
        recompute,
        unknown_files,
        facts,
    };
    let options = Options {
        run: args.run.clone(),
        out: args.out.clone(),
        overwrite: false,
        duration: None,
        simulated_time: false,
        has_window: args.window && !args.headless,
        replay: Some(replay),
        remote: None,
        planning: None,
    };
    Ok((options, source, scene))
}

/// The moments from the first to the last that is replayed, ns on the recorded run's clock.
fn span(facts: &Facts, recording: &Path, [from, to]: [Option<f64>; 2]) -> Result<[i64; 2], PrepareError> {
    let last_s = clock::ms(facts.last_ns.saturating_sub(facts.first_ns)) / 1e3;
    let from_s = from.unwrap_or(0.0);
    if from_s > last_s {
        return Err(PrepareError::Beyond {
            from_s,
            recording: recording.to_owned(),
            last_s,
        });
    }
    let moment = |s: f64| facts.first_ns.saturating_add(clock::seconds(s));
    match to {
        Some(to_s) if to_s < from_s => Err(PrepareError::Backwards { from_s, to_s }),
        Some(to_s) => Ok([moment(from_s), moment(to_s).min(facts.last_ns)]),
        None => Ok([moment(from_s), facts.last_ns]),
    }
}

fn whole(facts: &Facts, recording: &Path) -> Result<(), PrepareError> {
    if let Some(first) = facts.damage.first() {
        let more = match facts.damage.len() - 1 {
            0 => String::new(),
            n => format!(" (and {n} more)"),
        };
        return Err(PrepareError::Damaged {
            recording: recording.display().to_string(),
            damage: format!("{first}{more}"),
            poses: facts.poses,
            seconds: clock::ms(facts.last_ns.saturating_sub(facts.first_ns)) / 1e3,
        });
    }
    match facts.volume_hash {
        None => Err(PrepareError::NoVolume(recording.to_owned())),
        Some(_) => Ok(()),
    }
}

/// Refuses a scene in which the recorded states of organs would be shown with another tool, or not at all, without a word.
fn same_organs(source: &Source, (path, recorded): (&Path, &str), recording: &Path) -> Result<(), PrepareError> {
    // A recorded scene that cannot be read any more has nothing to be held against.
    let Ok(recorded) = raw::parse_attached(recorded, recording) else {
        return Ok(());
    };
    let refused = |why| PrepareError::OtherTool {
        scene: path.to_owned(),
        why,
        recording: recording.to_owned(),
    };
    let size = |source: &Source| (source.scene.tool.length_mm, source.scene.tool.diameter_mm);
    match (&recorded.scene.tissue, &source.scene.tissue) {
        (None, _) => Ok(()),
        (Some(_), None) => Err(refused("it has no [tissue]")),
        (Some(_), Some(_)) if size(&recorded) != size(source) => {
            Err(refused("its tool has another length or diameter"))
        }
        _ => Ok(()),
    }
}

/// Refuses other files than pictures, or states of a model that answers again, were made of; in words those of which the recording says nothing.
fn same_files(
    (source, scene): (&mut Source, &Scene),
    (args, recording): (&ReplayArgs, &Path),
    load: LoadLabels,
) -> Result<Vec<String>, PrepareError> {
    // An overview shows no other structures, whether it is forced or not.
    let made = Made {
        overview: Made::by(scene).overview && !args.force,
        organs: args.recompute_tissue,
    };
    let unknown = tied::check(&mut source.scene, (scene, made), recording, load)?;
    for words in &unknown {
        bus::stderr_line!("pilot: warning: {words}");
    }
    Ok(unknown)
}

/// The scene of the recording, with the examination where it lies now; without a recording of its own, unless poses are made
/// again.
fn scene(
    args: &ReplayArgs,
    facts: &Facts,
    recording: &Path,
) -> Result<(Source, Scene, Option<Recompute>), PrepareError> {
    let mut source = match (&args.scene, &facts.scene) {
        (Some(path), _) => raw::load(path)?,
        (None, Some(text)) => raw::parse_attached(text, recording)?,
        (None, None) => return Err(PrepareError::NoScene(recording.to_owned())),
    };
    if let (Some(path), Some(text)) = (&args.scene, &facts.scene) {
        same_organs(&source, (path, text), recording)?;
    }
    if let Some(mut recorded) = facts
        .scene
        .as_ref()
        .and_then(|text| raw::parse_attached(text, recording).ok())
    {
        tied::take_over(&mut source.scene, &mut recorded.scene);
    }
    // Structures beside planned ways are no part of a replay, and their file may be elsewhere by now: an overview that shows them says so.
    let labels = source.scene.plan.as_mut().and_then(|plan| plan.labels.take());
    follow(&mut source).map_err(ResolveError::from)?;
    let is_surface = |view: &RawView| view.plane == Plane::Surface;
    let is_shown = source.scene.views.iter().flatten().any(is_surface);
    if let Some(plan) = source.scene.plan.as_mut() {
        plan.labels = labels.filter(|_| is_shown);
    }
    // The recording says in which examination it was made, and each image whether it is that one.
    source.scene.volume.hash = None;
    let recompute = match (args.recompute, args.recompute_tissue) {
        (true, _) => Some(Recompute::prepare(args, facts, recording, &mut source.scene)?),
        (_, true) => Some(Recompute::tissue(recording, &mut source.scene)?),
        _ => {
            source.scene.recording = None;
            None
        }
    };
    if let Some(volume) = &args.volume {
        // Region, spacing and targets stay: this is the same examination in another place, and its hash says whether it is.
        source.scene.volume.source = volume_path(volume)?;
        source.scene.volume.series = args.series;
    }
    let scene = Scene::from_raw(&source)?;
    Ok((source, scene, recompute))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn facts() -> Facts {
        Facts {
            scene: None,
            run: None,
            volume_hash: Some("ab".to_owned()),
            registration_id: None,
            poses: 100,
            first_ns: 2_000_000_000,
            last_ns: 12_000_000_000,
            emitters: 0,
            emitters_refused: None,
            markers: 0,
            markers_refused: None,
            files: Vec::new(),
            damage: Vec::new(),
        }
    }

    fn of(from: Option<f64>, to: Option<f64>) -> Result<[i64; 2], String> {
        span(&facts(), Path::new("/d/s.mcap"), [from, to]).map_err(|e| e.to_string())
    }

    #[test]
    fn places_count_from_the_first_pose_and_end_with_the_last() {
        assert_eq!(of(None, None), Ok([2_000_000_000, 12_000_000_000]));
        assert_eq!(of(Some(3.2), Some(9.0)), Ok([5_200_000_000, 11_000_000_000]));
        assert_eq!(of(Some(10.0), Some(99.0)), Ok([12_000_000_000, 12_000_000_000]));
        let text = of(Some(10.1), None).unwrap_err();
        assert_eq!(text, "--from 10.1 s: /d/s.mcap goes from 0 s to 10.000 s");
        assert!(of(Some(3.0), Some(2.0)).unwrap_err().contains("before the beginning"));
    }

    #[test]
    fn another_scene_shows_recorded_organs_with_the_recorded_tool_or_is_refused() {
        let recorded = "[tool]\nlength_mm = 180.0\ndiameter_mm = 12.0\n[tissue]\norgans = \"o.toml\"\n";
        let of = |text: &str, recorded: &str| {
            let source = raw::parse(text, Path::new("other.toml")).unwrap();
            same_organs(&source, (Path::new("other.toml"), recorded), Path::new("s.mcap")).map_err(|e| e.to_string())
        };
        assert_eq!(of(recorded, recorded), Ok(()));
        assert_eq!(of("[tool]\ndiameter_mm = 3.0\n", "seed = 1\n"), Ok(()));
        assert!(
            of("seed = 1\n", recorded)
                .unwrap_err()
                .contains("other.toml: it has no [tissue]")
        );
        let thin = recorded.replace("12.0", "8.0");
        assert!(of(&thin, recorded).unwrap_err().contains("another length or diameter"));
    }

    #[test]
    fn damaged_recordings_say_what_is_missing_and_what_to_do() {
        let mut facts = facts();
        assert!(whole(&facts, Path::new("s.mcap")).is_ok());
        facts.damage = vec!["at byte 77: damaged chunk".to_owned(), "at byte 99: x".to_owned()];
        let text = whole(&facts, Path::new("s.mcap")).unwrap_err().to_string();
        for part in [
            "at byte 77: damaged chunk (and 1 more)",
            "recorder recover s.mcap",
            "--force",
            "100 poses, 10.00 s",
        ] {
            assert!(text.contains(part), "{text}");
        }
        facts.damage.clear();
        facts.volume_hash = None;
        assert!(matches!(
            whole(&facts, Path::new("s.mcap")),
            Err(PrepareError::NoVolume(_))
        ));
    }
}
