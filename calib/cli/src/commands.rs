//! The commands that calibrate from recorded poses: `pivot`, `spin`, `tool`, `probe` and `lag`.

#[cfg(test)]
mod body_tests;
pub(crate) mod common;
mod pivot;
mod pivot_report;
pub(crate) mod probe;
mod spin;
#[cfg(test)]
pub(crate) mod tests;
mod told;
mod tool;

pub(crate) use common::Outcome;
pub(crate) use pivot::{PIVOT_HELP, PivotArgs};
pub(crate) use spin::{SPIN_HELP, SpinArgs};
pub(crate) use tool::{TOOL_HELP, ToolArgs};
