//! What children left behind, added to the matrix of their parent.

use std::ops::Range;

use super::number::Number;
use super::share::share;
use super::symbolic::{Front, Symbolic};

/// Columns that are added to by one thread at a time, where a front has so many entries.
const COLUMNS: usize = 64;
const SHARED_ENTRIES: usize = 250_000;

/// What a child left: a dense lower triangle.
pub(super) type Left<E> = (usize, Vec<E>);

/// Adds what is for some columns of the parent.
fn add_to<E: Number>(columns: &mut Columns<'_, E>, symbolic: &Symbolic, (child, left): &Left<E>) {
    let child = &symbolic.fronts[*child];
    let to = &symbolic.in_parent[child.rows..child.rows + child.height];
    let runs = &symbolic.runs[child.runs..child.runs + child.run_count];
    let before = |column: usize| to.partition_point(|at| (*at as usize) < column);
    let mut first = 0;
    for j in before(columns.numbers.start)..before(columns.numbers.end) {
        // From the diagonal on: products may have spoilt what lies above it.
        while runs[first].end as usize <= j {
            first += 1;
        }
        let column = &left[j * child.height..(j + 1) * child.height];
        let above = columns.above;
        let target = columns.column(to[j] as usize);
        for run in &runs[first..] {
            let from = j.max(run.from as usize);
            let at = (run.at - run.from) as usize + from - above;
            let values = &column[from..run.end as usize];
            let sums = target[at..at + values.len()].iter_mut();
            sums.zip(values).for_each(|(sum, value)| *sum += *value);
        }
    }
}

/// Some columns of a front's matrix.
struct Columns<'a, E> {
    numbers: Range<usize>,
    entries: &'a mut [E],
    /// Rows of each, and how many of the front's rows lie above the first.
    rows: usize,
    above: usize,
}

impl<E> Columns<'_, E> {
    fn column(&mut self, number: usize) -> &mut [E] {
        let start = (number - self.numbers.start) * self.rows;
        &mut self.entries[start..start + self.rows]
    }
}

/// Adds what the children left to a front's columns and to what is below them: the sum of each entry in the children's order.
pub(super) fn add<E: Number>(
    symbolic: &Symbolic,
    children: &[Left<E>],
    front: &Front,
    [panel, own]: [&mut [E]; 2],
    threads: usize,
) {
    if children.is_empty() {
        return;
    }
    let size = front.size();
    let work = |mut columns: Columns<'_, E>| {
        children.iter().for_each(|child| add_to(&mut columns, symbolic, child));
    };
    let parts = [(panel, 0, size), (own, front.width, front.height)];
    // Each chunk has columns of its own and takes the children in one order: the bits are those of one thread. A small front is summed sooner than
    // it is handed out.
    if threads > 1 && size * size >= SHARED_ENTRIES {
        let jobs = parts
            .into_iter()
            .flat_map(|(entries, first, rows)| chunks(entries, first, rows, COLUMNS));
        share(jobs.collect(), threads, work);
    } else {
        let whole = parts
            .into_iter()
            .flat_map(|(entries, first, rows)| chunks(entries, first, rows, size));
        whole.for_each(work);
    }
}

/// Columns from one on, so many at a time.
fn chunks<E>(entries: &mut [E], first: usize, rows: usize, count: usize) -> impl Iterator<Item = Columns<'_, E>> {
    entries
        .chunks_mut((count * rows).max(1))
        .enumerate()
        .map(move |(k, entries)| {
            let start = first + k * count;
            Columns {
                numbers: start..start + entries.len() / rows,
                entries,
                rows,
                above: first,
            }
        })
}
