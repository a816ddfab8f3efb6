//! The search: touched points one after another, each tried on every bead that agrees with those before.

use geometry::{Ct, Frame, Point, Rigid};

use super::deviations::Deviations;
use super::{Pairing, Refused};
use calib::registration::{Method, Pairs, chi_squared, fit, greatest_chi_squared};

/// Branches before the search is given up: a second or two.
const MAX_STEPS: usize = 1_000_000;
/// Solutions that are kept for the question whether they agree.
const MAX_SOLUTIONS: usize = 4096;

/// A set of pairs that the errors explain.
#[derive(Debug, Clone)]
pub(super) struct Solution<F: Frame> {
    /// The bead of each touched point.
    pub(super) bead_of: Vec<Option<usize>>,
    pub(super) count: usize,
    pub(super) chi_squared: f64,
    pub(super) fre_rms_mm: f64,
    pub(super) transform: Rigid<Ct, F>,
}

impl<F: Frame> Solution<F> {
    /// (bead, touched point), in the order of the touched points.
    pub(super) fn pairs(&self) -> impl Iterator<Item = (usize, usize)> {
        let pair = |(j, bead): (usize, &Option<usize>)| bead.map(|i| (i, j));
        self.bead_of.iter().enumerate().filter_map(pair)
    }

    pub(super) fn pairing(&self) -> Pairing {
        Pairing {
            pairs: self.pairs().map(|(i, j)| (j, i)).collect(),
            fre_rms_mm: self.fre_rms_mm,
        }
    }
}

/// Degrees of freedom of the residuals of `n` pairs: `3 n - 6`.
pub(super) fn freedom(n: usize) -> u32 {
    u32::try_from(3 * n).map_or(u32::MAX, |all| all.saturating_sub(6))
}

/// The greatest `sum |r|^2 / sigma^2` of `n` pairs that the errors explain.
pub(super) fn most(n: usize) -> f64 {
    greatest_chi_squared(freedom(n))
}

/// All the largest sets of pairs that the errors explain, the one of the least residuals first, and the steps it took.
pub(super) fn solutions<F: Frame>(
    beads: &[Point<Ct>],
    touched: &[Point<F>],
    sigmas: &Deviations,
) -> Result<(Vec<Solution<F>>, usize), Refused> {
    let mut search = Search {
        beads,
        touched,
        sigmas,
        order: far_apart(touched),
        bead_of: vec![None; touched.len()],
        used: vec![false; beads.len()],
        count: 0,
        best: Vec::new(),
        most: 3,
        steps: 0,
    };
    search.expand(0);
    if search.steps > MAX_STEPS || search.best.len() >= MAX_SOLUTIONS {
        return Err(Refused::SearchTooLong { steps: search.steps });
    }
    let mut best = search.best;
    best.sort_by(|a, b| a.chi_squared.total_cmp(&b.chi_squared));
    Ok((best, search.steps))
}

/// The touched points in an order in which each lies as far as possible from those before: long distances tell most.
fn far_apart<F: Frame>(points: &[Point<F>]) -> Vec<usize> {
    let mut order: Vec<usize> = Vec::new();
    let centre = |i: usize| points.iter().map(|q| q.distance(points[i])).sum::<f64>();
    let nearest = |i: usize, order: &[usize]| {
        let distances = order.iter().map(|j| points[i].distance(points[*j]));
        distances.fold(f64::INFINITY, f64::min)
    };
    while order.len() < points.len() {
        let rest = (0..points.len()).filter(|i| !order.contains(i));
        let value = |i: &usize| {
            if order.is_empty() {
                centre(*i)
            } else {
                nearest(*i, &order)
            }
        };
        let Some(next) = rest.max_by(|a, b| value(a).total_cmp(&value(b))) else {
            break;
        };
        order.push(next);
    }
    order
}

struct Search<'a, F: Frame> {
    beads: &'a [Point<Ct>],
    touched: &'a [Point<F>],
    sigmas: &'a Deviations,
    order: Vec<usize>,
    bead_of: Vec<Option<usize>>,
    used: Vec<bool>,
    count: usize,
    /// Of `most` pairs each.
    best: Vec<Solution<F>>,
    most: usize,
    steps: usize,
}

impl<F: Frame> Search<'_, F> {
    fn expand(&mut self, depth: usize) {
        self.steps += 1;
        let left = self.order.len() - depth;
        let given_up = self.steps > MAX_STEPS || self.best.len() >= MAX_SOLUTIONS;
        // Sets as large as the best are looked at as well: one of them may lay the patient elsewhere.
        if given_up || self.count + left < self.most {
            return;
        }
        if left == 0 {
            self.keep();
            return;
        }
        let point = self.order[depth];
        for bead in 0..self.beads.len() {
            if self.used[bead] || !self.agrees(bead, point, depth) {
                continue;
            }
            self.assign(point, Some(bead));
            // Triangles of the same sides can always be laid on each other; only a fourth point can be a mirror
            // image's.
            if self.count < 4 || !self.contradicted() {
                self.expand(depth + 1);
            }
            self.assign(point, None);
        }
        // On no bead.
        self.expand(depth + 1);
    }

    fn assign(&mut self, point: usize, bead: Option<usize>) {
        if let Some(before) = std::mem::replace(&mut self.bead_of[point], bead) {
            self.used[before] = false;
            self.count -= 1;
        }
        if let Some(bead) = bead {
            self.used[bead] = true;
            self.count += 1;
        }
    }

    /// Whether a pair's distances to all pairs so far are the same in both frames.
    fn agrees(&self, bead: usize, point: usize, depth: usize) -> bool {
        self.order[..depth].iter().all(|&other| {
            self.bead_of[other].is_none_or(|other_bead| {
                let there = self.beads[bead].distance(self.beads[other_bead]);
                let here = self.touched[point].distance(self.touched[other]);
                (there - here).abs() <= self.sigmas.distance_mm(point, other)
            })
        })
    }

    /// The registration of the pairs so far and its `sum |r|^2 / sigma^2`; `None` while they lie on a line.
    fn registered(&self) -> Option<Solution<F>> {
        let paired = self
            .bead_of
            .iter()
            .enumerate()
            .filter_map(|(j, bead)| bead.map(|i| (i, j)));
        let (to, from): (Vec<_>, Vec<_>) = paired.map(|(i, j)| (self.beads[i], self.touched[j])).unzip();
        let pairs = Pairs::new(&to, &from).ok()?;
        let fitted = fit(pairs, Method::default()).ok()?;
        let fre_rms_mm = fitted.fre_rms_mm(pairs);
        let touches = self
            .bead_of
            .iter()
            .enumerate()
            .filter_map(|(j, bead)| bead.and(Some(j)));
        // By directions, and with what all share: by one length an error that is common to all would count as their disagreement.
        let chi_squared = match self.sigmas.of_pairs(touches) {
            Some(errors) => chi_squared(&fitted, pairs, &errors)?,
            None => self.count as f64 * (fre_rms_mm / self.sigmas.noise(None).sigma_mm).powi(2),
        };
        Some(Solution {
            bead_of: self.bead_of.clone(),
            count: self.count,
            chi_squared,
            fre_rms_mm,
            transform: fitted.transform,
        })
    }

    /// Whether the residuals are more than the errors explain, as those of a mirror image are.
    fn contradicted(&self) -> bool {
        let more = |solution: Solution<F>| solution.chi_squared > most(solution.count);
        self.registered().is_some_and(more)
    }

    fn keep(&mut self) {
        if self.count < self.most {
            return;
        }
        let Some(solution) = self.registered().filter(|s| s.chi_squared <= most(s.count)) else {
            return;
        };
        if self.count > self.most {
            self.most = self.count;
            self.best.clear();
        }
        self.best.push(solution);
    }
}
