//! A session whose recording can no longer be written: the navigation goes on, everybody is told, and what was acknowledged is
//! there.

use std::collections::BTreeSet;
use std::fs;
use std::path::PathBuf;

use crate::support::{SMALL, World, all_live};
use recorder::read::reader;
use recorder::wire::schema::TOOL_POSE;
use rustix::process::{Pid, Resource, Rlimit, prlimit};
use serde_json::Value;

fn recorder_note(status: &Value) -> &str {
    let processes = status["processes"].as_array().unwrap();
    let recorder = processes.iter().find(|p| p["name"] == "recorder").unwrap();
    recorder["note"].as_str().unwrap()
}

/// Poses and truths that the recorder says are on disk.
fn acknowledged(note: &str) -> Option<u64> {
    note.split_once(" on disk")?.0.parse().ok()
}

/// The numbers of the poses in all files of a session.
fn recorded(folder: PathBuf) -> BTreeSet<u64> {
    let files = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let sessions = files.filter(|path| path.to_string_lossy().contains("/session."));
    let poses = sessions.flat_map(|path| reader::poses(&path, TOOL_POSE).unwrap());
    poses.flatten().map(|pose| pose.seq).collect()
}

#[test]
fn where_nothing_can_be_written_any_more_the_navigation_goes_on_and_says_so() {
    let world = World::new();
    let scene = SMALL.replace("[recording]", "[recording]\nchunk_s = 0.1");
    let pilot = world.start(&world.file("small.toml", &scene), &world.path("out"), "default");
    let status = pilot.wait_for("a recording", |status| {
        all_live(status) && acknowledged(recorder_note(status)) > Some(60)
    });
    // Not one byte more, in this file or in another.
    let pid = i32::try_from(crate::support::pid_in(&status, "recorder").unwrap()).unwrap();
    let most = Some(1);
    let limit = Rlimit {
        current: most,
        maximum: most,
    };
    prlimit(Pid::from_raw(pid), Resource::Fsize, limit).unwrap();
    // The last count before that; a later one may or may not be seen.
    let acknowledged = acknowledged(recorder_note(&status));
    let status = pilot.wait_for("the recorder to say so", |status| {
        recorder_note(status).starts_with("NOT RECORDING")
    });
    // A second of poses later, every view is as live as before.
    let seq = |status: &Value| status["views"][0]["seq"].as_u64().unwrap();
    let from = seq(&status);
    let later = pilot.wait_for("a second of poses", |status| {
        seq(status) > from + 60 && all_live(status)
    });
    assert!(recorder_note(&later).starts_with("NOT RECORDING"), "{later:#}");
    assert_eq!(pilot.stop().code(), Some(3));
    let report = crate::support::report(&world.path("out"));
    let problems = report["problems"].to_string();
    assert!(problems.contains("NOT RECORDING"), "{problems}");
    assert!(
        report["views"]
            .as_array()
            .unwrap()
            .iter()
            .all(|view| view["unflagged_old"] == 0)
    );
    // Poses and truths count alike.
    let poses = recorded(world.path("out"));
    assert!(
        2 * poses.len() as u64 >= acknowledged.unwrap(),
        "{} of {acknowledged:?}",
        poses.len()
    );
}
