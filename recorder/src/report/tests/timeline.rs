//! What the bar of a replay is told, held against the poses that were written.

use std::ops::ControlFlow;

use bus::message::{Timeline, TimelineColumn};

use super::*;
use crate::report::timeline::follow;

/// All that was told, in order.
fn told(rig: &Rig) -> Result<Vec<Timeline>, ReportError> {
    let mut all = Vec::new();
    follow(&rig.path("s.mcap"), None, &mut |timeline| {
        all.push(timeline);
        ControlFlow::Continue(())
    })?;
    Ok(all)
}

fn at(timeline: &Timeline, t_ns: i64) -> TimelineColumn {
    let mut columns = timeline.columns();
    let found = columns.find(|([from_ns, to_ns], _)| (*from_ns..*to_ns).contains(&t_ns));
    *found.unwrap_or_else(|| panic!("no column at {t_ns}")).1
}

#[test]
fn each_pose_is_where_and_what_it_was() {
    let mut log = testing::log(0, 0);
    // One lost pose alone, many, and a gap in the numbers.
    let lost = |seq: u64| (seq == 100 || (300..330).contains(&seq)).then_some(Lost::NotSeen);
    let seqs = || (0..450).chain(480..600);
    poses(&mut log, seqs(), lost);
    say(&mut log, 2_000_000_000, Level::Info, "mark: first biopsy");
    let rig = Rig::of(ended(log));
    let all = told(&rig).unwrap();
    let last = all.last().unwrap();
    assert!(last.is_read() && last.why().is_empty() && last.unreadable == 0);
    let marks: Vec<_> = last.marks().iter().map(|mark| (mark.t_ns, mark.words())).collect();
    assert_eq!(marks, [(2_000_000_000, "first biopsy".to_owned())]);
    for seq in seqs() {
        let pose = testing::pose(seq);
        let column = at(last, pose.t_publish_ns);
        match lost(seq) {
            Some(_) => assert!(column.has(TimelineColumn::LOST), "{seq}: {column:?}"),
            // The last pose has no time behind it.
            None if seq < 599 => {
                assert!(column.has(TimelineColumn::LIVE), "{seq}: {column:?}");
                let (mm, column) = (pose.tip_95_mm().unwrap(), at(last, pose.t_capture_ns));
                assert!(f64::from(column.least_mm) <= mm && f64::from(column.most_mm) >= mm);
            }
            None => {}
        }
    }
    // In the middle of the gap nothing is live; far from all of it nothing is lost.
    let gap = at(last, testing::pose(470).t_capture_ns);
    assert!(
        gap.has(TimelineColumn::LOST) && !gap.has(TimelineColumn::LIVE),
        "{gap:?}"
    );
    let lost_ns: i64 = last
        .columns()
        .filter(|(_, column)| column.has(TimelineColumn::LOST))
        .map(|([from, to], _)| to - from)
        .sum();
    // 1 and 30 intervals of 60 Hz, and 31 without the 100 ms until the last pose was old, up to a publication 1.5 ms late.
    let expected = 62.0 / 60.0 * 1e9 - 100e6 + 1.5e6;
    // Each of the three stretches begins and ends somewhere in a column.
    let over = lost_ns as f64 - expected;
    assert!(
        (0.0..6.0 * last.column_ns as f64).contains(&over),
        "{over} {}",
        last.column_ns
    );
}

#[test]
fn what_cannot_be_read_is_told_and_does_not_pass_for_read() {
    // Cut off within the third chunk of ten poses.
    let length = testing::unfinished(2, 10).len() + 100;
    let cut = Rig::new(&testing::unfinished(3, 10)[..length]);
    let last = *told(&cut).unwrap().last().unwrap();
    assert!(last.unreadable > 0 && last.is_read(), "{}", last.unreadable);
    let (_, last_column) = last.columns().last().unwrap();
    assert!(last_column.states != 0);
    let end_ns = last.columns().last().unwrap().0[1];
    assert!((end_ns - last.column_ns..=end_ns).contains(&testing::pose(19).t_capture_ns));
    let nothing = Rig::new(b"no recording");
    assert!(told(&nothing).is_err());
}

#[test]
fn who_wants_no_more_is_left_alone() {
    let mut log = testing::log(0, 0);
    poses(&mut log, 0..600, |_| None);
    let rig = Rig::of(ended(log));
    let mut times = 0;
    follow(&rig.path("s.mcap"), None, &mut |_| {
        times += 1;
        ControlFlow::Break(())
    })
    .unwrap();
    assert_eq!(times, 1);
}
