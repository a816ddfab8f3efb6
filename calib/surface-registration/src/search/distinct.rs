//! Which ends of fits are one minimum.

use crate::search::Minimum;
use crate::solve::{Ended, State, apart_mm};

/// The distinct ones in the order of their cost, each with the number of those that are the same.
pub(crate) fn distinct(ends: Vec<(f64, State)>, radius_mm: f64, within_mm: f64) -> Vec<(f64, State, usize)> {
    merged(
        ends.into_iter().map(|(cost, state)| (cost, state, 1)).collect(),
        radius_mm,
        within_mm,
    )
}

pub(super) fn merged(mut ends: Vec<(f64, State, usize)>, radius_mm: f64, within_mm: f64) -> Vec<(f64, State, usize)> {
    ends.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut kept: Vec<(f64, State, usize)> = Vec::new();
    for (cost, state, hits) in ends {
        match kept.iter_mut().find(|k| apart_mm(&k.1, &state, radius_mm) < within_mm) {
            Some(same) => same.2 += hits,
            None => kept.push((cost, state, hits)),
        }
    }
    kept
}

pub(super) fn ends(mut ends: Vec<(f64, Ended, usize)>, radius_mm: f64, within_mm: f64) -> Vec<Minimum> {
    ends.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut kept: Vec<Minimum> = Vec::new();
    for (_, ended, hits) in ends {
        let same = kept
            .iter_mut()
            .find(|k| apart_mm(&k.ended.state, &ended.state, radius_mm) < within_mm);
        match same {
            Some(same) => same.hits += hits,
            None => kept.push(Minimum { ended, hits }),
        }
    }
    kept
}
