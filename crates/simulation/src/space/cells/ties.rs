//! Which nodes are free, and what the others are.
//!
//! A node that lies on a larger cube without being its node *hangs*: continuity makes it a fixed combination of that cube's
//! nodes. A node all of whose cubes are nearly empty is held by next to nothing: it is *extended* from a well-filled cube, as
//! the polynomial of second degree nearest to that cube's field (aggregation; Badia, Verdugo and Martin 2018). Both are
//! combinations of free nodes that reproduce constant, linear and (with 27 nodes) quadratic fields.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use nalgebra::{DMatrix, Vector3};

use super::grid::{Cell, Grid};
use super::settings::NoMesh;
use super::shape::values;
use crate::space::element::Order;

/// Nearly empty cubes this far from a well-filled one, in cubes, are extended from it.
const MOST_RINGS: usize = 2;

/// A combination of nodes.
type Tie = Vec<(u32, f64)>;

/// The nodes of a grid's cubes.
#[derive(Debug, Clone, Default)]
pub(super) struct Ties {
    /// Numbers of the nodes of each cube, in the order of the grid's cubes.
    pub(super) of_cell: Vec<Vec<u32>>,
    /// Of each node, what it is in free nodes.
    pub(super) ties: Vec<Tie>,
    /// Places of the free nodes on the lattice.
    pub(super) free: Vec<[i32; 3]>,
    /// Of each cube the one that it belongs to: itself where it is well filled.
    pub(super) root: Vec<usize>,
}

/// What ties are found from.
struct Lattice<'a> {
    grid: &'a Grid,
    order: Order,
    cells: Vec<Cell>,
    number: BTreeMap<[i32; 3], usize>,
    well: Vec<bool>,
    root: Vec<usize>,
    /// Nodes that a well-filled cube rests on.
    held: BTreeSet<[i32; 3]>,
}

impl Ties {
    /// Of the cubes of a grid, filled to these parts of them.
    pub(super) fn new(grid: &Grid, order: Order, filled: &[f64], least: f64) -> Result<Self, NoMesh> {
        let cells: Vec<Cell> = grid.cells().collect();
        let mut lattice = Lattice {
            grid,
            order,
            number: cells.iter().enumerate().map(|(k, c)| (c.corner, k)).collect(),
            well: filled.iter().map(|f| *f >= least).collect(),
            root: Vec::new(),
            held: BTreeSet::new(),
            cells,
        };
        lattice.root = lattice.roots(filled)?;
        lattice.find_held();
        Ok(lattice.ties())
    }
}

impl Lattice<'_> {
    /// Of each cube the well-filled one that it hangs on, across faces.
    fn roots(&self, filled: &[f64]) -> Result<Vec<usize>, NoMesh> {
        let mut root: Vec<Option<usize>> = (0..self.cells.len()).map(|k| self.well[k].then_some(k)).collect();
        let mut waiting: VecDeque<usize> = (0..self.cells.len()).filter(|k| self.well[*k]).collect();
        // In rings from the well-filled ones, not far: a polynomial says little beyond the next cube but one. Of several
        // neighbours in a ring the fullest.
        for _ in 0..MOST_RINGS {
            let mut next: BTreeMap<usize, usize> = BTreeMap::new();
            for from in waiting.drain(..) {
                for beside in self.grid.across(&self.cells[from]) {
                    let Some(&k) = self.number.get(&beside.corner) else {
                        continue;
                    };
                    if root[k].is_none() {
                        let best = next.entry(k).or_insert(from);
                        if filled[from] > filled[*best] {
                            *best = from;
                        }
                    }
                }
            }
            for (k, from) in next {
                root[k] = root[from];
                waiting.push_back(k);
            }
        }
        let missing = root.iter().position(Option::is_none);
        match missing {
            Some(k) => {
                let at = self
                    .grid
                    .place(self.cells[k].corner.map(|x| x + self.cells[k].span / 2));
                let side = self.grid.length(self.cells[k].span);
                Err(NoMesh::Thin { at: at.into(), side })
            }
            None => Ok(root.into_iter().flatten().collect()),
        }
    }

    /// Places of a cube's nodes.
    fn nodes(&self, cell: &Cell) -> Vec<[i32; 3]> {
        let (n, apart) = match self.order {
            Order::Linear => (2, cell.span),
            Order::Quadratic => (3, cell.span / 2),
        };
        let one = |k: i32| [k % n, k / n % n, k / n / n];
        (0..n * n * n)
            .map(|k| {
                let by = one(k);
                [0, 1, 2].map(|axis| cell.corner[axis] + apart * by[axis])
            })
            .collect()
    }

    /// The cube that a node hangs on: the largest that it lies on without being its node.
    fn hangs_on(&self, at: [i32; 3]) -> Option<Cell> {
        let apart = |c: &Cell| match self.order {
            Order::Linear => c.span,
            Order::Quadratic => c.span / 2,
        };
        let own = |c: &Cell| (0..3).all(|k| (at[k] - c.corner[k]) % apart(c) == 0);
        let others = self.grid.touching(at).into_iter().filter(|c| !own(c));
        others.max_by_key(|c| (c.span, std::cmp::Reverse(c.corner)))
    }

    fn find_held(&mut self) {
        let mut waiting: Vec<[i32; 3]> = (0..self.cells.len())
            .filter(|k| self.well[*k])
            .flat_map(|k| self.nodes(&self.cells[k]))
            .collect();
        let mut seen = BTreeSet::new();
        // What a hanging node of a well-filled cube rests on is held by that cube's material, wherever it lies.
        while let Some(at) = waiting.pop() {
            if !seen.insert(at) {
                continue;
            }
            match self.hangs_on(at) {
                Some(cell) => {
                    let weights = self.shape(&cell, at);
                    let nodes = self.nodes(&cell);
                    waiting.extend(nodes.iter().zip(weights).filter(|(_, w)| *w != 0.0).map(|(n, _)| *n));
                }
                None => {
                    self.held.insert(at);
                }
            }
        }
    }

    /// Shape functions of a cube's nodes at a place of the lattice.
    fn shape(&self, cell: &Cell, at: [i32; 3]) -> Vec<f64> {
        values(self.order, self.local(cell, at))
    }

    fn local(&self, cell: &Cell, at: [i32; 3]) -> [f64; 3] {
        [0, 1, 2].map(|k| f64::from(2 * (at[k] - cell.corner[k]) - cell.span) / f64::from(cell.span))
    }

    fn ties(self) -> Ties {
        let mut found = Found {
            extension: Extension::new(self.order),
            lattice: &self,
            free: BTreeMap::new(),
            places: Vec::new(),
            done: BTreeMap::new(),
        };
        // Free nodes are numbered in the order of the cubes.
        let mut numbers: BTreeMap<[i32; 3], u32> = BTreeMap::new();
        let (mut of_cell, mut ties) = (Vec::new(), Vec::new());
        for (k, cell) in self.cells.iter().enumerate() {
            let mut of_this = Vec::new();
            for at in self.nodes(cell) {
                let next = ties.len() as u32;
                let number = *numbers.entry(at).or_insert(next);
                if number == next {
                    let tie = found.tie(at, k);
                    ties.push(tie);
                }
                of_this.push(number);
            }
            of_cell.push(of_this);
        }
        Ties {
            of_cell,
            ties,
            free: found.places,
            root: self.root,
        }
    }
}

/// Ties found so far.
struct Found<'a> {
    lattice: &'a Lattice<'a>,
    extension: Extension,
    free: BTreeMap<[i32; 3], u32>,
    places: Vec<[i32; 3]>,
    done: BTreeMap<[i32; 3], Tie>,
}

impl Found<'_> {
    /// What the node at a place is, seen from a cube that it is a node of.
    fn tie(&mut self, at: [i32; 3], from: usize) -> Tie {
        if let Some(tie) = self.done.get(&at) {
            return tie.clone();
        }
        let lattice = self.lattice;
        let tie = if let Some(cell) = lattice.hangs_on(at) {
            self.combined(&cell, &lattice.shape(&cell, at))
        } else if lattice.held.contains(&at) {
            let next = self.places.len() as u32;
            let number = *self.free.entry(at).or_insert(next);
            // Numbered as they are met: near ones have near numbers.
            if number == next {
                self.places.push(at);
            }
            vec![(number, 1.0)]
        } else {
            // Held by no well-filled cube: `from` is none, and has one for a root.
            let root = lattice.cells[lattice.root[from]];
            self.combined(&root, &self.extension.values(lattice.local(&root, at)))
        };
        self.done.insert(at, tie.clone());
        tie
    }

    fn combined(&mut self, cell: &Cell, weights: &[f64]) -> Tie {
        let lattice = self.lattice;
        let number = lattice.number.get(&cell.corner).copied().unwrap_or_default();
        let mut sum: BTreeMap<u32, f64> = BTreeMap::new();
        for (at, weight) in lattice.nodes(cell).into_iter().zip(weights) {
            if *weight != 0.0 {
                for (node, part) in self.tie(at, number) {
                    *sum.entry(node).or_insert(0.0) += weight * part;
                }
            }
        }
        // Weights that cancel but for rounding would be nodes without effect in every table.
        sum.into_iter().filter(|(_, w)| w.abs() > 1e-14).collect()
    }
}

/// Weights of a cube's nodes in the polynomial nearest to its field, at places outside it too.
struct Extension {
    /// Nodes by polynomials.
    weights: DMatrix<f64>,
    degree: usize,
}

impl Extension {
    /// Of the first degree from 8 nodes, of the second from 27: by least squares over the nodes, which grow far less with
    /// the distance than the shape functions do.
    fn new(order: Order) -> Self {
        let (degree, n) = match order {
            Order::Linear => (1, 2),
            Order::Quadratic => (2, 3),
        };
        let apart = 2.0 / (n - 1) as f64;
        let node = |k: usize| [k % n, k / n % n, k / n / n].map(|i| i as f64 * apart - 1.0);
        let rows: Vec<Vec<f64>> = (0..n * n * n).map(|k| polynomials(node(k), degree)).collect();
        let b = DMatrix::from_fn(rows.len(), rows[0].len(), |i, j| rows[i][j]);
        // Of full rank: the lattice tells all these polynomials apart.
        let inverse = (b.transpose() * &b).try_inverse();
        let weights = inverse.map_or_else(|| DMatrix::zeros(b.nrows(), b.ncols()), |m| &b * m);
        Self { weights, degree }
    }

    fn values(&self, at: [f64; 3]) -> Vec<f64> {
        let p = nalgebra::DVector::from_vec(polynomials(at, self.degree));
        (&self.weights * p).iter().copied().collect()
    }
}

fn polynomials(at: [f64; 3], degree: usize) -> Vec<f64> {
    let x = Vector3::from(at);
    let mut values = vec![1.0, x.x, x.y, x.z];
    if degree == 2 {
        values.extend([x.x * x.x, x.y * x.y, x.z * x.z, x.x * x.y, x.y * x.z, x.z * x.x]);
    }
    values
}
