//! Which instant is found, what it comes with, and what is refused by name.

use std::fs;
use std::io::Cursor;

use bus::message::{Chosen, Lost, TissueHeader, TissueMeshHeader};
use geometry::Point;
use scene::Compression;

use super::*;
use crate::testing;
use crate::wire::proto;
use crate::wire::schema::{RunFacts, Source};
use crate::write::pose_log::{Entry, PoseLog};

type Log = PoseLog<Cursor<Vec<u8>>>;

fn log() -> Log {
    let mut log = PoseLog::new(Cursor::new(Vec::new()), Compression::Zstd, &[]).unwrap();
    log.scene("seed = 7\n", 0).unwrap();
    let facts = RunFacts {
        volume_hash: Some(bus::message::VolumeHash([0xab; 32])),
        ..testing::facts()
    };
    log.facts(&facts).unwrap();
    log
}

fn state(seq: u64, mesh: u8) -> TissueFrame {
    let pose = testing::pose(seq);
    TissueFrame {
        header: TissueHeader {
            seq: 100 + seq,
            pose_seq: seq,
            t_capture_ns: pose.t_capture_ns,
            t_publish_ns: pose.t_publish_ns + 7,
            registration_id: pose.registration_id,
            mesh_id: [mesh; 32],
            ..TissueHeader::default()
        },
        nodes: vec![1.0, f32::NAN, 3.0],
    }
}

fn put(log: &mut Log, state: &TissueFrame) {
    log.put(Entry::Tissue(&proto::TissueState::from(state))).unwrap();
}

fn put_mesh(log: &mut Log, id: u8) {
    let mesh = MeshFrame {
        header: TissueMeshHeader {
            mesh_id: [id; 32],
            ..TissueMeshHeader::default()
        },
        bytes: vec![id],
    };
    log.put(Entry::TissueMesh(&proto::TissueMesh::of(0, &mesh))).unwrap();
}

/// Poses 0 to 29 of 60 Hz, with organs of mesh 3, states of poses 4 to 6, and a choice at pose 5.
fn session() -> Log {
    let mut log = log();
    put_mesh(&mut log, 3);
    let chosen = Chosen {
        name: "node".to_owned(),
        centre: Point::new(1.0, 2.0, 3.0),
        radius_mm: 2.0,
        entry: None,
        stop_mm: 0.0,
    };
    let guide = Guide {
        t_ns: testing::pose(5).t_capture_ns,
        ..Guide::default().choosing(Some(&chosen), 1)
    };
    log.put(Entry::Guide(0, &proto::Guide::from(&guide))).unwrap();
    for seq in 0..30 {
        log.pose(Source::Tool, &testing::pose(seq)).unwrap();
        if (4..=6).contains(&seq) {
            put(&mut log, &state(seq, 3));
        }
    }
    log
}

fn at(bytes: &[u8], place: Place<'_>) -> Result<Instant, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("s.mcap");
    fs::write(&path, bytes).unwrap();
    instant(&path, place).map_err(|error| error.to_string())
}

fn finished(log: Log) -> Vec<u8> {
    log.finish().unwrap().into_inner()
}

#[test]
fn an_instant_has_the_pose_its_state_its_mesh_and_what_was_chosen_when_it_was_captured() {
    let bytes = finished(session());
    let found = at(&bytes, Place::Seq(5)).unwrap();
    assert_eq!(testing::bytes(&found.pose), testing::bytes(&testing::pose(5)));
    assert_eq!((found.scene.seed, found.volume_hash), (7, "ab".repeat(32)));
    assert_eq!(found.guide.unwrap().chosen().unwrap().unwrap().name, "node");
    let (mesh, state) = found.tissue.unwrap();
    assert_eq!((mesh.bytes, state.header.seq), (vec![3], 105));
    // What is no number comes as it was recorded: who draws refuses it.
    assert!(state.nodes[1].is_nan());
    // Nothing was chosen yet, and no state there is none of another pose.
    let before = at(&bytes, Place::Seq(4)).unwrap();
    assert!(before.guide.is_none() && before.tissue.is_some());
    assert!(at(&bytes, Place::Seq(7)).unwrap().tissue.is_none());
    // As a replay that is sent there: 20 ms behind the first pose is behind the second, 50 ms is the fourth.
    for (text, seq) in [("0", 0), ("20ms", 2), ("0.05s", 3), ("0.4833", 29)] {
        assert_eq!(at(&bytes, Place::At(text)).unwrap().pose.seq, seq, "{text}");
    }
}

#[test]
fn a_state_of_another_run_is_none_of_this_pose() {
    let of = |change: fn(&mut TissueHeader)| {
        let mut log = session();
        let mut foreign = state(20, 3);
        change(&mut foreign.header);
        put(&mut log, &foreign);
        at(&finished(log), Place::Seq(20)).unwrap().tissue.is_some()
    };
    assert!(of(|_| {}));
    assert!(!of(|header| header.t_capture_ns += 1));
    assert!(!of(|header| header.registration_id ^= 1));
    assert!(!of(|header| header.pose_seq += 1));
}

#[test]
fn what_cannot_be_drawn_is_refused_by_name() {
    let whole = finished(session());
    let why = |bytes: &[u8], place| at(bytes, place).map(|found| found.pose.seq).unwrap_err();
    let says = |text: String, parts: &[&str]| parts.iter().for_each(|part| assert!(text.contains(part), "{text}"));
    says(
        why(&whole, Place::Seq(30)),
        &["--seq 30", "no pose of this number", "first is 0, its last 29"],
    );
    says(why(&whole, Place::At("2s")), &["--at 2 s", "from 0 s to 0.483 s"]);
    says(why(&whole, Place::At("later")), &["--at \"later\"", "3.2s"]);

    let mut log = session();
    put(&mut log, &state(20, 9));
    let unknown = why(&finished(log), Place::Seq(20));
    says(
        unknown,
        &[
            "tissue 120, of pose 20, is of mesh 09090909",
            "the recording has 03030303",
        ],
    );

    // A source that counts anew, and a pose that is none.
    let mut log = session();
    for (seq, after) in [(5, 40), (6, 41)] {
        let later = testing::pose(after);
        let again = ToolPose { seq, ..later };
        log.pose(Source::Tool, &again).unwrap();
    }
    let mut lost = testing::pose(42);
    lost.set(Tracked::Lost(Lost::NotSeen));
    log.pose(Source::Tool, &lost).unwrap();
    let bytes = finished(log);
    says(
        why(&bytes, Place::Seq(5)),
        &["2 poses of this number", "at 0.0833", "at 0.6666", "--at"],
    );
    says(why(&bytes, Place::Seq(42)), &["pose 42", Lost::NotSeen.words()]);

    // Cut off anywhere, and a damaged chunk.
    for part in [0.3, 0.6, 0.95] {
        let cut = &whole[..(part * whole.len() as f64) as usize];
        let text = why(cut, Place::Seq(5));
        assert!(text.contains("byte") || text.contains("no poses"), "{part}: {text}");
    }
    let mut bare = PoseLog::new(Cursor::new(Vec::new()), Compression::Zstd, &[]).unwrap();
    bare.pose(Source::Tool, &testing::pose(0)).unwrap();
    says(why(&finished(bare), Place::Seq(0)), &["no scene attached"]);
    says(
        why(&testing::finished(1, 3), Place::Seq(0)),
        &["does not say in which examination"],
    );
}

/// The same numbers for longer than the scene bears are no measurement, wherever one looks.
#[test]
fn a_measurement_that_stood_still_has_no_picture() {
    let mut log = log();
    for seq in 0..60 {
        let (there, now) = (testing::pose(0), testing::pose(seq));
        let (q, t_mm) = (there.q, there.t_mm);
        log.pose(Source::Tool, &ToolPose { q, t_mm, ..now }).unwrap();
    }
    let bytes = finished(log);
    let early = at(&bytes, Place::Seq(10)).map(|found| found.pose.seq);
    let late = at(&bytes, Place::Seq(50)).map(|found| found.pose.seq);
    // The default scene's tracker is simulated with noise, and its limit 500 ms: 30 poses.
    assert_eq!(early, Ok(10));
    assert!(late.unwrap_err().contains(Lost::Frozen.words()));
}

/// The beginning of a cut was taken for that of the run.
#[test]
fn a_measurement_that_may_have_stood_still_before_a_cut_is_not_called_judged() {
    let mut log = log();
    for seq in 0..90 {
        // Still from pose 30 on.
        let (there, now) = (testing::pose(seq.min(30)), testing::pose(seq));
        let (q, t_mm) = (there.q, there.t_mm);
        log.pose(Source::Tool, &ToolPose { q, t_mm, ..now }).unwrap();
    }
    let bytes = finished(log);
    let tmp = tempfile::tempdir().unwrap();
    let (whole, part) = (tmp.path().join("s.mcap"), tmp.path().join("part.mcap"));
    fs::write(&whole, &bytes).unwrap();
    let stretch = crate::edit::cut::Stretch {
        from_ns: testing::pose(40).t_capture_ns.cast_unsigned(),
        to_ns: testing::pose(89).t_capture_ns.cast_unsigned(),
    };
    crate::edit::cut::cut(&whole, stretch, &part, false).unwrap();
    let judged = |bytes: &[u8], seq| at(bytes, Place::Seq(seq)).map(|found| found.standstill_judged);
    assert_eq!((judged(&bytes, 0), judged(&bytes, 40)), (Ok(true), Ok(true)));
    assert_eq!(judged(&fs::read(&part).unwrap(), 45), Ok(false));
    // For 500 ms it was seen to stand still.
    assert!(
        judged(&fs::read(&part).unwrap(), 80)
            .unwrap_err()
            .contains(Lost::Frozen.words())
    );
}

/// The pose behind a gap of two seconds was drawn for a moment within it, and nothing was said.
#[test]
fn a_moment_in_a_gap_has_no_picture_and_the_pose_behind_it_is_named() {
    let mut log = log();
    for seq in (0..30).chain(150..160) {
        log.pose(Source::Tool, &testing::pose(seq)).unwrap();
    }
    let bytes = finished(log);
    let why = at(&bytes, Place::At("1s")).map(|found| found.pose.seq).unwrap_err();
    for words in ["--at 1.000 s", "is 150, at 2.500 s", "within 1000 ms", "--seq 150"] {
        assert!(why.contains(words), "{why}");
    }
    let near = at(&bytes, Place::At("2.1s")).unwrap();
    assert_eq!((near.pose.seq, near.behind_s), (150, 2.5));
}
