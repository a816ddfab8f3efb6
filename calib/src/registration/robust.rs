//! Registration where some pairs are wrong.

use geometry::Frame;

use super::clique::Graph;
use super::{Method, Pairs, Refused, Registration, register};

/// Branches of the search for consistent pairs; 24 pairs take some hundreds, 500 some ten thousands.
const MAX_STEPS: usize = 2_000_000;
/// Rounds of fitting and choosing again.
const MAX_ROUNDS: usize = 20;

/// A registration of the pairs that agree, and which these are.
#[derive(Debug, Clone)]
pub struct Robust<To: Frame, From: Frame> {
    /// The registration by the inliers alone; residuals are given for all pairs.
    pub registration: Registration<To, From>,
    /// For each pair, whether its distance after registration is within the tolerance.
    pub inliers: Vec<bool>,
}

/// Registers the largest set of pairs that agree within `tolerance_mm`.
///
/// Two pairs agree where their distance is the same in both frames within twice the tolerance: no transform need be
/// known. The largest set in which all agree is found exactly, by branch and bound, so that there is no start and no
/// chance in it; then pairs are admitted by their residual until nothing changes. Needs at least `needed` (3 or more)
/// inliers: with more wrong pairs than right ones, ask for one or two above what chance provides, 5 for a tolerance of
/// 1 % of the size.
///
/// Weights count in the fit, not in the choice. Some hundred pairs at most: all distances are compared.
///
/// # Errors
/// [`Refused::NoConsensus`], [`Refused::SearchTooLong`], and those of [`super::fit`] for the inliers.
pub fn register_robust<To: Frame, From: Frame>(
    pairs: Pairs<'_, To, From>,
    method: Method,
    tolerance_mm: f64,
    needed: usize,
) -> Result<Robust<To, From>, Refused> {
    pairs.check()?;
    let needed = needed.max(3);
    let refuse = |found: usize| Refused::NoConsensus {
        found,
        pairs: pairs.len(),
        needed,
        tolerance_mm,
    };
    let clique = consistent(pairs, tolerance_mm)?;
    if clique.len() < needed {
        return Err(refuse(clique.len()));
    }
    let mut inliers = vec![false; pairs.len()];
    clique.iter().for_each(|&i| inliers[i] = true);
    // Pairs that agree by distances may fit by residuals as well, and the other way round: until nothing changes.
    for _ in 0..MAX_ROUNDS {
        let registration = chosen(pairs, method, &inliers)?;
        let next: Vec<bool> = registration.fre_mm.iter().map(|r| *r <= tolerance_mm).collect();
        let found = next.iter().filter(|x| **x).count();
        if found < needed {
            return Err(refuse(found));
        }
        if next == inliers {
            return Ok(Robust { registration, inliers });
        }
        inliers = next;
    }
    // Two sets may lead to one another for ever, because of a residual that lies at the tolerance.
    Err(Refused::NoConvergence {
        steps: MAX_ROUNDS,
        last: 1.0,
    })
}

/// The largest set of pairs whose mutual distances agree.
fn consistent<To, From>(pairs: Pairs<'_, To, From>, tolerance_mm: f64) -> Result<Vec<usize>, Refused> {
    let agree = |i: usize, j: usize| {
        let there = pairs.to[i].distance(pairs.to[j]);
        let here = pairs.from[i].distance(pairs.from[j]);
        // Triangle inequality: two pairs within the tolerance after any registration pass, so no inlier is lost here.
        // NaN as a tolerance joins no pairs, and ends in `NoConsensus`.
        (there - here).abs() <= 2.0 * tolerance_mm
    };
    let graph = Graph::new(pairs.len(), agree);
    graph.largest_clique(MAX_STEPS).map_err(|steps| Refused::SearchTooLong {
        pairs: pairs.len(),
        steps,
    })
}

fn chosen<To: Frame, From: Frame>(
    pairs: Pairs<'_, To, From>,
    method: Method,
    inliers: &[bool],
) -> Result<Registration<To, From>, Refused> {
    // Weight zero instead of a shorter list, so that indices and residuals are those of all pairs.
    let weight = |(i, chosen): (usize, &bool)| if *chosen { pairs.weight(i) } else { 0.0 };
    let weights: Vec<f64> = inliers.iter().enumerate().map(weight).collect();
    register(Pairs::new(pairs.to, pairs.from)?.weighted(&weights)?, method)
}
