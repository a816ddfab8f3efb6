//! How far a contact has come on its way: a barrier that acts over less and less distance from search to search, then exact
//! contact.

use super::exact::Exact;

/// The activation distance changes by this factor from search to search.
const DISTANCE_FACTOR: f64 = 0.25;

/// Where a constraint stands between two searches.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// A barrier or multipliers that the next update replaces whatever is found: the search before it need not be exact.
    Provisional,
    /// A barrier that no update replaces any more: its error is its activation distance.
    FinalBarrier,
    /// Neither a barrier nor replaced: an energy, or multipliers that updates bring to the exact forces.
    Final,
    /// Rows of exact contact, whose forces are unknowns of their own.
    Exact,
}

/// The way of a contact from its first, widest barrier to exact contact.
#[derive(Debug, Clone)]
pub struct Continuation {
    /// The distance below which the barrier pushes: its width. Contacts with multipliers push without it; their exact contact
    /// looks for rows within twice of it.
    activation_distance: f64,
    /// The least that it is narrowed to.
    final_distance: f64,
    /// Exact contact takes over after the barrier of the final distance.
    wants_exact: bool,
    exact: Option<Exact>,
}

impl Continuation {
    /// A barrier of the first activation distance that is to narrow to the last.
    pub(super) fn new([first, last]: [f64; 2]) -> Self {
        Self {
            activation_distance: first,
            final_distance: last.min(first),
            wants_exact: false,
            exact: None,
        }
    }

    /// The distance below which the barrier pushes now.
    pub(super) fn activation_distance(&self) -> f64 {
        self.activation_distance
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

    /// After exact contact that did not converge, with the contact as it was before: one narrower barrier and then exact
    /// contact once more where `retry_exact`, else this barrier for good.
    pub(crate) fn narrow(&mut self, retry_exact: bool) {
        self.wants_exact &= retry_exact;
        if retry_exact {
            self.activation_distance *= DISTANCE_FACTOR;
        }
        self.final_distance = self.activation_distance;
    }

    /// Where it stands; `stage_without_exact` is the last stage of a contact that exact contact never takes over from.
    pub(super) fn stage(&self, stage_without_exact: Stage) -> Stage {
        match self.exact {
            Some(_) => Stage::Exact,
            None if self.wants_exact || self.activation_distance > self.final_distance => Stage::Provisional,
            None => stage_without_exact,
        }
    }

    /// True where exact contact is to take over now.
    pub(super) fn is_due(&self) -> bool {
        self.wants_exact && self.exact.is_none() && self.activation_distance <= self.final_distance
    }

    /// After a search: to the next narrower barrier, or to `exact` contact where that [`Self::is_due`]. True where that
    /// changes anything.
    ///
    /// Not to be called once exact contact has taken over: `None` would end it. `Contact`'s `update` then updates the exact
    /// contact and returns before it comes here.
    pub(super) fn advance(&mut self, exact: Option<Exact>) -> bool {
        let changes = self.activation_distance > self.final_distance || exact.is_some();
        self.exact = exact;
        self.activation_distance = (self.activation_distance * DISTANCE_FACTOR).max(self.final_distance);
        changes
    }
}
