//! A recorded session, shown again: the same poses, the same pictures, and nobody takes it for the present.

use std::fs;
use std::path::{Path, PathBuf};

use crate::support::{SMALL, World, stderr, stdout};
use bus::message::ToolPose;
use recorder::read::reader;
use recorder::wire::schema::TOOL_POSE;

/// A run of 1.5 s of the small scene, recorded into `out`.
fn recorded(world: &World, out: &str) -> PathBuf {
    let scene = world.file("small.toml", SMALL);
    let out = world.path(out);
    world.navigate(&scene, &out, &["--for", "1500ms"]);
    out.join("session.mcap")
}

fn poses(recording: &Path) -> Vec<ToolPose> {
    let poses = reader::poses(recording, TOOL_POSE).unwrap();
    poses.map(Result::unwrap).collect()
}

fn replay(world: &World, recording: &Path, out: &Path, arguments: &[&str]) -> std::process::Output {
    let (recording, out) = (recording.to_string_lossy(), out.to_string_lossy());
    let mut all = vec!["replay", &*recording, "--headless", "--out", &*out];
    all.extend(arguments);
    world.output("pilot", &all)
}

const VIEWS: [&str; 3] = ["axial-global", "frontal-local", "perpendicular"];

#[test]
fn the_pictures_of_a_replay_are_those_of_the_run_byte_for_byte() {
    let world = World::new();
    let recording = recorded(&world, "live");
    let out = world.path("again");
    let output = replay(&world, &recording, &out, &["--speed", "max", "--images", "every"]);
    assert!(output.status.success(), "{}\n{}", stdout(&output), stderr(&output));
    let poses = poses(&recording);
    let report = crate::support::report(&out);
    // Every pose went out and was drawn in every view.
    assert_eq!(report["poses"]["published"], poses.len());
    // What the recording itself lacks is nobody's loss here.
    let gaps: u64 = poses.windows(2).map(|pair| pair[1].seq - pair[0].seq - 1).sum();
    assert_eq!(
        (&report["poses"]["missing"], &report["poses"]["refused"]),
        (&gaps.into(), &0.into())
    );
    for view in report["views"].as_array().unwrap() {
        assert_eq!(
            (&view["rendered"], &view["dropped"]),
            (&poses.len().into(), &0.into()),
            "{view}"
        );
        assert_eq!(view["unflagged_old"], 0);
    }
    for view in VIEWS {
        let live = world.path("live").join(format!("{view}.png"));
        let seq: u64 = crate::support::png_texts(&live)["pose_seq"].parse().unwrap();
        let again = out.join("images").join(format!("{view}-{seq:06}.png"));
        assert!(
            fs::read(&live).unwrap() == fs::read(&again).unwrap(),
            "{view}, pose {seq}"
        );
        // The pictures of the last pose, as at the end of every run, too.
        let last = poses.last().unwrap().seq;
        let last_of_all = out.join("images").join(format!("{view}-{last:06}.png"));
        assert_eq!(
            fs::read(out.join(format!("{view}.png"))).unwrap(),
            fs::read(last_of_all).unwrap()
        );
    }
    let pictures = fs::read_dir(out.join("images")).unwrap().count();
    assert_eq!(pictures, poses.len() * VIEWS.len());
    let account: serde_json::Value = serde_json::from_slice(&fs::read(out.join("replay.json")).unwrap()).unwrap();
    assert_eq!(
        (&account["published"], &account["images"]),
        (&poses.len().into(), &pictures.into())
    );
    assert_eq!(account["state"], "ended");
}
