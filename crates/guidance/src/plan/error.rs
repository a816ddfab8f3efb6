//! Why a plan, or a change of it, is refused.

/// Why a plan, or a change of it, is refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PlanError {
    /// A number is none, or out of its range.
    #[error("{what}: found {found}; allowed: {least} to {most} mm")]
    Number {
        /// Which.
        what: String,
        /// Its value.
        found: f64,
        /// The least allowed.
        least: f64,
        /// The largest allowed.
        most: f64,
    },
    /// Words that cannot stand in one line, or are too long.
    #[error("{what}: found {found:?}; allowed: 1 to {most} bytes, without control characters and blanks at its ends")]
    Words {
        /// Which.
        what: &'static str,
        /// Their beginning.
        found: String,
        /// Most bytes.
        most: usize,
    },
    /// More than there may be.
    #[error("{found} {what}; at most {most} are allowed")]
    TooMany {
        /// Of what.
        what: &'static str,
        /// How many there are.
        found: usize,
        /// How many there may be.
        most: usize,
    },
    /// Two targets of one name.
    #[error("there is a target {0:?} already; give this one another name")]
    NameTaken(String),
    /// The entry lies so near to the target that the tube has no way to go.
    #[error(
        "target {name:?}: its entry is {way_mm:.2} mm from its centre; the tube needs more than {least_mm} mm to where it stops"
    )]
    NoWay {
        /// The target's name.
        name: String,
        /// From the entry to the centre, mm.
        way_mm: f64,
        /// What it must exceed, mm.
        least_mm: f64,
    },
    /// No target has this name.
    #[error("there is no target {name:?}; {}", there_are(.names))]
    NoTarget {
        /// The name that was asked for.
        name: String,
        /// Those that there are.
        names: Vec<String>,
    },
    /// No measure has this place.
    #[error("there is no measure {place}; there are {count}")]
    NoMeasure {
        /// The place that was asked for, from 1.
        place: usize,
        /// How many there are.
        count: usize,
    },
    /// A person has confirmed the plan.
    #[error("the plan was confirmed by {by} at {at} and is read-only: change a copy of it")]
    Confirmed {
        /// Who confirmed it.
        by: String,
        /// When.
        at: String,
    },
    /// There is nothing to be confirmed.
    #[error("the plan has no target: there is nothing to confirm")]
    NothingToConfirm,
    /// Nothing was changed.
    #[error("there is no change to take back")]
    NothingToUndo,
    /// Nothing was taken back.
    #[error("there is no change to make again")]
    NothingToRedo,
}

fn there_are(names: &[String]) -> String {
    match names.is_empty() {
        true => "the plan has none".to_owned(),
        false => format!("there are {}", names.join(", ")),
    }
}
