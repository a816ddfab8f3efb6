//! What a task is done under.

use crate::errors::Errors;
use crate::human::Human;

/// What a task is done under.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Conditions {
    /// The operator.
    pub human: Human,
    /// What poses are off by.
    pub errors: Errors,
    /// From the capture of a pose to the glass, without the added lag, s. The window's 99 of 100 pictures are younger
    /// than 0.05 (`docs/window.md`).
    pub delay_s: f64,
    /// Added to it, s.
    pub lag_s: f64,
    /// When the task is given up, s.
    pub limit_s: f64,
}

impl Default for Conditions {
    fn default() -> Self {
        Self {
            human: Human::default(),
            errors: Errors::noisy(0.3),
            delay_s: 0.05,
            lag_s: 0.0,
            limit_s: 120.0,
        }
    }
}
