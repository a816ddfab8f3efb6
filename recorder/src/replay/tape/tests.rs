use super::*;
use std::path::PathBuf;

use crate::testing;
use crate::wire::proto;
use crate::wire::schema::Source;
use crate::write::pose_log::Entry;

fn written(bytes: &[u8]) -> (tempfile::TempDir, PathBuf) {
    let tmp = tempfile::tempdir().unwrap();
    let path = tmp.path().join("s.mcap");
    std::fs::write(&path, bytes).unwrap();
    (tmp, path)
}

#[test]
fn every_pose_comes_bit_for_bit_with_its_truth() {
    let (_tmp, path) = written(&testing::finished(3, 10));
    let mut tape = Tape::open(&path).unwrap();
    for round in 0..2 {
        for seq in 0..30 {
            assert_eq!(tape.peek().map(|m| m.pose.seq), Some(seq), "round {round}");
            let moment = tape.take().unwrap();
            assert_eq!(testing::bytes(&moment.pose), testing::bytes(&testing::pose(seq)));
            let truths: Vec<u64> = moment.truths.iter().map(|t| t.seq).collect();
            assert_eq!(truths, [seq]);
        }
        assert!(tape.take().is_none() && tape.peek().is_none());
        tape.near(0).unwrap();
    }
}

#[test]
fn truths_come_behind_the_pose_that_was_published_before_them() {
    let mut log = testing::log(0, 1);
    for seq in 0..3 {
        log.pose(Source::Tool, &testing::pose(seq)).unwrap();
    }
    for (seq, after_ns) in [(0, -1), (1, 1), (2, 5), (9, 1_000_000_000)] {
        let mut truth = testing::pose(seq);
        truth.t_publish_ns += after_ns;
        log.pose(Source::Truth, &truth).unwrap();
    }
    let (_tmp, path) = written(&log.finish().unwrap().into_inner());
    let mut tape = Tape::open(&path).unwrap();
    let mut all = Vec::new();
    while let Some(moment) = tape.take() {
        all.push(moment.truths.iter().map(|t| t.seq).collect::<Vec<_>>());
    }
    assert_eq!(all, [vec![0], vec![1], vec![2, 9]]);
}

#[test]
fn ultrasound_images_come_behind_the_pose_that_was_published_before_them_bit_for_bit() {
    let mut log = testing::log(0, 1);
    let images =
        [(0, 0, -1), (1, 0, 1), (2, 1, 5), (3, 2, 1_000_000_000)].map(|(n, seq, ns)| testing::us_frame(n, seq, ns));
    (0..3).for_each(|seq| log.pose(Source::Tool, &testing::pose(seq)).unwrap());
    for image in &images {
        log.put(Entry::UsImage(&proto::RawImage::from(image))).unwrap();
    }
    let (_tmp, path) = written(&log.finish().unwrap().into_inner());
    let mut tape = Tape::open(&path).unwrap();
    for round in 0..2 {
        let mut all = Vec::new();
        while let Some(moment) = tape.take() {
            all.push(moment.images);
        }
        assert_eq!(all.concat(), images, "round {round}");
        tape.near(0).unwrap();
    }
    // From a place in the middle on, those of before do not come again.
    tape.near(testing::pose(2).t_publish_ns).unwrap();
    while tape.peek().is_some_and(|moment| moment.pose.seq < 2) {
        tape.take();
    }
    let last = tape.take().unwrap().images;
    assert_eq!(last, images[3..]);
    assert!(tape.unread().is_empty());
}

#[test]
fn the_pose_before_is_found_from_everywhere() {
    let (_tmp, path) = written(&testing::finished(3, 10));
    let mut tape = Tape::open(&path).unwrap();
    let due = |seq: u64| testing::pose(seq).t_publish_ns;
    for seq in [29_u64, 1, 15, 10, 0] {
        let before = seq.checked_sub(1).map(due);
        assert_eq!(tape.before(due(seq)).unwrap(), before, "{seq}");
        assert_eq!(tape.peek().map(|moment| moment.pose.seq), Some(seq));
    }
    assert_eq!(tape.before(i64::MAX >> 3).unwrap(), Some(due(29)));
}

#[test]
fn damage_is_passed_over() {
    // Cut off within the third chunk.
    let cut = testing::unfinished(2, 10).len() + 100;
    let (_tmp, path) = written(&testing::unfinished(3, 10)[..cut]);
    let mut tape = Tape::open(&path).unwrap();
    let seqs: Vec<u64> = std::iter::from_fn(|| tape.take()).map(|m| m.pose.seq).collect();
    assert_eq!(seqs, (0..20).collect::<Vec<_>>());
}

/// Everything, read from the start.
fn all(path: &Path) -> Vec<Moment> {
    let mut tape = Tape::with_frames(path, Delivery::Emitters).unwrap();
    std::iter::from_fn(|| tape.take()).collect()
}

/// What comes from `at_ns` on.
fn expected(all: &[Moment], at_ns: i64) -> Option<Moment> {
    all.iter().find(|moment| moment.due_ns() >= at_ns).cloned()
}

/// The same as the replayer finds it, and how many were passed over.
fn found(tape: &mut Tape, at_ns: i64) -> (Option<Moment>, usize) {
    tape.near(at_ns).unwrap();
    let mut passed = 0;
    while tape.peek().is_some_and(|next| next.due_ns() < at_ns) {
        tape.take();
        passed += 1;
    }
    (tape.take(), passed)
}

#[test]
fn a_place_is_found_as_by_reading_everything_and_little_is_passed_over() {
    const CHUNKS: u64 = 40;
    for bytes in [testing::finished(CHUNKS, 7), testing::unfinished(CHUNKS, 7)] {
        let (_tmp, path) = written(&bytes);
        let (all, mut tape) = (all(&path), Tape::with_frames(&path, Delivery::Emitters).unwrap());
        // In no order: forwards and backwards.
        for i in 0..=CHUNKS * 7 + 2 {
            let seq = i * 89 % (CHUNKS * 7 + 3);
            let due_ns = testing::pose(seq).t_publish_ns;
            for at_ns in [due_ns - 1, due_ns, due_ns + 1] {
                let (moment, passed) = found(&mut tape, at_ns);
                assert_eq!(moment, expected(&all, at_ns), "at {at_ns}");
                // 50 ms of 60 poses a second.
                assert!(passed <= 4 || moment.is_none(), "{passed} before {at_ns}");
            }
        }
        assert_eq!(found(&mut tape, i64::MIN).0.unwrap().pose.seq, 0);
        assert!(found(&mut tape, 1 << 60).0.is_none());
    }
}

#[test]
fn a_place_is_found_however_long_poses_took() {
    let mut log = testing::log(0, 1);
    for seq in 0..200 {
        let mut pose = testing::pose(seq);
        // From nothing to seven seconds.
        pose.t_publish_ns = pose.t_capture_ns + 35_000_000 * seq.cast_signed();
        log.pose(Source::Tool, &pose).unwrap();
        log.flush().unwrap();
    }
    let (_tmp, path) = written(&log.finish().unwrap().into_inner());
    let (all, mut tape) = (all(&path), Tape::with_frames(&path, Delivery::Emitters).unwrap());
    for at_ns in (0..11_000_000_000).step_by(97_000_000) {
        assert_eq!(found(&mut tape, at_ns).0, expected(&all, at_ns), "at {at_ns}");
    }
}

#[test]
fn a_pose_comes_with_the_frame_that_it_was_made_of() {
    let mut log = testing::log(0, 1);
    let put = |log: &mut crate::write::pose_log::PoseLog<_>, frame: &EmitterFrame| {
        let frame = crate::wire::proto::EmitterFrame::try_from(frame).unwrap();
        log.put(crate::write::pose_log::Entry::Emitters(&frame)).unwrap();
    };
    let mut late = testing::frame(1);
    late.t_capture_ns -= 1;
    // The third one is not in the recording; 1 came again with another time, 90 and 91 gave no poses.
    for frame in [testing::frame(0), testing::frame(1), late, testing::frame(3)] {
        put(&mut log, &frame);
    }
    for seq in [90, 91] {
        let mut stray = testing::frame(seq);
        stray.t_publish_ns = testing::frame(4).t_publish_ns - 1;
        put(&mut log, &stray);
    }
    put(&mut log, &testing::frame(4));
    (0..5).for_each(|seq| log.pose(Source::Tool, &testing::pose(seq)).unwrap());
    let (_tmp, path) = written(&log.finish().unwrap().into_inner());
    let mut tape = Tape::with_frames(&path, Delivery::Emitters).unwrap();
    let frames: Vec<_> = std::iter::from_fn(|| tape.take()).map(|moment| moment.frame).collect();
    let of = |seq| Some(Delivered::Emitters(Box::new(testing::frame(seq))));
    assert_eq!(frames, [of(0), of(1), None, of(3), of(4)]);
    // Frames of markers are others.
    let mut tape = Tape::with_frames(&path, Delivery::Markers).unwrap();
    assert!(std::iter::from_fn(|| tape.take()).all(|moment| moment.frame.is_none()));
    let mut tape = Tape::open(&path).unwrap();
    assert!(std::iter::from_fn(|| tape.take()).all(|moment| moment.frame.is_none()));
}
