//! Where the entries of a factor are, from where those of the matrix are.

use super::graph::Graph;
use super::order::{Dissection, Ordered};
use super::tree::Elimination;

/// Unknowns eliminated together: a dense matrix whose first columns are columns of `L`, the rest what they leave behind.
#[derive(Debug, Clone, Copy)]
pub(super) struct Front {
    /// The first unknown, in the order of elimination.
    pub(super) first: usize,
    /// How many.
    pub(super) width: usize,
    /// Of the unknowns below, in [`Symbolic::rows`]: from, and how many.
    pub(super) rows: usize,
    pub(super) height: usize,
    /// Where its columns begin in the factor: `width` of `width + height` entries.
    pub(super) start: usize,
    /// How many fronts before it leave something to it: the last ones that no other has taken.
    pub(super) children: usize,
    /// Its rows that lie together in the parent, in [`Symbolic::runs`]: from, and how many runs.
    pub(super) runs: usize,
    pub(super) run_count: usize,
}

/// Rows of a front that follow one another in it and in its parent.
#[derive(Debug, Clone, Copy)]
pub(super) struct Run {
    pub(super) from: u32,
    pub(super) end: u32,
    /// The first of them in the parent.
    pub(super) at: u32,
}

impl Front {
    /// Rows of its dense matrix.
    pub(super) fn size(&self) -> usize {
        self.width + self.height
    }

    /// Where its columns lie in the factor.
    pub(super) fn panel(&self) -> std::ops::Range<usize> {
        self.start..self.start + self.width * self.size()
    }
}

/// The elimination of one pattern.
#[derive(Debug, Clone, Default)]
pub(super) struct Symbolic {
    /// The unknown eliminated k-th.
    pub(super) order: Vec<u32>,
    /// Fronts, children before parents.
    pub(super) fronts: Vec<Front>,
    /// The unknowns below each front, ascending, in the order of elimination.
    pub(super) rows: Vec<u32>,
    /// Where each of them lies in the parent's dense matrix.
    pub(super) in_parent: Vec<u32>,
    /// The same by runs.
    pub(super) runs: Vec<Run>,
    /// Entries of all fronts' columns.
    pub(super) entries: usize,
    /// How many unknowns at the end are the root: the last front, if any.
    pub(super) kept: usize,
    /// When each unknown is eliminated, and by which front.
    place_of: Vec<u32>,
    front_of: Vec<u32>,
}

impl Symbolic {
    /// The elimination of a matrix with entries at these places of its lower triangle.
    pub(super) fn new(size: usize, places: &[(u32, u32)], dissection: Option<&Dissection>) -> Self {
        let ordered = Ordered::new(&Graph::of_places(size, places), dissection);
        let (groups, weights, kept) = (&ordered.groups, &ordered.weights, ordered.kept);
        let Elimination { order, columns } = Elimination::new(&ordered.graph, weights, &ordered.order, kept);
        let mut symbolic = Self {
            order: order.iter().flat_map(|g| groups[*g as usize].iter().copied()).collect(),
            place_of: vec![0; size],
            front_of: vec![0; size],
            kept,
            ..Self::default()
        };
        for (k, i) in symbolic.order.iter().enumerate() {
            symbolic.place_of[*i as usize] = k as u32;
        }
        // The tree is that of groups of unknowns; from here on each unknown has a number of its own.
        let mut starts = vec![0];
        for g in &order {
            starts.push(starts[starts.len() - 1] + weights[*g as usize]);
        }
        for (k, c) in columns.iter().enumerate() {
            symbolic.add(k, [starts[c.first], starts[c.end]], |rows| {
                let each = c.below.iter().map(|g| *g as usize);
                rows.extend(each.flat_map(|g| (starts[g]..starts[g + 1]).map(|u| u as u32)));
            });
        }
        // Not before all are there, as a front's parent comes after it.
        symbolic.link();
        symbolic.join_rows();
        symbolic
    }

    /// Rows that follow one another in a front and in its parent.
    fn join_rows(&mut self) {
        for front in &mut self.fronts {
            front.runs = self.runs.len();
            let rows = &self.in_parent[front.rows..front.rows + front.height];
            for (from, at) in rows.iter().enumerate() {
                let from = from as u32;
                match self.runs[front.runs..].last_mut() {
                    // A row is never above its place in the parent.
                    Some(run) if run.at + from - run.from == *at => run.end = from + 1,
                    _ => self.runs.push(Run {
                        from,
                        end: from + 1,
                        at: *at,
                    }),
                }
            }
            front.run_count = self.runs.len() - front.runs;
        }
    }

    fn add(&mut self, number: usize, [first, end]: [usize; 2], below: impl FnOnce(&mut Vec<u32>)) {
        let rows = self.rows.len();
        below(&mut self.rows);
        let front = Front {
            first,
            width: end - first,
            rows,
            height: self.rows.len() - rows,
            start: self.entries,
            children: 0,
            runs: 0,
            run_count: 0,
        };
        self.entries += front.width * front.size();
        self.front_of[first..end].fill(number as u32);
        self.fronts.push(front);
    }

    /// Where each front's rows lie in its parent.
    fn link(&mut self) {
        self.in_parent = vec![0; self.rows.len()];
        for front in self.fronts.clone() {
            let rows = front.rows..front.rows + front.height;
            let Some(&first) = self.rows[rows.clone()].first() else {
                continue;
            };
            // Rows ascend: the first below is eliminated next of them, and its front takes what this one leaves.
            let parent = self.front_of[first as usize] as usize;
            self.fronts[parent].children += 1;
            let parent = self.fronts[parent];
            let (mut at, above) = (0, &self.rows[parent.rows..parent.rows + parent.height]);
            for k in rows {
                let row = self.rows[k];
                if (row as usize) < parent.first + parent.width {
                    self.in_parent[k] = row - parent.first as u32;
                    continue;
                }
                // Both lists ascend: one pass finds all.
                at += above[at..].iter().take_while(|r| **r < row).count();
                self.in_parent[k] = (parent.width + at) as u32;
            }
        }
    }

    /// The unknowns below a front.
    pub(super) fn below(&self, front: &Front) -> &[u32] {
        &self.rows[front.rows..front.rows + front.height]
    }

    /// The entry of the factor's storage that a place adds to. `None` where the pattern lacks it.
    pub(super) fn slot(&self, (i, j): (u32, u32)) -> Option<u32> {
        let (a, b) = (self.place_of[i as usize], self.place_of[j as usize]);
        // The lower triangle in the order of elimination, which may swap the two.
        let (row, column) = (a.max(b), a.min(b) as usize);
        let front = &self.fronts[self.front_of[column] as usize];
        let local = if (row as usize) < front.first + front.width {
            row as usize - front.first
        } else {
            // A row may be missing, as with a new contact: the caller then finds another elimination.
            let rows = &self.rows[front.rows..front.rows + front.height];
            front.width + rows.binary_search(&row).ok()?
        };
        Some((front.start + (column - front.first) * front.size() + local) as u32)
    }

    /// The front that eliminates the k-th unknown.
    pub(super) fn front_of(&self, k: usize) -> usize {
        self.front_of[k] as usize
    }

    /// The first entry of each front's columns among places in them that ascend, and the end.
    pub(super) fn starts_among(&self, places: &[u32]) -> Vec<usize> {
        let starts = self.fronts.iter().map(|f| f.start);
        let starts = starts.chain([self.entries]);
        starts
            .map(|start| places.partition_point(|p| (*p as usize) < start))
            .collect()
    }
}
