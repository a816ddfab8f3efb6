//! The metrics, fed by hand.

use super::*;
use bus::message::Lost;
use geometry::Rigid;

const BY: Judging = Judging {
    now_ns: i64::MAX,
    frozen_ns: None,
    replay: None,
};

const REPLAYED: Judging = Judging {
    replay: Some(Place { first_ns: 0, set_ns: 0 }),
    ..BY
};

fn pose(seq: u64, tracked: Tracked) -> ToolPose {
    let mut pose = ToolPose {
        seq,
        t_capture_ns: seq as i64,
        ..ToolPose::EMPTY
    };
    pose.set(tracked);
    pose
}

/// Each image once cost 40 bytes for ever: 60 MB an hour.
#[test]
fn latencies_take_the_same_memory_however_many_there_are() {
    let mut latencies = Latencies::default();
    let most = |latencies: &Latencies| percentiles(&latencies.0[4]);
    assert_eq!(most(&latencies), Latency::default());
    for i in 1..=100_000 {
        latencies.add([0, 0, 0, 0, i * 1_000]);
    }
    let l = most(&latencies);
    assert_eq!((l.max, l.count), (100.0, 100_000));
    for (found, truth) in [(l.p50, 50.0), (l.p95, 95.0), (l.p99, 99.0)] {
        assert!((found / truth - 1.0_f64).abs() < 0.0101, "{found} {truth}");
    }
    let one = size_of_val(&latencies) + 5 * 8 * 2100;
    assert!(one < 100_000, "{one} bytes");
}

/// A pose that came 6 s late was shown on no image, and the largest latency of the report was 49 ms.
#[test]
fn a_late_sample_that_no_image_showed_is_among_the_latencies() {
    let mut metrics = Metrics::new(1);
    for (seq, late_ns) in [(0, 1_000_000), (1, 6_012_000_000)] {
        let mut late = pose(seq, Tracked::Valid(Rigid::identity()));
        late.t_publish_ns = late.t_capture_ns + late_ns;
        metrics.pose(late, BY);
    }
    let all = |key: &str| metrics.all_latencies().find(|(stage, _)| *stage == key).unwrap().1;
    assert_eq!((all(ALL).count, all(ALL).max), (2, 6012.0));
    assert_eq!(all("capture_to_publish").count, 0);
}

#[test]
fn poses_are_counted_by_kind_and_gaps_too() {
    let mut metrics = Metrics::new(1);
    metrics.pose(pose(0, Tracked::Valid(Rigid::identity())), BY);
    metrics.pose(pose(3, Tracked::Lost(Lost::NotSeen)), BY);
    let mut bad = pose(4, Tracked::Valid(Rigid::identity()));
    bad.q[0] = f64::NAN;
    metrics.pose(bad, BY);
    let expected = PoseCounts {
        published: 3,
        lost: 1,
        refused: 1,
        missing: 2,
        ..PoseCounts::default()
    };
    assert_eq!(metrics.poses, expected);
    assert_eq!(metrics.valid_pose_until(9).map(|p| p.seq), Some(0));
}

/// Each went by without a word.
#[test]
fn what_breaks_the_stream_is_counted() {
    let mut metrics = Metrics::new(1);
    let valid = Tracked::Valid(Rigid::identity());
    let frozen = Judging {
        frozen_ns: Some(5),
        ..BY
    };
    for seq in [3, 4, 10, 10, 9] {
        metrics.pose(pose(seq, valid), frozen);
    }
    let mut other = pose(20, valid);
    other.registration_id = 1;
    other.flags = ToolPose::NOISELESS;
    metrics.pose(other, frozen);
    metrics.pose(pose(1 << 50, valid), frozen);
    let found = metrics.poses;
    // Both samples 10 are one, 7 ns after the first with these numbers; 9 is older; the last one has them again.
    assert_eq!((found.published, found.lost, found.refused), (7, 3, 1));
    assert_eq!((found.counted_anew, found.registration_changes), (1, 2));
    assert_eq!(metrics.valid_pose_until(19).map(|p| p.seq), Some(4));
}

#[test]
fn old_images_that_claim_to_be_live_are_found() {
    let mut metrics = Metrics::new(1);
    let stamp = FrameStamp {
        t_framed_ns: 101,
        ..FrameStamp::default()
    };
    metrics.frame(&stamp, 100);
    assert_eq!(metrics.views[0].unflagged_old, 1);
    let said = FrameStamp {
        state: FrameState::Stale.code(),
        seq: 1,
        ..stamp
    };
    metrics.frame(&said, 100);
    assert_eq!((metrics.views[0].unflagged_old, metrics.views[0].rendered), (1, 2));
}

/// At full speed in a loop, poses from before a jump came behind it and those after it were refused.
#[test]
fn a_sample_that_was_under_way_when_a_replay_jumped_breaks_nothing() {
    let mut metrics = Metrics::new(1);
    let valid = Tracked::Valid(Rigid::identity());
    metrics.pose(pose(98, valid), REPLAYED);
    metrics.jumped();
    for seq in [99, 0, 1] {
        metrics.pose(pose(seq, valid), REPLAYED);
    }
    assert_eq!(
        (metrics.poses.refused, metrics.poses.counted_anew, metrics.poses.missing),
        (0, 0, 0)
    );
}

/// The pilot never said FROZEN in a replay; the bar of the same replay did.
#[test]
fn a_measurement_that_stands_still_is_frozen_in_a_replay_from_its_first_sample_on() {
    let mut metrics = Metrics::new(1);
    let valid = Tracked::Valid(Rigid::identity());
    let by = Judging {
        frozen_ns: Some(500),
        replay: Some(Place {
            first_ns: 1000,
            set_ns: 1000,
        }),
        ..BY
    };
    let published = |seq: u64| ToolPose {
        t_publish_ns: seq as i64,
        ..pose(seq, valid)
    };
    // From before what is replayed: when the measurement began, and the last one.
    for seq in [400, 999] {
        metrics.pose(published(seq), by);
    }
    assert_eq!((metrics.poses.published, metrics.newest_pose()), (0, None));
    metrics.pose(published(1000), by);
    assert_eq!(
        (metrics.poses.published, metrics.frozen(), metrics.poses.missing),
        (1, 1, 0)
    );
    // Elsewhere in it, where it stood still for a shorter time.
    metrics.jumped();
    let by = Judging {
        replay: by.replay.map(|place| Place { set_ns: 5000, ..place }),
        ..by
    };
    for seq in [4800, 4999, 5000, 5001] {
        metrics.pose(published(seq), by);
    }
    assert_eq!((metrics.frozen(), metrics.poses.missing), (1, 0));
    metrics.pose(published(5301), by);
    assert_eq!(metrics.frozen(), 2);
}

#[test]
fn what_a_replay_passes_over_is_not_missing_and_what_comes_again_is_shown_again() {
    let mut metrics = Metrics::new(1);
    let stamp = |seq| FrameStamp {
        seq,
        ..FrameStamp::default()
    };
    for seq in [7, 100, 3] {
        metrics.pose(pose(seq, Tracked::Valid(Rigid::identity())), BY);
        metrics.frame(&stamp(seq), 100);
        metrics.jumped();
        // Until the next one comes, it is the newest there is.
        assert_eq!(metrics.newest_pose().map(|p| p.seq), Some(seq));
    }
    assert_eq!((metrics.poses.missing, metrics.views[0].rendered), (0, 3));
}

/// Subtracting such stamps ended the pilot.
#[test]
fn stamps_at_the_ends_of_time_break_nothing() {
    let mut metrics = Metrics::new(1);
    for ns in [i64::MIN, i64::MAX, 0] {
        let stamp = FrameStamp {
            t_capture_ns: ns,
            t_publish_ns: ns.saturating_neg(),
            t_framed_ns: ns.saturating_neg(),
            ..FrameStamp::default()
        };
        metrics.frame(&stamp, 100);
        let mut bad = pose(7, Tracked::Valid(Rigid::identity()));
        bad.t_capture_ns = ns;
        metrics.pose(bad, BY);
    }
    assert_eq!(metrics.poses.published, 3);
}

#[test]
fn the_same_pose_drawn_again_is_not_a_latency() {
    let mut metrics = Metrics::new(1);
    for _ in 0..3 {
        metrics.frame(&FrameStamp::default(), 100);
    }
    assert_eq!(metrics.views[0].rendered, 1);
    assert_eq!(metrics.latencies().last().map(|(_, l)| l.count), Some(1));
}
