//! The numbers of a stratum.

use std::collections::{BTreeMap, BTreeSet};

use crate::record::{Ended, Reasons, Row};
use crate::statistics::{CHI_SQUARE_95, Estimate, LEVEL, mean, nees_bounds, quantile, rms, share};
use crate::truth::LINKS;

/// Errors that shares are told of, mm.
pub const WITHIN_MM: [f64; 3] = [1.0, 2.0, 5.0];

/// What a step refused.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Refusals {
    /// Lines.
    pub lines: usize,
    /// Those that were right, and those that were not.
    pub judged: [usize; 2],
    /// Of those that are known the true errors, sorted, and the radii that were predicted of them, mm.
    pub known_mm: [Vec<f64>; 2],
}

/// The numbers of a stratum.
#[derive(Debug, Clone, PartialEq)]
pub struct Summary {
    /// Its name.
    pub name: String,
    /// Operations that were done.
    pub operations: usize,
    /// Of those at least one target was approached.
    pub approached: usize,
    /// Lines, and those that arrived, were given up and refused.
    pub lines: [usize; 4],
    /// True errors at the targets of what was approached, mm, sorted.
    pub errors_mm: Vec<f64>,
    /// Their median, and what 95 of 100 do not exceed.
    pub tre_mm: [Estimate; 2],
    /// Shares within [`WITHIN_MM`].
    pub within: [Estimate; 3],
    /// Median of the predicted radius.
    pub predicted_mm: f64,
    /// Share within the predicted radius of 95 %.
    pub covered: Estimate,
    /// Share within the ellipsoid of 95 %.
    pub in_ellipsoid: Estimate,
    /// Mean of the normalised error, and where it lies in 95 of 100 cases if the covariances are right.
    pub nees: (f64, [f64; 2]),
    /// From the true tip to the target: median and 95 of 100, mm.
    pub miss_mm: [Estimate; 2],
    /// Lines that arrived with the true tip outside of the target: ON TARGET was false.
    pub false_arrivals: usize,
    /// Median time to the target, s.
    pub time_s: Estimate,
    /// Pictures that were looked at, also on ways of which no error is known.
    pub pictures: u64,
    /// Share of them without a pose.
    pub lost: f64,
    /// How many were without one, by reason.
    pub reasons: Reasons,
    /// Root mean square of what each link has made of the error, and of its own prediction, mm.
    pub links: [[f64; 2]; LINKS.len()],
    /// Refusals by step.
    pub refusals: BTreeMap<String, Refusals>,
    /// Operations whose marker was moved before the check and passed it all the same, and all that were moved before it.
    pub missed: [usize; 2],
}

impl Summary {
    /// Of a stratum's lines; its targets have this radius, mm.
    pub fn of(name: &str, rows: &[&Row], radius_mm: f64) -> Self {
        let known: Vec<&Row> = rows
            .iter()
            .filter(|row| row.ended != Ended::Refused && row.is_within().is_some())
            .copied()
            .collect();
        let operations = |rows: &[&Row]| rows.iter().map(|row| row.number).collect::<BTreeSet<_>>().len();
        let ended = |which: Ended| rows.iter().filter(|row| row.ended == which).count();
        let n = operations(&known) as f64;
        let sorted = |of: &dyn Fn(&Row) -> f64| {
            let mut values: Vec<f64> = known.iter().map(|row| of(row)).collect();
            values.sort_by(f64::total_cmp);
            values
        };
        let part = |is: &dyn Fn(&Row) -> bool| {
            let count = known.iter().filter(|row| is(row)).count();
            share(count as f64 / known.len() as f64, n)
        };
        let (errors_mm, misses, times) = (
            sorted(&|row| row.tre_mm),
            sorted(&|row| row.miss_mm),
            sorted(&|row| row.time_s),
        );
        let ends = |values: &[f64]| [0.5, LEVEL].map(|p| quantile(values, p, n));
        let [pictures, lost] = [0, 1].map(|which| rows.iter().map(|row| row.pictures[which]).sum::<u64>());
        let of_reason = |at: usize| rows.iter().filter_map(|row| row.reasons.get(at)).sum();
        Self {
            name: name.to_owned(),
            operations: operations(rows),
            approached: operations(&known),
            lines: [
                rows.len(),
                ended(Ended::Arrived),
                ended(Ended::GivenUp),
                ended(Ended::Refused),
            ],
            tre_mm: ends(&errors_mm),
            within: WITHIN_MM.map(|mm| part(&|row| row.tre_mm <= mm)),
            predicted_mm: quantile(&sorted(&|row| row.predicted_mm), 0.5, n).found,
            covered: part(&|row| row.is_within() == Some(true)),
            in_ellipsoid: part(&|row| row.nees <= CHI_SQUARE_95),
            nees: (mean(known.iter().map(|row| row.nees)), nees_bounds(n)),
            miss_mm: ends(&misses),
            false_arrivals: rows
                .iter()
                .filter(|row| row.ended == Ended::Arrived && row.miss_mm > radius_mm)
                .count(),
            time_s: quantile(&times, 0.5, n),
            pictures,
            lost: lost as f64 / pictures as f64,
            reasons: std::array::from_fn(of_reason),
            links: std::array::from_fn(|link| [0, 1].map(|which| rms(known.iter().map(|row| row.links[link][which])))),
            refusals: refusals(rows),
            missed: missed(rows),
            errors_mm,
        }
    }

    /// Whether the prediction keeps its word as far as this many operations can tell: neither the interval of the share within the ball
    /// nor that within the ellipsoid ends below 95 %, and errors are not larger than the covariance (NEES). The ball alone is too wide
    /// to tell. `None` where nothing was predicted.
    pub fn keeps_its_word(&self) -> Option<bool> {
        let shares = [self.covered, self.in_ellipsoid];
        let holds = shares.iter().all(|share| share.interval[1] >= LEVEL);
        (self.approached > 0).then_some(holds && self.nees.0 <= self.nees.1[1])
    }
}

fn refusals(rows: &[&Row]) -> BTreeMap<String, Refusals> {
    let mut all: BTreeMap<String, Refusals> = BTreeMap::new();
    for row in rows.iter().filter(|row| row.ended == Ended::Refused) {
        let of = all.entry(row.step.clone()).or_default();
        of.lines += 1;
        match row.right {
            Some(true) => of.judged[0] += 1,
            Some(false) => of.judged[1] += 1,
            None => {}
        }
        if row.is_within().is_some() {
            for (all, mm) in of.known_mm.iter_mut().zip([row.tre_mm, row.predicted_mm]) {
                all.push(mm);
            }
        }
    }
    for mm in all.values_mut().flat_map(|of| &mut of.known_mm) {
        mm.sort_by(f64::total_cmp);
    }
    all
}

fn missed(rows: &[&Row]) -> [usize; 2] {
    let moved = || rows.iter().filter(|row| row.bump == "before");
    let of = |rows: &mut dyn Iterator<Item = &&Row>| rows.map(|row| row.number).collect::<BTreeSet<_>>().len();
    [
        of(&mut moved().filter(|row| row.ended != Ended::Refused)),
        of(&mut moved()),
    ]
}

#[cfg(test)]
mod tests;
