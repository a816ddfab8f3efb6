//! A second machine's recorder: what it writes is whole, and its poses are those of the first machine's recording.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

use bus::message::Heartbeat;
use bus::port::Subscriber;
use bus::topic::HEARTBEAT;
use serde_json::Value;

use crate::both::{Both, programs, small};
use crate::rig::{PATIENCE, alone, until, world};

/// What `recorder` says; it must succeed.
fn recorder(programs: &Path, arguments: &[&str]) -> String {
    let mut command = Command::new(programs.join("recorder"));
    let output = command.args(arguments).output().unwrap();
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?}: {said}{errors}");
    said
}

/// The poses of a whole recording by their number: every number bit for bit, as the export brings them back.
fn poses(programs: &Path, folder: &Path) -> BTreeMap<u64, String> {
    let (file, out) = (folder.join("session.mcap"), folder.join("poses.json"));
    until("a whole recording", || file.exists().then_some(()));
    recorder(programs, &["verify", file.to_str().unwrap()]);
    let words = ["export", "json", file.to_str().unwrap(), "--out", out.to_str().unwrap()];
    recorder(programs, &words);
    let list: Vec<Value> = serde_json::from_slice(&std::fs::read(out).unwrap()).unwrap();
    list.into_iter()
        // As text, in which -0 is not 0.
        .map(|pose| (pose["seq"].as_u64().unwrap(), pose.to_string()))
        .collect()
}

#[test]
fn a_second_machine_records_the_poses_of_the_first() {
    let Some(programs) = programs() else { return };
    let _alone = alone();
    let world = world();
    let mut both = Both::start_with(
        world.path(),
        &programs,
        &[&small(world.path())],
        &["--headless", "--record"],
        |_| {},
    );
    let out: [PathBuf; 2] = ["o1", "o2"].map(|name| world.path().join(name));
    until("a recording on the second machine", || {
        out[1].join("session.mcap.recording").exists().then_some(())
    });
    // Two hundred poses at least, each of them recorded there or counted as lost.
    let (began, mut came) = (Instant::now(), 0);
    while came < 200 {
        came += std::iter::from_fn(|| both.far.poses.next().unwrap()).count();
        assert!(began.elapsed() < PATIENCE, "{came} poses\n{}", both.said());
        std::thread::sleep(Duration::from_millis(20));
    }
    let lost = Subscriber::<Heartbeat>::open(&both.far.bus, &HEARTBEAT, "remote", 1).unwrap();
    let lost = until("the receiver's count", || {
        Some(lost.newest().unwrap()?.counters.dropped)
    });
    for name in ["second", "or"] {
        both.stop(world.path(), &programs, name);
    }
    let [near, far] = [0, 1].map(|at| poses(&programs, &out[at]));
    assert!(far.len() >= 200, "{} poses\n{}", far.len(), both.said());
    for (seq, pose) in &far {
        assert_eq!(near.get(seq), Some(pose), "pose {seq}\n{}", both.said());
    }
    let (first, last) = (far.keys().next().unwrap(), far.keys().next_back().unwrap());
    println!(
        "{} poses from {first} to {last} are those of the first machine's recording, which has {}; lost on the way: {lost}",
        far.len(),
        near.len()
    );
}
