//! What a refusal of a right pose means: whether what the points were told to be holds, and which limits refused it.

use std::collections::BTreeMap;

use geometry::{Ct, Point};
use surface_registration::{Limits, Priors, Refusal, Surface};

use super::common::draw::{Drawn, bound_mm};

/// What is true of a run.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) enum Kind {
    /// All that was told holds, and the points hold the pose: a refusal is one too many.
    Holds,
    /// What was told holds, and the points do not hold the pose, or hold it by fewer than the verdict asks for: a refusal is right.
    Weak,
    /// Something that was told is false: a refusal is right, where the pose happens to be near too.
    Broken,
}

pub(crate) const KINDS: [(Kind, &str); 3] = [
    (Kind::Holds, "premises hold"),
    (Kind::Weak, "too weak by geometry or by shares"),
    (Kind::Broken, "something told is false"),
];

impl Kind {
    /// The kind of a run of a row of this one, by its truth alone: nothing of what was found is asked, or a limit could excuse itself.
    pub(crate) fn of_run(
        self,
        surface: &Surface<Ct>,
        drawn: &Drawn,
        is_beyond: impl Fn(&Point<Ct>) -> bool,
        targets: &[Point<Ct>],
        priors: &Priors,
    ) -> Self {
        if self != Self::Holds {
            return self;
        }
        let limits = Limits::default();
        let beyond: Vec<bool> = drawn.exact.iter().map(is_beyond).collect();
        let is_good: Vec<bool> = drawn
            .is_outlier
            .iter()
            .zip(&beyond)
            .map(|(out, beyond)| !out && !beyond)
            .collect();
        let [all, known, good] = [
            beyond.len(),
            beyond.iter().filter(|b| !**b).count(),
            is_good.iter().filter(|g| **g).count(),
        ]
        .map(|count| count as f64);
        let has_points =
            1.0 - known / all <= limits.most_beyond && good >= limits.least_share * known && good >= limits.least_kept;
        let own = Drawn {
            points: drawn.points.clone(),
            is_outlier: is_good.iter().map(|good| !good).collect(),
            ct_from_tracker: drawn.ct_from_tracker,
            exact: drawn.exact.clone(),
        };
        let is_held = || {
            targets
                .iter()
                .all(|target| bound_mm(surface, &own, &[*target], priors) <= limits.most_tre_mm)
        };
        if has_points && is_held() {
            Self::Holds
        } else {
            Self::Weak
        }
    }
}

/// What is counted of the right ones of one kind.
#[derive(Default, Clone)]
pub(crate) struct OfKind {
    pub(crate) right: usize,
    pub(crate) refused: usize,
    /// Wrong by 4 mm and more, and not refused.
    pub(crate) silent: usize,
    /// How often each limit spoke; of one run more than one may.
    gates: BTreeMap<&'static str, usize>,
}

impl OfKind {
    pub(crate) fn right(&mut self, refusals: &[Refusal]) {
        self.right += 1;
        let mut gates: Vec<&str> = refusals.iter().map(gate).filter(|gate| !gate.is_empty()).collect();
        gates.sort_unstable();
        gates.dedup();
        self.refused += usize::from(!gates.is_empty());
        for gate in gates {
            *self.gates.entry(gate).or_default() += 1;
        }
    }

    pub(crate) fn add(&mut self, other: &Self) {
        self.right += other.right;
        self.refused += other.refused;
        self.silent += other.silent;
        for (gate, count) in &other.gates {
            *self.gates.entry(gate).or_default() += count;
        }
    }

    /// The limits that spoke, with how often.
    pub(crate) fn words(&self) -> String {
        let each: Vec<String> = self
            .gates
            .iter()
            .map(|(gate, count)| format!("{gate} {count}"))
            .collect();
        each.join(", ")
    }
}

/// The name of a limit; empty for what is no limit of what was found.
fn gate(refusal: &Refusal) -> &'static str {
    match refusal {
        Refusal::NotSearched => "",
        Refusal::NotSettled => "not settled",
        Refusal::Noise { .. } => "noise",
        Refusal::Quiet { .. } => "quiet",
        Refusal::Margin { .. } => "margin",
        Refusal::Share { .. } => "share",
        Refusal::Kept { .. } => "points",
        Refusal::FacingAway { .. } => "facing away",
        Refusal::Beyond { .. } => "beyond",
        Refusal::Tre { .. } | Refusal::Free(_) => "TRE",
        Refusal::GrossError { .. } => "gross error",
        Refusal::Hits { .. } => "fits",
        Refusal::Landmarks { .. } => "landmarks",
        Refusal::Tail(_) => "tail",
        Refusal::Prior { .. } => "priors",
        Refusal::Moved { .. } => "moved",
        Refusal::Drifted { .. } => "drifted",
        Refusal::OneSided { .. } => "one-sided",
        Refusal::SecondSurface(_) => "second surface",
    }
}

/// Rows of the table of limits: where right ones were refused.
#[derive(Default)]
pub(crate) struct Gates(Vec<String>);

impl Gates {
    pub(crate) fn row(&mut self, name: &str, kinds: &[OfKind; 3]) {
        for (own, (_, words)) in kinds.iter().zip(KINDS).filter(|(own, _)| own.refused > 0) {
            self.0.push(format!(
                "| {name} | {words} | {} of {} | {} |",
                own.refused,
                own.right,
                own.words()
            ));
        }
    }

    pub(crate) fn text(&self) -> String {
        format!(
            "| right and refused | | | by which limits |\n|---|---|---|---|\n{}",
            self.0.join("\n")
        )
    }
}
