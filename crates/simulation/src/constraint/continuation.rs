//! How far a contact has come on its way: a barrier that narrows from search to search, then exact contact.

use super::exact::Exact;

/// The barrier narrows by this factor from search to search.
const WIDTH_FACTOR: f64 = 0.25;

/// Where a constraint stands between two searches.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// A barrier or multipliers that the next update replaces whatever is found: the search before it need not be exact.
    Provisional,
    /// A barrier that stays: it stands for contact up to its width.
    Barrier,
    /// Energy, or multipliers that tend to exact forces: it stands for what it is.
    Lasting,
    /// Rows of exact contact, whose forces are unknowns of their own.
    Exact,
}

/// The way of a contact from its first, widest barrier to exact contact.
#[derive(Debug, Clone)]
pub struct Continuation {
    /// The distance below which the barrier pushes.
    width: f64,
    last_width: f64,
    /// Exact contact takes over after the last width.
    wants_exact: bool,
    exact: Option<Exact>,
}

impl Continuation {
    /// A barrier of the first width that is to narrow to the last.
    pub(super) fn new([first, last]: [f64; 2]) -> Self {
        Self {
            width: first,
            last_width: last.min(first),
            wants_exact: false,
            exact: None,
        }
    }

    /// The distance below which the barrier pushes now.
    pub(super) fn width(&self) -> f64 {
        self.width
    }

    /// The exact contact, once it has taken over.
    pub(super) fn exact(&self) -> Option<&Exact> {
        self.exact.as_ref()
    }

    /// The same, to be changed.
    pub(super) fn exact_mut(&mut self) -> Option<&mut Exact> {
        self.exact.as_mut()
    }

    /// Asks for exact contact after the narrowest barrier, or in the place of multipliers.
    pub fn want_exact(&mut self) {
        self.wants_exact = true;
    }

    /// After exact contact that did not converge: one narrower barrier more where `again`, else this barrier for good.
    pub(crate) fn narrow(&mut self, again: bool) {
        self.wants_exact &= again;
        if again {
            self.width *= WIDTH_FACTOR;
        }
        self.last_width = self.width;
    }

    /// Where it stands, if what stays in the place of exact contact is `soft`.
    pub(super) fn stage(&self, soft: Stage) -> Stage {
        match self.exact {
            Some(_) => Stage::Exact,
            None if self.wants_exact || self.width > self.last_width => Stage::Provisional,
            None => soft,
        }
    }

    /// True where exact contact is to take over now.
    pub(super) fn is_due(&self) -> bool {
        self.wants_exact && self.exact.is_none() && self.width <= self.last_width
    }

    /// After a search: to the next narrower barrier, or to `exact` contact where that [`Self::is_due`]. True where that
    /// changes anything.
    pub(super) fn go_on(&mut self, exact: Option<Exact>) -> bool {
        let changes = self.width > self.last_width || exact.is_some();
        self.exact = exact;
        self.width = (self.width * WIDTH_FACTOR).max(self.last_width);
        changes
    }
}
