//! Which solids keep out of which.

use std::collections::BTreeSet;

/// Pairs of solids that keep out of one another.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Meeting {
    /// Solids that keep out of themselves.
    pub(super) own: BTreeSet<usize>,
    /// The pairs of two solids, the lower number first; all where it is `None`.
    pub(super) only: Option<BTreeSet<[usize; 2]>>,
}

impl Meeting {
    /// True where these two, or one with itself, keep apart.
    pub(super) fn of(&self, first: usize, second: usize) -> bool {
        if first == second {
            return self.own.contains(&first);
        }
        let pair = [first.min(second), first.max(second)];
        self.only.as_ref().is_none_or(|only| only.contains(&pair))
    }

    /// Leaves these pairs alone; a solid with itself keeps out of itself.
    pub(super) fn among(pairs: &[[usize; 2]]) -> Self {
        let own = pairs.iter().filter(|[i, j]| i == j);
        let only = pairs.iter().filter(|[i, j]| i != j);
        Self {
            own: own.map(|[i, _]| *i).collect(),
            only: Some(only.map(|[i, j]| [*i.min(j), *i.max(j)]).collect()),
        }
    }
}
