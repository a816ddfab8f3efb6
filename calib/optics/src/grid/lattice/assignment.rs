//! Which column and row a lattice's cells are: by the size of the grid, and by its large discs where they are known.

use std::collections::HashSet;

use nalgebra::{Matrix3, Vector2};

use crate::grid::error::GridRefused;
use crate::grid::found::GridSpec;
use crate::grid::lattice::Cell;

/// Quarter turns of the lattice, row by row.
pub(crate) const TURNS: [[i32; 4]; 4] = [[1, 0, 0, 1], [0, -1, 1, 0], [-1, 0, 0, -1], [0, 1, -1, 0]];

/// Column and row of a cell: `turn * cell + shift`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Assignment {
    pub(crate) turn: [i32; 4],
    pub(crate) shift: Cell,
    /// How many ways of counting columns and rows the object looks the same in, this one with them: 1, 2 or 4.
    pub(crate) alike: usize,
}

/// What of a grid is seen, in the lattice's cells.
pub(crate) struct View<'a> {
    pub(crate) spec: &'a GridSpec,
    /// First and last column and row that hold discs.
    pub(crate) span: [[i32; 2]; 2],
    /// Places of discs of the usual size, and of large ones.
    pub(crate) small: &'a [Cell],
    pub(crate) large: &'a HashSet<Cell>,
    /// The image's direction of the lattice's two axes: columns are to go to the right.
    pub(crate) axes: [Vector2<f64>; 2],
    pub(crate) candidates: usize,
}

fn turned([a, b, c, d]: [i32; 4], [u, v]: Cell) -> Cell {
    [a * u + b * v, c * u + d * v]
}

impl Assignment {
    /// Column and row of a cell, which may lie outside the grid.
    pub(crate) fn place(&self, cell: Cell) -> Cell {
        let [u, v] = turned(self.turn, cell);
        [u + self.shift[0], v + self.shift[1]]
    }

    /// The cell of a column and row.
    pub(crate) fn cell(&self, [col, row]: Cell) -> Cell {
        let [a, b, c, d] = self.turn;
        // A rotation's inverse is its transpose.
        turned([a, c, b, d], [col - self.shift[0], row - self.shift[1]])
    }

    /// [`Assignment::cell`] as a map of the plane.
    pub(crate) fn lattice_from_grid(&self) -> Matrix3<f64> {
        let [o, x, y] = [self.cell([0, 0]), self.cell([1, 0]), self.cell([0, 1])];
        let step = |p: Cell, k: usize| f64::from(p[k] - o[k]);
        let [u, v] = o.map(f64::from);
        Matrix3::new(step(x, 0), step(y, 0), u, step(x, 1), step(y, 1), v, 0.0, 0.0, 1.0)
    }
}

/// The turns of the whole grid, quarter by quarter, that leave its outline and its large discs where they are.
fn symmetries(spec: &GridSpec) -> usize {
    let marks: HashSet<[usize; 2]> = spec.marks.iter().copied().collect();
    let (last, square) = ([spec.cols - 1, spec.rows - 1], spec.cols == spec.rows);
    let turn = |k: usize, [c, r]: [usize; 2]| match k {
        0 => [c, r],
        1 => [last[1] - r, c],
        2 => [last[0] - c, last[1] - r],
        _ => [r, last[0] - c],
    };
    let leaves = |k: &usize| (square || k.is_multiple_of(2)) && marks.iter().all(|m| marks.contains(&turn(*k, *m)));
    (0..4).filter(leaves).count()
}

impl View<'_> {
    /// Seats the lattice in the grid where only one way agrees with what is seen, or ways that the object itself looks
    /// the same in; of those the one whose columns go most to the right.
    pub(crate) fn seat(&self) -> Result<Assignment, GridRefused> {
        // Without marks a view shows the whole grid, and each turn that fits has one shift; with them a part may have
        // many.
        let fitting: Vec<Assignment> = TURNS.into_iter().flat_map(|turn| self.shifts(turn)).collect();
        if fitting.is_empty() || (self.spec.marks.is_empty() && !self.is_whole()) {
            return Err(self.wrong_size());
        }
        let marks: HashSet<Cell> = self.spec.marks.iter().map(|m| m.map(|k| k as i32)).collect();
        let mut agreeing: Vec<Assignment> = fitting.into_iter().filter(|s| self.agrees(s, &marks)).collect();
        let alike = symmetries(self.spec);
        // Every way that agrees does so in each symmetry of the grid: more than those are different ways.
        if agreeing.len() != alike {
            return Err(GridRefused::Undecided {
                found: self.small.len() + self.large.len(),
                large: self.large.len(),
                marks: marks.len(),
                ways: agreeing.len() / alike,
            });
        }
        agreeing.sort_by(|a, b| self.right(a).total_cmp(&self.right(b)));
        let seat = agreeing.pop().ok_or_else(|| self.wrong_size())?;
        Ok(Assignment { alike, ..seat })
    }

    fn is_whole(&self) -> bool {
        let size = self.size();
        let asked = [self.spec.cols, self.spec.rows];
        size == asked || [size[1], size[0]] == asked
    }

    /// Whether more columns or rows are seen than the grid has, whichever way it is turned.
    pub(crate) fn is_too_large(&self) -> bool {
        let [columns, rows] = self.size();
        let fits = |cols: usize, lines: usize| columns <= cols && rows <= lines;
        !fits(self.spec.cols, self.spec.rows) && !fits(self.spec.rows, self.spec.cols)
    }

    /// Columns and rows that are seen.
    pub(crate) fn size(&self) -> [usize; 2] {
        self.span.map(|[a, b]| (b - a + 1).max(0) as usize)
    }

    /// All shifts at which a turned span lies in the grid.
    fn shifts(&self, turn: [i32; 4]) -> Vec<Assignment> {
        let [columns, rows] = self.span;
        let corners = [turned(turn, [columns[0], rows[0]]), turned(turn, [columns[1], rows[1]])];
        let low = [0, 1].map(|k| corners[0][k].min(corners[1][k]));
        let high = [0, 1].map(|k| corners[0][k].max(corners[1][k]));
        let free = [
            self.spec.cols as i32 - 1 - (high[0] - low[0]),
            self.spec.rows as i32 - 1 - (high[1] - low[1]),
        ];
        let seat = |x: i32, y: i32| Assignment {
            turn,
            shift: [x - low[0], y - low[1]],
            alike: 1,
        };
        (0..=free[1])
            .flat_map(|y| (0..=free[0]).map(move |x| seat(x, y)))
            .collect()
    }

    /// Large discs stand only where the grid has them, and usual ones only where it has not.
    fn agrees(&self, seat: &Assignment, marks: &HashSet<Cell>) -> bool {
        if marks.is_empty() {
            return true;
        }
        self.large.iter().all(|c| marks.contains(&seat.place(*c)))
            && self.small.iter().all(|c| !marks.contains(&seat.place(*c)))
    }

    /// How far to the right the columns go.
    fn right(&self, seat: &Assignment) -> f64 {
        // The lattice's step that makes one column: the first row of the turn, whose inverse is its transpose.
        let [a, b, ..] = seat.turn;
        let step = self.axes[0] * f64::from(a) + self.axes[1] * f64::from(b);
        step.try_normalize(0.0).map_or(-1.0, |s| s.x)
    }

    pub(crate) fn wrong_size(&self) -> GridRefused {
        let [seen_cols, seen_rows] = self.size();
        GridRefused::WrongSize {
            candidates: self.candidates,
            found: self.small.len() + self.large.len(),
            seen_cols,
            seen_rows,
            cols: self.spec.cols,
            rows: self.spec.rows,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What a window of a grid with three large discs shows, its lattice turned and counted from elsewhere.
    fn seated(
        window: [[i32; 2]; 2],
        turn: usize,
        marks: &[[usize; 2]],
    ) -> Result<(Assignment, Assignment), GridRefused> {
        let spec = GridSpec {
            marks: marks.to_vec(),
            ..GridSpec::new(9, 9, 5.0)
        };
        let truth = Assignment {
            turn: TURNS[turn],
            shift: [3, 11],
            alike: 1,
        };
        let is_mark = |c: &Cell| marks.contains(&c.map(|k| k as usize));
        let [columns, rows] = window;
        let all: Vec<Cell> = (rows[0]..=rows[1])
            .flat_map(|r| (columns[0]..=columns[1]).map(move |c| [c, r]))
            .collect();
        let lattice = |cells: Vec<Cell>| -> Vec<Cell> { cells.iter().map(|c| truth.cell(*c)).collect() };
        let small = lattice(all.iter().copied().filter(|c| !is_mark(c)).collect());
        let large = lattice(all.iter().copied().filter(is_mark).collect());
        let every: Vec<Cell> = small.iter().chain(&large).copied().collect();
        let bound = |k: usize| {
            let v = every.iter().map(|c| c[k]);
            [v.clone().min().unwrap(), v.max().unwrap()]
        };
        let view = View {
            spec: &spec,
            span: [bound(0), bound(1)],
            small: &small,
            large: &large.into_iter().collect(),
            axes: [Vector2::x(), Vector2::y()],
            candidates: 81,
        };
        view.seat().map(|s| (s, truth))
    }

    const MARKS: [[usize; 2]; 3] = [[2, 2], [6, 2], [2, 6]];

    #[test]
    fn three_large_discs_decide_the_turn_and_the_place_of_every_window_that_shows_them() {
        for turn in 0..4 {
            for window in [[[0, 8], [0, 8]], [[1, 7], [2, 6]], [[2, 6], [2, 8]]] {
                let (seat, truth) = seated(window, turn, &MARKS).unwrap();
                assert_eq!((seat.turn, seat.shift, seat.alike), (truth.turn, truth.shift, 1));
            }
        }
    }

    #[test]
    fn a_window_that_the_large_discs_do_not_decide_is_refused() {
        for window in [[[3, 8], [3, 8]], [[0, 4], [0, 4]]] {
            let refused = seated(window, 1, &MARKS).unwrap_err();
            assert!(matches!(refused, GridRefused::Undecided { ways: 2.., .. }), "{refused}");
        }
        // Without large discs only the whole grid is told, and all four turns look the same.
        assert!(matches!(
            seated([[0, 7], [0, 8]], 0, &[]),
            Err(GridRefused::WrongSize { seen_cols: 8, .. })
        ));
        assert_eq!(seated([[0, 8], [0, 8]], 3, &[]).unwrap().0.alike, 4);
    }

    #[test]
    fn what_the_grid_has_not_is_no_way() {
        // Large discs at places where the description has none.
        let spec = GridSpec {
            marks: vec![[0, 0]],
            ..GridSpec::new(3, 3, 1.0)
        };
        let view = View {
            spec: &spec,
            span: [[0, 2], [0, 2]],
            small: &[],
            large: &HashSet::from([[1, 1]]),
            axes: [Vector2::x(), Vector2::y()],
            candidates: 9,
        };
        let refused = view.seat().unwrap_err();
        assert!(matches!(refused, GridRefused::Undecided { ways: 0, .. }), "{refused}");
    }

    #[test]
    fn turns_that_the_large_discs_survive_are_counted() {
        let with = |cols, rows, marks: &[[usize; 2]]| GridSpec {
            marks: marks.to_vec(),
            ..GridSpec::new(cols, rows, 5.0)
        };
        assert_eq!(symmetries(&with(10, 10, &[])), 4);
        assert_eq!(symmetries(&with(16, 14, &[])), 2);
        assert_eq!(symmetries(&with(16, 14, &[[5, 4], [10, 4], [5, 9], [10, 9]])), 2);
        assert_eq!(symmetries(&with(9, 9, &MARKS)), 1);
        assert_eq!(symmetries(&with(9, 9, &[[4, 4]])), 4);
        assert_eq!(symmetries(&with(4, 4, &[[0, 0]])), 1);
    }
}
