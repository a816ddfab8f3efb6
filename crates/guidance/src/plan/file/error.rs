//! Why the text of a plan is refused.

use super::super::PlanError;
use super::MAX_BYTES;

/// Why the text of a plan is refused.
#[derive(Debug, thiserror::Error)]
pub enum FileError {
    /// Longer than any plan.
    #[error("{bytes} bytes; a plan has at most {MAX_BYTES}")]
    TooLong {
        /// Its length.
        bytes: usize,
    },
    /// No JSON, or not with the keys of a plan.
    #[error("{0}")]
    Json(#[from] serde_json::Error),
    /// Another kind of file, or one of a later version.
    #[error("found format {found}; expected format \"trocar-plan\", version 1. {}", advice(*.is_newer))]
    OtherVersion {
        /// What it says of itself.
        found: String,
        /// Whether its version is a later one.
        is_newer: bool,
    },
    /// In other units or axes.
    #[error("found frame {found:?}; expected \"ct, LPS, mm\"")]
    OtherFrame {
        /// What it says.
        found: String,
    },
    /// Its content has another id than it states.
    #[error(
        "it states the id {stated}, and its content has {found}: it was changed by other means than `pilot plan`, which checks what is \
         changed. Look at every number of it, and take it with --accept-changes; it is then no plan that anybody confirmed"
    )]
    OtherContent {
        /// What it states.
        stated: String,
        /// What its content has.
        found: String,
    },
    /// A hash that is none.
    #[error("key volume.hash: found {found:?}; expected 64 hexadecimal digits")]
    Hash {
        /// What stands there.
        found: String,
    },
    /// A measure of another number of points.
    #[error("key measures.{place}.ct_mm: found {found} points; expected {expected}")]
    Points {
        /// Which, from 0.
        place: usize,
        /// How many there are.
        found: usize,
        /// How many there must be.
        expected: usize,
    },
    /// Part of it is outside its domain.
    #[error(transparent)]
    Plan(#[from] PlanError),
}

const fn advice(is_newer: bool) -> &'static str {
    match is_newer {
        true => "It was written by a later Trocar: read it with that one",
        false => "Give a plan that `pilot plan` wrote",
    }
}

/// What is quoted stays short, whatever a file holds.
pub(super) fn quoted(text: &str) -> String {
    text.chars().take(64).collect()
}
