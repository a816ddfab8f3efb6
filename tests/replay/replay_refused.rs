//! Recordings that are not replayed, or only with `--force`, and what is then said of them.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;

use crate::support::{SMALL, World, stderr, stdout};

fn recorded(world: &World) -> PathBuf {
    // Short chunks, so that what is cut off leaves some.
    let scene = SMALL.replace("[recording]", "[recording]\nchunk_s = 0.1");
    let scene = world.file("small.toml", &scene);
    let out = world.path("live");
    world.navigate(&scene, &out, &["--for", "1s"]);
    out.join("session.mcap")
}

fn replay(world: &World, recording: &Path, arguments: &[&str]) -> Output {
    let (recording, out) = (recording.to_string_lossy(), world.path("again"));
    let out = out.to_string_lossy();
    let mut all = vec!["replay", &*recording, "--headless", "--speed", "max", "--out", &*out];
    all.extend(arguments);
    world.output("pilot", &all)
}

fn assert_refused(output: &Output, with: &[&str]) {
    let words = stderr(output);
    assert_eq!(output.status.code(), Some(1), "{words}");
    for part in with {
        assert!(words.contains(part), "{part:?} is not in: {words}");
    }
}

#[test]
fn another_examination_is_refused_and_with_force_marked_on_every_image() {
    let world = World::new();
    let recording = recorded(&world);
    // The same patient with other voxels: another examination.
    let other = world.file("other.toml", &SMALL.replace("spacing_mm = 6.0", "spacing_mm = 7.0"));
    let other = other.to_string_lossy();
    assert_refused(
        &replay(&world, &recording, &["--scene", &other]),
        &[
            "was recorded in examination",
            "--volume PATH",
            "--force",
            "replay could not be started",
        ],
    );
    assert!(!world.path("again").join("report.json").exists());
    let output = replay(&world, &recording, &["--scene", &other, "--force", "--to", "0.2s"]);
    assert_eq!(output.status.code(), Some(3), "{}", stderr(&output));
    assert!(stdout(&output).contains("PROBLEM: the poses were recorded in another examination"));
    let report = crate::support::report(&world.path("again"));
    assert_eq!(report["replay"]["same_volume"], false);
    // Every picture says it: those of a run in that examination have no red on them. The sheet holds them all.
    for name in ["axial-global", "frontal-local", "perpendicular", "sheet"] {
        let picture = |of: &str| {
            image::open(world.path(of).join(format!("{name}.png")))
                .unwrap()
                .into_rgb8()
        };
        // Small letters are thinner than a pixel: more red than anything else.
        let alarm = |p: &&image::Rgb<u8>| p.0[0] > p.0[1].saturating_add(60) && p.0[0] > p.0[2].saturating_add(60);
        assert!(picture("again").pixels().filter(alarm).count() > 20, "{name}");
        assert_eq!(picture("live").pixels().filter(alarm).count(), 0, "{name}");
    }
}

#[test]
fn a_cut_off_recording_says_what_is_missing_and_is_replayed_with_force() {
    let world = World::new();
    let recording = recorded(&world);
    let bytes = fs::read(&recording).unwrap();
    let cut = world.path("cut.mcap");
    fs::write(&cut, &bytes[..bytes.len() * 6 / 10]).unwrap();
    assert_refused(
        &replay(&world, &cut, &[]),
        &[
            "is not whole: at byte",
            "the file ends within a record",
            "recorder recover",
            "--force",
            "poses",
        ],
    );
    let output = replay(&world, &cut, &["--force"]);
    // The recording's examination is known from its first chunk on, or not: both are said.
    assert_eq!(output.status.code(), Some(3), "{}", stderr(&output));
    assert!(
        stdout(&output).contains("PROBLEM: the recording, at byte"),
        "{}",
        stdout(&output)
    );
}

#[test]
fn a_damaged_chunk_behind_a_sound_index_is_named_with_its_messages_and_left_out() {
    let world = World::new();
    let recording = recorded(&world);
    let whole = fs::read(&recording).unwrap();
    // Each chunk says how it is compressed, then how long it is, then comes what it holds. One that holds poses, and some follow.
    let chunks = (0..whole.len()).filter(|&at| whole[at..].starts_with(b"zstd"));
    let flipped = world.path("flipped.mcap");
    let holds_poses = |at: usize| {
        let mut bytes = whole.clone();
        bytes[at + 4 + 8 + 100] ^= 4;
        fs::write(&flipped, bytes).unwrap();
        let found = recorder::read::verify::verify(&flipped).unwrap().findings.join("\n");
        found.contains(" of /tool_pose (number")
    };
    assert!(chunks.into_iter().any(holds_poses), "no chunk whose poses are named");
    let output = replay(&world, &flipped, &[]);
    assert_eq!(output.status.code(), Some(3), "{}", stderr(&output));
    for words in ["damaged chunk", " of /tool_pose (number", "left out"] {
        assert!(stderr(&output).contains(words), "{words:?} in {}", stderr(&output));
    }
    assert!(
        !stderr(&output).contains("read from start to end"),
        "{}",
        stderr(&output)
    );
    let problem = "PROBLEM: the recording, at byte";
    assert!(stdout(&output).contains(problem), "{}", stdout(&output));
}

#[test]
fn what_is_no_session_is_refused_by_name() {
    let world = World::new();
    let recording = recorded(&world);
    assert_refused(
        &replay(&world, &recording, &["--from", "1h"]),
        &["--from 3600 s", "goes from 0 s to"],
    );
    assert_refused(
        &replay(&world, &recording, &["--from", "0.5s", "--to", "0.2s"]),
        &["--from 0.5 s --to 0.2 s: the end lies before the beginning"],
    );
    let text = world.file("text.mcap", "hello");
    assert_refused(
        &replay(&world, &text, &[]),
        &["is not an MCAP file", "cannot be replayed"],
    );
    assert_refused(
        &replay(&world, &world.path("none.mcap"), &[]),
        &["opening", "none.mcap", "cannot be replayed"],
    );
    let live = world.path("live");
    let output = world.output(
        "pilot",
        &["replay", &recording.to_string_lossy(), "--out", &live.to_string_lossy()],
    );
    assert_refused(&output, &["holds a recorded session", "--out DIR"]);
    assert!(recording.exists());
    let slow = [
        "replay",
        &recording.to_string_lossy(),
        "--speed",
        "0.5",
        "--images",
        "every",
        "--out",
        "x",
    ];
    assert_refused(
        &world.output("pilot", &slow),
        &["--images: at speed 0.5", "--speed max"],
    );
}
