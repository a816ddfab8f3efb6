//! What may be done at each stage.

use super::state::{Stage, State};

/// What somebody wants to do.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Activity {
    /// Scroll through slices that do not follow the tool.
    LookAtSlices,
    /// Touch points of the patient with a tool.
    TouchPoints,
    /// See images that follow the tool, without a sight.
    LiveImages,
    /// See sight, digits and verdict.
    Sight,
    /// Change targets, entry or stop distance.
    ChangePlan,
}

/// What has to stand on what is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Mark {
    /// The images do not follow the tool.
    NotFollowing,
    /// No check was passed.
    NotChecked,
    /// The navigation was not started.
    NotStarted,
}

impl Mark {
    /// As a person reads it.
    pub const fn word(self) -> &'static str {
        match self {
            Self::NotFollowing => "NOT FOLLOWING",
            Self::NotChecked => "NOT CHECKED",
            Self::NotStarted => "NOT STARTED",
        }
    }
}

/// Whether something may be done.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum May {
    /// No.
    No,
    /// Yes.
    Yes,
    /// Yes, with this mark on it.
    Marked(Mark),
    /// After a person has been asked.
    Asks,
    /// After a person has been asked, and the run goes back to REGISTERED.
    AsksAndGoesBack,
}

use May::{Asks, AsksAndGoesBack, Marked, No, Yes};

/// What may be done, a column a stage in the order of [`Stage::ALL`]. In NAVIGATING images follow the tool as part of the sight.
pub const MAY: [(Activity, [May; 7]); 5] = [
    (
        Activity::LookAtSlices,
        [No, Yes, Yes, Yes, Yes, Yes, Marked(Mark::NotFollowing)],
    ),
    (Activity::TouchPoints, [No, No, No, Yes, Yes, Yes, No]),
    (
        Activity::LiveImages,
        [No, No, No, No, Marked(Mark::NotChecked), Marked(Mark::NotStarted), No],
    ),
    (Activity::Sight, [No, No, No, No, No, No, Yes]),
    (Activity::ChangePlan, [No, Yes, Yes, Yes, Asks, AsksAndGoesBack, No]),
];

/// Whether `activity` may be done now: [`MAY`], but no sight without the tool, and none unmarked without a check.
pub fn may(state: &State, activity: Activity) -> May {
    let column = Stage::ALL.iter().position(|stage| *stage == state.stage());
    let row = MAY.iter().find(|(of, _)| *of == activity);
    let Some(may) = row.zip(column).map(|((_, row), column)| row[column]) else {
        return No;
    };
    match activity {
        Activity::Sight if !state.shows_sight() => No,
        Activity::Sight if state.skipped().check => Marked(Mark::NotChecked),
        _ => may,
    }
}
