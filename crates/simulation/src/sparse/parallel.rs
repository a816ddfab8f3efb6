//! An elimination by several threads: each eliminates subtrees, and all share the products of large fronts above them.
//!
//! A front sums what its children left in their order, whoever eliminated them: the bits are those of one thread.

use std::ops::Range;

use nalgebra::DMatrix;

use super::front::{Vanished, eliminate};
use super::numbers::{Matrix, Worker};
use super::share::share;
use super::symbolic::Symbolic;

/// Runs of subtrees are so many times as many as threads, as they differ in work.
const RUNS_PER_THREAD: usize = 6;

/// The front whose pivot vanished.
type Failed = (usize, Vanished);

/// Memory of the threads, kept from one elimination to the next.
#[derive(Debug, Clone, Default)]
pub(super) struct Workers {
    main: Worker,
    runs: Vec<Worker>,
}

/// Fronts that follow one another.
#[derive(Debug, Clone, PartialEq)]
enum Part {
    /// Whole subtrees, for any thread.
    Run(Range<usize>),
    /// A front above them.
    Top(usize),
}

/// A run and where its result goes.
struct Job<'a> {
    fronts: Range<usize>,
    panels: &'a mut [f64],
    worker: &'a mut Worker,
    found: &'a mut Result<usize, Failed>,
}

impl Workers {
    /// Eliminates all fronts. How many pivots are negative; once they are `most`, the rest is left as it is.
    /// `root` becomes what is left on the root before its own elimination.
    pub(super) fn eliminate(
        &mut self,
        matrix: Matrix<'_>,
        factor: &mut [f64],
        root: &mut DMatrix<f64>,
        most: usize,
        threads: usize,
    ) -> Result<usize, Failed> {
        self.main.clear();
        self.main.scratch.threads = threads;
        let symbolic = matrix.symbolic;
        if root.nrows() != symbolic.kept {
            *root = DMatrix::zeros(symbolic.kept, symbolic.kept);
        }
        let rest = symbolic.fronts.len() - usize::from(symbolic.kept > 0);
        let negative = if threads > 1 {
            self.by_parts(matrix, factor, parts(symbolic, rest, threads), most, threads)?
        } else {
            run(matrix, 0..rest, factor, &mut self.main, most)?
        };
        if rest == symbolic.fronts.len() || negative >= most {
            return Ok(negative);
        }
        Ok(negative + self.root(matrix, factor, root, most - negative)?)
    }

    /// The root's front: kept as it is before it is eliminated.
    fn root(
        &mut self,
        matrix: Matrix<'_>,
        factor: &mut [f64],
        root: &mut DMatrix<f64>,
        most: usize,
    ) -> Result<usize, Failed> {
        let number = matrix.symbolic.fronts.len() - 1;
        let front = &matrix.symbolic.fronts[number];
        let panel = &mut factor[front.panel()];
        self.main.assemble(matrix.symbolic, front, panel);
        root.copy_from_slice(panel);
        // Only the lower triangle is assembled; those who take the root are to have it whole.
        root.fill_upper_triangle_with_lower_triangle();
        let diagonal = &matrix.diagonal[front.first..];
        eliminate(panel, front.width, diagonal, most, &mut self.main.scratch).map_err(|vanished| (number, vanished))
    }

    fn by_parts(
        &mut self,
        matrix: Matrix<'_>,
        factor: &mut [f64],
        parts: Vec<Part>,
        most: usize,
        threads: usize,
    ) -> Result<usize, Failed> {
        // Runs need nothing from one another, while a front above them may need any run before it.
        let mut results = self.runs(matrix, factor, &parts, most, threads).into_iter();
        let mut runs = self.runs.iter();
        let mut negative = 0;
        for part in parts {
            match part {
                Part::Run(_) => {
                    negative += results.next().unwrap_or(Ok(0))?;
                    // In the order of the parts: the stack is as one thread would have left it, and so are all sums.
                    if let Some(run) = runs.next() {
                        self.main.append(run);
                    }
                }
                // Fronts above the runs are few and large: threads share the products within them instead.
                Part::Top(k) => {
                    negative += run(
                        matrix,
                        k..k + 1,
                        &mut factor[panels(matrix.symbolic, k..k + 1)],
                        &mut self.main,
                        most - negative,
                    )?
                }
            }
            // A run that ended early found so many by itself: what it left unfinished is never taken up.
            if negative >= most {
                break;
            }
        }
        Ok(negative)
    }

    /// All runs, on so many threads: what each found, in their order.
    fn runs(
        &mut self,
        matrix: Matrix<'_>,
        mut factor: &mut [f64],
        parts: &[Part],
        most: usize,
        threads: usize,
    ) -> Vec<Result<usize, Failed>> {
        let count = parts.iter().filter(|p| matches!(p, Part::Run(_))).count();
        self.runs.resize_with(count, Worker::default);
        let mut results = vec![Ok(0); count];
        let (mut workers, mut found) = (self.runs.iter_mut(), results.iter_mut());
        let mut jobs = Vec::new();
        for part in parts {
            let fronts = match part {
                Part::Run(fronts) => fronts.clone(),
                Part::Top(k) => *k..k + 1,
            };
            // Parts follow one another without gaps: each run gets columns that no other can touch,
            // and those of the fronts above are passed over.
            let (panels, after) =
                std::mem::take(&mut factor).split_at_mut(panels(matrix.symbolic, fronts.clone()).len());
            factor = after;
            if let Part::Run(_) = part
                && let (Some(worker), Some(found)) = (workers.next(), found.next())
            {
                jobs.push(Job {
                    fronts,
                    panels,
                    worker,
                    found,
                });
            }
        }
        // Each run counts up to `most` by itself: what the others find is not known before all have ended.
        share(jobs, threads, |job| {
            job.worker.clear();
            *job.found = run(matrix, job.fronts, job.panels, job.worker, most);
        });
        results
    }
}

/// Where the columns of some fronts lie in the factor.
fn panels(symbolic: &Symbolic, fronts: Range<usize>) -> Range<usize> {
    match fronts.is_empty() {
        true => 0..0,
        false => symbolic.fronts[fronts.start].start..symbolic.fronts[fronts.end - 1].panel().end,
    }
}

/// Eliminates fronts that follow one another, whose columns are `panels`.
fn run(
    matrix: Matrix<'_>,
    fronts: Range<usize>,
    panels: &mut [f64],
    worker: &mut Worker,
    most: usize,
) -> Result<usize, Failed> {
    let Some(first) = matrix.symbolic.fronts.get(fronts.start) else {
        return Ok(0);
    };
    let mut negative = 0;
    for k in fronts {
        let panel = matrix.symbolic.fronts[k].panel();
        let own = &mut panels[panel.start - first.start..panel.end - first.start];
        negative += worker
            .front(matrix, k, own, most - negative)
            .map_err(|vanished| (k, vanished))?;
        if negative >= most {
            break;
        }
    }
    Ok(negative)
}

/// The first fronts in runs of whole subtrees with no more than their part of the work, and the fronts above them.
fn parts(symbolic: &Symbolic, count: usize, threads: usize) -> Vec<Part> {
    // Of each front's subtree: its first front, and its work.
    let (mut subtrees, mut waiting): (Vec<(usize, f64)>, Vec<usize>) = (Vec::new(), Vec::new());
    let mut whole = 0.0;
    for (k, front) in symbolic.fronts[..count].iter().enumerate() {
        let [w, h] = [front.width as f64, front.height as f64];
        // The work of a dense elimination up to a factor, as only its parts of the whole matter.
        let own = w * (w * w / 3.0 + w * h + h * h);
        whole += own;
        let mut subtree = (k, own);
        for child in waiting.drain(waiting.len() - front.children..) {
            let (first, work) = subtrees[child];
            subtree = (subtree.0.min(first), subtree.1 + work);
        }
        if front.height > 0 {
            waiting.push(k);
        }
        subtrees.push(subtree);
    }
    let most = whole / (RUNS_PER_THREAD * threads) as f64;
    let (mut parts, mut run) = (Vec::new(), (count..count, 0.0));
    let mut next = count;
    // Backwards, as a subtree ends with its root: the last front of what is left is the root of one.
    while next > 0 {
        let (first, work) = subtrees[next - 1];
        if work > most {
            // Too much for one run: this front waits above, and its subtrees are looked at one by one.
            parts.extend([Part::Run(run.0), Part::Top(next - 1)]);
            (run, next) = ((next - 1..next - 1, 0.0), next - 1);
            continue;
        }
        if run.1 + work > most {
            parts.push(Part::Run(run.0));
            run = (next..next, 0.0);
        }
        run = (first..run.0.end, run.1 + work);
        next = first;
    }
    parts.push(Part::Run(run.0));
    parts.retain(|part| !matches!(part, Part::Run(fronts) if fronts.is_empty()));
    parts.reverse();
    parts
}
