//! How far a contact has come on its way: a barrier that narrows from search to search, then exact contact.

use super::exact::Exact;
use super::{Active, Change};
use crate::bodies::Bodies;

/// The barrier narrows by this factor from search to search.
const NARROWER: f64 = 0.25;

/// Where a contact stands between its first, widest barrier and exact contact.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Stage {
    /// The distance below which the barrier pushes.
    pub(super) width: f64,
    last_width: f64,
    /// Exact contact takes over after the last width.
    polish: bool,
    /// The exact contact, once it has.
    pub(super) exact: Option<Exact>,
}

impl Stage {
    /// A barrier of the first width that is to narrow to the last.
    pub(super) fn new([first, last]: [f64; 2]) -> Self {
        Self {
            width: first,
            last_width: last.min(first),
            polish: false,
            exact: None,
        }
    }

    /// Wants exact contact after the last width.
    pub(super) fn polish(&mut self) {
        self.polish = true;
    }

    /// True where exact contact is to take over now.
    pub(super) fn due(&self) -> bool {
        self.polish && self.exact.is_none() && self.width <= self.last_width
    }

    /// After a search: the next narrower barrier, or `exact` contact where that is [`Self::due`].
    pub(super) fn update(&mut self, bodies: &Bodies, a: &[f64], exact: Option<Exact>) -> Change {
        if let Some(exact) = &mut self.exact {
            return exact.update(bodies, a);
        }
        let again = self.width > self.last_width || exact.is_some();
        self.exact = exact;
        self.width = (self.width * NARROWER).max(self.last_width);
        Change {
            again,
            ..Change::default()
        }
    }

    /// See [`super::Term::provisional`].
    pub(super) fn provisional(&self) -> bool {
        self.exact.is_none() && (self.polish || self.width > self.last_width)
    }

    /// See [`super::Term::narrow`].
    pub(super) fn narrow(&mut self, again: bool) {
        self.polish &= again;
        if again {
            self.width *= NARROWER;
        }
        self.last_width = self.width;
    }

    /// The rows of the exact contact.
    pub(super) fn active(&mut self) -> Option<&mut dyn Active> {
        self.exact.as_mut().map(|exact| exact as &mut dyn Active)
    }
}
