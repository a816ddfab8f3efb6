//! An elimination by several threads: each eliminates subtrees, and all share the products of large fronts above them.
//!
//! A front sums what its children left in their order, whoever eliminated them: the bits are those of one thread.

use std::ops::Range;

use nalgebra::DMatrix;

use super::front::Vanished;
use super::number::Number;
use super::numbers::{Keep, Matrix, Room, Worker};
use super::parts::{Part, parts};
use super::share::share;
use super::symbolic::Symbolic;

/// The front whose pivot vanished.
pub(super) type Failed = (usize, Vanished);

/// Memory of the threads, kept from one elimination to the next.
#[derive(Debug, Clone, Default)]
pub(super) struct Workers<E> {
    main: Worker<E>,
    runs: Vec<Worker<E>>,
}

/// Where a whole factor is kept.
pub(super) struct Place<'a, E, T> {
    pub(super) entries: &'a mut [T],
    pub(super) pivots: &'a mut [f64],
    /// The first entry of each front, and the end.
    pub(super) starts: &'a [usize],
    pub(super) keep: Keep<E, T>,
}

/// How it is kept.
struct Layout<'a, E, T> {
    starts: &'a [usize],
    keep: Keep<E, T>,
}

impl<E, T> Clone for Layout<'_, E, T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<E, T> Copy for Layout<'_, E, T> {}

impl<E, T> Layout<'_, E, T> {
    /// The room of fronts that follow one another, in that of these and all after them, which is left the rest.
    fn split<'r>(&self, symbolic: &Symbolic, fronts: &Range<usize>, rest: &mut Room<'r, T>) -> Room<'r, T> {
        let entries = self.starts[fronts.end] - self.starts[fronts.start];
        let pivots = symbolic.fronts[fronts.clone()].iter().map(|f| f.width).sum();
        let (own, after) = std::mem::take(&mut rest.entries).split_at_mut(entries);
        let (own_pivots, pivots_after) = std::mem::take(&mut rest.pivots).split_at_mut(pivots);
        (rest.entries, rest.pivots) = (after, pivots_after);
        Room {
            entries: own,
            pivots: own_pivots,
        }
    }
}

/// A run and where its result goes.
struct Job<'a, E, T> {
    fronts: Range<usize>,
    room: Room<'a, T>,
    worker: &'a mut Worker<E>,
    found: &'a mut Result<usize, Failed>,
}

impl<E: Number> Workers<E> {
    /// Numbers that its memory holds for what fronts leave behind.
    #[cfg(test)]
    pub(super) fn held(&self) -> usize {
        let all = self.runs.iter().chain([&self.main]);
        let left = |worker: &Worker<E>| worker.left.iter().map(|(_, left)| left.capacity()).sum::<usize>();
        all.map(|worker| left(worker) + worker.spare.iter().map(Vec::capacity).sum::<usize>())
            .sum()
    }

    /// Eliminates all fronts. How many pivots are negative; once they are `most`, the rest is left as it is.
    /// `root` becomes what is left on the root before its own elimination.
    pub(super) fn eliminate<T: Send>(
        &mut self,
        matrix: Matrix<'_>,
        place: Place<'_, E, T>,
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
        // A root that is kept comes last, alone: all others must have been summed into it.
        let rest = symbolic.fronts.len() - usize::from(symbolic.kept > 0);
        let layout = Layout {
            starts: place.starts,
            keep: place.keep,
        };
        let mut room = Room {
            entries: place.entries,
            pivots: place.pivots,
        };
        let parts = match threads {
            0 | 1 if rest > 0 => vec![Part::Run(0..rest)],
            0 | 1 => Vec::new(),
            _ => parts(symbolic, rest, threads),
        };
        let negative = self.by_parts(matrix, layout, parts, &mut room, most, threads)?;
        // Enough negative pivots were found: the caller takes the matrix for indefinite, and the rest is of no use.
        if rest == symbolic.fronts.len() || negative >= most {
            return Ok(negative);
        }
        Ok(negative + self.root(matrix, layout, room, root, most - negative)?)
    }

    /// The root's front: kept as it is before it is eliminated.
    fn root<T>(
        &mut self,
        matrix: Matrix<'_>,
        layout: Layout<'_, E, T>,
        room: Room<'_, T>,
        root: &mut DMatrix<f64>,
        most: usize,
    ) -> Result<usize, Failed> {
        let number = matrix.symbolic.fronts.len() - 1;
        let front = &matrix.symbolic.fronts[number];
        self.main.assemble(matrix, number);
        let entries = root.as_mut_slice().iter_mut().zip(&self.main.panel);
        entries.for_each(|(root, entry)| *root = entry.value() / matrix.scale);
        // Only the lower triangle is assembled; those who take the root are to have it whole.
        root.fill_upper_triangle_with_lower_triangle();
        let negative = self.main.eliminate(matrix, front, most);
        let negative = negative.map_err(|vanished| (number, vanished))?;
        self.main.keep(matrix, front, layout.keep, room);
        Ok(negative)
    }

    fn by_parts<T: Send>(
        &mut self,
        matrix: Matrix<'_>,
        layout: Layout<'_, E, T>,
        parts: Vec<Part>,
        room: &mut Room<'_, T>,
        most: usize,
        threads: usize,
    ) -> Result<usize, Failed> {
        // Runs need nothing from one another, while a front above them may need any run before it.
        let (mut tops, runs) = split(matrix.symbolic, layout, &parts, room);
        let mut results = self.runs(matrix, layout, runs, most, threads).into_iter();
        let mut runs = self.runs.iter_mut();
        let mut negative = 0;
        for part in parts {
            match part {
                Part::Run(_) => {
                    negative += results.next().unwrap_or(Ok(0))?;
                    let run = runs.next().filter(|_| negative < most);
                    // In the order of the parts: what is left lies as one thread would have left it, and so are all sums. What a run that
                    // ended early left stays its own memory, and only one that gave gets some in return: memory grew each time otherwise.
                    if let Some(run) = run {
                        self.main.left.append(&mut run.left);
                        run.spare.extend(self.main.spare.pop());
                    }
                }
                // Fronts above the runs are few and large: threads share the products within them instead.
                Part::Top(k) => {
                    if let Some(room) = tops.next() {
                        negative += run(matrix, layout, k..k + 1, room, &mut self.main, most - negative)?;
                    }
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
    fn runs<T: Send>(
        &mut self,
        matrix: Matrix<'_>,
        layout: Layout<'_, E, T>,
        runs: Vec<(Range<usize>, Room<'_, T>)>,
        most: usize,
        threads: usize,
    ) -> Vec<Result<usize, Failed>> {
        self.runs.resize_with(runs.len(), Worker::default);
        self.runs.iter_mut().for_each(Worker::clear);
        // The fronts above have no more at once than runs leave; a run may leave more than it is given back.
        self.main.spare.truncate(self.runs.len());
        let mut results = vec![Ok(0); runs.len()];
        let rooms = runs.into_iter().zip(&mut self.runs).zip(&mut results);
        let jobs = rooms.map(|(((fronts, room), worker), found)| Job {
            fronts,
            room,
            worker,
            found,
        });
        // Each run counts up to `most` by itself: what the others find is not known before all have ended.
        share(jobs.collect(), threads, |job| {
            *job.found = run(matrix, layout, job.fronts, job.room, job.worker, most);
        });
        results
    }
}

/// A run of fronts, and their room.
type Run<'r, T> = (Range<usize>, Room<'r, T>);

/// The room of each front above the runs, and the runs with theirs; what is after all of them is left.
fn split<'r, E, T>(
    symbolic: &Symbolic,
    layout: Layout<'_, E, T>,
    parts: &[Part],
    rest: &mut Room<'r, T>,
) -> (std::vec::IntoIter<Room<'r, T>>, Vec<Run<'r, T>>) {
    let (mut tops, mut runs) = (Vec::new(), Vec::new());
    // Parts follow one another without gaps: each gets room that no other can touch.
    for part in parts {
        match part {
            Part::Run(fronts) => runs.push((fronts.clone(), layout.split(symbolic, fronts, rest))),
            Part::Top(k) => tops.push(layout.split(symbolic, &(*k..k + 1), rest)),
        }
    }
    (tops.into_iter(), runs)
}

/// Eliminates fronts that follow one another.
fn run<E: Number, T>(
    matrix: Matrix<'_>,
    layout: Layout<'_, E, T>,
    fronts: Range<usize>,
    mut room: Room<'_, T>,
    worker: &mut Worker<E>,
    most: usize,
) -> Result<usize, Failed> {
    let mut negative = 0;
    for k in fronts {
        let own = layout.split(matrix.symbolic, &(k..k + 1), &mut room);
        negative += worker
            .front(matrix, k, layout.keep, own, most - negative)
            .map_err(|vanished| (k, vanished))?;
        if negative >= most {
            break;
        }
    }
    Ok(negative)
}
