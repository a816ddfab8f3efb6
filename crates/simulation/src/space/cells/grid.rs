//! An octree of cubes.

use std::collections::BTreeMap;

use nalgebra::Vector3;

/// A cube, in steps of its grid: half sides of the smallest cubes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Cell {
    /// Its lowest corner.
    pub corner: [i32; 3],
    /// Its side, a power of two of at least 2.
    pub span: i32,
}

/// Cubes that do not overlap, each at most twice as large as those that it touches, be it at a corner.
#[derive(Debug, Clone)]
pub struct Grid {
    origin: Vector3<f64>,
    step: f64,
    largest: i32,
    spans: BTreeMap<[i32; 3], i32>,
}

/// What a grid is made of.
pub(super) struct Cover<'a> {
    /// The box to cover.
    pub(super) low: Vector3<f64>,
    /// Its highest corner.
    pub(super) high: Vector3<f64>,
    /// Side of the largest cubes, mm.
    pub(super) side: f64,
    /// Times that they may be halved.
    pub(super) levels: u32,
    /// Whether a cube between two corners is wanted at all.
    pub(super) wanted: &'a dyn Fn(&Vector3<f64>, &Vector3<f64>) -> bool,
    /// Whether a cube between two corners is to be cut into eight.
    pub(super) fine: &'a dyn Fn(&Vector3<f64>, &Vector3<f64>) -> bool,
    /// More cubes than these are refused.
    pub(super) most: usize,
}

impl Grid {
    /// The cubes of a cover. `None` where they are too many.
    pub(super) fn new(cover: &Cover<'_>) -> Option<Self> {
        let largest = 2 << cover.levels;
        let mut grid = Self {
            origin: cover.low,
            step: cover.side / f64::from(largest),
            largest,
            spans: BTreeMap::new(),
        };
        // A side that fits a whole number of times must not make one cube more by its rounding.
        let counts = (cover.high - cover.low).map(|x| (x / cover.side * (1.0 - 1e-12)).ceil().max(1.0));
        // Steps are counted in 32 bits, and cubes below the limit.
        if !(counts.product() <= cover.most as f64 && counts.max() * f64::from(largest) < 1e9) {
            return None;
        }
        let counts = counts.map(|c| c as i32);
        for k in 0..counts.z {
            for j in 0..counts.y {
                for i in 0..counts.x {
                    let corner = [i, j, k].map(|x| x * largest);
                    grid.divide(cover, Cell { corner, span: largest })?;
                }
            }
        }
        grid.balance(cover)?;
        Some(grid)
    }

    fn divide(&mut self, cover: &Cover<'_>, cell: Cell) -> Option<()> {
        let [low, high] = self.corners(&cell);
        if !(cover.wanted)(&low, &high) {
            return Some(());
        }
        if cell.span > 2 && (cover.fine)(&low, &high) {
            return cell.parts().into_iter().try_for_each(|part| self.divide(cover, part));
        }
        self.spans.insert(cell.corner, cell.span);
        (self.spans.len() <= cover.most).then_some(())
    }

    /// Cuts what is more than twice as large as something that it touches.
    fn balance(&mut self, cover: &Cover<'_>) -> Option<()> {
        let mut waiting: Vec<Cell> = self.cells().collect();
        while let Some(cell) = waiting.pop() {
            if self.spans.get(&cell.corner) != Some(&cell.span) {
                continue;
            }
            for large in self.around(&cell).into_iter().filter(|c| c.span > 2 * cell.span) {
                self.spans.remove(&large.corner);
                for part in large.parts() {
                    let [low, high] = self.corners(&part);
                    if (cover.wanted)(&low, &high) {
                        self.spans.insert(part.corner, part.span);
                        waiting.push(part);
                    }
                }
                // Its parts may still be too large.
                waiting.push(cell);
            }
            (self.spans.len() <= cover.most).then_some(())?;
        }
        Some(())
    }

    /// The cubes, in the order of their corners.
    pub fn cells(&self) -> impl Iterator<Item = Cell> {
        self.spans.iter().map(|(corner, span)| Cell {
            corner: *corner,
            span: *span,
        })
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.spans.len()
    }

    /// True without any.
    pub fn is_empty(&self) -> bool {
        self.spans.is_empty()
    }

    /// Leaves out the cubes that are not wanted.
    pub(super) fn retain(&mut self, mut wanted: impl FnMut(&Cell) -> bool) {
        self.spans.retain(|corner, span| {
            wanted(&Cell {
                corner: *corner,
                span: *span,
            })
        });
    }

    /// A length of steps, mm.
    pub fn length(&self, steps: i32) -> f64 {
        self.step * f64::from(steps)
    }

    /// Where a place of the lattice of steps is.
    pub fn place(&self, at: [i32; 3]) -> Vector3<f64> {
        self.origin + Vector3::from(at.map(f64::from)) * self.step
    }

    /// Lowest and highest corner of a cube.
    pub fn corners(&self, cell: &Cell) -> [Vector3<f64>; 2] {
        [self.place(cell.corner), self.place(cell.corner.map(|x| x + cell.span))]
    }

    /// A place in a cube's own coordinates, from -1 to 1 inside.
    pub fn local(&self, cell: &Cell, at: &Vector3<f64>) -> [f64; 3] {
        let [low, high] = self.corners(cell);
        [0, 1, 2].map(|k| ((at[k] - low[k]) - (high[k] - at[k])) / (high[k] - low[k]))
    }

    /// The cube that a place lies in; on a shared face the upper one, on the last the lower one.
    pub fn containing(&self, at: &Vector3<f64>) -> Option<Cell> {
        let place = (at - self.origin) / self.step;
        let steps = place.map(f64::floor);
        if !steps.iter().all(|x| x.abs() < 1e9) {
            return None;
        }
        // On the last face there is no upper cube; the lower one holds the place as well.
        (0..8).find_map(|part| {
            let lower = |k: usize| part >> k & 1 == 1;
            // A place of the lattice, but for rounding.
            let allowed = (0..3).all(|k| !lower(k) || place[k] - steps[k] < 1e-9);
            allowed.then(|| self.cell_at([0, 1, 2].map(|k| steps[k] as i32 - i32::from(lower(k)))))?
        })
    }

    /// The cube that holds the step with this lowest corner.
    pub(super) fn cell_at(&self, step: [i32; 3]) -> Option<Cell> {
        // Corners are multiples of the span: one question for each size finds the cube.
        let mut span = 2;
        while span <= self.largest {
            let corner = step.map(|x| x.div_euclid(span) * span);
            if self.spans.get(&corner) == Some(&span) {
                return Some(Cell { corner, span });
            }
            span *= 2;
        }
        None
    }

    /// The cubes that hold a place of the lattice, inside or on their boundary.
    pub(super) fn touching(&self, at: [i32; 3]) -> Vec<Cell> {
        let each = (0..8).filter_map(|k| self.cell_at([0, 1, 2].map(|axis| at[axis] - (k >> axis & 1))));
        let mut cells: Vec<Cell> = each.collect();
        cells.sort_unstable();
        cells.dedup();
        cells
    }

    /// The cubes that touch another, as far as they are not smaller than half of it.
    fn around(&self, cell: &Cell) -> Vec<Cell> {
        let beside = [-1, 0, cell.span - 1, cell.span];
        let mut cells = Vec::new();
        for place in 0..64 {
            let steps = [place % 4, place / 4 % 4, place / 16].map(|k| beside[k]);
            if steps.iter().any(|s| *s < 0 || *s >= cell.span) {
                cells.extend(self.cell_at([0, 1, 2].map(|k| cell.corner[k] + steps[k])));
            }
        }
        cells.sort_unstable();
        cells.dedup();
        cells
    }

    /// The cubes across its six faces; of four smaller ones each.
    pub fn across(&self, cell: &Cell) -> Vec<Cell> {
        let one_beside = |c: &Cell| {
            let apart = |k: usize| c.corner[k] + c.span <= cell.corner[k] || c.corner[k] >= cell.corner[k] + cell.span;
            (0..3).filter(|k| apart(*k)).count() == 1
        };
        let mut cells = self.around(cell);
        cells.retain(one_beside);
        cells
    }
}

impl Cell {
    fn parts(&self) -> [Self; 8] {
        let half = self.span / 2;
        std::array::from_fn(|part| Self {
            corner: [0, 1, 2].map(|axis| self.corner[axis] + half * (part as i32 >> axis & 1)),
            span: half,
        })
    }
}
