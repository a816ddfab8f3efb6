//! Whether a sample goes on from the one before it: numbers, stamps, registration, and whether anything is measured at all.
//!
//! One sample can be a pose and the stream of them be none: a localizer that has hung up goes on sending its last place under
//! fresh stamps, a program that was started anew counts from 0 again, and a registration that changes moves the patient. Pure;
//! renderers and the pilot judge with it, each the samples that it sees.

use std::fmt;

use geometry::{Ct, Rigid, Tool};

use crate::clock;
use crate::message::{Lost, ToolPose, Tracked};

/// A sequence number may run ahead by this many, and by [`MOST_PER_S`] for each second between the stamps; beyond that it is
/// another count, and not samples that were lost.
const SLACK: u64 = 10_000;
/// More samples a second than any localizer gives.
const MOST_PER_S: f64 = 10_000.0;
/// Different measurements that are kept. A source that has hung up may send its last place in turn as it was rounded in several ways; a tool
/// at rest has noise, and gives a new place within a few samples.
const KEPT: usize = 8;

/// What is said of a sample beside the one before it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Break {
    /// It was captured before the sample judged last: what is newer stays. Not shown.
    Older {
        /// By how much, ns.
        by_ns: i64,
    },
    /// It bears the number of the sample judged last, and was captured later. Not shown.
    SameNumber,
    /// Its number is lower: the source counts anew. Shown, and told.
    NumberBack {
        /// The number before.
        from: u64,
    },
    /// Its number is higher by more than can have been lost. Shown, and told.
    NumberAhead {
        /// The number before.
        from: u64,
    },
}

impl Break {
    /// Whether the sample is not shown.
    pub fn refuses(self) -> bool {
        matches!(self, Self::Older { .. } | Self::SameNumber)
    }
}

impl fmt::Display for Break {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Older { by_ns } => {
                let ms = clock::ms(*by_ns);
                write!(
                    f,
                    "captured {ms:.1} ms before the one shown last; stamps must not go back"
                )
            }
            Self::SameNumber => write!(
                f,
                "the one before has the same number; each needs its own, growing by 1"
            ),
            Self::NumberBack { from } => {
                write!(f, "the one before has the higher number {from}: the source counts anew")
            }
            Self::NumberAhead { from } => {
                write!(
                    f,
                    "the one before has number {from}: too far for samples that were lost, the source counts anew"
                )
            }
        }
    }
}

/// What a sample is, after those before it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Judged {
    /// What may be shown: the sample's pose, or why there is none ([`Lost::Frozen`], [`Lost::Refused`] among the reasons).
    pub tracked: Tracked,
    /// What is wrong with its number or stamp.
    pub broken: Option<Break>,
    /// The registration before, where it is another one.
    pub registration_before: Option<u64>,
    /// How many samples were lost before it.
    pub missing: u64,
}

/// What is remembered of the samples.
#[derive(Debug, Clone, Copy, Default)]
pub struct Continuity {
    last: Option<(u64, i64)>,
    registration_id: Option<u64>,
    /// The newest different measurements; the one at `next` gives way to the next one.
    measured: [Option<Rigid<Ct, Tool>>; KEPT],
    next: usize,
    /// When the newest of them was captured, ns.
    since_ns: i64,
}

impl Continuity {
    /// Judges `pose`, which the door has let in as `tracked`. `frozen_ns`: the same measurement for longer than this is none;
    /// `None` in a replay, whose poses were judged when they were recorded.
    pub fn judge(&mut self, pose: &ToolPose, tracked: Tracked, frozen_ns: Option<i64>) -> Judged {
        let (broken, missing) = self.order(pose);
        if broken.is_some_and(Break::refuses) {
            return Judged {
                tracked: Tracked::Lost(Lost::Refused),
                broken,
                registration_before: None,
                missing,
            };
        }
        self.last = Some((pose.seq, pose.t_capture_ns));
        let Tracked::Valid(at) = tracked else {
            return Judged {
                tracked,
                broken,
                registration_before: None,
                missing,
            };
        };
        let before = self.registration_id.replace(pose.registration_id);
        let stands = frozen_ns.is_some_and(|limit| self.stands_ns(pose, at) > limit);
        Judged {
            tracked: match stands {
                true => Tracked::Lost(Lost::Frozen),
                false => tracked,
            },
            broken,
            registration_before: before.filter(|before| *before != pose.registration_id),
            missing,
        }
    }

    /// Judges a sample from before the place that a replay went to (see [`crate::session::Lead`]): what comes is judged beside it. One that
    /// was under way when the replay went back is none that anything goes on from.
    pub fn lead(&mut self, pose: &ToolPose, tracked: Tracked, frozen_ns: Option<i64>) -> Judged {
        let judged = self.judge(pose, tracked, frozen_ns);
        if !judged.broken.is_some_and(Break::refuses) {
            return judged;
        }
        *self = Self::default();
        self.judge(pose, tracked, frozen_ns)
    }

    fn order(&self, pose: &ToolPose) -> (Option<Break>, u64) {
        let Some((last, captured_ns)) = self.last else {
            return (None, 0);
        };
        let later_ns = pose.t_capture_ns.saturating_sub(captured_ns);
        if later_ns < 0 {
            let by_ns = later_ns.saturating_neg();
            return (Some(Break::Older { by_ns }), 0);
        }
        let possible = SLACK + (later_ns as f64 / 1e9 * MOST_PER_S) as u64;
        match pose.seq.checked_sub(last) {
            None => (Some(Break::NumberBack { from: last }), 0),
            // The very same sample once more, as from a replayer that was started again: it is as old as it was.
            Some(0) if later_ns == 0 => (None, 0),
            Some(0) => (Some(Break::SameNumber), 0),
            Some(ahead) if ahead > possible => (Some(Break::NumberAhead { from: last }), 0),
            Some(ahead) => (None, ahead - 1),
        }
    }

    /// For how long no other measurement than the [`KEPT`] newest has come, ns.
    fn stands_ns(&mut self, pose: &ToolPose, at: Rigid<Ct, Tool>) -> i64 {
        if pose.flags & ToolPose::NOISELESS == 0 && self.measured.contains(&Some(at)) {
            return pose.t_capture_ns.saturating_sub(self.since_ns);
        }
        self.measured[self.next] = Some(at);
        self.next = (self.next + 1) % KEPT;
        self.since_ns = pose.t_capture_ns;
        0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::Vector;

    const MS: i64 = 1_000_000;
    const FROZEN: Option<i64> = Some(500 * MS);

    fn place(x: f64) -> Rigid<Ct, Tool> {
        Rigid::from_rotation_vector(Vector::new(0.1, 0.2, 0.3), Vector::new(x, 0.0, 0.0)).unwrap()
    }

    fn judge(continuity: &mut Continuity, seq: u64, ms: i64, x: f64) -> Judged {
        judge_flagged(continuity, seq, ms, x, 0)
    }

    fn judge_flagged(continuity: &mut Continuity, seq: u64, ms: i64, x: f64, flags: u32) -> Judged {
        let mut pose = ToolPose {
            seq,
            t_capture_ns: ms * MS,
            flags,
            ..ToolPose::EMPTY
        };
        pose.set(Tracked::Valid(place(x)));
        let tracked = pose.tracked().unwrap();
        continuity.judge(&pose, tracked, FROZEN)
    }

    fn is_valid(judged: &Judged) -> bool {
        matches!(judged.tracked, Tracked::Valid(_))
    }

    #[test]
    fn a_stream_that_goes_on_has_nothing_to_say() {
        let mut continuity = Continuity::default();
        for seq in 0..100 {
            let judged = judge(&mut continuity, seq, 16 * seq as i64, seq as f64);
            assert!(is_valid(&judged) && judged.broken.is_none() && judged.missing == 0);
        }
        assert_eq!(judge(&mut continuity, 104, 1700, -1.0).missing, 4);
    }

    /// A localizer that hung up stood LIVE on the images for ever.
    #[test]
    fn the_same_numbers_under_fresh_stamps_are_no_measurement() {
        let mut continuity = Continuity::default();
        for seq in 0..100 {
            let judged = judge(&mut continuity, seq, 10 * seq as i64, 7.0);
            let expected = 10 * seq as i64 <= 500;
            assert_eq!(is_valid(&judged), expected, "{seq}");
            assert!(expected || judged.tracked == Tracked::Lost(Lost::Frozen));
        }
        // The last digit of one number is enough.
        assert!(is_valid(&judge(&mut continuity, 100, 1000, 7.000_000_000_000_001)));
        // A lost sample between two equal ones is no measurement either.
        let mut lost = ToolPose {
            seq: 101,
            t_capture_ns: 1010 * MS,
            ..ToolPose::EMPTY
        };
        lost.set(Tracked::Lost(Lost::NotSeen));
        continuity.judge(&lost, Tracked::Lost(Lost::NotSeen), FROZEN);
        assert!(!is_valid(&judge(&mut continuity, 102, 1600, 7.000_000_000_000_001)));
    }

    /// Stated: LIVE for ever, as each place differed from the one before. True: the source had hung up, and sent its last place rounded in
    /// two ways, in turn.
    #[test]
    fn a_place_that_is_rounded_in_several_ways_is_no_measurement() {
        for ways in [2, KEPT as u64] {
            let mut continuity = Continuity::default();
            let valid = (0..100).filter(|seq| {
                let x = 7.0 + 1e-7 * (seq % ways) as f64;
                is_valid(&judge(&mut continuity, *seq, 10 * *seq as i64, x))
            });
            // Each way is new once; from the last of them on they stand for 500 ms.
            assert_eq!(valid.count() as u64, ways + 50, "{ways}");
        }
    }

    /// A localizer of 1e-3 mm, whose noise at rest is a step or two along each axis.
    #[test]
    fn a_tool_at_rest_in_coarse_steps_is_measured() {
        let (mut continuity, mut random) = (Continuity::default(), 1_u32);
        for seq in 0..10_000 {
            let [x, y, z] = std::array::from_fn(|_| {
                random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                1e-3 * f64::from((random >> 16) % 3)
            });
            let at = Rigid::from_rotation_vector(Vector::new(0.1, 0.2, 0.3), Vector::new(x, y, z)).unwrap();
            let mut pose = ToolPose {
                seq,
                t_capture_ns: 16 * MS * seq as i64,
                ..ToolPose::EMPTY
            };
            pose.set(Tracked::Valid(at));
            let tracked = pose.tracked().unwrap();
            assert!(is_valid(&continuity.judge(&pose, tracked, FROZEN)), "{seq}");
        }
    }

    #[test]
    fn a_source_without_noise_and_a_replay_may_stand_still() {
        let mut continuity = Continuity::default();
        for seq in 0..100 {
            assert!(is_valid(&judge_flagged(
                &mut continuity,
                seq,
                10 * seq as i64,
                7.0,
                ToolPose::NOISELESS
            )));
        }
        let mut pose = ToolPose {
            seq: 200,
            t_capture_ns: 9000 * MS,
            ..ToolPose::EMPTY
        };
        pose.set(Tracked::Valid(place(7.0)));
        let judged = continuity.judge(&pose, Tracked::Valid(place(7.0)), None);
        assert!(is_valid(&judged));
    }

    #[test]
    fn what_is_older_or_bears_a_number_again_is_not_shown() {
        let mut continuity = Continuity::default();
        judge(&mut continuity, 10, 100, 1.0);
        let older = judge(&mut continuity, 11, 90, 2.0);
        assert_eq!(older.broken, Some(Break::Older { by_ns: 10 * MS }));
        let again = judge(&mut continuity, 10, 116, 3.0);
        assert_eq!(again.broken, Some(Break::SameNumber));
        assert!(!is_valid(&older) && !is_valid(&again));
        assert_eq!(judge(&mut continuity, 11, 120, 4.0).broken, None);
        let same = judge(&mut continuity, 11, 120, 4.0);
        assert!(is_valid(&same) && same.broken.is_none() && same.missing == 0);
    }

    #[test]
    fn another_count_is_told_and_not_counted_as_lost_samples() {
        let mut continuity = Continuity::default();
        judge(&mut continuity, 7, 100, 1.0);
        let ahead = judge(&mut continuity, 1_000_000_000_000_000, 116, 2.0);
        assert_eq!((ahead.broken, ahead.missing), (Some(Break::NumberAhead { from: 7 }), 0));
        let back = judge(&mut continuity, 0, 132, 3.0);
        assert!(is_valid(&ahead) && is_valid(&back));
        assert!(matches!(back.broken, Some(Break::NumberBack { .. })));
        // An hour at 4000 samples a second without a reader is no other count.
        assert_eq!(judge(&mut continuity, 14_400_000, 3_600_000, 4.0).missing, 14_399_999);
        assert_eq!(judge(&mut continuity, u64::MAX, i64::MAX / MS, 5.0).missing, 0);
    }

    #[test]
    fn a_registration_never_changes_without_a_word() {
        let mut continuity = Continuity::default();
        judge(&mut continuity, 0, 0, 1.0);
        let mut pose = ToolPose {
            seq: 1,
            t_capture_ns: 16 * MS,
            registration_id: 9,
            ..ToolPose::EMPTY
        };
        pose.set(Tracked::Valid(place(2.0)));
        let judged = continuity.judge(&pose, Tracked::Valid(place(2.0)), FROZEN);
        assert_eq!(judged.registration_before, Some(0));
        pose.seq = 2;
        let judged = continuity.judge(&pose, Tracked::Valid(place(3.0)), FROZEN);
        assert_eq!(judged.registration_before, None);
    }
}
