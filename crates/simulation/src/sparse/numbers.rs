//! The numbers of an elimination, front by front: what is left below a front waits on a stack for its parent.

use super::front::{Factor, Scratch, Vanished, eliminate, subtract};
use super::symbolic::{Front, Symbolic};

/// What is eliminated: the elimination, and the diagonal of the matrix in its order.
#[derive(Clone, Copy)]
pub(super) struct Matrix<'a> {
    pub(super) symbolic: &'a Symbolic,
    pub(super) diagonal: &'a [f64],
}

/// Memory of one thread's elimination.
#[derive(Debug, Clone, Default)]
pub(super) struct Worker {
    /// What fronts left behind and no other has taken yet: front and beginning, and dense lower triangles.
    left: Vec<(usize, usize)>,
    stack: Vec<f64>,
    pub(super) scratch: Scratch,
}

impl Worker {
    pub(super) fn clear(&mut self) {
        self.left.clear();
        self.stack.clear();
    }

    /// Eliminates a front, whose columns are `panel`. How many pivots are negative: at `most` of them it ends.
    pub(super) fn front(
        &mut self,
        matrix: Matrix<'_>,
        number: usize,
        panel: &mut [f64],
        most: usize,
    ) -> Result<usize, Vanished> {
        let front = &matrix.symbolic.fronts[number];
        let (top, children) = self.assemble(matrix.symbolic, front, panel);
        let diagonal = &matrix.diagonal[front.first..front.first + front.width];
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
        // What the children left is in there already: after this it is what goes to the parent.
        let own = &mut self.stack[top..];
        subtract(&factor, own, front.height, front.height, &mut self.scratch);
        self.leave(front, number, [top, children]);
        Ok(negative)
    }

    /// Sums what the children left where this front needs it (Duff and Reid 1983). Where its own begins on the stack, and its
    /// first child.
    pub(super) fn assemble(&mut self, symbolic: &Symbolic, front: &Front, panel: &mut [f64]) -> (usize, usize) {
        let top = self.stack.len();
        // Zeros first, as some entries come from no child and others from several.
        self.stack.resize(top + front.height * front.height, 0.0);
        let (waiting, own) = self.stack.split_at_mut(top);
        let children = self.left.len() - front.children;
        for &(child, start) in &self.left[children..] {
            take_up(symbolic, child, &waiting[start..], front, panel, own);
        }
        (top, children)
    }

    /// The children are used up: what this front leaves takes their place on the stack.
    fn leave(&mut self, front: &Front, number: usize, [top, children]: [usize; 2]) {
        let base = self.left.get(children).map_or(top, |(_, start)| *start);
        // Moved down over what the children left, so that no room stays behind that nobody will read.
        self.stack.copy_within(top.., base);
        self.stack.truncate(base + front.height * front.height);
        self.left.truncate(children);
        if front.height > 0 {
            self.left.push((number, base));
        }
    }

    /// Takes over what another left.
    pub(super) fn append(&mut self, other: &Self) {
        let base = self.stack.len();
        self.stack.extend_from_slice(&other.stack);
        self.left
            .extend(other.left.iter().map(|(front, start)| (*front, base + start)));
    }
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
        // From the diagonal on: products of strips may have spoilt what lies above it.
        for (row, value) in to[j..].iter().zip(&column[j..]) {
            target[*row as usize - before] += value;
        }
    }
}
