//! What is counted over the runs of a row.

use geometry::{Ct, Point, Tracker};
use surface_registration::{Refusal, SurfaceRegistration};

use super::common::draw::{Drawn, chi2, rms};
use super::kinds::{KINDS, Kind, OfKind};

#[derive(Default)]
pub(crate) struct Count {
    pub(crate) runs: usize,
    pub(crate) right: usize,
    pub(crate) wrong: usize,
    pub(crate) silent: usize,
    pub(crate) refused: usize,
    pub(crate) failed: usize,
    /// Refused as moved, of all and of the right ones.
    pub(crate) moved: usize,
    pub(crate) right_moved: usize,
    /// Refused of all.
    pub(crate) stopped: usize,
    /// Of each of [`super::kinds::KINDS`].
    pub(crate) kinds: [OfKind; 3],
    pub(crate) tre: Vec<f64>,
    /// Of all that have a result.
    pub(crate) all_tre: Vec<f64>,
    pub(crate) bound: Vec<f64>,
    pub(crate) within: usize,
    pub(crate) looked: usize,
    /// Of those that were taken, the error and what was predicted, root mean squares over the targets, mm.
    pub(crate) taken: Vec<[f64; 2]>,
    /// Squares of errors at targets in their covariance.
    pub(crate) squares: Vec<f64>,
    pub(crate) seconds: f64,
    /// Of each run; of one start the second time.
    pub(crate) least_ms: Vec<f64>,
}

/// What is known of a run beside what was found.
pub(crate) struct Truth<'a> {
    /// Root mean square target registration error, mm.
    pub(crate) tre: f64,
    pub(crate) kind: Kind,
    pub(crate) drawn: &'a Drawn,
    pub(crate) targets: &'a [Point<Ct>],
}

pub(crate) fn middle(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied().unwrap_or(f64::NAN)
}

impl Count {
    /// Counts what became of a run.
    pub(crate) fn judged(
        &mut self,
        name: &str,
        seed: u64,
        truth: &Truth<'_>,
        found: &SurfaceRegistration<Ct, Tracker>,
        refusals: &[Refusal],
    ) {
        let (tre, of_kind) = (truth.tre, &mut self.kinds[truth.kind as usize]);
        if tre < 2.0 {
            of_kind.right(refusals);
        }
        self.all_tre.push(tre);
        let is_refused = refusals.iter().any(|r| *r != Refusal::NotSearched);
        let is_moved = refusals.iter().any(|r| matches!(r, Refusal::Moved { .. }));
        self.stopped += usize::from(is_refused);
        self.moved += usize::from(is_moved);
        self.wrong += usize::from(tre >= 4.0);
        if std::env::var_os("WHY").is_some() {
            println!(
                "  {name} {seed} {tre:.2} share beyond {:.2}, {:?}, {} seeds, {} steps",
                found.share_beyond,
                found.halves.as_ref().map(|h| (h.before, h.square)),
                found.seeds,
                found.steps,
            );
            refusals.iter().for_each(|r| println!("  {seed} {tre:.2} {r}"));
        }
        if tre >= 4.0 && !is_refused {
            self.silent += 1;
            of_kind.silent += 1;
            println!(
                "  SILENT {name} seed {seed}: TRE {tre:.1}, ratio {:.2}, margin {:?}, share {:.2}, beyond {:.2}, hits {}",
                found.noise_ratio,
                found.margin(),
                found.share_kept,
                found.share_beyond,
                found.hits
            );
        }
        if !is_refused {
            let predicted: Vec<f64> = truth
                .targets
                .iter()
                .map(|target| found.predicted_tre_mm(*target))
                .collect();
            self.taken.push([tre, rms(&predicted)]);
        }
        if tre < 2.0 {
            self.right += 1;
            self.refused += usize::from(is_refused);
            self.right_moved += usize::from(is_moved);
            self.tre.push(tre);
        }
        // Of all that are in the right minimum, right by 2 mm or not.
        if !is_refused || tre < 6.0 {
            for target in truth.targets {
                let square = chi2(found, &truth.drawn.ct_from_tracker, *target);
                self.looked += 1;
                self.within += usize::from(square < 7.815);
                self.squares.push(square);
            }
        }
    }

    /// Adds what is counted of a row to what is counted of all.
    pub(crate) fn add(&mut self, row: &Self) {
        self.runs += row.runs;
        self.wrong += row.wrong;
        self.silent += row.silent;
        self.right += row.right;
        self.refused += row.refused;
        self.failed += row.failed;
        self.right_moved += row.right_moved;
        self.seconds += row.seconds;
        for (own, other) in self.kinds.iter_mut().zip(&row.kinds) {
            own.add(other);
        }
    }

    /// Of all rows: the counts, and those of each kind.
    pub(crate) fn last(&self) -> String {
        let mut text = format!(
            "searched: {} runs, {} wrong by 4 mm and more, {} of them not refused; {} right, {} of them refused, {} as moved; {} without a result; {:.0} s",
            self.runs, self.wrong, self.silent, self.right, self.refused, self.right_moved, self.failed, self.seconds
        );
        for (own, (_, words)) in self.kinds.iter().zip(KINDS) {
            let share = 100.0 * own.refused as f64 / own.right.max(1) as f64;
            text += &format!(
                "\n{words}: {} of {} right ones refused, {share:.1} % ({}); {} wrong and not refused",
                own.refused,
                own.right,
                own.words(),
                own.silent
            );
        }
        text
    }

    /// Of a row of [`super::ends`]: beside the counts the mean share beyond the end, and of the runs that were taken the errors' root mean
    /// square with the predicted one.
    pub(crate) fn line_of_end(&self, name: &str, beyond: f64, [tre, predicted]: [f64; 2]) -> String {
        format!(
            "| {name} | {} of {} | {} | {} | {} | {:.0} % | {tre:.2}, {predicted:.2} | {:.1} | {:.2} | {:.1} |",
            self.right,
            self.runs,
            self.wrong,
            self.silent,
            self.refused,
            100.0 * beyond,
            self.coverage(),
            self.squares.iter().sum::<f64>() / self.squares.len() as f64 / 3.0,
            self.ms(),
        )
    }

    /// Milliseconds of a run, their mean.
    pub(crate) fn ms(&self) -> f64 {
        1e3 * self.seconds / self.runs as f64
    }

    /// Share of targets within the 95 % that were promised, %.
    pub(crate) fn coverage(&self) -> f64 {
        100.0 * self.within as f64 / self.looked as f64
    }

    /// Of those that were taken: how many, medians of the error and of what was predicted, the greatest ratio of the two, and how many were
    /// off by more than three times what was predicted.
    fn taken(&self) -> String {
        let of = |k: usize| middle(&self.taken.iter().map(|both| both[k]).collect::<Vec<_>>());
        let ratios = || self.taken.iter().map(|[tre, predicted]| tre / predicted);
        format!(
            "{}: {:.2}, {:.2}; {:.1}, {}",
            self.taken.len(),
            of(0),
            of(1),
            ratios().fold(0.0, f64::max),
            ratios().filter(|ratio| *ratio > 3.0).count()
        )
    }

    pub(crate) fn line(&self, name: &str) -> String {
        format!(
            "| {name} | {} of {} | {} | {} | {} | {}, {} | {:.2} | {:.2}, {:.2} | {:.1} | {:.2} | {} | {:.2}, {:.2} |",
            self.right,
            self.runs,
            self.wrong,
            self.silent,
            self.refused,
            self.moved,
            self.right_moved,
            middle(&self.tre),
            middle(&self.tre) / middle(&self.bound),
            rms(&self.tre) / rms(&self.bound),
            self.coverage(),
            // Of three degrees of freedom.
            self.squares.iter().sum::<f64>() / self.squares.len() as f64 / 3.0,
            self.taken(),
            self.ms(),
            middle(&self.least_ms),
        )
    }
}
