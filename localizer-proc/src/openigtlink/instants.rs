//! What a peer said of each marker under its newest stamps.
//!
//! A stamp is of one instant, so that all that is said of a marker under it has to agree. Where one message has its pose and another says
//! that it is lost, the loss counts, and while that goes on no pose of the marker does. Where messages of one kind have several poses of it,
//! stamps stand still or are coarser than the time between two measurements: they do not tell instants apart, and contradict nothing.

use std::collections::VecDeque;

use bus::message::Lost;
use igtl::{Stamp, TypeName};

use super::pose::Tool;

/// So many stamps back a message may be late.
const STAMPS: usize = 8;
/// No pose of a marker counts for so long after it was seen and lost under one stamp, ns.
const CONTRADICTED_NS: i64 = 2_000_000_000;

/// What a message says of a marker.
type Outcome = Result<(Tool, f64), Lost>;

/// What one connection has said.
#[derive(Debug, Clone, Default)]
pub(super) struct Instants {
    markers: Vec<OfMarker>,
    stand_still: bool,
}

/// What was said of one marker.
#[derive(Debug, Clone)]
struct OfMarker {
    marker: u32,
    newest: VecDeque<Under>,
    /// Until when a loss counts against its poses, ns, and which.
    contradicted: Option<(i64, Lost)>,
}

/// What was said of it under one stamp.
#[derive(Debug, Clone)]
struct Under {
    stamp: Stamp,
    /// The newest pose of each kind of message.
    poses: Vec<(TypeName, Tool)>,
    lost: Option<Lost>,
}

impl Instants {
    /// Whether stamps have shown that they do not tell instants apart.
    pub(super) fn stand_still(&self) -> bool {
        self.stand_still
    }

    /// Whether anything was said of this marker.
    pub(super) fn know(&self, marker: u32) -> bool {
        self.markers.iter().any(|of| of.marker == marker)
    }

    /// What counts of a marker of which a message of this kind and stamp says `outcome`, and whether its peer contradicts itself in that.
    pub(super) fn judge(
        &mut self,
        said: (Stamp, TypeName),
        marker: u32,
        outcome: Outcome,
        now_ns: i64,
    ) -> (Outcome, bool) {
        let of = match self.markers.iter().position(|of| of.marker == marker) {
            Some(place) => &mut self.markers[place],
            None => {
                self.markers.push(OfMarker::new(marker));
                let last = self.markers.len() - 1;
                &mut self.markers[last]
            }
        };
        if said.0 == Stamp::NONE {
            return (outcome, false);
        }
        let (is_moved, against) = of.under(said.0).add(said.1, outcome);
        self.stand_still |= is_moved;
        if self.stand_still {
            return (outcome, false);
        }
        if let Some(lost) = against {
            of.contradicted = Some((now_ns.saturating_add(CONTRADICTED_NS), lost));
        }
        match (outcome, of.contradicted) {
            (Ok(_), Some((until_ns, lost))) if now_ns < until_ns => (Err(lost), true),
            (outcome, _) => (outcome, against.is_some()),
        }
    }
}

impl OfMarker {
    fn new(marker: u32) -> Self {
        Self {
            marker,
            newest: VecDeque::with_capacity(STAMPS + 1),
            contradicted: None,
        }
    }

    fn under(&mut self, stamp: Stamp) -> &mut Under {
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
}

impl Under {
    fn new(stamp: Stamp) -> Self {
        Self {
            stamp,
            poses: Vec::new(),
            lost: None,
        }
    }

    /// Whether it has moved under its stamp, by messages of one kind, and the loss that its poses stand against.
    fn add(&mut self, kind: TypeName, outcome: Outcome) -> (bool, Option<Lost>) {
        let is_moved = match outcome {
            Err(lost) => {
                self.lost = self.lost.or(Some(lost));
                false
            }
            Ok((pose, _)) => match self.poses.iter_mut().find(|(other, _)| *other == kind) {
                Some((_, last)) => std::mem::replace(last, pose) != pose,
                None => {
                    self.poses.push((kind, pose));
                    false
                }
            },
        };
        (is_moved, self.lost.filter(|_| !self.poses.is_empty()))
    }
}

#[cfg(test)]
mod tests {
    use geometry::Vector;

    use super::*;

    const MS: i64 = 1_000_000;

    fn said(ms: u64, kind: &str) -> (Stamp, TypeName) {
        let stamp = Stamp::of_ns(1_790_000_000_000_000_000 + ms * 1_000_000).unwrap();
        (stamp, TypeName::new(kind).unwrap())
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
            let mut instants = Instants::default();
            let mut good = 0;
            for k in 0..100_u64 {
                let now_ns = 16 * MS * k as i64;
                let (seen, _) = instants.judge(said(16 * k, "TRANSFORM"), 0, at(k as f64), now_ns);
                good += u64::from(seen.is_ok());
                if k >= late {
                    let lost = instants.judge(said(16 * (k - late), "TDATA"), 0, Err(Lost::NotSeen), now_ns + MS);
                    assert_eq!(lost, (Err(Lost::NotSeen), true));
                }
            }
            // Those before the first loss came.
            assert_eq!((good, instants.stand_still()), (late + 1, false));
            let (seen, is_told) = instants.judge(said(5000, "TRANSFORM"), 0, at(1.0), 5000 * MS);
            assert_eq!((seen, is_told), (at(1.0), false));
        }
    }

    #[test]
    fn a_pose_under_a_stamp_of_which_the_marker_was_lost_does_not_count() {
        let mut instants = Instants::default();
        assert!(!instants.judge(said(0, "TDATA"), 0, Err(Lost::OutOfVolume), 0).1);
        let seen = instants.judge(said(0, "TRANSFORM"), 0, at(1.0), MS);
        assert_eq!(seen, (Err(Lost::OutOfVolume), true));
        // Of the other marker nothing was said, nor is anything of what has no stamp.
        assert_eq!(instants.judge(said(0, "TRANSFORM"), 1, at(1.0), MS), (at(1.0), false));
        let none = (Stamp::NONE, said(0, "TDATA").1);
        assert_eq!(
            instants.judge(none, 1, Err(Lost::NotSeen), MS),
            (Err(Lost::NotSeen), false)
        );
        assert_eq!(instants.judge(none, 1, at(2.0), MS), (at(2.0), false));
    }

    #[test]
    fn stamps_that_stand_still_contradict_nothing() {
        let mut instants = Instants::default();
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
        let mut twice = Instants::default();
        for k in 0..100_u32 {
            for kind in ["TRANSFORM", "QTDATA"] {
                let x = f64::from(k) + if kind == "QTDATA" { 1e-7 } else { 0.0 };
                assert!(twice.judge(said(k.into(), kind), 0, at(x), 0).0.is_ok());
            }
        }
        assert!(!twice.stand_still());
    }
}
