//! The overview in a replay: the same poses give the same bytes, with the structures of the label map.

use std::fs;

use crate::support::nifti::Nifti;
use crate::support::{World, png_texts, report, stderr, stdout};

/// A CT of 20 mm voxels about a ball of bone, and structures on both sides of it; with the overview of it.
const SCENE: &str = r#"
[volume]
source = "ct.nii"
[tracker.approach]
insert_s = 1.0
pause_s = 0.2
sweep_s = 1.0
[recording]
[limits]
stale_ms = 1000.0
silent_s = 30.0
stop_s = 30.0
max_missing_share = 1.0
latency_p99_ms = 0.0
[plan]
labels = "labels.nii"
[[targets]]
name = "node"
ct_mm = [-100, -90, 70]
[[views]]
name = "surface"
plane = "surface"
extent = "global"
size = [256, 256]
[[views]]
name = "axial"
plane = "axial"
extent = "local"
size = [128, 128]
"#;

fn nifti(value: impl Fn(i32, i32, i32) -> i16) -> Vec<u8> {
    let voxels = (0..8).flat_map(|k| (0..10).flat_map(move |j| (0..12).map(move |i| (i, j, k))));
    let bytes = voxels.flat_map(|(i, j, k)| value(i, j, k).to_le_bytes());
    Nifti::header().with(bytes).into()
}

/// The label map: structures where `which` says so beside the bone.
fn structures(world: &World, which: impl Fn(i32) -> bool) {
    let value = |i, j, k| i16::from(!ball(i, j, k) && which(i + j + k));
    fs::write(world.path("labels.nii"), nifti(value)).unwrap();
}

fn ball(i: i32, j: i32, k: i32) -> bool {
    (i - 6).pow(2) + (j - 5).pow(2) + (k - 4).pow(2) < 7
}

fn write(world: &World) {
    fs::write(
        world.path("ct.nii"),
        nifti(|i, j, k| if ball(i, j, k) { 900 } else { 40 }),
    )
    .unwrap();
    structures(world, |sum| sum % 9 == 0);
}

fn replay(world: &World, out: &str) -> std::process::Output {
    let output = tried(world, out, &[]);
    assert!(output.status.success(), "{}\n{}", stdout(&output), stderr(&output));
    output
}

fn tried(world: &World, out: &str, more: &[&str]) -> std::process::Output {
    let (recording, out) = (world.path("live/session.mcap"), world.path(out));
    let [recording, out] = [&recording, &out].map(|path| path.to_string_lossy());
    let all = [
        "replay",
        &recording,
        "--headless",
        "--speed",
        "max",
        "--images",
        "every",
        "--out",
        &out,
    ];
    world.output("pilot", &[&all[..], more].concat())
}

/// The last pose of the run as a snapshot of its recording, in `name`.
fn snapshot(world: &World, name: &str) -> std::process::Output {
    let paths = [world.path("live/session.mcap"), world.path(name)];
    let [recording, out] = paths.each_ref().map(|path| path.to_str().unwrap());
    let seq = &png_texts(&world.path("live/surface.png"))["pose_seq"];
    let all = [
        "snapshot",
        "--recording",
        recording,
        "--view",
        "surface",
        "--seq",
        seq,
        "--out",
        out,
    ];
    world.output("slice-view-proc", &all)
}

/// The hash of the label map that lies there, as Trocar writes it.
fn hash(world: &World) -> String {
    let map = volume_loader::load_label_map(&world.path("labels.nii")).unwrap();
    map.hash.to_string()
}

/// Nothing tied the label map to the recording: structures of today's file were shown as those of the run.
#[test]
fn another_label_map_than_the_recorded_one_is_refused_with_both_hashes() {
    let world = World::new();
    write(&world);
    let scene = world.file("s.toml", SCENE);
    world.navigate(&scene, &world.path("live"), &["--for", "1s", "--speed", "max"]);
    let recorded = hash(&world);
    assert!(snapshot(&world, "same.png").status.success());
    assert_eq!(
        fs::read(world.path("same.png")).unwrap(),
        fs::read(world.path("live/surface.png")).unwrap()
    );

    structures(&world, |sum| sum % 7 == 0);
    let found = hash(&world);
    let refused = [
        tried(&world, "other", &[]),
        tried(&world, "other", &["--scene", scene.to_str().unwrap()]),
    ];
    for output in refused.iter().chain([&snapshot(&world, "other.png")]) {
        let said = stderr(output);
        let words = ["labels.nii", recorded.as_str(), found.as_str()];
        assert!(
            !output.status.success() && words.iter().all(|word| said.contains(word)),
            "{said}"
        );
    }
    assert!(!world.path("other.png").exists());
    // Forced, everything else is shown.
    let forced = tried(&world, "forced", &["--force"]);
    let said = stderr(&forced);
    assert!(
        forced.status.success() && said.contains("It is not shown") && said.contains(&recorded),
        "{said}"
    );
    // A scene says itself which map it takes.
    let pinned = SCENE.replace("labels.nii\"", &format!("labels.nii\"\nlabels_hash = \"{recorded}\""));
    let pinned = world.file("pinned.toml", &pinned);
    let arguments = [
        "run",
        pinned.to_str().unwrap(),
        "--headless",
        "--for",
        "1s",
        "--out",
        world.path("no").to_str().unwrap(),
    ]
    .map(str::to_owned);
    let run = world.output("pilot", &arguments.each_ref().map(String::as_str));
    assert!(
        !run.status.success() && stderr(&run).contains(&found),
        "{}",
        stderr(&run)
    );
}

/// Of a recording that does not say which label map its run had, images say so, and the report.
#[test]
fn a_recording_without_the_hash_of_its_label_map_has_structures_that_are_not_verified() {
    let world = World::new();
    write(&world);
    let (good, labels) = (fs::read(world.path("labels.nii")).unwrap(), world.path("labels.nii"));
    fs::write(&labels, "no label map").unwrap();
    let scene = world.file("s.toml", SCENE);
    world.navigate(&scene, &world.path("live"), &["--for", "1s", "--speed", "max"]);
    fs::write(&labels, good).unwrap();
    let output = replay(&world, "later");
    let unknown = "does not say which the label map it was made with";
    assert!(stderr(&output).contains(unknown), "{}", stderr(&output));
    let notes = report(&world.path("later"))["notes"].to_string();
    assert!(notes.contains(unknown) && notes.contains("labels.nii"), "{notes}");
    let unverified = fs::read(world.path("later/surface.png")).unwrap();
    // The same map where the recording says that it is it: the words are the difference.
    world.navigate(&scene, &world.path("known"), &["--for", "1s", "--speed", "max"]);
    assert!(unverified != fs::read(world.path("known/surface.png")).unwrap());
}

#[test]
fn the_overview_of_a_replay_is_that_of_the_run_byte_for_byte() {
    let world = World::new();
    write(&world);
    let scene = world.file("s.toml", SCENE);
    world.navigate(&scene, &world.path("live"), &["--for", "1500ms"]);
    replay(&world, "again");
    let live = world.path("live/surface.png");
    let seq: u64 = png_texts(&live)["pose_seq"].parse().unwrap();
    let of = |out: &str, seq: u64| fs::read(world.path(out).join(format!("images/surface-{seq:06}.png"))).unwrap();
    assert!(fs::read(&live).unwrap() == of("again", seq));
    let views = report(&world.path("again"));
    for view in views["views"].as_array().unwrap() {
        assert_eq!(
            (&view["rendered"], &view["dropped"]),
            (&views["poses"]["published"], &0.into()),
            "{view}"
        );
    }
    // Twice is the same, all of them.
    replay(&world, "twice");
    let names = fs::read_dir(world.path("again/images"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name());
    let mut count = 0;
    for name in names
        .map(|name| name.to_string_lossy().into_owned())
        .filter(|name| name.starts_with("surface-"))
    {
        let [again, twice] =
            ["again", "twice"].map(|out| fs::read(world.path(out).join("images").join(&name)).unwrap());
        assert!(again == twice, "{name}");
        count += 1;
    }
    assert!(count > 20, "{count}");
    // Where the map has gone, the image says so and the replay goes on.
    fs::remove_file(world.path("labels.nii")).unwrap();
    let output = replay(&world, "without");
    assert!(
        stderr(&output).contains("labels.nii") && stderr(&output).contains("It is not shown"),
        "{}",
        stderr(&output)
    );
    assert!(of("without", seq) != of("again", seq));
}
