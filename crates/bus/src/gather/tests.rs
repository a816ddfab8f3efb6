use proptest::prelude::*;

use super::*;

const STALE_NS: i64 = 100;

fn pose(seq: u64) -> PoseId {
    PoseId {
        seq,
        t_capture_ns: 10 * seq as i64,
    }
}

/// A gather of as many views as there are lists, each of which has had the poses of its list.
fn gathered(lists: &[&[u64]]) -> Gather<u64> {
    let mut gather = Gather::new(lists.len());
    for (view, list) in lists.iter().enumerate() {
        list.iter().for_each(|seq| gather.put(view, pose(*seq), *seq));
    }
    gather
}

fn shown(gather: &Gather<u64>) -> Vec<Option<u64>> {
    gather.frames().map(|frame| frame.copied()).collect()
}

#[test]
fn the_newest_pose_that_all_views_have_is_shown() {
    let mut gather = gathered(&[&[4, 5, 6], &[5, 7], &[5, 6, 7]]);
    assert_eq!(gather.decide(60, STALE_NS), Some(Set::One(pose(5))));
    assert_eq!(shown(&gather), [Some(5); 3]);
}

#[test]
fn an_old_set_gives_way_to_a_marked_mixture() {
    let mut gather = gathered(&[&[5, 18], &[5, 20]]);
    assert_eq!(gather.decide(150, STALE_NS), Some(Set::One(pose(5))));
    assert_eq!(gather.decide(151, STALE_NS), Some(Set::Mixed { poses: 2, missing: 0 }));
    assert_eq!(shown(&gather), [Some(18), Some(20)]);
}

#[test]
fn a_set_that_stands_still_stays_one_however_old() {
    let mut gather = gathered(&[&[5], &[4, 5]]);
    assert_eq!(gather.decide(i64::MAX, STALE_NS), Some(Set::One(pose(5))));
}

#[test]
fn a_view_without_an_image_is_counted_and_nothing_is_one() {
    let mut gather = gathered(&[&[5], &[]]);
    assert_eq!(gather.decide(50, STALE_NS), Some(Set::Mixed { poses: 0, missing: 1 }));
    assert_eq!(shown(&gather), [Some(5), None]);
    assert_eq!(gathered(&[&[], &[]]).decide(0, STALE_NS), None);
    assert_eq!(Gather::<u64>::new(0).decide(0, STALE_NS), None);
}

#[test]
fn the_set_shown_is_kept_while_a_slow_view_falls_behind() {
    let mut gather = gathered(&[&[5], &[5]]);
    gather.decide(50, STALE_NS);
    (6..14).for_each(|seq| gather.put(0, pose(seq), seq));
    assert_eq!(gather.decide(140, STALE_NS), Some(Set::One(pose(5))));
    assert_eq!(shown(&gather), [Some(5), Some(5)]);
    // What the slow view catches up with is among the newest that the fast one has.
    gather.put(1, pose(13), 13);
    assert_eq!(gather.decide(140, STALE_NS), Some(Set::One(pose(13))));
}

#[test]
fn a_source_that_counts_anew_is_not_taken_for_the_one_before() {
    let mut gather = gathered(&[&[5], &[5]]);
    let anew = PoseId {
        seq: 5,
        t_capture_ns: 300,
    };
    gather.put(0, anew, 1005);
    assert_eq!(gather.decide(300, STALE_NS), Some(Set::Mixed { poses: 1, missing: 0 }));
}

#[test]
fn the_same_pose_drawn_again_takes_the_place_of_what_was_drawn_before() {
    let mut gather = gathered(&[&[5], &[5]]);
    gather.put(0, pose(5), 99);
    gather.decide(50, STALE_NS);
    assert_eq!(shown(&gather), [Some(99), Some(5)]);
}

/// The last two different poses of a list: what a gather holds of a view in any case.
fn last_two(list: &[u64]) -> Vec<u64> {
    let mut list = list.to_vec();
    list.dedup();
    list.split_off(list.len().saturating_sub(2))
}

proptest! {
    /// Beside a gather stands all that ever came. What is called one pose is one in every view, and young or the last of all; and no
    /// young pose that is later, and among the last two of every view, was passed over.
    #[test]
    fn what_is_called_one_pose_is_one(
        views in 1..5_usize,
        steps in prop::collection::vec((0..5_usize, 0..4_u64, 0..40_i64, any::<bool>()), 1..120),
    ) {
        let mut gather = Gather::new(views);
        let mut all = vec![Vec::new(); views];
        let (mut seq, mut now) = (0, 0);
        for (view, skip, later, asked) in steps {
            let view = view % views;
            (seq, now) = (seq + skip, now + later);
            // Renderers skip poses, and never go back: `seq` only grows.
            gather.put(view, pose(seq), seq);
            all[view].push(seq);
            prop_assert!(gather.views.iter().all(|held| held.len() <= KEPT));
            // A viewer may take several images before it paints.
            if !asked {
                continue;
            }
            let set = gather.decide(now, STALE_NS);
            let frames = shown(&gather);
            let last: Vec<Option<u64>> = all.iter().map(|list| list.last().copied()).collect();
            let is_young = |seq: u64| now - pose(seq).t_capture_ns <= STALE_NS;
            let mut common = last_two(&all[0]);
            common.retain(|seq| is_young(*seq) && all.iter().all(|list| last_two(list).contains(seq)));
            match set {
                Some(Set::One(one)) => {
                    prop_assert!(frames.iter().all(|frame| *frame == Some(one.seq)), "{one:?} {frames:?}");
                    prop_assert!(is_young(one.seq) || last.iter().all(|seq| *seq == Some(one.seq)));
                    prop_assert!(common.iter().all(|seq| *seq <= one.seq), "{common:?} {one:?}");
                }
                Some(Set::Mixed { poses, missing }) => {
                    prop_assert!(common.is_empty(), "{common:?}");
                    prop_assert_eq!(&frames, &last);
                    prop_assert_eq!(missing, last.iter().filter(|seq| seq.is_none()).count());
                    let there = || last.iter().flatten();
                    prop_assert_eq!(poses, there().max().unwrap() - there().min().unwrap());
                    // All views at one pose is never called a mixture.
                    prop_assert!(missing > 0 || poses > 0);
                }
                None => prop_assert!(false, "an image has come"),
            }
        }
    }
}
