//! TRANSFORMs of one instant, which come one by one, as one frame.
//!
//! They belong together where they bear one stamp. A frame is whole once every marker that is looked for is in it; else it ends with
//! the next stamp, or in time ([`patience`]), as a peer may send nothing for a tool that it does not see. What comes after its frame went
//! out is left out: two frames of one stamp would be a stamp that stands still. Where stamps are missing or stand still, nothing says
//! what belongs together: each pose is then a frame of its own, and tool and patient are never combined. Nor are they where a message was
//! damaged, until the second stamp after it: it may have been what shows that two instants share a stamp.

mod patience;
#[cfg(test)]
mod tests;

use bus::message::Lost;
use igtl::Stamp;

use super::stamp_ns;
use crate::driver::{Frame, Seen};
use patience::Patience;

/// What is being gathered.
#[derive(Debug, Clone)]
pub(super) struct Gather {
    wanted: Vec<u32>,
    open: Option<Frame>,
    /// The stamp of the frame before, the markers that came with it, and when the first did, ns.
    last: Option<(Stamp, Vec<u32>, i64)>,
    stamp: Stamp,
    patience: Patience,
    alone: bool,
    late: bool,
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
            patience: Patience::new(),
            alone: false,
            late: false,
            never: false,
            damaged: Damaged::No,
        }
    }

    /// Whether the newest pose was a frame of its own, as its stamp does not say what it belongs to.
    pub(super) fn is_alone(&self) -> bool {
        self.alone
    }

    /// Whether the newest pose came when the frame of its stamp had gone out, and was left out.
    pub(super) fn is_late(&self) -> bool {
        self.late
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
        self.patience.measure(seen.marker, now_ns);
        let is_in_it = !self.never && self.open.is_some() && self.stamp == stamp && !self.holds(seen.marker);
        if !is_in_it {
            frames.extend(self.close());
        }
        (self.alone, self.late) = (false, false);
        if !is_in_it && self.last.as_ref().is_some_and(|(last, ..)| *last == stamp) {
            frames.extend(self.behind(stamp, seen, now_ns));
            return frames;
        }
        if !is_in_it {
            let is_whole = self.last.as_ref().is_some_and(|(_, markers, _)| self.are_all(markers));
            self.patience.stamp_ended(is_whole);
        }
        self.alone = stamp == Stamp::NONE || self.never;
        if self.alone || self.is_damaged(stamp) {
            self.last = Some((stamp, vec![seen.marker], now_ns));
            frames.push(frame(stamp, seen, now_ns));
            return frames;
        }
        match &mut self.open {
            Some(open) => {
                open.seen.push(seen);
                open.arrival_ns = now_ns;
                self.patience.last_came(now_ns.saturating_sub(open.first_ns));
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

    /// One marker under the stamp of the frame that went out last; a frame of its own, where that stamp says nothing.
    fn behind(&mut self, stamp: Stamp, seen: Seen, now_ns: i64) -> Option<Frame> {
        let most = self.wanted.len();
        let (_, markers, first_ns) = self.last.as_mut()?;
        let is_new = !markers.contains(&seen.marker);
        // One more than there are shows that not each came once.
        if markers.len() <= most {
            markers.push(seen.marker);
        }
        let after_ns = now_ns.saturating_sub(*first_ns);
        // One that was in the frame already says that the stamp stands still; another one came too late for it.
        if is_new && stamp != Stamp::NONE && !self.never {
            self.late = true;
            self.patience.last_came(after_ns);
            return None;
        }
        self.alone = true;
        Some(frame(stamp, seen, now_ns))
    }

    /// Whether these are the markers that are looked for, each once.
    fn are_all(&self, markers: &[u32]) -> bool {
        markers.len() == self.wanted.len() && self.wanted.iter().all(|marker| markers.contains(marker))
    }

    fn holds(&self, marker: u32) -> bool {
        let open = self.open.as_ref();
        open.is_some_and(|open| open.seen.iter().any(|seen| seen.marker == marker))
    }

    /// This marker of what is being gathered has no pose after all; whether it is in that.
    pub(super) fn lose(&mut self, marker: u32, lost: Lost) -> bool {
        let mut seen = self.open.iter_mut().flat_map(|open| &mut open.seen);
        match seen.find(|seen| seen.marker == marker) {
            Some(seen) => {
                seen.outcome = Err(lost);
                true
            }
            None => false,
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
        let markers = open.seen.iter().map(|seen| seen.marker).collect();
        self.last = Some((self.stamp, markers, open.first_ns));
        Some(open)
    }

    /// When it ends of itself.
    pub(super) fn due_ns(&self) -> Option<i64> {
        let open = self.open.as_ref()?;
        Some(open.first_ns.saturating_add(self.patience.waits_ns()))
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
