use super::*;

const MS: i64 = 1_000_000;

fn stamp(ms: u64) -> Stamp {
    Stamp::of_ns(1_790_000_000_000_000_000 + ms * 1_000_000).unwrap()
}

/// A marker that is lost.
fn lost(marker: u32) -> Seen {
    Seen {
        marker,
        outcome: Err(Lost::NotSeen),
    }
}

/// The markers of frames.
fn of(frames: Vec<Frame>) -> Vec<Vec<u32>> {
    frames
        .iter()
        .map(|frame| frame.seen.iter().map(|seen| seen.marker).collect())
        .collect()
}

#[test]
fn a_frame_is_whole_with_its_last_marker_and_else_ends_with_the_next_stamp_or_in_time() {
    let mut gather = Gather::new(vec![0, 1]);
    assert_eq!(of(gather.add(stamp(0), lost(1), 0)), [] as [Vec<u32>; 0]);
    assert_eq!(of(gather.add(stamp(0), lost(0), MS)), [[1, 0]]);
    assert_eq!((gather.due_ns(), gather.expired(99 * MS)), (None, None));
    // The tool is not seen, and nothing is sent for it.
    assert!(gather.add(stamp(20), lost(1), 20 * MS).is_empty());
    assert_eq!(of(gather.add(stamp(40), lost(1), 40 * MS)), [[1]]);
    assert_eq!(gather.due_ns(), Some(50 * MS));
    assert_eq!(gather.expired(50 * MS - 1), None);
    assert_eq!(of(gather.expired(50 * MS).into_iter().collect()), [[1]]);
    // What comes after its frame is left out, and begins no other.
    assert_eq!(of(gather.add(stamp(40), lost(0), 51 * MS)), [] as [Vec<u32>; 0]);
    assert_eq!(gather.due_ns(), None);
    let frames: Vec<Frame> = [
        gather.add(stamp(60), lost(0), 60 * MS),
        gather.add(stamp(60), lost(1), 61 * MS),
    ]
    .concat();
    assert_eq!((frames[0].first_ns, frames[0].arrival_ns), (60 * MS, 61 * MS));
}

/// A tool and a patient of two instants were one frame where stamps stood still: each pair of neighbours looks like one.
#[test]
fn poses_whose_stamps_do_not_tell_are_never_combined() {
    for stamps in [[Stamp::NONE; 2], [stamp(7); 2]] {
        let mut gather = Gather::new(vec![0, 1]);
        let mut frames = Vec::new();
        for i in 0..40 {
            // The tool is missing now and then.
            let markers: &[u32] = if i % 7 == 3 { &[1] } else { &[0, 1] };
            for marker in markers {
                frames.extend(gather.add(stamps[0], lost(*marker), i * 20 * MS));
            }
        }
        // But for the first stamp, which nobody can know to stand still.
        let combined = frames.iter().skip(1).filter(|frame| frame.seen.len() > 1).count();
        assert_eq!(combined, 0);
        assert!(frames.len() > 70 && gather.is_alone(), "{}", frames.len());
    }
}

/// Stamps of whole seconds: the tool of one instant and the patient of the next were one frame.
#[test]
fn nothing_is_combined_once_stamps_do_not_tell_instants_apart() {
    let mut gather = Gather::new(vec![0, 1]);
    gather.add(stamp(0), lost(0), 0);
    gather.never_combine();
    let frames: Vec<Frame> = [(0, 1), (1000, 0), (1000, 1), (2000, 1), (2000, 0)]
        .into_iter()
        .flat_map(|(ms, marker)| gather.add(stamp(ms), lost(marker), ms as i64 * MS))
        .collect();
    assert_eq!(of(frames), [[0], [1], [0], [1], [1], [0]]);
    assert!(gather.is_alone());
}

/// Half of the time between two stamps was waited for, which was longer than that between two instants where stamps are coarse.
#[test]
fn the_time_between_frames_is_that_between_messages_of_one_marker() {
    let mut gather = Gather::new(vec![0, 1]);
    for k in 0..200 {
        gather.add(stamp(k / 50 * 1000), lost(1), 20 * MS * k as i64);
    }
    gather.add(stamp(9000), lost(1), 4000 * MS);
    assert_eq!(gather.due_ns(), Some(4010 * MS));
}

/// Two instants share a stamp, and of one the patient's message was damaged: the tool of it was combined with the patient of the next.
#[test]
fn a_damaged_message_combines_nothing_of_two_instants_that_share_a_stamp() {
    let add = |gather: &mut Gather, ms: u64, marker| of(gather.add(stamp(ms), lost(marker), ms as i64 * MS));
    let mut gather = Gather::new(vec![0, 1]);
    assert_eq!(gather.damage(), None);
    assert_eq!(add(&mut gather, 0, 0), [[0]]);
    assert!(add(&mut gather, 0, 1).is_empty());
    // The next stamp is whole again.
    assert!(add(&mut gather, 20, 1).is_empty());
    assert_eq!(add(&mut gather, 20, 0), [[1, 0]]);
    // In the middle of a frame, which ends.
    assert!(add(&mut gather, 40, 1).is_empty());
    assert_eq!(of(gather.damage().into_iter().collect()), [[1]]);
    assert_eq!(add(&mut gather, 40, 1), [[1]]);
    assert!(add(&mut gather, 40, 0).is_empty());
    assert_eq!(add(&mut gather, 60, 0), [[0]]);
    assert!(add(&mut gather, 80, 0).is_empty());
    assert_eq!(add(&mut gather, 80, 1), [[0, 1]]);
}

#[test]
fn one_marker_is_a_frame_at_once() {
    let mut gather = Gather::new(vec![0]);
    for i in 0..5 {
        let frames = gather.add(stamp(10 * i), lost(0), 10 * MS * i as i64);
        assert_eq!(of(frames), [[0]]);
    }
}
