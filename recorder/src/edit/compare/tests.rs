use std::path::PathBuf;

use bus::message::Lost;
use geometry::Vector;

use super::*;
use crate::testing;
use crate::wire::schema::{GROUND_TRUTH, Source, TF, TOOL_POSE};

/// A recording of these poses.
fn recorded(folder: &Path, name: &str, poses: impl Iterator<Item = ToolPose>) -> PathBuf {
    let mut log = testing::log(0, 1);
    poses.for_each(|pose| log.pose(Source::Tool, &pose).unwrap());
    let path = folder.join(name);
    std::fs::write(&path, log.finish().unwrap().into_inner()).unwrap();
    path
}

/// The pose of sample `seq` with the tool turned by `angle` about a slanted axis and the tip shifted along another.
fn moved(seq: u64, angle: f64, shift_mm: f64) -> ToolPose {
    let mut pose = testing::pose(seq);
    let Ok(Tracked::Valid(ct_from_tool)) = pose.tracked() else {
        panic!("a valid pose")
    };
    let axis = Vector::new(2.0 / 3.0 * angle, -1.0 / 3.0 * angle, 2.0 / 3.0 * angle);
    let turn: Rigid<Tool, Tool> = Rigid::from_rotation_vector(axis, Vector::new(0.0, 0.0, 0.0)).unwrap();
    if angle != 0.0 {
        pose.set(Tracked::Valid(ct_from_tool * turn));
    }
    pose.t_mm[0] += shift_mm * 0.6;
    pose.t_mm[2] -= shift_mm * 0.8;
    pose
}

#[test]
fn a_recording_does_not_differ_from_itself() {
    let tmp = tempfile::tempdir().unwrap();
    let path = recorded(tmp.path(), "a.mcap", (0..50).map(testing::pose));
    let summary = Summary::of(&compare(&path, TOOL_POSE, &path, TOOL_POSE).unwrap());
    assert_eq!((summary.common, summary.compared, summary.identical), (50, 50, 50));
    assert_eq!((summary.tip_mm.max, summary.angle_deg.max), (0.0, 0.0));
}

/// Another registration, covariance and sign of the quaternion were "without a difference", and nobody was told of damage.
#[test]
fn what_differs_beside_the_place_and_what_is_not_compared_is_told() {
    let tmp = tempfile::tempdir().unwrap();
    let a = recorded(tmp.path(), "a.mcap", (0..50).map(testing::pose));
    let other = |seq: u64| {
        let mut pose = testing::pose(seq);
        match seq {
            3 => pose.registration_id ^= 1,
            4 => pose.covariance[5] += 1.0,
            5 => pose.q = pose.q.map(|x| -x),
            6 => pose.t_publish_ns += 1,
            _ => {}
        }
        pose
    };
    let b = recorded(tmp.path(), "b.mcap", (0..50).map(other));
    let summary = Summary::of(&compare(&a, TOOL_POSE, &b, TOOL_POSE).unwrap());
    assert_eq!((summary.compared, summary.same_place, summary.identical), (50, 50, 47));
    std::fs::write(&b, testing::damaged()).unwrap();
    let summary = Summary::of(&compare(&a, TOOL_POSE, &b, TOOL_POSE).unwrap());
    // The chunk, and the sum over the file.
    assert_eq!((summary.damaged, summary.common), ([0, 2], 10));
    let of = |name: &str, byte| {
        let mut log = testing::log(1, 5);
        let volume_hash = Some(bus::message::VolumeHash([byte; 32]));
        let facts = crate::wire::schema::RunFacts {
            volume_hash,
            ..testing::facts()
        };
        log.facts(&facts).unwrap();
        std::fs::write(tmp.path().join(name), log.finish().unwrap().into_inner()).unwrap();
        tmp.path().join(name)
    };
    let summary = Summary::of(&compare(&of("c.mcap", 1), TOOL_POSE, &of("d.mcap", 2), TOOL_POSE).unwrap());
    assert!(summary.to_string().contains("OF TWO EXAMINATIONS: 0101"), "{summary}");
}

#[test]
fn planted_distances_and_angles_are_found() {
    let tmp = tempfile::tempdir().unwrap();
    let a = recorded(tmp.path(), "a.mcap", (0..100).map(testing::pose));
    for (angle, shift_mm) in [(1e-9, 1e-6), (1e-3, 0.5), (1.5, 40.0), (3.1, 0.0)] {
        let b = recorded(tmp.path(), "b.mcap", (0..100).map(|seq| moved(seq, angle, shift_mm)));
        let compared = compare(&a, TOOL_POSE, &b, TOOL_POSE).unwrap();
        for d in &compared.differences {
            // Tips are below 400 mm: a few roundings of that size. Quaternions round at 1e-16, twice that is an angle; a
            // rotation that was composed, normalised and read back has gone through a dozen of them.
            assert!((d.tip_mm().unwrap() - shift_mm).abs() < 1e-12, "{d:?}");
            assert!((d.angle_rad().unwrap() - angle).abs() < 5e-15, "{angle}: {d:?}");
        }
        let summary = Summary::of(&compared);
        assert!((summary.tip_mm.rms - shift_mm).abs() < 1e-12);
        assert!((summary.angle_deg.p95 - angle.to_degrees()).abs() < 1e-12);
    }
}

#[test]
fn one_large_difference_is_the_maximum_and_moves_the_rms() {
    let tmp = tempfile::tempdir().unwrap();
    let a = recorded(tmp.path(), "a.mcap", (0..100).map(testing::pose));
    let b = recorded(
        tmp.path(),
        "b.mcap",
        (0..100).map(|s| moved(s, 0.0, if s == 37 { 5.0 } else { 0.0 })),
    );
    let summary = Summary::of(&compare(&a, TOOL_POSE, &b, TOOL_POSE).unwrap());
    assert_eq!((summary.tip_mm.max_seq, summary.identical), (37, 99));
    assert!((summary.tip_mm.max - 5.0).abs() < 1e-12 && summary.tip_mm.p95 == 0.0);
    // sqrt(5^2 / 100)
    assert!((summary.tip_mm.rms - 0.5).abs() < 1e-12);
}

#[test]
fn lost_missing_and_repeated_poses_are_counted_and_not_compared() {
    let tmp = tempfile::tempdir().unwrap();
    let lost = |seq| {
        let mut pose = testing::pose(seq);
        pose.set(Tracked::Lost(Lost::NotSeen));
        pose
    };
    let a = recorded(
        tmp.path(),
        "a.mcap",
        (0..10).map(|s| if s == 3 { lost(s) } else { testing::pose(s) }),
    );
    let b = recorded(tmp.path(), "b.mcap", [4, 5, 3, 5, 9, 12].into_iter().map(testing::pose));
    let compared = compare(&a, TOOL_POSE, &b, TOOL_POSE).unwrap();
    let seqs: Vec<u64> = compared.differences.iter().map(|d| d.seq).collect();
    assert_eq!(
        (seqs.as_slice(), compared.alone, compared.repeated),
        (&[3, 4, 5, 9][..], [6, 1], [0, 1])
    );
    let summary = Summary::of(&compared);
    assert_eq!((summary.compared, summary.valid_in_one), (3, [0, 1]));
    let out = tmp.path().join("out");
    write(&compared, &summary, &out).unwrap();
    let table = std::fs::read_to_string(out.join("compare.csv")).unwrap();
    assert_eq!(table.lines().count(), 5);
    // Lost in the first, and the tip of the second is there all the same.
    let [x, y, z] = testing::pose(3).t_mm;
    let lost_in_one = format!(",1,0,,,,,,,,,{x},{y},{z}");
    assert!(table.lines().nth(1).unwrap().ends_with(&lost_in_one), "{table}");
    let [x, y, z] = testing::pose(4).t_mm;
    let same = format!(",0,0,0,0,0,0,0,{x},{y},{z},{x},{y},{z}");
    assert!(table.lines().nth(2).unwrap().ends_with(&same), "{table}");
    assert!(out.join("compare.png").exists() && out.join("compare.json").exists());
}

#[test]
fn what_cannot_be_compared_is_refused_by_name() {
    let tmp = tempfile::tempdir().unwrap();
    let a = recorded(tmp.path(), "a.mcap", (0..5).map(testing::pose));
    let b = recorded(tmp.path(), "b.mcap", (70..80).map(testing::pose));
    let text = compare(&a, TOOL_POSE, &b, TOOL_POSE).unwrap_err().to_string();
    assert!(
        text.contains("has poses 0 to 4") && text.contains("has poses 70 to 79"),
        "{text}"
    );
    let text = compare(&a, TOOL_POSE, &b, GROUND_TRUTH).unwrap_err().to_string();
    assert!(text.contains("b.mcap holds no poses on topic /ground_truth"), "{text}");
    let text = compare(&a, TF, &b, TF).unwrap_err().to_string();
    assert!(
        text.contains("a.mcap: topic /tf holds foxglove.FrameTransform"),
        "{text}"
    );
}
