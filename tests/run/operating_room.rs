//! The simulated operating room in a run: emitters through the chain to poses, each with the truth beside it.

#![allow(clippy::print_stdout, reason = "the figures of the run")]

use std::collections::BTreeMap;
use std::path::Path;

use crate::support::{SMALL, World};
use bus::message::{Lost, ToolPose, Tracked};
use geometry::{Ct, Point, Rigid, Tool, Uncertain};
use recorder::read::reader;
use recorder::wire::schema::{GROUND_TRUTH, TOOL_POSE};

/// The small scene with its tracker in an operating room.
fn scene(room: &str) -> String {
    SMALL.replace("[tracker]\n", "[tracker]\nsource = \"operating-room\"\n") + room
}

/// The poses are what is looked at: a small picture leaves the machine to them.
const ONE_VIEW: &str = "[[views]]\nname = \"a\"\nplane = \"axial\"\nextent = \"local\"\nsize = [64, 64]\n";

/// The recorded samples of a topic by their number.
fn recorded(out: &Path, topic: &str) -> BTreeMap<u64, ToolPose> {
    let poses = reader::poses(&out.join("session.mcap"), topic).unwrap();
    poses.map(|pose| pose.unwrap()).map(|pose| (pose.seq, pose)).collect()
}

fn valid(pose: &ToolPose) -> Option<Rigid<Ct, Tool>> {
    match pose.tracked().unwrap() {
        Tracked::Valid(pose) => Some(pose),
        Tracked::Lost(_) => None,
    }
}

fn tip(pose: Rigid<Ct, Tool>) -> Point<Ct> {
    pose * Point::<Tool>::new(0.0, 0.0, 0.0)
}

#[test]
fn with_everything_off_the_poses_are_the_truth() {
    let world = World::new();
    let exact = "[tracker.room.localizer]\nacross_mm = 0.0\ndepth_mm = 0.0\n[tracker.room.marker]\ncone_deg = 180.0\n\
                 [tracker.room.handle]\nradius_mm = 0.0\n";
    let (scene, out) = (world.file("room.toml", &scene(exact)), world.path("out"));
    let report = world.navigate(&scene, &out, &["--for", "1500ms", "--speed", "max"]);
    assert!(
        report["problems"].as_array().unwrap().is_empty(),
        "{}",
        report["problems"]
    );
    let (poses, truths) = (recorded(&out, TOOL_POSE), recorded(&out, GROUND_TRUTH));
    assert!(poses.len() > 20, "{}", poses.len());
    for (seq, pose) in &poses {
        let (found, truth) = (valid(pose).unwrap(), valid(&truths[seq]).unwrap());
        // Coordinates of 2300 mm carry 4.5e-13 mm each, thrown 300 mm far from a ball of 50 mm, twice.
        assert!(tip(found).distance(tip(truth)) < 2e-11, "{seq}");
        assert_eq!(pose.visible, 24);
    }
}

#[test]
fn the_shipped_room_is_navigated_with_its_errors_as_predicted() {
    let world = World::new();
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("config/operating-room-stress.toml");
    let text = std::fs::read_to_string(shipped)
        .unwrap()
        .replace("spacing_mm = 1.5", "spacing_mm = 6.0")
        // How long a busy machine takes is not looked at here.
        .replace("stale_ms = 100.0", "stale_ms = 100.0\nsilent_s = 30.0\nstop_s = 30.0")
        + ONE_VIEW
        + "[recording]\n";
    let (scene, out) = (world.file("room.toml", &text), world.path("out"));
    let report = world.navigate(&scene, &out, &["--for", "9s", "--speed", "max"]);
    assert!(
        report["problems"].as_array().unwrap().is_empty(),
        "{}",
        report["problems"]
    );
    let (poses, truths) = (recorded(&out, TOOL_POSE), recorded(&out, GROUND_TRUTH));
    let (mut within, mut found, mut worst) = (0, 0, 0.0_f64);
    let mut lost: BTreeMap<&str, u32> = BTreeMap::new();
    for (seq, pose) in &poses {
        let truth = tip(valid(&truths[seq]).unwrap());
        match pose.tracked().unwrap() {
            Tracked::Valid(at) => {
                let uncertain = Uncertain::from_upper(at, pose.covariance).unwrap();
                let covariance = (uncertain * Point::<Tool>::new(0.0, 0.0, 0.0)).covariance();
                let off = tip(at).distance(truth);
                found += 1;
                worst = worst.max(off);
                within += u64::from(off <= 4.0 * covariance.trace().sqrt());
                assert!(pose.visible >= 4 && pose.fre_rms_mm < 1.0 && covariance.trace() > 0.0);
                assert!(pose.used >= 4 && pose.used <= pose.visible);
                // The radius that holds 95 % lies between 1.6 and 2 roots of the trace, however it is divided.
                let share = pose.tip_95_mm().unwrap() / covariance.trace().sqrt();
                assert!((1.6..2.0).contains(&share), "{share}");
            }
            Tracked::Lost(reason) => *lost.entry(Lost::words(reason)).or_default() += 1,
        }
    }
    println!("{found} poses, worst error at the tip {worst:.2} mm, lost: {lost:?}");
    let accuracy = &report["accuracy"];
    assert_eq!(accuracy["tip_known"].as_u64(), Some(found), "{accuracy}");
    let counted: BTreeMap<&str, u64> = lost.iter().map(|(reason, n)| (*reason, u64::from(*n))).collect();
    assert_eq!(accuracy["lost"], serde_json::json!(counted));
    // The hand hides the ball for 1.5 s of 5.
    assert!(found > 50, "{found}");
    assert!(lost.values().sum::<u32>() > 5, "the hand never hid the ball");
    // Four deviations: one pose in ten thousand is further off, in one dimension.
    assert_eq!(within, found);
}
