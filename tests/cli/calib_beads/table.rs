//! Centres of beads in real CTs by what the ground around them is taken for: the table of `docs/beads.md`.

use bead::{Bead, Dense, Found, Ground, Search, find};

use super::sites::{Body, KINDS, Site, distance, planted, sites};

/// HU of the beads' metal.
const METAL_HU: f64 = 14_000.0;
/// A bead found farther than this from where it was planted is another, mm.
const SAME_MM: f64 = 1.0;

/// Of one kind of place: errors of those found, how many were missed, and what their covariances say.
#[derive(Debug, Clone, Default)]
pub(crate) struct Row {
    pub(crate) errors: Vec<f64>,
    pub(crate) missed: usize,
    /// Traces of the covariances, mm^2, and squared errors in units of them.
    traces: Vec<f64>,
    squares: Vec<f64>,
}

/// What was found of planted beads: a row for each kind of place, and the beads where none was planted.
#[derive(Debug, Clone)]
pub(crate) struct Score {
    pub(crate) rows: Vec<Row>,
    pub(crate) wrong: usize,
}

impl Row {
    /// Root mean square of the errors, mm.
    pub(crate) fn rms(&self) -> f64 {
        root_mean(self.errors.iter().map(|e| e * e))
    }

    /// The error that 95 of 100 do not exceed, mm.
    pub(crate) fn p95(&self) -> f64 {
        let mut sorted = self.errors.clone();
        sorted.sort_by(f64::total_cmp);
        sorted
            .get((95 * sorted.len()).div_ceil(100).saturating_sub(1))
            .copied()
            .unwrap_or_default()
    }

    /// Root mean square error that the covariances predict, mm; and mean squared error by them, 1 where they are right.
    pub(crate) fn predicted(&self) -> [f64; 2] {
        let mean = self.squares.iter().sum::<f64>() / (3 * self.squares.len()).max(1) as f64;
        [root_mean(self.traces.iter().copied()), mean]
    }

    fn add(&mut self, bead: Option<&Bead>, truth: &[f64; 3]) {
        let Some(bead) = bead else {
            self.missed += 1;
            return;
        };
        let p = bead.centre.mm();
        let error = [0, 1, 2].map(|a| p[a] - truth[a]);
        let solved = bead.covariance.try_inverse().map_or(f64::INFINITY, |inverse| {
            let entries = (0..9).map(|i| (i / 3, i % 3));
            entries.map(|(a, b)| error[a] * inverse[(a, b)] * error[b]).sum()
        });
        self.errors.push(distance(&p, truth));
        self.traces.push(bead.covariance.trace());
        self.squares.push(solved);
    }
}

fn root_mean(squares: impl ExactSizeIterator<Item = f64>) -> f64 {
    let n = squares.len().max(1) as f64;
    (squares.sum::<f64>() / n).sqrt()
}

fn score(found: &Found, all: &[Site]) -> Score {
    let mut rows = vec![Row::default(); KINDS.len()];
    for site in all {
        let near = |b: &&Bead| distance(&b.centre.mm(), &site.centre) < SAME_MM;
        let bead = found.beads.iter().find(near);
        if bead.is_none() {
            let spot = |p: [f64; 3]| distance(&p, &site.centre) < 3.0;
            let why = found.rejected.iter().find(|r| spot(r.place.mm()));
            println!("missed: {} at {:?}: {why:?}", KINDS[site.kind].name, site.centre);
        }
        rows[site.kind].add(bead, &site.centre);
    }
    let planted = |b: &&Bead| all.iter().any(|s| distance(&b.centre.mm(), &s.centre) < SAME_MM);
    let wrong = found.beads.iter().filter(|b| !planted(b)).count();
    Score { rows, wrong }
}

/// Plants up to `count` beads of each kind, finds them with each ground, and prints the table.
pub(crate) fn compared(what: &str, volume: &Dense, radius_mm: f64, count: usize, grounds: &[Ground]) -> Vec<Score> {
    let all = sites(volume, count, 5.0 * radius_mm + 8.0, 7);
    let specimen = planted(volume, &all, &Body::ball(radius_mm), METAL_HU);
    println!("{what}: {} beads of {} mm", all.len(), 2.0 * radius_mm);
    let of = |ground: &Ground| {
        let search = Search {
            ground: *ground,
            ..Search::of_radius(radius_mm)
        };
        let score = score(&find(&specimen, &search).unwrap(), &all);
        for (kind, row) in KINDS.iter().zip(&score.rows).filter(|(_, r)| !r.errors.is_empty()) {
            let [predicted, ratio] = row.predicted();
            println!(
                "{ground:?}, {:<22} {:>3} beads, {} missed: rms {:.4}, 95 % {:.4} mm; predicted {predicted:.4} mm, squares {ratio:.2}",
                kind.name,
                row.errors.len(),
                row.missed,
                row.rms(),
                row.p95()
            );
        }
        println!("{ground:?}: {} false beads", score.wrong);
        score
    };
    grounds.iter().map(of).collect()
}
