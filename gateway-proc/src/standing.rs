//! What may be said of the tool now: a pose, or why there is none. Pure: samples, the workflow and the time go in.

use bus::continuity::{Break, Continuity};
use bus::message::{Ages, FrameState, Lost, ToolPose, Tracked, Workflow};
use geometry::{Ct, Rigid, Tool};

/// What may be said of the tool at one moment.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Standing {
    /// Its pose, young enough.
    Valid(Rigid<Ct, Tool>),
    /// There was a pose; it is older than the scene allows.
    Stale,
    /// There is none.
    Lost(Lost),
    /// No sample has come yet.
    Waiting,
    /// There may be one, and the run's workflow does not let it be shown.
    Withheld(&'static str),
    /// The run ends, and nothing more will come.
    Ended,
}

/// What a person must be told of a sample beside its pose.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Remark {
    /// The registration changed: everything that was shown before lay elsewhere in the patient.
    Registration {
        /// The one now.
        now: u64,
    },
    /// The sample does not go on from the one before.
    Broken(String),
    /// It is no pose.
    Refused(String),
}

impl std::fmt::Display for Remark {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Registration { now } => write!(f, "THE REGISTRATION CHANGED: it is {now:016x} now"),
            Self::Broken(words) | Self::Refused(words) => f.write_str(words),
        }
    }
}

/// The scene's limits, ns.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Rules {
    /// When a pose is stale, and when it is none.
    pub(crate) ages: Ages,
    /// The same numbers under fresh stamps for longer are no measurement; `None` where the scene's own source has no noise.
    pub(crate) frozen_ns: Option<i64>,
}

/// Follows the samples of the tool.
#[derive(Debug)]
pub(crate) struct Follower {
    rules: Rules,
    continuity: Continuity,
    last: Option<(ToolPose, Tracked)>,
    workflow: Option<Workflow>,
    /// Samples that were no poses.
    pub(crate) refused: u64,
}

impl Follower {
    /// Nothing has come.
    pub(crate) fn new(rules: Rules) -> Self {
        Self {
            rules,
            continuity: Continuity::default(),
            last: None,
            workflow: None,
            refused: 0,
        }
    }

    /// The newest sample.
    pub(crate) fn sample(&self) -> Option<&ToolPose> {
        self.last.as_ref().map(|(sample, _)| sample)
    }

    /// How far the run has come.
    pub(crate) fn workflow(&self) -> Option<&Workflow> {
        self.workflow.as_ref()
    }

    /// The run has come further, or back.
    pub(crate) fn take_workflow(&mut self, workflow: Workflow) {
        self.workflow = Some(workflow);
    }

    /// A replay went elsewhere: what came before says nothing of what comes.
    pub(crate) fn forget(&mut self) {
        self.continuity = Continuity::default();
        self.last = None;
    }

    /// Takes a sample that came at `now_ns` on the session's clock.
    pub(crate) fn take(&mut self, sample: ToolPose, now_ns: i64) -> Vec<Remark> {
        let mut remarks = Vec::new();
        let tracked = match sample.tracked_at(now_ns) {
            Ok(tracked) => {
                let judged = self.continuity.judge(&sample, tracked, self.rules.frozen_ns);
                if let Some(broken) = judged.broken {
                    self.refused += u64::from(broken.refuses());
                    remarks.push(broken_words(&sample, broken));
                }
                if judged.registration_before.is_some() {
                    let now = sample.registration_id;
                    remarks.push(Remark::Registration { now });
                }
                judged.tracked
            }
            Err(error) => {
                self.refused += 1;
                remarks.push(Remark::Refused(error.to_string()));
                Tracked::Lost(Lost::Refused)
            }
        };
        self.last = Some((sample, tracked));
        remarks
    }

    /// Takes note of a sample from before the place that a replay went to: what comes is judged beside it (`recorder::replay::lead`).
    pub(crate) fn lead(&mut self, sample: ToolPose) {
        let Ok(tracked) = sample.tracked() else { return };
        let judged = self.continuity.lead(&sample, tracked, self.rules.frozen_ns);
        self.last = Some((sample, judged.tracked));
    }

    /// What may be said at `now_ns` on the session's clock.
    pub(crate) fn standing(&self, now_ns: i64) -> Standing {
        if let Some(why) = self.withheld() {
            return Standing::Withheld(why);
        }
        let Some((sample, tracked)) = &self.last else {
            return Standing::Waiting;
        };
        match (tracked, self.rules.ages.of_sample(sample, *tracked, now_ns)) {
            (Tracked::Valid(pose), FrameState::Live) => Standing::Valid(*pose),
            (Tracked::Valid(_), FrameState::Stale) => Standing::Stale,
            (_, FrameState::Lost(reason)) => Standing::Lost(reason),
            _ => Standing::Lost(Lost::Silent),
        }
    }

    /// Why nothing may be shown of the tool, whatever its pose is.
    pub(crate) fn withheld(&self) -> Option<&'static str> {
        let Some(workflow) = &self.workflow else {
            return Some("the run has not said yet how far it has come");
        };
        if workflow.has(Workflow::IMAGES) {
            return None;
        }
        Some(match workflow {
            told if told.has(Workflow::REJECTED) => "the examination is said not to be the patient's",
            told if told.has(Workflow::BUMPED) => "the marker on the patient was pushed",
            told if told.has(Workflow::CHECK_FAILED) => "the check of the registration failed",
            _ => "the run is not ready for navigation",
        })
    }
}

fn broken_words(sample: &ToolPose, broken: Break) -> Remark {
    let words = format!("pose {}: {broken}", sample.seq);
    if broken.refuses() {
        Remark::Refused(words)
    } else {
        Remark::Broken(words)
    }
}

impl Standing {
    /// In one word.
    pub(crate) const fn word(&self, is_present: bool) -> &'static str {
        match self {
            Self::Valid(_) if is_present => "LIVE",
            Self::Valid(_) => "VALID",
            Self::Stale => "STALE",
            Self::Lost(_) => "LOST",
            Self::Waiting => "WAITING",
            Self::Withheld(_) => "WITHHELD",
            Self::Ended => "ENDED",
        }
    }

    /// Why there is no pose; empty where there is one.
    pub(crate) const fn why(&self) -> &'static str {
        match self {
            Self::Valid(_) => "",
            Self::Stale => "the last pose is too old",
            Self::Lost(reason) => reason.words(),
            Self::Waiting => "no pose has come yet",
            Self::Withheld(why) => why,
            Self::Ended => "the run has ended",
        }
    }

    /// Whether a person would read the same words.
    pub(crate) fn says_as(&self, other: &Self) -> bool {
        (self.word(true), self.why()) == (other.word(true), other.why())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::Vector;

    const MS: i64 = 1_000_000;

    fn follower(frozen: bool) -> Follower {
        let mut follower = Follower::new(Rules {
            ages: Ages {
                stale_ns: 100 * MS,
                lost_ns: 1000 * MS,
            },
            frozen_ns: frozen.then_some(500 * MS),
        });
        follower.take_workflow(Workflow {
            flags: Workflow::IMAGES,
            ..Workflow::default()
        });
        follower
    }

    fn sample(seq: u64, ms: i64, x: f64) -> ToolPose {
        let mut pose = ToolPose {
            seq,
            t_capture_ns: ms * MS,
            ..ToolPose::EMPTY
        };
        let place = Rigid::from_rotation_vector(Vector::new(0.1, 0.2, 0.3), Vector::new(x, 0.0, 0.0)).unwrap();
        pose.set(Tracked::Valid(place));
        pose
    }

    fn is_valid(follower: &Follower, ms: i64) -> bool {
        matches!(follower.standing(ms * MS), Standing::Valid(_))
    }

    #[test]
    fn a_pose_is_valid_until_it_is_stale_and_then_says_why_it_is_none() {
        let mut follower = follower(true);
        assert_eq!(follower.standing(0), Standing::Waiting);
        follower.take(sample(0, 0, 1.0), 0);
        assert!(is_valid(&follower, 0) && is_valid(&follower, 100));
        assert_eq!(follower.standing(100 * MS + 1), Standing::Stale);
        assert_eq!(follower.standing(1000 * MS), Standing::Stale);
        assert_eq!(follower.standing(1000 * MS + 1), Standing::Lost(Lost::Silent));
    }

    #[test]
    fn every_reason_of_a_lost_pose_is_passed_on() {
        for reason in Lost::ALL {
            let mut follower = follower(true);
            let mut lost = sample(0, 0, 1.0);
            lost.set(Tracked::Lost(reason));
            follower.take(lost, 0);
            assert_eq!(follower.standing(50 * MS), Standing::Lost(reason));
            assert_eq!(follower.standing(50 * MS).why(), reason.words());
            assert_eq!(follower.standing(200 * MS), Standing::Lost(Lost::Silent));
        }
    }

    #[test]
    fn a_frozen_measurement_and_one_that_is_refused_are_no_poses() {
        let mut frozen = follower(true);
        for seq in 0..60 {
            frozen.take(sample(seq, 10 * seq as i64, 7.0), 10 * seq as i64 * MS);
        }
        assert_eq!(frozen.standing(590 * MS), Standing::Lost(Lost::Frozen));
        let mut refused = follower(true);
        refused.take(sample(3, 30, 1.0), 30 * MS);
        let mut nan = sample(4, 40, 2.0);
        nan.t_mm[1] = f64::NAN;
        let remarks = refused.take(nan, 40 * MS);
        assert!(matches!(&remarks[..], [Remark::Refused(words)] if words.contains("pose 4")));
        assert_eq!(refused.standing(40 * MS), Standing::Lost(Lost::Refused));
        let remarks = refused.take(sample(5, 10, 1.0), 50 * MS);
        assert!(matches!(&remarks[..], [Remark::Refused(words)] if words.contains("stamps must not go back")));
        assert!(!is_valid(&refused, 50));
        assert_eq!(refused.refused, 2);
        let future = refused.take(sample(6, 500, 1.0), 60 * MS);
        assert!(matches!(&future[..], [Remark::Refused(words)] if words.contains("in the future")));
        assert!(!is_valid(&refused, 60));
    }

    #[test]
    fn what_stood_still_before_a_replay_went_on_is_frozen_behind() {
        let mut follower = follower(true);
        // Where the measurement began, and the last one: both from before the place.
        for (seq, ms) in [(0, 0), (40, 400), (10, 100), (50, 500)] {
            follower.lead(sample(seq, ms, 7.0));
        }
        follower.take(sample(60, 620, 7.0), 620 * MS);
        assert_eq!(follower.standing(620 * MS), Standing::Lost(Lost::Frozen));
        follower.take(sample(61, 630, 8.0), 630 * MS);
        assert!(is_valid(&follower, 630));
    }

    #[test]
    fn another_registration_is_told() {
        let mut follower = follower(true);
        follower.take(sample(0, 0, 1.0), 0);
        let other = ToolPose {
            registration_id: 9,
            ..sample(1, 16, 2.0)
        };
        let remarks = follower.take(other, 16 * MS);
        assert_eq!(remarks, [Remark::Registration { now: 9 }]);
        assert!(is_valid(&follower, 16));
    }

    #[test]
    fn nothing_is_shown_that_the_workflow_does_not_let_be_shown() {
        let mut follower = follower(true);
        follower.take(sample(0, 0, 1.0), 0);
        for (flags, words) in [
            (0, "not ready"),
            (Workflow::BUMPED, "pushed"),
            (Workflow::CHECK_FAILED, "failed"),
            (Workflow::REJECTED, "not to be the patient's"),
        ] {
            follower.take_workflow(Workflow {
                flags,
                ..Workflow::default()
            });
            assert!(matches!(follower.standing(0), Standing::Withheld(why) if why.contains(words)));
        }
        follower.workflow = None;
        assert!(matches!(follower.standing(0), Standing::Withheld(_)));
    }
}
