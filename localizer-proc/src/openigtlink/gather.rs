//! TRANSFORMs of one instant, which come one by one, as one frame.
//!
//! They belong together where they bear one stamp. A frame is whole once every marker that is looked for is in it; else it ends with
//! the next stamp, or after half the time between two frames, as a peer may send nothing for a tool that it does not see. What comes
//! after its frame went out is left out. Where stamps are missing or stand still, nothing says what belongs together: each pose is then a
//! frame of its own, and tool and patient are never combined. Nor are they where a message was damaged, until the second stamp after it:
//! it may have been what shows that two instants share a stamp.

use bus::message::Lost;
use igtl::Stamp;

use super::stamp_ns;
use crate::driver::{Frame, Seen};

/// Frames come at least so far apart, and at most: what half of is waited for, ns.
const LEAST_NS: i64 = 2_000_000;
const MOST_NS: i64 = 100_000_000;
/// Before anything is known: 50 Hz.
const FIRST_NS: i64 = 20_000_000;
/// The weight of one more time between two frames.
const WEIGHT: f64 = 0.1;

/// What is being gathered.
#[derive(Debug, Clone)]
pub(super) struct Gather {
    wanted: Vec<u32>,
    open: Option<Frame>,
    /// The stamp of the frame before, and the markers that came with it.
    last: Option<(Stamp, Vec<u32>)>,
    stamp: Stamp,
    /// When each marker came last, ns.
    came_ns: Vec<(u32, i64)>,
    period_ns: f64,
    alone: bool,
    /// Stamps do not tell instants apart.
    never: bool,
    damaged: Damaged,
}

/// Whether a message was damaged, of which nobody knows the stamp.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Damaged {
    No,
    /// It was of the newest stamp or is of the next one.
    Came,
    /// Of this one.
    At(Stamp),
}

impl Gather {
    /// For these markers.
    pub(super) fn new(wanted: Vec<u32>) -> Self {
        Self {
            wanted,
            open: None,
            last: None,
            stamp: Stamp::NONE,
            came_ns: Vec::new(),
            period_ns: FIRST_NS as f64,
            alone: false,
            never: false,
            damaged: Damaged::No,
        }
    }

    /// Whether the newest pose was a frame of its own, as its stamp does not say what it belongs to.
    pub(super) fn is_alone(&self) -> bool {
        self.alone
    }

    /// Stamps have shown that they do not tell instants apart: from now on each pose is a frame of its own.
    pub(super) fn never_combine(&mut self) {
        self.never = true;
    }

    /// A message came that cannot be read; the frame that it ends.
    pub(super) fn damage(&mut self) -> Option<Frame> {
        self.damaged = Damaged::Came;
        self.close()
    }

    /// One marker with its stamp, that arrived at `now_ns`; the frames that are whole then, in order.
    pub(super) fn add(&mut self, stamp: Stamp, seen: Seen, now_ns: i64) -> Vec<Frame> {
        let mut frames = Vec::new();
        self.measure(seen.marker, now_ns);
        let is_in_it = !self.never && self.open.is_some() && self.stamp == stamp && !self.holds(seen.marker);
        if !is_in_it {
            frames.extend(self.close());
        }
        self.alone = false;
        if let Some((last, markers)) = self.last.as_mut().filter(|(last, _)| *last == stamp && !is_in_it) {
            let is_new = !markers.contains(&seen.marker);
            if is_new {
                markers.push(seen.marker);
            }
            // One that was in the frame already says that the stamp stands still; another one came too late for it.
            if !is_new || *last == Stamp::NONE || self.never {
                self.alone = true;
                frames.push(frame(stamp, seen, now_ns));
            }
            return frames;
        }
        self.alone = stamp == Stamp::NONE || self.never;
        if self.alone || self.is_damaged(stamp) {
            self.last = Some((stamp, vec![seen.marker]));
            frames.push(frame(stamp, seen, now_ns));
            return frames;
        }
        match &mut self.open {
            Some(open) => {
                open.seen.push(seen);
                open.arrival_ns = now_ns;
            }
            None => {
                self.stamp = stamp;
                self.open = Some(frame(stamp, seen, now_ns));
            }
        }
        if self.wanted.iter().all(|marker| self.holds(*marker)) {
            frames.extend(self.close());
        }
        frames
    }

    fn holds(&self, marker: u32) -> bool {
        let open = self.open.as_ref();
        open.is_some_and(|open| open.seen.iter().any(|seen| seen.marker == marker))
    }

    /// This marker of what is being gathered has no pose after all.
    pub(super) fn refuse(&mut self, marker: u32) {
        let seen = self.open.iter_mut().flat_map(|open| &mut open.seen);
        seen.filter(|seen| seen.marker == marker)
            .for_each(|seen| seen.outcome = Err(Lost::Refused));
    }

    /// The time between two frames is that between two messages of one marker, whatever their stamps are.
    fn measure(&mut self, marker: u32, now_ns: i64) {
        match self.came_ns.iter_mut().find(|(other, _)| *other == marker) {
            None => self.came_ns.push((marker, now_ns)),
            Some((_, last_ns)) => {
                let before_ns = std::mem::replace(last_ns, now_ns);
                let period_ns = now_ns.saturating_sub(before_ns).clamp(LEAST_NS, MOST_NS);
                self.period_ns += WEIGHT * (period_ns as f64 - self.period_ns);
            }
        }
    }

    /// Whether a message of this stamp may have been damaged. With one marker it does not matter.
    fn is_damaged(&mut self, stamp: Stamp) -> bool {
        self.damaged = match self.damaged {
            Damaged::Came => Damaged::At(stamp),
            Damaged::At(other) if other != stamp => Damaged::No,
            known => known,
        };
        self.damaged != Damaged::No && self.wanted.len() > 1
    }

    /// Ends what is being gathered.
    pub(super) fn close(&mut self) -> Option<Frame> {
        let open = self.open.take()?;
        self.last = Some((self.stamp, open.seen.iter().map(|seen| seen.marker).collect()));
        Some(open)
    }

    /// When it ends of itself.
    pub(super) fn due_ns(&self) -> Option<i64> {
        let open = self.open.as_ref()?;
        Some(open.first_ns.saturating_add((self.period_ns / 2.0) as i64))
    }

    /// The frame whose time is over.
    pub(super) fn expired(&mut self, now_ns: i64) -> Option<Frame> {
        self.due_ns().filter(|due_ns| *due_ns <= now_ns)?;
        self.close()
    }
}

fn frame(stamp: Stamp, seen: Seen, now_ns: i64) -> Frame {
    Frame {
        device_ns: stamp_ns(stamp),
        first_ns: now_ns,
        arrival_ns: now_ns,
        asked_ns: now_ns,
        seen: vec![seen],
    }
}

#[cfg(test)]
mod tests {
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
}
