//! Inside or outside, by crossings: along each row of a lattice, how often a closed surface winds about its nodes.

use nalgebra::Vector3;

/// Crossings of the rows along x of a lattice with a closed surface.
pub(super) struct Rows {
    /// For each row the place of its first crossing; one more at the end.
    first: Vec<u32>,
    /// Where a row crosses, and by how much the winding number changes there.
    crossings: Vec<(f64, i32)>,
    rows_y: usize,
}

/// Rows in y and z.
#[derive(Clone, Copy)]
pub(super) struct Lattice {
    pub(super) origin: Vector3<f64>,
    pub(super) spacing: f64,
    pub(super) rows: [usize; 2],
}

impl Rows {
    pub(super) fn new(triangles: impl Iterator<Item = [Vector3<f64>; 3]>, lattice: Lattice) -> Self {
        let mut all: Vec<(u32, f64, i32)> = Vec::new();
        for t in triangles {
            crossings_of(&t, lattice, &mut all);
        }
        all.sort_unstable_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.cmp(&b.2)));
        let count = lattice.rows[0] * lattice.rows[1];
        let first = (0..=count).map(|row| all.partition_point(|c| (c.0 as usize) < row) as u32);
        Self {
            first: first.collect(),
            crossings: all.iter().map(|c| (c.1, c.2)).collect(),
            rows_y: lattice.rows[0],
        }
    }

    /// The row (j, k), to be walked along x.
    pub(super) fn along(&self, j: usize, k: usize) -> Along<'_> {
        let row = k * self.rows_y + j;
        Along {
            left: &self.crossings[self.first[row] as usize..self.first[row + 1] as usize],
            winding: 0,
        }
    }
}

/// One row, walked along x.
pub(super) struct Along<'a> {
    left: &'a [(f64, i32)],
    winding: i32,
}

impl Along<'_> {
    /// The winding number at `x`, which must not be less than the one before.
    pub(super) fn winding(&mut self, x: f64) -> i32 {
        while let Some(((at, by), left)) = self.left.split_first()
            && *at < x
        {
            self.winding += by;
            self.left = left;
        }
        self.winding
    }
}

fn crossings_of([a, b, c]: &[Vector3<f64>; 3], lattice: Lattice, all: &mut Vec<(u32, f64, i32)>) {
    let normal = (b - a).cross(&(c - a));
    if normal.x == 0.0 {
        return;
    }
    let least = a.inf(b).inf(c) - lattice.origin;
    let most = a.sup(b).sup(c) - lattice.origin;
    // Casts saturate: what lies below the lattice begins at its first row.
    let range = |axis: usize| {
        let first = (least[axis] / lattice.spacing).ceil().max(0.0) as usize;
        let last = (most[axis] / lattice.spacing).floor();
        let end = if last < 0.0 {
            0
        } else {
            (last as usize + 1).min(lattice.rows[axis - 1])
        };
        first..end
    };
    for k in range(2) {
        for j in range(1) {
            let y = lattice.origin.y + lattice.spacing * j as f64;
            let z = lattice.origin.z + lattice.spacing * k as f64;
            let sides = [is_left(a, b, y, z), is_left(b, c, y, z), is_left(c, a, y, z)];
            if sides[0] == sides[1] && sides[1] == sides[2] {
                let x = a.x - (normal.y * (y - a.y) + normal.z * (z - a.z)) / normal.x;
                // A face that looks against x is where a row goes in.
                let by = if normal.x < 0.0 { 1 } else { -1 };
                all.push(((k * lattice.rows[0] + j) as u32, x, by));
            }
        }
    }
}

/// Whether (y, z) is left of the way from a to b. Computed for the edge in one direction whichever way a triangle goes along it, so that
/// its two triangles agree to the bit: no row slips through between them.
fn is_left(a: &Vector3<f64>, b: &Vector3<f64>, y: f64, z: f64) -> bool {
    let is_ordered = (a.y, a.z, a.x) < (b.y, b.z, b.x);
    let (p, q) = if is_ordered { (a, b) } else { (b, a) };
    let side = (q.y - p.y) * (z - p.z) - (q.z - p.z) * (y - p.y) >= 0.0;
    side == is_ordered
}
