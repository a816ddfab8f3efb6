//! Which kind of message makes the frames, where a peer sends a marker in several.
//!
//! One does for each marker, the first that had a pose of it. The numbers of two kinds are rounded otherwise: taken in turn, those of a
//! device that hangs would be new each time. What another kind says under the same stamp is only held against it ([`super::instants`]);
//! under another stamp it is left out, counted and told, but for a loss of a marker that has a pose. Another kind takes over where the
//! first is silent for longer than poses are shown for, so that nothing that hangs is new for long; and where it alone has all markers
//! under one stamp.

use std::fmt;

use igtl::{DeviceName, Stamp, TypeName};

use crate::driver::Seen;

/// A kind of message that says nothing of a marker for so long is over, ns. No pose of it is shown any more by then: `limits.lost_ms` is
/// 1000 by default.
const SILENT_NS: i64 = 2_000_000_000;
/// While it has said nothing for so long, what others lose is handed on each time, ns: a marker that is lost is not one of which nothing comes.
const QUIET_NS: i64 = 500_000_000;
/// So many kinds and lists of one marker are known.
const KNOWN: usize = 16;

/// A kind of message; lists of tools are told apart by their names too.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Source {
    kind: TypeName,
    list: DeviceName,
}

impl Source {
    /// A message of one tool.
    pub(super) fn one(kind: TypeName) -> Self {
        let list = DeviceName::EMPTY;
        Self { kind, list }
    }

    /// A list of tools.
    pub(super) fn list(kind: TypeName, list: DeviceName) -> Self {
        Self { kind, list }
    }
}

impl fmt::Display for Source {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.list == DeviceName::EMPTY {
            true => write!(f, "{}", self.kind),
            false => write!(f, "{} of {}", self.kind, self.list),
        }
    }
}

/// What a person must know.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum News {
    /// A pose of this marker of the second kind was left out, as it comes as the first.
    LeftOut(u32, Source, Source),
    /// This marker comes as the second kind from now on, and no longer as the first.
    TookOver(u32, Source, Source),
}

/// What is made of one message.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Taken {
    /// Makes a frame.
    pub(super) frame: Vec<Seen>,
    /// Lost, by another kind of message than makes the frames, where that had a pose last.
    pub(super) lost: Vec<Seen>,
    pub(super) news: Vec<News>,
}

/// What one connection has shown.
#[derive(Debug, Clone)]
pub(super) struct Sources {
    wanted: Vec<u32>,
    markers: Vec<OfMarker>,
}

/// What it has shown of one marker.
#[derive(Debug, Clone)]
struct OfMarker {
    marker: u32,
    source: Source,
    /// It has had a pose.
    is_proved: bool,
    /// When it said something last, ns, and under which stamp.
    heard_ns: i64,
    stamp: Stamp,
    /// What went out last is that it is lost.
    is_lost: bool,
    /// A pose of another kind under a stamp that is not, or not yet, that of the source.
    ahead: Option<(Source, Stamp)>,
    /// The stamp of the newest pose of each kind.
    poses: Vec<(Source, Stamp)>,
    /// The lists that have had it, by name.
    lists: Vec<DeviceName>,
}

impl Sources {
    /// Of a new connection, on which these markers are looked for.
    pub(super) fn new(wanted: Vec<u32>) -> Self {
        let markers = Vec::new();
        Self { wanted, markers }
    }

    /// Whether nothing has made a frame yet.
    pub(super) fn are_none(&self) -> bool {
        self.markers.is_empty()
    }

    /// Whether a list of this name loses the marker by leaving it out: where it has had it, or no list has. Where too many have, any may.
    pub(super) fn loses(&self, marker: u32, list: DeviceName) -> bool {
        let of = self.markers.iter().find(|of| of.marker == marker);
        of.is_some_and(|of| of.lists.is_empty() || of.lists.contains(&list) || of.lists.len() >= KNOWN)
    }

    /// A list of this name has the marker.
    pub(super) fn list_has(&mut self, marker: u32, list: DeviceName) {
        let of = self.markers.iter_mut().find(|of| of.marker == marker);
        if let Some(of) = of.filter(|of| !of.lists.contains(&list) && of.lists.len() < KNOWN) {
            of.lists.push(list);
        }
    }

    /// What is made of a message of this kind and stamp that says this of markers.
    pub(super) fn take(&mut self, from: Source, stamp: Stamp, all: Vec<Seen>, now_ns: i64) -> Taken {
        let mut taken = Taken::default();
        for seen in &all {
            self.know(from, seen, now_ns).came(from, stamp, seen);
        }
        if self.has_all_alone(from, stamp, &all) {
            self.take_over(from, stamp, now_ns, &mut taken.news);
            return taken;
        }
        for seen in all {
            self.know(from, &seen, now_ns)
                .take(from, stamp, seen, now_ns, &mut taken);
        }
        taken
    }

    fn know(&mut self, from: Source, seen: &Seen, now_ns: i64) -> &mut OfMarker {
        let place = match self.markers.iter().position(|of| of.marker == seen.marker) {
            Some(place) => place,
            None => {
                self.markers.push(OfMarker::new(seen.marker, from, now_ns));
                self.markers.len() - 1
            }
        };
        &mut self.markers[place]
    }

    /// Whether the markers come as different kinds, so that they may never be in one frame, while this kind has poses of all of them.
    fn has_all_alone(&self, from: Source, stamp: Stamp, all: &[Seen]) -> bool {
        let of = |marker: &u32| self.markers.iter().find(|of| of.marker == *marker);
        let mut known = self.wanted.iter().filter_map(of).map(|of| of.source);
        let Some(first) = known.next() else {
            return false;
        };
        let are_different = known.any(|source| source != first);
        let is_here = |marker: &u32| {
            let is_it = |seen: &Seen| seen.marker == *marker && seen.outcome.is_ok();
            let is_under = |of: &OfMarker| stamp != Stamp::NONE && of.poses.contains(&(from, stamp));
            all.iter().any(is_it) || of(marker).is_some_and(is_under)
        };
        are_different && self.wanted.iter().all(is_here)
    }

    /// All markers come as this kind from the next message on: this one is of an instant of which some went out.
    fn take_over(&mut self, from: Source, stamp: Stamp, now_ns: i64, news: &mut Vec<News>) {
        for of in &mut self.markers {
            if of.source != from {
                news.push(News::TookOver(of.marker, of.source, from));
            }
            (of.source, of.is_proved, of.heard_ns, of.stamp) = (from, true, now_ns, stamp);
            of.ahead = None;
        }
    }
}

impl OfMarker {
    fn new(marker: u32, source: Source, now_ns: i64) -> Self {
        Self {
            marker,
            source,
            is_proved: false,
            heard_ns: now_ns,
            stamp: Stamp::NONE,
            is_lost: true,
            ahead: None,
            poses: Vec::new(),
            lists: Vec::new(),
        }
    }

    /// The newest pose of its kind.
    fn came(&mut self, from: Source, stamp: Stamp, seen: &Seen) {
        if seen.outcome.is_err() {
            return;
        }
        self.poses.retain(|(other, _)| *other != from);
        if self.poses.len() >= KNOWN {
            self.poses.remove(0);
        }
        self.poses.push((from, stamp));
    }

    fn take(&mut self, from: Source, stamp: Stamp, seen: Seen, now_ns: i64, taken: &mut Taken) {
        let is_pose = seen.outcome.is_ok();
        let heard_ago_ns = now_ns.saturating_sub(self.heard_ns);
        let is_silent = heard_ago_ns > SILENT_NS;
        if self.source != from && (is_silent || (is_pose && !self.is_proved)) {
            if self.is_proved {
                taken.news.push(News::TookOver(self.marker, self.source, from));
            }
            (self.source, self.is_proved) = (from, false);
        }
        if self.source == from {
            self.leave_out_unless(stamp, taken);
            (self.heard_ns, self.stamp, self.is_lost) = (now_ns, stamp, !is_pose);
            self.is_proved |= is_pose;
            taken.frame.push(seen);
        } else if is_pose {
            self.hold(from, stamp, taken);
        } else if !self.is_lost || heard_ago_ns > QUIET_NS {
            self.is_lost = true;
            taken.lost.push(seen);
        }
    }

    /// A pose of another kind: nothing more under the stamp of the source, which it may be ahead of by a message.
    fn hold(&mut self, from: Source, stamp: Stamp, taken: &mut Taken) {
        self.leave_out_unless(stamp, taken);
        if stamp == Stamp::NONE || stamp != self.stamp {
            self.ahead = Some((from, stamp));
        }
    }

    /// What came ahead is left out unless it was of this stamp.
    fn leave_out_unless(&mut self, stamp: Stamp, taken: &mut Taken) {
        if let Some((other, _)) = self
            .ahead
            .take()
            .filter(|(_, ahead)| *ahead != stamp || stamp == Stamp::NONE)
        {
            taken.news.push(News::LeftOut(self.marker, self.source, other));
        }
    }
}
