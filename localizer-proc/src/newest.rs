//! The newest stamp of a localizer with what came under it: whether a frame is one of those once more.

use crate::driver::{Frame, Seen};

/// So many frames of one stamp are remembered: a peer may send each pose as messages of several kinds, whose numbers are rounded otherwise.
const MOST: usize = 8;

#[derive(Debug, Default)]
pub(crate) struct Newest {
    stamp_ns: i64,
    /// When the last frame of it came.
    arrival_ns: i64,
    /// The markers of its frames, by their numbers.
    frames: Vec<Vec<Seen>>,
}

impl Newest {
    /// The next frame comes over another connection: it is none of those.
    pub(crate) fn forget(&mut self) {
        self.frames.clear();
    }

    /// The stamp of the newest frame, over all connections, and when it came.
    pub(crate) fn came(&self) -> (i64, i64) {
        (self.stamp_ns, self.arrival_ns)
    }

    /// Whether a stamp is not known to be a later one: of a marker that is not seen it may be that of when it was.
    pub(crate) fn is_no_later(&self, stamp_ns: i64) -> bool {
        self.stamp_ns == 0 || stamp_ns <= self.stamp_ns
    }

    /// Takes a frame; whether it has the stamp of the one before and holds what a frame of that stamp held. In which order its markers
    /// came is no difference.
    pub(crate) fn repeats(&mut self, frame: &Frame) -> bool {
        let mut seen = frame.seen.clone();
        seen.sort_by_key(|seen| seen.marker);
        if self.stamp_ns != frame.device_ns {
            self.frames.clear();
        }
        (self.stamp_ns, self.arrival_ns) = (frame.device_ns, frame.first_ns);
        let repeats = self.frames.contains(&seen);
        if !repeats && self.frames.len() < MOST {
            self.frames.push(seen);
        }
        repeats && frame.device_ns != 0
    }
}

#[cfg(test)]
mod tests {
    use bus::message::Lost;
    use geometry::rotation::Rotation;
    use geometry::{Marker, Rigid, Tracker, Vector};

    use super::*;

    fn frame(device_ns: i64, seen: Vec<Seen>) -> Frame {
        Frame::of_device(Some(device_ns), (0, device_ns), seen)
    }

    fn seen(marker: u32, x: f64) -> Seen {
        let pose = Rigid::<Tracker, Marker>::from_parts(Rotation::IDENTITY, Vector::new(x, 0.0, 0.0));
        Seen {
            marker,
            outcome: Ok((pose, 0.0)),
        }
    }

    /// A hung peer that sent its last pose as a matrix and as a quaternion in turns, which differ by what is rounded, was never one that
    /// repeats itself.
    #[test]
    fn two_kinds_of_one_pose_in_turns_repeat_it() {
        let mut newest = Newest::default();
        let kinds = [vec![seen(0, 1.0)], vec![seen(0, 1.000_000_1)]];
        let found: Vec<bool> = (0..6)
            .map(|k| newest.repeats(&frame(5, kinds[k % 2].clone())))
            .collect();
        assert_eq!(found, [false, false, true, true, true, true]);
        assert!(!newest.repeats(&frame(6, kinds[0].clone())));
        newest.forget();
        assert!(!newest.repeats(&frame(6, kinds[0].clone())));
        assert_eq!(newest.came(), (6, 6));
    }

    /// A list that came behind the same poses one by one, with the patient's marker first, was counted as a queue of 26 ms.
    #[test]
    fn the_order_of_markers_is_no_difference_and_a_loss_is_one() {
        let mut newest = Newest::default();
        assert!(!newest.repeats(&frame(5, vec![seen(0, 1.0), seen(1, 2.0)])));
        assert!(newest.repeats(&frame(5, vec![seen(1, 2.0), seen(0, 1.0)])));
        let lost = Seen {
            marker: 1,
            outcome: Err(Lost::NotSeen),
        };
        assert!(!newest.repeats(&frame(5, vec![seen(0, 1.0), lost])));
        // Without stamps nothing says that two frames are one.
        assert!(!newest.repeats(&frame(0, vec![seen(0, 1.0)])));
        assert!(!newest.repeats(&frame(0, vec![seen(0, 1.0)])));
    }

    #[test]
    fn what_is_remembered_of_one_stamp_is_bounded() {
        let mut newest = Newest::default();
        for k in 0..10_000 {
            assert!(!newest.repeats(&frame(5, vec![seen(0, f64::from(k))])));
        }
        assert_eq!(newest.frames.len(), MOST);
    }
}
