//! What a peer said of each marker under its newest stamps.
//!
//! A stamp is of one instant, so that all that is said of a marker under it has to agree ([`under`]). Where one message has its pose and
//! another says that it is lost, the loss counts, and while that goes on no pose of the marker does; nor where two kinds of message have
//! two poses of it. Where messages of one kind have several poses of it, stamps stand still or are coarser than the time between two
//! measurements: they do not tell instants apart. Then, and between stamps, time alone says what belongs together: no pose counts beside
//! another kind of message that says at about that time that the marker is lost.

mod of_marker;
mod under;

#[cfg(test)]
mod tests;

use bus::message::Lost;
use igtl::Stamp;

use super::pose::Tool;
use super::sources::Source;
use of_marker::OfMarker;
use under::Heard;

/// So many kinds of message of one marker are known at most, with the lists of their names.
const KINDS: usize = 8;
/// What a message says of a marker.
type Outcome = Result<(Tool, f64), Lost>;

/// How a peer contradicts itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Against {
    /// A marker is seen and lost under one stamp.
    Stamp,
    /// It is seen by one kind of message and lost by another at one time.
    Kind,
    /// Two kinds of message have two poses of it under one stamp.
    Pose,
}

/// What one connection has said.
#[derive(Debug, Clone)]
pub(super) struct Instants {
    markers: Vec<OfMarker>,
    stand_still: bool,
    /// The largest entry of `R^T R - 1` that is put right, which two kinds of message may put right otherwise.
    allowed: f64,
}

impl Instants {
    /// Of a new connection.
    pub(super) fn new(allowed: f64) -> Self {
        Self {
            markers: Vec::new(),
            stand_still: false,
            allowed,
        }
    }

    /// Whether stamps have shown that they do not tell instants apart.
    pub(super) fn stand_still(&self) -> bool {
        self.stand_still
    }

    /// Whether anything was said of this marker.
    pub(super) fn know(&self, marker: u32) -> bool {
        self.markers.iter().any(|of| of.marker == marker)
    }

    /// Whether all these markers were seen under one of the newest stamps.
    pub(super) fn share_a_stamp(&self, markers: &[u32]) -> bool {
        let Some((first, others)) = markers.split_first() else {
            return false;
        };
        let has = |marker: u32, stamp| self.of(marker).is_some_and(|of| of.has_pose(stamp));
        let first = self.of(*first).into_iter().flat_map(|of| &of.newest);
        let mut stamps = first.filter(|under| under.has_pose()).map(|under| under.stamp);
        stamps.any(|stamp| others.iter().all(|marker| has(*marker, stamp)))
    }

    fn of(&self, marker: u32) -> Option<&OfMarker> {
        self.markers.iter().find(|of| of.marker == marker)
    }

    /// What counts of a marker of which a message of this kind and stamp says `outcome`, and how its peer contradicts itself in that.
    pub(super) fn judge(
        &mut self,
        (stamp, from): (Stamp, Source),
        marker: u32,
        outcome: Outcome,
        now_ns: i64,
    ) -> (Outcome, Option<Against>) {
        let place = match self.markers.iter().position(|of| of.marker == marker) {
            Some(place) => place,
            None => {
                self.markers.push(OfMarker::new(marker));
                self.markers.len() - 1
            }
        };
        let of = &mut self.markers[place];
        of.hear(from, outcome.err(), now_ns);
        if stamp != Stamp::NONE {
            let heard = Heard {
                from,
                now_ns,
                patience_ns: of.patience_ns(stamp),
            };
            let (is_moved, against) = of.under(stamp).add(heard, outcome, self.allowed);
            self.stand_still |= is_moved;
            if let Some((lost, why)) = against.filter(|_| !self.stand_still) {
                of.contradict(lost, why, now_ns);
            }
            if let Err(lost) = outcome {
                if against.is_none() {
                    of.lose(stamp, lost, now_ns);
                }
                return (outcome, against.map(|(_, why)| why).filter(|_| !self.stand_still));
            }
            of.seen(stamp, now_ns);
        }
        let contradicted = of.contradicted.filter(|_| !self.stand_still && stamp != Stamp::NONE);
        match (outcome, contradicted) {
            (Ok(_), Some((until_ns, lost, why))) if now_ns < until_ns => (Err(lost), Some(why)),
            (Ok(_), _) => of.beside(from, outcome, now_ns),
            (Err(_), _) => (outcome, None),
        }
    }
}
