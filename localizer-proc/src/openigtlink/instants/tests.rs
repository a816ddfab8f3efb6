use geometry::Vector;
use igtl::TypeName;

use super::*;

const MS: i64 = 1_000_000;

/// The largest entry of `R^T R - 1` that scenes allow by default.
const ALLOWED: f64 = 2e-3;

fn said(ms: u64, kind: &str) -> (Stamp, Source) {
    let stamp = Stamp::of_ns(1_790_000_000_000_000_000 + ms * 1_000_000).unwrap();
    (stamp, Source::one(TypeName::new(kind).unwrap()))
}

fn at(x: f64) -> Outcome {
    let place = Vector::new(x, 0.0, -1500.0);
    Ok((
        Tool::from_rotation_vector(Vector::new(0.0, 0.0, 0.0), place).unwrap(),
        0.0,
    ))
}

/// A tool of which one message said OK and the next, under the same stamp, MISSING, was LIVE and LOST in turn.
#[test]
fn a_tool_that_is_seen_and_lost_under_one_stamp_is_lost_until_that_ends() {
    for late in [0, 3] {
        let mut instants = Instants::new(ALLOWED);
        let mut good = 0;
        for k in 0..100_u64 {
            let now_ns = 16 * MS * k as i64;
            let (seen, _) = instants.judge(said(16 * k, "TRANSFORM"), 0, at(k as f64), now_ns);
            good += u64::from(seen.is_ok());
            if k >= late {
                let lost = instants.judge(said(16 * (k - late), "TDATA"), 0, Err(Lost::NotSeen), now_ns + MS);
                assert_eq!(lost, (Err(Lost::NotSeen), Some(Against::Stamp)));
            }
        }
        // Those before the first loss came.
        assert_eq!((good, instants.stand_still()), (late + 1, false));
        let (seen, is_told) = instants.judge(said(5000, "TRANSFORM"), 0, at(1.0), 5000 * MS);
        assert_eq!((seen, is_told), (at(1.0), None));
    }
}

#[test]
fn a_pose_under_a_stamp_of_which_the_marker_was_lost_does_not_count() {
    let mut instants = Instants::new(ALLOWED);
    assert!(
        instants
            .judge(said(0, "TDATA"), 0, Err(Lost::OutOfVolume), 0)
            .1
            .is_none()
    );
    let seen = instants.judge(said(0, "TRANSFORM"), 0, at(1.0), MS);
    assert_eq!(seen, (Err(Lost::OutOfVolume), Some(Against::Stamp)));
    // Of the other marker nothing was said, nor is anything of what has no stamp.
    assert_eq!(instants.judge(said(0, "TRANSFORM"), 1, at(1.0), MS), (at(1.0), None));
    let none = (Stamp::NONE, said(0, "TDATA").1);
    assert_eq!(
        instants.judge(none, 1, Err(Lost::NotSeen), MS),
        (Err(Lost::NotSeen), None)
    );
    assert_eq!(instants.judge(none, 1, at(2.0), MS), (at(2.0), None));
}

#[test]
fn stamps_that_stand_still_contradict_nothing() {
    let mut instants = Instants::new(ALLOWED);
    let mut good = 0;
    for k in 0..100 {
        let outcome = if k % 10 == 0 {
            Err(Lost::NotSeen)
        } else {
            at(f64::from(k))
        };
        let (found, _) = instants.judge(said(7, "TRANSFORM"), 0, outcome, 16 * MS * i64::from(k));
        good += u32::from(found.is_ok());
    }
    // The first pose is against the loss before it; the second shows that the stamp stands still.
    assert_eq!((good, instants.stand_still()), (89, true));
    // The same in another kind of message is the same instant.
    let mut twice = Instants::new(ALLOWED);
    for k in 0..100_u32 {
        for kind in ["TRANSFORM", "QTDATA"] {
            let x = f64::from(k) + if kind == "QTDATA" { 1e-7 } else { 0.0 };
            assert!(twice.judge(said(k.into(), kind), 0, at(x), 0).0.is_ok());
        }
    }
    assert!(!twice.stand_still());
}

/// One message whose last bits differed from that before it, under its stamp, ended for good that what contradicts itself is lost.
#[test]
fn a_pose_that_is_rounded_otherwise_shows_no_stamp_that_stands_still() {
    let mut instants = Instants::new(ALLOWED);
    for (x, stands_still) in [(10.0, false), (10.000_01, false), (10.001, false), (10.01, true)] {
        let _ = instants.judge(said(0, "TRANSFORM"), 0, at(x), 0);
        assert_eq!(instants.stand_still(), stands_still, "{x}");
    }
    // A slow movement adds up.
    let mut slow = Instants::new(ALLOWED);
    let moved = (0..20).position(|k| {
        let _ = slow.judge(said(0, "TRANSFORM"), 0, at(10.0 + 0.001 * f64::from(k)), 0);
        slow.stand_still()
    });
    // Eight roundings of 1500 mm are 0.0014 mm.
    assert_eq!(moved, Some(2));
}

/// Where stamps stood still, a tool that one kind of message had and another one lost was LIVE and LOST in turn.
#[test]
fn a_tool_that_another_kind_of_message_loses_is_lost_where_stamps_stand_still_too() {
    let mut instants = Instants::new(ALLOWED);
    let mut good = Vec::new();
    for k in 0..100_i64 {
        let now_ns = 50 * MS * k;
        if instants.judge(said(7, "TRANSFORM"), 0, at(k as f64), now_ns).0.is_ok() {
            good.push(k);
        }
        if (1..90).contains(&k) {
            let _ = instants.judge(said(7, "TDATA"), 0, Err(Lost::NotSeen), now_ns + 25 * MS);
        }
    }
    assert!(instants.stand_still());
    // The last loss came at 4.475 s, and is over 0.5 s later.
    assert_eq!(good, [0, 1]);
    let (seen, _) = instants.judge(said(7, "TRANSFORM"), 0, at(1.0), 4976 * MS);
    assert_eq!(seen, at(1.0));
}

/// Each kind of message had its own stamps, and what one lost the other had: LIVE and LOST in turn.
#[test]
fn kinds_of_message_that_have_stamps_of_their_own_are_held_against_each_other_by_time() {
    let mut instants = Instants::new(ALLOWED);
    let mut told = 0;
    for k in 0..40_u64 {
        let now_ns = 50 * MS * k as i64;
        let (seen, against) = instants.judge(said(50 * k, "TRANSFORM"), 0, at(k as f64), now_ns);
        assert_eq!(seen.is_ok(), k == 0, "{k}");
        told += u32::from(against == Some(Against::Kind));
        let _ = instants.judge(said(50 * k + 1, "TDATA"), 0, Err(Lost::NotSeen), now_ns + MS);
    }
    assert_eq!(told, 37);
    // A tool that comes back is seen by one of them first: no contradiction that would be told, and one pose.
    let (seen, against) = instants.judge(said(2001, "TDATA"), 0, at(1.0), 2001 * MS);
    assert_eq!((seen, against), (at(1.0), None));
}

/// A lost tool whose messages bore the stamp of when it was seen had no pose for 2 s more, and contradicted itself as was told.
#[test]
fn a_loss_under_the_stamp_of_when_the_tool_was_seen_is_no_contradiction() {
    for (rate_ms, seconds) in [(50, 3), (16, 1), (100, 8)] {
        let mut instants = Instants::new(ALLOWED);
        let mut now_ms = 0;
        for round in 0..5 {
            for k in 0..20_u64 {
                now_ms += rate_ms;
                let found = instants.judge(said(now_ms, "TRANSFORM"), 0, at(k as f64), now_ms as i64 * MS);
                assert_eq!(found, (at(k as f64), None), "{rate_ms} {round} {k}");
            }
            let stamp_ms = now_ms;
            for _ in 0..seconds * 1000 / rate_ms {
                now_ms += rate_ms;
                let found = instants.judge(said(stamp_ms, "TRANSFORM"), 0, Err(Lost::NotSeen), now_ms as i64 * MS);
                assert_eq!(found, (Err(Lost::NotSeen), None), "{rate_ms} {round}");
            }
        }
    }
}

/// What that must not let through: two tools with one name of which one is lost, in turn at whatever pace; and a loss of before.
#[test]
fn a_loss_that_comes_between_two_poses_is_a_contradiction_still() {
    for behind_ms in [1, 10, 25, 36, 40, 45, 49, 60, 110] {
        let mut instants = Instants::new(ALLOWED);
        let mut all: Vec<(u64, u64, Outcome)> = (0..200)
            .flat_map(|k| {
                [
                    (50 * k, 50 * k, at(k as f64)),
                    (50 * k + behind_ms, 50 * k, Err(Lost::NotSeen)),
                ]
            })
            .collect();
        all.sort_by_key(|(now_ms, ..)| *now_ms);
        let mut shown = 0;
        for (now_ms, stamp_ms, outcome) in all {
            let (found, _) = instants.judge(said(stamp_ms, "TRANSFORM"), 0, outcome, now_ms as i64 * MS);
            shown += u64::from(found.is_ok());
        }
        // Those before the first loss came.
        assert_eq!(shown, behind_ms.div_ceil(50), "{behind_ms}");
    }
}

/// Two kinds of message have two poses under one stamp: which of them is true nobody knows. Roundings are one pose.
#[test]
fn two_poses_of_two_kinds_under_one_stamp_are_none() {
    for (off_mm, expected) in [(0.0005, at(1.0)), (0.01, Err(Lost::Refused))] {
        let mut instants = Instants::new(ALLOWED);
        let mut last = None;
        for k in 0..10_u64 {
            let now_ns = 16 * MS * k as i64;
            let first = instants.judge(said(16 * k, "TRANSFORM"), 0, at(1.0), now_ns);
            let _ = instants.judge(said(16 * k, "POSITION"), 0, at(1.0 + off_mm), now_ns);
            last = Some(first);
        }
        let against = expected.is_err().then_some(Against::Pose);
        assert_eq!(last, Some((expected, against)), "{off_mm}");
    }
}
