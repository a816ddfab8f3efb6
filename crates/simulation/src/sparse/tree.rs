//! The elimination tree, and columns of the factor that are eliminated together.

use super::graph::Graph;

const NO_PARENT: u32 = u32::MAX;

/// Columns that share their rows below: a dense block of the factor, and a front of the elimination.
#[derive(Debug, Clone)]
pub(super) struct Columns {
    /// The first of them, in the order of elimination of the graph's vertices.
    pub(super) first: usize,
    /// One past the last of them.
    pub(super) end: usize,
    /// The vertices below them that they reach, ascending.
    pub(super) below: Vec<u32>,
    /// Unknowns of the columns.
    width: usize,
    /// Unknowns below.
    height: usize,
    /// Entries that are zero and stored all the same.
    zeros: usize,
}

/// A postorder of the elimination tree, and the supernodes in it.
pub(super) struct Elimination {
    /// The vertex eliminated k-th.
    pub(super) order: Vec<u32>,
    pub(super) columns: Vec<Columns>,
}

impl Elimination {
    /// Of a graph in an order that fills little; weights are unknowns by vertex. The last `kept` vertices stay the last ones, in
    /// their order, in columns of their own, as if each saw all of them.
    pub(super) fn new(graph: &Graph, weights: &[usize], order: &[u32], kept: usize) -> Self {
        let mut parents = parents(graph, order);
        // Vertices that see one another are eliminated in a chain.
        for k in (order.len() - kept + 1..order.len()).rev() {
            parents[k - 1] = k as u32;
        }
        let order: Vec<u32> = postorder(&parents).iter().map(|k| order[*k as usize]).collect();
        let columns = columns(graph, weights, &order, kept);
        Self { order, columns }
    }
}

fn places(order: &[u32]) -> Vec<u32> {
    let mut place = vec![0_u32; order.len()];
    for (k, i) in order.iter().enumerate() {
        place[*i as usize] = k as u32;
    }
    place
}

/// The parent of each column in the elimination tree (Liu 1986), by way of shortened paths.
fn parents(graph: &Graph, order: &[u32]) -> Vec<u32> {
    let place = places(order);
    let (mut parent, mut ancestor) = (vec![NO_PARENT; order.len()], vec![NO_PARENT; order.len()]);
    for (k, vertex) in order.iter().enumerate() {
        for &j in graph.of(*vertex as usize) {
            let mut i = place[j as usize] as usize;
            while i < k {
                // Every vertex of the path now points at `k`: the next walk takes the short cut.
                let up = std::mem::replace(&mut ancestor[i], k as u32);
                if up == NO_PARENT {
                    parent[i] = k as u32;
                    break;
                }
                i = up as usize;
            }
        }
    }
    parent
}

/// Children before parents, and every subtree in one piece.
fn postorder(parents: &[u32]) -> Vec<u32> {
    let n = parents.len();
    // Heads and links of the lists of children: the last one first, so that walks meet them in order.
    let (mut child, mut sibling, mut roots) = (vec![NO_PARENT; n], vec![NO_PARENT; n], Vec::new());
    for k in (0..n).rev() {
        match parents[k] {
            NO_PARENT => roots.push(k as u32),
            p => sibling[k] = std::mem::replace(&mut child[p as usize], k as u32),
        }
    }
    let mut order = Vec::with_capacity(n);
    // Not as a call within a call: a tree may be a chain as long as the matrix.
    let mut stack = roots;
    while let Some(&k) = stack.last() {
        let first = std::mem::replace(&mut child[k as usize], NO_PARENT);
        if first != NO_PARENT {
            stack.push(first);
            continue;
        }
        order.push(k);
        stack.pop();
        if sibling[k as usize] != NO_PARENT {
            stack.push(sibling[k as usize]);
        }
    }
    order
}

/// The columns in a postorder, joined to supernodes, some zeros accepted.
fn columns(graph: &Graph, weights: &[usize], order: &[u32], kept: usize) -> Vec<Columns> {
    let weight = |k: usize| weights[order[k] as usize];
    let eliminated = order.len() - kept;
    let place = places(order);
    let mut done: Vec<Columns> = Vec::new();
    // Rows of a column that no parent has taken yet, by parent.
    let mut waiting: Vec<Vec<Vec<u32>>> = vec![Vec::new(); order.len()];
    let mut mark = vec![NO_PARENT; order.len()];
    for (k, vertex) in order.iter().enumerate().take(eliminated) {
        mark[k] = k as u32;
        let mut below = Vec::new();
        let mut take = |row: u32| {
            if row > k as u32 && mark[row as usize] != k as u32 {
                mark[row as usize] = k as u32;
                below.push(row);
            }
        };
        graph.of(*vertex as usize).iter().for_each(|j| take(place[*j as usize]));
        std::mem::take(&mut waiting[k])
            .iter()
            .flatten()
            .for_each(|row| take(*row));
        below.sort_unstable();
        if let Some(parent) = below.first() {
            // A column's rows pass to its parent only, which passes them on: the rows of `L` need no other search.
            waiting[*parent as usize].push(below.clone());
        }
        let height = below.iter().map(|row| weight(*row as usize)).sum();
        let mut next = Columns {
            first: k,
            end: k + 1,
            below,
            width: weight(k),
            height,
            zeros: 0,
        };
        // Columns of one front lie side by side: only the child right before its parent can join it.
        while done.last().is_some_and(|before| before.joins(&next)) {
            if let Some(before) = done.pop() {
                next = before.with(next);
            }
        }
        done.push(next);
    }
    if kept > 0 {
        done.push(Columns {
            first: eliminated,
            end: order.len(),
            below: Vec::new(),
            width: (eliminated..order.len()).map(weight).sum(),
            height: 0,
            zeros: 0,
        });
    }
    done
}

impl Columns {
    fn zeros_with(&self, next: &Self) -> usize {
        // Each column of the first gets the rows of the second: those that it had not are zeros.
        self.zeros + next.zeros + self.width * (next.width + next.height - self.height)
    }

    /// True where a supernode of both, the second the parent of the first, stores few zeros (the limits of CHOLMOD).
    fn joins(&self, next: &Self) -> bool {
        let parent = self
            .below
            .first()
            .is_some_and(|row| (next.first..next.end).contains(&(*row as usize)));
        if !parent {
            return false;
        }
        let (width, zeros) = (self.width + next.width, self.zeros_with(next));
        let stored = width * (width + 1) / 2 + width * next.height;
        let part = zeros as f64 / stored as f64;
        zeros == 0 || width <= 4 || part < 0.05 || (width <= 16 && part < 0.8) || (width <= 48 && part < 0.1)
    }

    fn with(self, next: Self) -> Self {
        Self {
            first: self.first,
            width: self.width + next.width,
            zeros: self.zeros_with(&next),
            ..next
        }
    }
}
