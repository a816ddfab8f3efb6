use clap::Parser;
use scene::raw;

use super::super::facts::AttachedText;
use super::*;

#[derive(Debug, Parser)]
struct Line {
    #[command(flatten)]
    args: ReplayArgs,
}

fn args(more: &[&str]) -> ReplayArgs {
    let line = ["pilot", "s.mcap", "--recompute", "--out", "/o"];
    Line::try_parse_from([&line[..], more].concat()).unwrap().args
}

fn facts(files: &[(&str, &str)]) -> Facts {
    let file = |&(name, text): &(&str, &str)| AttachedText {
        name: name.to_owned(),
        text: text.to_owned(),
    };
    Facts {
        scene: None,
        run: None,
        volume_hash: None,
        registration_id: None,
        poses: 1,
        first_ns: 0,
        last_ns: 0,
        emitters: 1,
        emitters_refused: None,
        markers: 0,
        markers_refused: None,
        files: files.iter().map(file).collect(),
        damage: Vec::new(),
    }
}

fn scene(tracker: &str) -> RawScene {
    let source = raw::parse(&format!("[tracker]\n{tracker}"), Path::new("/d/scene.toml"));
    source.unwrap().scene
}

fn prepared(args: &ReplayArgs, facts: &Facts, scene: &mut RawScene) -> Result<Recompute, String> {
    Recompute::prepare(args, facts, Path::new("/d/s.mcap"), scene).map_err(|error| error.to_string())
}

const ROOM: &str = "source = \"operating-room\"\n";
const FILES: &str = "[tracker.calibration]\nfile = \"tool.json\"\nmarker = \"ball\"\n\
                     [tracker.registration]\nfile = \"r/patient.json\"\n";

#[test]
fn states_of_tissue_are_made_again_of_a_scene_that_has_some_and_at_no_other_speed() {
    let refused = Recompute::tissue(Path::new("/d/s.mcap"), &mut scene(""))
        .unwrap_err()
        .to_string();
    assert!(
        refused.contains("/d/s.mcap was recorded in a scene without [tissue]"),
        "{refused}"
    );
    let source = raw::parse("[tissue]\norgans = \"o.toml\"", Path::new("/d/scene.toml"));
    let mut scene = source.unwrap().scene;
    let found = Recompute::tissue(Path::new("/d/s.mcap"), &mut scene).unwrap();
    assert!(found.frames.is_none() && scene.recording.is_some());
    let with = |more: &[&str]| Line::try_parse_from([&["pilot", "s.mcap", "--recompute-tissue"], more].concat());
    assert_eq!(with(&[]).unwrap().args.speed, "max");
    assert!(with(&["--loop"]).is_err() && with(&["--recompute"]).is_err());
    let slow = super::super::prepare(
        &with(&["--speed", "1", "--out", "/nowhere/o"]).unwrap().args,
        |_, _, _| Err("unread".into()),
    );
    let words = slow.map(|_| ()).unwrap_err().to_string();
    assert!(words.contains("--recompute-tissue --speed 1"), "{words}");
}

/// What is said of states that differ, or were not made.
#[test]
fn states_that_are_not_the_recorded_ones_are_a_problem() {
    let tissue = Recompute::default();
    let of = |text: &str| tissue.tissue_problem(Some(&serde_json::from_str(text).unwrap()));
    assert_eq!(
        of(r#"{"tissue": {"common": 9, "identical": 9, "alone": [0, 0]}}"#),
        None
    );
    let words = of(r#"{"tissue": {"common": 9, "identical": 7, "alone": [3, 0]}}"#).unwrap();
    assert!(
        words.starts_with("2 states") && words.contains("and 3 were not made again"),
        "{words}"
    );
}

#[test]
fn the_recordings_own_files_are_taken_where_the_command_line_names_none() {
    let mut scene = scene(&format!("{ROOM}{FILES}"));
    let facts = facts(&[("tool.json", "{}"), ("report.json", "[]")]);
    let found = prepared(&args(&[]), &facts, &mut scene).unwrap();
    // The copy in the recording, and where there is none the file itself.
    assert_eq!(found.calibration.as_deref(), Some(Path::new("/o/links/tool.json")));
    assert_eq!(found.files, [(PathBuf::from("/o/links/tool.json"), "{}".to_owned())]);
    assert_eq!(found.registration.as_deref(), Some(Path::new("/d/r/patient.json")));
    let link = scene.tracker.calibration.unwrap();
    assert_eq!(
        (link.file.as_str(), link.marker.as_deref()),
        ("/o/links/tool.json", Some("ball"))
    );
    assert!(scene.recording.is_some());
}

#[test]
fn the_command_line_comes_first_and_its_files_must_be_there() {
    let tmp = tempfile::tempdir().unwrap();
    let path = tmp.path().join("other.json");
    fs::write(&path, "{}").unwrap();
    let mut room = scene(ROOM);
    let given = args(&["--calibration", path.to_str().unwrap()]);
    let found = prepared(&given, &facts(&[]), &mut room).unwrap();
    assert_eq!((found.calibration, found.registration), (Some(path), None));
    let given = args(&["--registration", "/nowhere/r.json"]);
    let text = prepared(&given, &facts(&[]), &mut room).unwrap_err();
    assert!(text.starts_with("--registration /nowhere/r.json: "), "{text}");
}

#[test]
fn what_no_poses_can_be_made_of_is_refused_by_name() {
    let none = Facts {
        emitters: 0,
        ..facts(&[])
    };
    let text = prepared(&args(&[]), &none, &mut scene(ROOM)).unwrap_err();
    assert!(text.contains("/d/s.mcap holds no emitters (topic /emitters)"), "{text}");
    let text = prepared(&args(&[]), &facts(&[]), &mut scene("source = \"external\"")).unwrap_err();
    assert!(text.contains("a tracker of source \"external\""), "{text}");
    // Markers are what poses are made of where the scene's localizer delivers them, and nowhere else.
    let markers = scene("source = \"markers\"");
    let text = prepared(&args(&[]), &facts(&[]), &mut markers.clone()).unwrap_err();
    assert!(text.contains("/d/s.mcap holds no markers (topic /markers)"), "{text}");
    let posed = Facts {
        emitters: 0,
        markers: 5,
        ..facts(&[])
    };
    assert_eq!(
        prepared(&args(&[]), &posed, &mut markers.clone())
            .unwrap()
            .frames
            .unwrap(),
        "markers"
    );
    let text = prepared(&args(&[]), &posed, &mut scene("source = \"external\"")).unwrap_err();
    assert!(
        text.contains("makes none of markers; needed is a scene whose tracker is \"markers\""),
        "{text}"
    );
    let text = prepared(&args(&[]), &posed, &mut scene(ROOM)).unwrap_err();
    assert!(text.contains("holds no emitters"), "{text}");
    let unread = Facts {
        markers_refused: Some("another schema".to_owned()),
        ..posed
    };
    let text = prepared(&args(&[]), &unread, &mut markers.clone()).unwrap_err();
    assert!(
        text.ends_with("no poses can be made of its markers: another schema"),
        "{text}"
    );
    let later = Facts {
        emitters_refused: Some("another schema".to_owned()),
        ..facts(&[])
    };
    let text = prepared(&args(&[]), &later, &mut scene(ROOM)).unwrap_err();
    assert!(text.ends_with("another schema"), "{text}");
    let two = facts(&[("tool.json", "{}"), ("tool.json", "[]")]);
    let text = prepared(&args(&[]), &two, &mut scene(&format!("{ROOM}{FILES}"))).unwrap_err();
    assert!(
        text.contains("2 different files named \"tool.json\"") && text.contains("`--calibration FILE`"),
        "{text}"
    );
}

#[test]
fn a_recomputation_is_as_fast_as_can_be_unless_a_speed_is_asked_for() {
    assert_eq!(args(&[]).speed, "max");
    assert_eq!(args(&["--speed", "0.5"]).speed, "0.5");
    assert!(Line::try_parse_from(["pilot", "s.mcap", "--recompute", "--loop"]).is_err());
    assert!(Line::try_parse_from(["pilot", "s.mcap", "--calibration", "t.json"]).is_err());
    assert_eq!(Line::try_parse_from(["pilot", "s.mcap"]).unwrap().args.speed, "1");
}
