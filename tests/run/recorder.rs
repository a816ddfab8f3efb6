//! The recorder process: what is published is on disk, whatever kills it, and other programs can read it.

use std::path::Path;
use std::process::{Command, Output};

use crate::recorder_rig::{Rig, frame, pose, said};
use bus::message::ToolPose;
use recorder::read::{info, reader};
use recorder::wire::schema::{EMITTERS, GROUND_TRUTH, LOG, TF, TOOL_POSE};
use recorder::write::paths;

fn poses(path: &Path, topic: &str) -> Vec<ToolPose> {
    reader::poses(path, topic).unwrap().map(Result::unwrap).collect()
}

fn expected(n: u64) -> Vec<ToolPose> {
    (0..n).map(pose).collect()
}

#[test]
fn asked_to_stop_it_completes_the_file() {
    let rig = Rig::new();
    let recorder = rig.start();
    assert!(paths::recording(&rig.out()).exists() && !rig.out().exists());
    rig.publish(0..200);
    recorder.terminate();
    assert!(!paths::recording(&rig.out()).exists());
    assert_eq!(poses(&rig.out(), TOOL_POSE), expected(200));
    assert_eq!(poses(&rig.out(), GROUND_TRUTH), expected(200));
    let info = info::info(&rig.out()).unwrap();
    assert!(info.damage.is_empty());
    assert_eq!(info.tally.topics[TF].messages, 400);
    let beside = reader::beside(&rig.out()).unwrap();
    assert!(beside.scene.unwrap().contains("chunk_s"));
    assert_eq!(beside.run.unwrap().metadata["registration_id"], "feed000000000042");
}

#[test]
fn killed_it_loses_nothing_that_it_acknowledged() {
    let rig = Rig::new();
    let recorder = rig.start();
    rig.publish(0..400);
    let acknowledged = rig.wait_for_beat(|beat| beat.counters.recorded > 300).counters.recorded;
    recorder.kill();
    rig.publish(400..410);
    let second = rig.start();
    rig.publish(410..450);
    second.terminate();
    let part = poses(&paths::part(&rig.out(), 1), TOOL_POSE);
    assert!(
        2 * part.len() as u64 >= acknowledged,
        "{} of {acknowledged}",
        2 * part.len()
    );
    assert_eq!(part, expected(part.len() as u64));
    // The last of the poses sent in between comes from the topic's history.
    let rest = poses(&rig.out(), TOOL_POSE);
    assert_eq!(rest, (409..450).map(pose).collect::<Vec<_>>());
    assert!(!paths::recording(&rig.out()).exists());
}

#[test]
fn an_unfinished_file_is_shown_and_recovered() {
    let rig = Rig::new();
    let recorder = rig.start();
    rig.publish(0..100);
    rig.wait_for_beat(|beat| beat.counters.recorded == 200);
    recorder.kill();
    let growing = paths::recording(&rig.out());
    let growing = growing.to_str().unwrap();

    let shown = said(&["info", growing]);
    let text = String::from_utf8(shown.stdout).unwrap();
    assert!(
        shown.status.success() && text.contains("its recording was never finished"),
        "{text}"
    );

    let recovered = said(&["recover", growing]);
    let text = String::from_utf8(recovered.stdout).unwrap();
    assert!(recovered.status.success(), "{text}");
    // Two topics of 100 poses, their transforms, and the line of the log that says that there is a pose.
    assert!(text.starts_with("recovered 401 messages into "), "{text}");
    assert_eq!(poses(&rig.out(), TOOL_POSE), expected(100));

    let again = said(&["recover", growing]);
    let text = String::from_utf8(again.stderr).unwrap();
    assert!(!again.status.success() && text.contains("exists already"), "{text}");
    assert!(said(&["recover", growing, "--force"]).status.success());
}

#[test]
fn a_folder_that_is_not_there_is_explained() {
    let rig = Rig::new();
    let run_dir = rig.tmp.path().to_str().unwrap();
    let said = said(&["record", "--run-dir", run_dir, "--out", "/nonexistent/s.mcap"]);
    let text = String::from_utf8(said.stderr).unwrap();
    assert_eq!(said.status.code(), Some(1));
    assert!(
        text.contains("creating /nonexistent/s.mcap.recording: No such file"),
        "{text}"
    );
}

/// Runs the public Python readers over `path`.
#[expect(
    clippy::disallowed_methods,
    reason = "an independent reader is the point of the test"
)]
fn python(interpreter: &str, path: &Path) -> Output {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/python/check_mcap.py");
    Command::new(interpreter).arg(script).arg(path).output().unwrap()
}

fn hex(value: f64) -> String {
    format!("{:016x}", value.to_bits())
}

#[test]
fn python_reads_every_field() {
    let Ok(interpreter) = std::env::var("TROCAR_PYTHON") else {
        println!("skipped: TROCAR_PYTHON names no interpreter with mcap and mcap-protobuf-support");
        return;
    };
    let rig = Rig::new();
    let recorder = rig.start();
    rig.publish(0..50);
    (0..50).for_each(|seq| rig.emitters.send(frame(seq)).unwrap());
    rig.wait_for_beat(|beat| beat.counters.recorded == 150);
    // Python's reader wants the index: before it is there, it reads nothing.
    let unfinished = python(&interpreter, &paths::recording(&rig.out()));
    assert!(!unfinished.status.success());
    recorder.terminate();

    let read = python(&interpreter, &rig.out());
    assert!(read.status.success(), "{}", String::from_utf8_lossy(&read.stderr));
    let seen: serde_json::Value = serde_json::from_slice(&read.stdout).unwrap();
    assert_eq!(
        seen["counts"],
        serde_json::json!({ TOOL_POSE: 50, GROUND_TRUTH: 50, TF: 100, EMITTERS: 50, LOG: 1 })
    );
    let (found, sent) = (&seen["first"][TOOL_POSE], pose(0));
    assert_eq!(found["registration_id"], sent.registration_id);
    assert_eq!(found["t_publish_ns"], sent.t_publish_ns);
    assert_eq!(found["q"], serde_json::json!(sent.q.map(hex)));
    assert_eq!(found["t_mm"], serde_json::json!(sent.t_mm.map(hex)));
    assert_eq!(found["covariance"], serde_json::json!(sent.covariance.map(hex)));
    assert_eq!(found["fre_rms_mm"], hex(-0.0));
    assert_eq!(seen["metadata"][0]["record"], "run");
    let tf = &seen["first"][TF];
    assert_eq!(tf["t_metres"], serde_json::json!(sent.t_mm.map(|mm| hex(mm / 1e3))));
    let [w, x, y, z] = sent.q;
    assert_eq!(tf["q_xyzw"], serde_json::json!([x, y, z, w].map(hex)));
    let (found, sent) = (&seen["first"][EMITTERS], frame(0));
    assert_eq!(found["tool_emitter"], serde_json::json!((0..24).collect::<Vec<_>>()));
    let places: Vec<_> = sent
        .tool()
        .unwrap()
        .iter()
        .flat_map(|sight| sight.place_mm.map(hex))
        .collect();
    assert_eq!(found["tool_mm"], serde_json::json!(places));
    assert_eq!(found["reference_emitter"], serde_json::json!([0, 1, 2, 3]));
    assert_eq!(seen["first"][LOG]["message"], "from pose 0 on: tracked");
    assert_eq!(seen["first"][LOG]["level"], 2);
}
