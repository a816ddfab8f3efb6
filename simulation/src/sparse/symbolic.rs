//! Where the entries of a factor are, from where those of the matrix are.

use super::order::minimum_degree;

/// The elimination of one pattern: order, columns of `L`, and where each entry of the matrix goes.
#[derive(Debug, Clone, Default)]
pub(super) struct Symbolic {
    /// The unknown eliminated k-th.
    pub(super) order: Vec<u32>,
    /// Rows of `L` by row: the columns left of the diagonal that row k holds, in an order fit for elimination.
    pub(super) row_start: Vec<usize>,
    pub(super) row_columns: Vec<u32>,
    /// `L` by column.
    pub(super) column_start: Vec<usize>,
    pub(super) column_rows: Vec<u32>,
    /// The upper triangle of the permuted matrix by column: rows of its entries.
    pub(super) entry_start: Vec<usize>,
    pub(super) entry_rows: Vec<u32>,
    /// When each unknown is eliminated.
    place_of: Vec<u32>,
}

const NONE: u32 = u32::MAX;

impl Symbolic {
    /// The elimination of a matrix with entries at these places of its lower triangle.
    pub(super) fn new(size: usize, places: &[(u32, u32)]) -> Self {
        let order = minimum_degree(&neighbours(size, places));
        let mut place_of = vec![0_u32; size];
        for (k, i) in order.iter().enumerate() {
            place_of[*i] = k as u32;
        }
        let mut symbolic = Self {
            order: order.into_iter().map(|i| i as u32).collect(),
            ..Self::default()
        };
        symbolic.place_of = place_of;
        symbolic.gather_entries(size, places);
        let parents = symbolic.rows_of_factor(size);
        symbolic.columns_of_factor(size);
        debug_assert_eq!(parents.len(), size);
        symbolic
    }

    /// Column and row of a place in the permuted upper triangle.
    fn key(&self, (i, j): (u32, u32)) -> (u32, u32) {
        let (a, b) = (self.place_of[i as usize], self.place_of[j as usize]);
        (a.max(b), a.min(b))
    }

    /// Columns of the permuted upper triangle, each sorted, without repetitions.
    fn gather_entries(&mut self, size: usize, places: &[(u32, u32)]) {
        let keys = places.iter().map(|place| self.key(*place));
        let mut sorted: Vec<(u32, u32)> = keys.chain((0..size as u32).map(|k| (k, k))).collect();
        sorted.sort_unstable();
        sorted.dedup();
        self.entry_start = starts(size, sorted.iter().map(|(column, _)| *column));
        self.entry_rows = sorted.iter().map(|(_, row)| *row).collect();
    }

    /// The entry that each triplet adds to. `None` where the pattern lacks one.
    pub(super) fn slots(&self, places: &[(u32, u32)]) -> Option<Vec<u32>> {
        let find = |place: &(u32, u32)| {
            let (column, row) = self.key(*place);
            let start = self.entry_start[column as usize];
            let rows = &self.entry_rows[start..self.entry_start[column as usize + 1]];
            let k = rows.partition_point(|r| *r < row);
            (rows.get(k) == Some(&row)).then_some((start + k) as u32)
        };
        places.iter().map(find).collect()
    }

    /// The pattern of each row of `L` by walks up the elimination tree (Liu 1986), which they build.
    fn rows_of_factor(&mut self, size: usize) -> Vec<u32> {
        let mut parent = vec![NONE; size];
        let mut flag = vec![NONE; size];
        self.row_start = vec![0];
        for k in 0..size {
            flag[k] = k as u32;
            let mut row = Vec::new();
            for &entry in &self.entry_rows[self.entry_start[k]..self.entry_start[k + 1]] {
                let mut i = entry as usize;
                while flag[i] != k as u32 {
                    if parent[i] == NONE {
                        parent[i] = k as u32;
                    }
                    row.push(i as u32);
                    flag[i] = k as u32;
                    i = parent[i] as usize;
                }
            }
            // Descendants before ancestors: ascending numbers are such an order.
            row.sort_unstable();
            self.row_columns.extend(row);
            self.row_start.push(self.row_columns.len());
        }
        parent
    }

    fn columns_of_factor(&mut self, size: usize) {
        let mut columns = self.row_columns.clone();
        columns.sort_unstable();
        self.column_start = starts(size, columns.into_iter());
        let mut next = self.column_start.clone();
        self.column_rows = vec![0; self.row_columns.len()];
        for k in 0..size {
            for &column in &self.row_columns[self.row_start[k]..self.row_start[k + 1]] {
                self.column_rows[next[column as usize]] = k as u32;
                next[column as usize] += 1;
            }
        }
    }
}

/// Start of each of `size` runs of sorted numbers, and the end.
fn starts(size: usize, sorted: impl Iterator<Item = u32>) -> Vec<usize> {
    let mut starts = vec![0; size + 1];
    for number in sorted {
        starts[number as usize + 1] += 1;
    }
    for k in 0..size {
        starts[k + 1] += starts[k];
    }
    starts
}

fn neighbours(size: usize, places: &[(u32, u32)]) -> Vec<Vec<u32>> {
    let mut lists = vec![Vec::new(); size];
    for &(i, j) in places.iter().filter(|(i, j)| i != j) {
        lists[i as usize].push(j);
        lists[j as usize].push(i);
    }
    for list in &mut lists {
        list.sort_unstable();
        list.dedup();
    }
    lists
}
