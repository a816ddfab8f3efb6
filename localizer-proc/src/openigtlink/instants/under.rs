//! What was said of one marker under one stamp.

use bus::message::Lost;
use igtl::Stamp;

use super::{Against, KINDS, Outcome};
use crate::openigtlink::pose::{Tool, are_apart};
use crate::openigtlink::sources::Source;

/// Two turns of one kind of message that are nearer are one, rad: single precision knows the numbers of a turn to 6e-8.
const ONE_KIND_RAD: f64 = 1e-5;
/// Of two kinds, rad: a quaternion without its real part knows a half turn to 7e-4.
const TWO_KINDS_RAD: f64 = 1e-3;

/// A message.
#[derive(Debug, Clone, Copy)]
pub(super) struct Heard {
    /// Of what kind.
    pub(super) from: Source,
    /// When, ns.
    pub(super) now_ns: i64,
    /// How long after a pose of its kind it may say that the marker has been lost since, ns; `None`: never, as there are newer poses.
    pub(super) patience_ns: Option<i64>,
}

/// The poses of one kind of message.
#[derive(Debug, Clone)]
struct Posed {
    from: Source,
    /// All are held against the first, so that a slow movement adds up.
    first: Tool,
    newest: Tool,
    at_ns: i64,
    /// The marker has been lost since, as the same kind of message says in time.
    is_over: bool,
}

/// What was said.
#[derive(Debug, Clone)]
pub(super) struct Under {
    pub(super) stamp: Stamp,
    poses: Vec<Posed>,
    lost: Option<Lost>,
}

impl Under {
    pub(super) fn new(stamp: Stamp) -> Self {
        Self {
            stamp,
            poses: Vec::new(),
            lost: None,
        }
    }

    pub(super) fn has_pose(&self) -> bool {
        !self.poses.is_empty()
    }

    /// Whether the marker has moved under its stamp, by messages of one kind, and what its poses stand against.
    pub(super) fn add(&mut self, heard: Heard, outcome: Outcome, allowed: f64) -> (bool, Option<(Lost, Against)>) {
        let is_moved = match outcome {
            Err(lost) => {
                self.lose(heard, lost);
                false
            }
            Ok((pose, _)) => self.see(heard, pose),
        };
        let stands = self.poses.iter().any(|posed| !posed.is_over);
        let lost = self.lost.filter(|_| stands).map(|lost| (lost, Against::Stamp));
        // Two ways to put a rotation right lie on both sides of it.
        let two_kinds = 2.0f64.mul_add(allowed, TWO_KINDS_RAD);
        let other = || self.are_two(two_kinds).then_some((Lost::Refused, Against::Pose));
        (is_moved, lost.or_else(other))
    }

    /// A marker that is lost bears the stamp of when it was seen last with some peers, and has no pose that would be newer.
    fn lose(&mut self, heard: Heard, lost: Lost) {
        self.lost = self.lost.or(Some(lost));
        let own = self.poses.iter_mut().find(|posed| posed.from == heard.from);
        if let (Some(posed), Some(patience_ns)) = (own, heard.patience_ns) {
            posed.is_over |= heard.now_ns.saturating_sub(posed.at_ns) > patience_ns;
        }
    }

    /// Whether its kind of message had another pose.
    fn see(&mut self, heard: Heard, pose: Tool) -> bool {
        if let Some(posed) = self.poses.iter_mut().find(|posed| posed.from == heard.from) {
            (posed.newest, posed.at_ns, posed.is_over) = (pose, heard.now_ns, false);
            return are_apart(&posed.first, &pose, ONE_KIND_RAD);
        }
        if self.poses.len() < KINDS {
            self.poses.push(Posed {
                from: heard.from,
                first: pose,
                newest: pose,
                at_ns: heard.now_ns,
                is_over: false,
            });
        }
        false
    }

    /// Whether two kinds of message have two poses.
    fn are_two(&self, most_rad: f64) -> bool {
        let Some((first, others)) = self.poses.split_first() else {
            return false;
        };
        let is_other = |posed: &Posed| are_apart(&first.newest, &posed.newest, most_rad);
        others.iter().any(is_other)
    }
}
