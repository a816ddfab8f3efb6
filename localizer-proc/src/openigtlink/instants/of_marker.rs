//! What was said of one marker, and when.

use std::collections::VecDeque;

use bus::message::Lost;
use igtl::Stamp;

use super::under::Under;
use super::{Against, KINDS, Outcome};
use crate::openigtlink::sources::Source;

/// So many stamps back a message may be late.
const STAMPS: usize = 8;
/// No pose of a marker counts for so long after its peer contradicted itself under one stamp, ns.
const CONTRADICTED_NS: i64 = 2_000_000_000;
/// Nor for so long after another kind of message said that it is lost, and has said nothing else since, ns: kinds that come more seldom
/// than twice a second say nothing of now.
const BESIDE_NS: i64 = 500_000_000;
/// The times between so many poses are known.
const GAPS: usize = 8;
/// A marker that is lost for longer has more losses under one stamp than so many.
const FEW: u32 = 2;
/// What comes at once comes within this, ns.
const AT_ONCE_NS: i64 = 5_000_000;
/// A marker that comes back is seen by one kind of message first: so many poses are held back before that is told as a contradiction.
const TOLD_AFTER: u32 = 3;

/// What was said of one marker.
#[derive(Debug, Clone)]
pub(super) struct OfMarker {
    pub(super) marker: u32,
    pub(super) newest: VecDeque<Under>,
    /// The newest word of each kind of message: when, ns, and the loss, if it is one.
    words: Vec<(Source, i64, Option<Lost>)>,
    /// The stamp of the newest pose, and when it came, ns.
    pose: Option<(Stamp, i64)>,
    /// Between the newest poses, ns.
    gaps_ns: VecDeque<i64>,
    /// Losses that are no contradiction, under the stamp of the newest pose: how many, when the newest came, ns, and which.
    losses: (u32, i64, Lost),
    /// Until when a loss counts against its poses, ns, which, and why.
    pub(super) contradicted: Option<(i64, Lost, Against)>,
    /// So many poses in a row were held back by another kind of message.
    held_back: u32,
}

impl OfMarker {
    pub(super) fn new(marker: u32) -> Self {
        Self {
            marker,
            newest: VecDeque::with_capacity(STAMPS + 1),
            words: Vec::new(),
            pose: None,
            gaps_ns: VecDeque::with_capacity(GAPS + 1),
            losses: (0, 0, Lost::NotSeen),
            contradicted: None,
            held_back: 0,
        }
    }

    pub(super) fn under(&mut self, stamp: Stamp) -> &mut Under {
        let place = match self.newest.iter().position(|under| under.stamp == stamp) {
            Some(place) => place,
            None => {
                self.newest.push_back(Under::new(stamp));
                if self.newest.len() > STAMPS {
                    self.newest.pop_front();
                }
                self.newest.len() - 1
            }
        };
        &mut self.newest[place]
    }

    pub(super) fn has_pose(&self, stamp: Stamp) -> bool {
        let mut newest = self.newest.iter();
        newest.any(|under| under.stamp == stamp && under.has_pose())
    }

    /// Its peer contradicts itself in this.
    pub(super) fn contradict(&mut self, lost: Lost, why: Against, now_ns: i64) {
        self.contradicted = Some((now_ns.saturating_add(CONTRADICTED_NS), lost, why));
    }

    /// The newest word of a kind of message. Where there are too many kinds, the one that has said nothing for longest is forgotten.
    pub(super) fn hear(&mut self, from: Source, lost: Option<Lost>, now_ns: i64) {
        self.words.retain(|(other, ..)| *other != from);
        if self.words.len() >= KINDS {
            self.words.remove(0);
        }
        self.words.push((from, now_ns, lost));
    }

    /// A loss that is no contradiction.
    pub(super) fn lose(&mut self, stamp: Stamp, lost: Lost, now_ns: i64) {
        if self.is_newest(stamp) {
            self.losses = (self.losses.0.saturating_add(1), now_ns, lost);
        }
    }

    fn is_newest(&self, stamp: Stamp) -> bool {
        self.pose.is_some_and(|(newest, _)| newest == stamp)
    }

    /// A pose of this stamp came. Where a loss came just before it, and hardly any before that, the two take turns: the loss was not of a time
    /// between this pose and the one before it.
    pub(super) fn seen(&mut self, stamp: Stamp, now_ns: i64) {
        if let Some((_, last_ns)) = self.pose.filter(|(last, _)| *last != stamp) {
            let (count, at_ns, lost) = std::mem::replace(&mut self.losses, (0, now_ns, Lost::NotSeen));
            let is_soon = self
                .usual_ns()
                .is_none_or(|usual_ns| now_ns.saturating_sub(at_ns) <= usual_ns);
            if (1..=FEW).contains(&count) && is_soon {
                self.contradict(lost, Against::Stamp, now_ns);
            }
            self.gaps_ns.push_back(now_ns.saturating_sub(last_ns));
            if self.gaps_ns.len() > GAPS {
                self.gaps_ns.pop_front();
            }
        }
        self.pose = Some((stamp, now_ns));
    }

    /// How long after a pose of this stamp its own kind of message may say nothing but that the marker is there, ns: where a loss comes later,
    /// the marker has been lost since. `None` where that is not known, or there is a newer pose.
    pub(super) fn patience_ns(&self, stamp: Stamp) -> Option<i64> {
        self.usual_ns().filter(|_| self.is_newest(stamp))
    }

    /// Three quarters of the usual time between two poses, ns: of what comes twice within that time, one comes sooner.
    fn usual_ns(&self) -> Option<i64> {
        let mut gaps_ns: Vec<i64> = self.gaps_ns.iter().copied().collect();
        gaps_ns.sort_unstable();
        let usual_ns = gaps_ns.get(gaps_ns.len() / 2)?;
        Some((usual_ns / 4 * 3).max(AT_ONCE_NS))
    }

    /// What counts of a pose, where another kind of message says that the marker is lost.
    pub(super) fn beside(&mut self, from: Source, outcome: Outcome, now_ns: i64) -> (Outcome, Option<Against>) {
        let is_new = |at_ns: i64| now_ns.saturating_sub(at_ns) <= BESIDE_NS;
        let mut others = self.words.iter().filter(|(other, ..)| *other != from);
        let Some(lost) = others.find_map(|(_, at_ns, lost)| lost.filter(|_| is_new(*at_ns))) else {
            self.held_back = 0;
            return (outcome, None);
        };
        self.held_back = self.held_back.saturating_add(1);
        let is_told = self.held_back >= TOLD_AFTER;
        (Err(lost), is_told.then_some(Against::Kind))
    }
}
