//! `L D L^T` of a sparse symmetric matrix.

use super::Triplets;
use super::front::{Factor, Vanished, eliminate, subtract};
use super::symbolic::{Front, Symbolic};

/// Patterns that are joined before the oldest are forgotten.
const MOST_JOINED: usize = 8;

/// The signs of the pivots, which are those of the eigenvalues.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Inertia {
    /// Pivots above zero.
    pub positive: usize,
    /// Pivots below zero.
    pub negative: usize,
}

/// A pivot vanished: the matrix, or a leading block of it, is singular.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error(
    "the pivot of unknown {unknown} is {pivot:e}, nothing beside its diagonal entry {diagonal:e}: the matrix is singular"
)]
pub struct NoPivot {
    /// The unknown whose pivot it is.
    pub unknown: usize,
    /// The pivot.
    pub pivot: f64,
    /// The diagonal entry that it comes from.
    pub diagonal: f64,
}

/// A factorisation that remembers the pattern it met last, so that a matrix of the same pattern costs no search.
///
/// Multifrontal (Duff and Reid 1983): unknowns with the same rows below are eliminated together, in a dense matrix that takes
/// up what those before it left behind. On a mesh the first ones are the elements, whose inner nodes are thus condensed.
#[derive(Debug, Clone, Default)]
pub struct Ldl {
    places: Vec<(u32, u32)>,
    /// The entry that each triplet adds to.
    slots: Vec<u32>,
    /// The places that the elimination was found for: those of several matrices.
    pattern: Vec<(u32, u32)>,
    pub(super) joined: usize,
    symbolic: Symbolic,
    /// The matrix taken up last, by the same places as the factor.
    matrix: Vec<f64>,
    /// The columns of all fronts: `L`, and the pivots on the diagonal.
    factor: Vec<f64>,
    /// What a shift is multiplied by, unknown by unknown; none: 1.
    weights: Vec<f64>,
    /// The diagonal of what is factored, in the order of elimination.
    diagonal: Vec<f64>,
    /// What fronts left behind and no other has taken yet: front and beginning, and dense lower triangles.
    left: Vec<(usize, usize)>,
    stack: Vec<f64>,
    scratch: Vec<f64>,
}

impl Ldl {
    /// A factorisation of nothing yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Factors `matrix + shift I`. Without pivoting: exact for definite matrices, and for others while no leading block
    /// in the order of elimination is near singular; [`Self::solve`]'s residual tells.
    ///
    /// # Errors
    /// [`NoPivot`], also where an entry is not a number.
    pub fn factor(&mut self, matrix: &Triplets, shift: f64) -> Result<Inertia, NoPivot> {
        self.take(matrix);
        self.shifted(shift)
    }

    /// Shifts from here on are `shift` times these on the diagonal, by unknown; of none of them times 1.
    pub fn weigh(&mut self, weights: &[f64]) {
        self.weights.clear();
        self.weights.extend_from_slice(weights);
    }

    /// Takes up a matrix, to be factored with several shifts.
    pub fn take(&mut self, matrix: &Triplets) {
        let size = matrix.size();
        if self.symbolic.order.len() != size || self.places != matrix.places {
            self.learn(size, &matrix.places);
        }
        self.matrix.clear();
        self.matrix.resize(self.symbolic.entries, 0.0);
        for (slot, value) in self.slots.iter().zip(&matrix.values) {
            self.matrix[*slot as usize] += value;
        }
    }

    /// Factors the matrix taken up last, and `shift I`, as [`Self::factor`] does.
    ///
    /// # Errors
    /// [`NoPivot`].
    pub fn shifted(&mut self, shift: f64) -> Result<Inertia, NoPivot> {
        self.shift(shift);
        let negative = self.eliminate(usize::MAX)?;
        Ok(Inertia {
            positive: self.diagonal.len() - negative,
            negative,
        })
    }

    /// The same, but at the first negative pivot it ends: true where the matrix is definite. After false
    /// [`Self::falling_direction`] has an answer, and [`Self::solve`] none.
    ///
    /// # Errors
    /// [`NoPivot`].
    pub fn definite(&mut self, shift: f64) -> Result<bool, NoPivot> {
        self.shift(shift);
        Ok(self.eliminate(1)? == 0)
    }

    /// Where the entries of a new pattern go. Contacts come and go: the elimination is kept while it has a place for each,
    /// and found anew for both patterns together where it has not.
    fn learn(&mut self, size: usize, places: &[(u32, u32)]) {
        let known = self.symbolic.order.len() == size && size > 0;
        if !(known && self.find_slots(places)) {
            // A pattern that only grew would keep room, and work, for contacts long gone.
            if !known || self.joined >= MOST_JOINED {
                self.pattern.clear();
                self.joined = 0;
            }
            self.joined += 1;
            let same = common(&self.pattern, places);
            self.pattern.extend_from_slice(&places[same..]);
            self.symbolic = Symbolic::new(size, &self.pattern);
            self.places.clear();
            // Every place was put in above.
            self.find_slots(places);
        }
        let known = self.places.len();
        self.places.extend_from_slice(&places[known..]);
    }

    /// The slots of these places; those that begin as the last ones did are known. False where the elimination lacks one.
    fn find_slots(&mut self, places: &[(u32, u32)]) -> bool {
        let same = common(&self.places, places);
        self.slots.truncate(same);
        self.places.truncate(same);
        for place in &places[same..] {
            match self.symbolic.slot(*place) {
                Some(slot) => self.slots.push(slot),
                None => return false,
            }
        }
        true
    }

    /// Entries of `L` below the diagonal.
    pub fn fill(&self) -> usize {
        let fronts = self.symbolic.fronts.iter();
        fronts.map(|f| f.width * (f.width - 1) / 2 + f.width * f.height).sum()
    }

    /// Multiplications of a factorisation.
    pub fn work(&self) -> usize {
        let columns = self
            .symbolic
            .fronts
            .iter()
            .flat_map(|f| (0..f.width).map(|k| f.size() - 1 - k));
        columns.map(|c| c * (c + 3) / 2).sum()
    }

    fn shift(&mut self, shift: f64) {
        // Elimination is in place: the matrix stays for the next shift.
        self.factor.clone_from(&self.matrix);
        self.diagonal.clear();
        for (slot, unknown) in self.symbolic.diagonals().zip(&self.symbolic.order) {
            let weight = self.weights.get(*unknown as usize).copied().unwrap_or(1.0);
            self.factor[slot] += shift * weight;
            self.diagonal.push(self.factor[slot]);
        }
    }

    /// Front by front: what is left below a front waits on the stack for its parent. How many pivots are negative; once they
    /// are `most`, the rest is left as it is.
    fn eliminate(&mut self, most: usize) -> Result<usize, NoPivot> {
        self.left.clear();
        self.stack.clear();
        let mut negative = 0;
        for k in 0..self.symbolic.fronts.len() {
            let front = self.symbolic.fronts[k];
            let found = self.front(k, &front, most - negative);
            negative += found.map_err(|(column, pivot, diagonal)| NoPivot {
                unknown: self.symbolic.order[front.first + column] as usize,
                pivot,
                diagonal,
            })?;
            if negative >= most {
                break;
            }
        }
        Ok(negative)
    }

    fn front(&mut self, number: usize, front: &Front, most: usize) -> Result<usize, Vanished> {
        let top = self.stack.len();
        self.stack.resize(top + front.height * front.height, 0.0);
        let panel = &mut self.factor[front.panel()];
        let (waiting, own) = self.stack.split_at_mut(top);
        let children = self.left.len() - front.children;
        // What the children left is summed where this front needs it (Duff and Reid 1983).
        for &(child, start) in &self.left[children..] {
            take_up(&self.symbolic, child, &waiting[start..], front, panel, own);
        }
        let diagonal = &self.diagonal[front.first..front.first + front.width];
        let negative = eliminate(panel, front.size(), diagonal, most, &mut self.scratch)?;
        // Only the number of negative pivots was asked for, up to that many.
        if negative >= most {
            return Ok(negative);
        }
        let factor = Factor {
            columns: panel,
            size: front.size(),
            skip: front.width,
        };
        subtract(&factor, own, front.height, front.height, &mut self.scratch);
        let base = self.left.get(children).map_or(top, |(_, start)| *start);
        // The children are used up: what this front leaves takes their place on the stack.
        self.stack.copy_within(top.., base);
        self.stack.truncate(base + front.height * front.height);
        self.left.truncate(children);
        if front.height > 0 {
            self.left.push((number, base));
        }
        Ok(negative)
    }

    /// A direction `v` with `v^T A v < 0`, from the first negative pivot of the matrix `A` factored last: `L^T v = e_k`, which
    /// asks for the columns before that pivot only.
    pub fn falling_direction(&self) -> Option<Vec<f64>> {
        let s = &self.symbolic;
        // `v^T A v = d_k < 0` for `L^T v = e_k`. Columns after the first negative pivot may not be eliminated; `e_k`
        // has no part in them.
        let first = s.diagonals().position(|slot| self.factor[slot] < 0.0)?;
        let mut x = vec![0.0; s.order.len()];
        x[first] = 1.0;
        self.solve_transposed(&mut x);
        let mut direction = vec![0.0; x.len()];
        for (i, value) in s.order.iter().zip(x) {
            direction[*i as usize] = value;
        }
        Some(direction)
    }

    /// `L^T x = b` in the order of elimination.
    fn solve_transposed(&self, x: &mut [f64]) {
        let mut below = Vec::new();
        for front in self.symbolic.fronts.iter().rev() {
            let (panel, size) = (&self.factor[front.panel()], front.size());
            let rows = &self.symbolic.rows[front.rows..front.rows + front.height];
            below.clear();
            below.extend_from_slice(&x[front.first..front.first + front.width]);
            below.extend(rows.iter().map(|row| x[*row as usize]));
            // Backwards: a column needs those after it.
            for k in (0..front.width).rev() {
                let column = &panel[k * size + k + 1..(k + 1) * size];
                let sum: f64 = column.iter().zip(&below[k + 1..]).map(|(l, x)| l * x).sum();
                below[k] -= sum;
            }
            x[front.first..front.first + front.width].copy_from_slice(&below[..front.width]);
        }
    }

    /// `L x = b`, then `D x = b`, in the order of elimination.
    fn solve_lower(&self, x: &mut [f64]) {
        let mut below = Vec::new();
        for front in &self.symbolic.fronts {
            let (panel, size) = (&self.factor[front.panel()], front.size());
            let rows = &self.symbolic.rows[front.rows..front.rows + front.height];
            below.clear();
            below.resize(front.height, 0.0);
            let (own, width) = (&mut x[front.first..front.first + front.width], front.width);
            for k in 0..width {
                let (value, column) = (own[k], &panel[k * size..(k + 1) * size]);
                own[k + 1..]
                    .iter_mut()
                    .zip(&column[k + 1..width])
                    .for_each(|(x, l)| *x -= l * value);
                below
                    .iter_mut()
                    .zip(&column[width..])
                    .for_each(|(x, l)| *x += l * value);
                // The pivot on the diagonal; `L` itself has ones there.
                own[k] = value / column[k];
            }
            rows.iter().zip(&below).for_each(|(row, by)| x[*row as usize] -= by);
        }
    }

    /// Solves with the matrix factored last; `b` becomes the solution.
    pub fn solve(&self, b: &mut [f64]) {
        let order = &self.symbolic.order;
        let mut x: Vec<f64> = order.iter().map(|i| b[*i as usize]).collect();
        self.solve_lower(&mut x);
        self.solve_transposed(&mut x);
        for (i, value) in order.iter().zip(x) {
            b[*i as usize] = value;
        }
    }
}

/// How many places two lists have in common at their beginning.
fn common(one: &[(u32, u32)], other: &[(u32, u32)]) -> usize {
    one.iter().zip(other).take_while(|(a, b)| a == b).count()
}

/// Adds what a child left behind to its parent's columns and to the rest.
fn take_up(symbolic: &Symbolic, child: usize, left: &[f64], front: &Front, panel: &mut [f64], own: &mut [f64]) {
    let child = &symbolic.fronts[child];
    let to = &symbolic.in_parent[child.rows..child.rows + child.height];
    let (width, size) = (front.width, front.size());
    for (j, column) in left.chunks_exact(child.height).take(child.height).enumerate() {
        let at = to[j] as usize;
        let target = if at < width {
            &mut panel[at * size..(at + 1) * size]
        } else {
            // From here on all rows lie below the columns.
            let start = (at - width) * front.height;
            &mut own[start..start + front.height]
        };
        let before = if at < width { 0 } else { width };
        for (row, value) in to[j..].iter().zip(&column[j..]) {
            target[*row as usize - before] += value;
        }
    }
}
