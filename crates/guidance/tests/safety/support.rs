//! Label maps and tubes made by hand or by a seed, and the distance of a tube by force.

use chance::SplitMix64;
use geometry::{Affine, Ct, Point, Vector, VolumeGrid, Voxel};
use guidance::safety::{Structures, Tube};

pub(crate) struct Map {
    pub(crate) grid: VolumeGrid,
    /// x fastest, then y.
    pub(crate) labels: Vec<i16>,
}

impl Map {
    /// The labels by a rule of the voxel's index.
    pub(crate) fn of(grid: VolumeGrid, mut label: impl FnMut([u32; 3]) -> i16) -> Self {
        let labels = voxels(&grid).map(&mut label).collect();
        Self { grid, labels }
    }

    pub(crate) fn build(&self) -> Structures {
        let [x, y, _] = self.grid.dims();
        let slice = (x * y) as usize;
        let read = |z: u32, out: &mut [i16]| out.copy_from_slice(&self.labels[z as usize * slice..][..slice]);
        Structures::build(&self.grid, read).unwrap()
    }

    /// Every voxel that has a label.
    pub(crate) fn labelled(&self) -> impl Iterator<Item = (i16, [u32; 3])> + '_ {
        let all = self.labels.iter().copied().zip(voxels(&self.grid));
        all.filter(|(label, _)| *label != 0)
    }

    /// The label of the cell that holds `p`, 0 outside the map.
    pub(crate) fn at(&self, p: Point<Ct>) -> i16 {
        let index = (self.grid.voxel_from_ct() * p).mm().map(f64::round);
        let dims = self.grid.dims().map(f64::from);
        if (0..3).any(|k| index[k] < 0.0 || index[k] >= dims[k]) {
            return 0;
        }
        self.labels[(index[0] + dims[0] * (index[1] + dims[1] * index[2])) as usize]
    }
}

pub(crate) fn voxels(grid: &VolumeGrid) -> impl Iterator<Item = [u32; 3]> + use<> {
    let [nx, ny, nz] = grid.dims();
    (0..nz).flat_map(move |z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z])))
}

pub(crate) fn centre(grid: &VolumeGrid, voxel: [u32; 3]) -> Point<Ct> {
    let [x, y, z] = voxel.map(f64::from);
    grid.ct_from_voxel() * Point::<Voxel>::new(x, y, z)
}

pub(crate) fn point(p: [f64; 3]) -> Point<Ct> {
    Point::new(p[0], p[1], p[2])
}

/// Right angles along the patient's axes, the first voxel's centre in the origin.
pub(crate) fn straight(dims: [i64; 3], spacing: [f64; 3]) -> VolumeGrid {
    let [x, y, z] = spacing;
    let rows = [[x, 0.0, 0.0, 0.0], [0.0, y, 0.0, 0.0], [0.0, 0.0, z, 0.0]];
    VolumeGrid::checked(dims, Affine::from_rows(rows)).unwrap()
}

/// Steps of any lengths and directions that a grid accepts: sheared, turned, mirrored.
pub(crate) fn skewed(dims: [i64; 3], random: &mut SplitMix64) -> VolumeGrid {
    loop {
        let mut step = || {
            let length = random.around(0.0, 1.3).exp();
            let v = Vector::<Ct>::new(
                random.around(0.0, 1.0),
                random.around(0.0, 1.0),
                random.around(0.0, 1.0),
            );
            v.direction().map(|d| d * length)
        };
        let (Some(a), Some(b), Some(c)) = (step(), step(), step()) else {
            continue;
        };
        let origin = point([0; 3].map(|_| random.around(0.0, 300.0)));
        if let Ok(grid) = VolumeGrid::checked(dims, Affine::from_steps(origin, [a, b, c])) {
            return grid;
        }
    }
}

/// Depth and distance from the axis.
fn about(tube: &Tube, p: Point<Ct>) -> (Vector<Ct>, f64, Vector<Ct>) {
    let axis = (tube.tip() - tube.entry()) * (1.0 / tube.tip().distance(tube.entry()));
    let depth = (p - tube.entry()).dot(axis);
    (axis, depth, p - tube.entry() - axis * depth)
}

/// From the nearest point of what the tube has between two depths, found by clamping depth and distance from the axis; 0 within it.
pub(crate) fn outside(tube: &Tube, [from, to]: [f64; 2], p: Point<Ct>) -> f64 {
    let (axis, depth, across) = about(tube, p);
    let (off, radius) = (across.norm(), tube.radius_mm());
    if off <= radius && (from..=to).contains(&depth) {
        return 0.0;
    }
    let kept = if off > radius { across * (radius / off) } else { across };
    p.distance(tube.entry() + axis * depth.clamp(from, to) + kept)
}

/// The signed distance from the tube: within it that of the nearest of its three surfaces.
pub(crate) fn signed(tube: &Tube, p: Point<Ct>) -> f64 {
    let length = tube.tip().distance(tube.entry());
    let (_, depth, across) = about(tube, p);
    let inside = (tube.radius_mm() - across.norm()).min(depth).min(length - depth);
    if inside >= 0.0 {
        -inside
    } else {
        outside(tube, [0.0, length], p)
    }
}

/// What two computations of a distance may differ by: 32 eps times the largest coordinate, each.
pub(crate) fn rounding(tube: &Tube, grid: &VolumeGrid) -> f64 {
    let (low, high) = grid.bounds();
    let ends = [low, high, tube.entry(), tube.tip()];
    let largest = ends
        .into_iter()
        .flat_map(Point::mm)
        .fold(tube.radius_mm(), |m, x| m.max(x.abs()));
    64.0 * f64::EPSILON * largest
}

/// Labels of one of eight kinds.
pub(crate) fn random_labels(grid: VolumeGrid, random: &mut SplitMix64) -> Map {
    let kind = random.bits() % 8;
    let dims = grid.dims().map(f64::from);
    let mut any = |k: usize| (random.bits() % dims[k] as u64) as u32;
    let (seed, other) = ([any(0), any(1), any(2)], [any(0), any(1), any(2)]);
    let axis = (random.bits() % 3) as usize;
    let radius = random.around(4.0, 3.5);
    let off = |v: [u32; 3], from: [u32; 3]| {
        (0..3)
            .map(|k| (f64::from(v[k]) - f64::from(from[k])).powi(2))
            .sum::<f64>()
            .sqrt()
    };
    let noise = 1 + random.bits() % 40;
    Map::of(grid, |v| match kind {
        // Single voxels.
        0 => i16::from(v == seed) + 2 * i16::from(v == other && v != seed),
        // Everything is one structure.
        1 => 7,
        // Noise, dense or thin.
        2 => {
            if random.bits().is_multiple_of(noise) {
                1 + (random.bits() % 300) as i16
            } else {
                0
            }
        }
        // A plate of one voxel, and a ball behind it.
        3 => {
            if v[axis] == seed[axis] {
                32_767
            } else {
                5 * i16::from(off(v, other) <= radius)
            }
        }
        // Two balls, one in the other.
        4 => i16::from(off(v, seed) <= radius * 2.0) + i16::from(off(v, seed) <= radius),
        // Half of the map, to its border, and a ball.
        5 => {
            if v[axis] >= seed[axis] {
                3
            } else {
                9 * i16::from(off(v, other) <= radius)
            }
        }
        // A shell, and a rod along an axis.
        6 => {
            if (off(v, seed) - radius).abs() < 0.9 {
                11
            } else {
                12 * i16::from((0..3).all(|k| k == axis || v[k] == other[k]))
            }
        }
        // Blocks of many labels.
        _ => ((v[0] / 3 * 7 + v[1] / 4 * 5 + v[2] / 5 * 3) % 6) as i16,
    })
}

/// A tube in or about the map: long, short, thin, thick, along an axis of the grid, through centres, within, or beside it.
pub(crate) fn random_tube(grid: &VolumeGrid, random: &mut SplitMix64) -> Tube {
    let dims = grid.dims().map(f64::from);
    let size = grid
        .spacing_mm()
        .iter()
        .zip(dims)
        .map(|(s, n)| s * n)
        .fold(0.0, f64::max);
    loop {
        let mut index = |spread: f64| [0, 1, 2].map(|k: usize| random.around(dims[k] / 2.0 - 0.5, spread * dims[k]));
        let (mut from, mut to) = (index(0.9), index(0.6));
        match random.bits() % 5 {
            0 => to = [to[0], from[1], from[2]],
            1 => (from, to) = (from.map(f64::round), to.map(f64::round)),
            2 => from = [from[0].round() + 0.5, to[1], to[2].round() + 0.5],
            3 => to = [0, 1, 2].map(|k| from[k] + random.around(0.0, 1.0)),
            _ => {}
        }
        let place = |i: [f64; 3]| grid.ct_from_voxel() * Point::<Voxel>::new(i[0], i[1], i[2]);
        let radius = match random.bits() % 4 {
            0 => 1e-3,
            1 => random.around(size, size * 0.9),
            _ => random.around(0.1 * size, 0.09 * size),
        };
        if let Ok(tube) = Tube::new(place(from), place(to), radius) {
            return tube;
        }
    }
}

pub(crate) fn random_map(random: &mut SplitMix64) -> Map {
    let dims = [0; 3].map(|_| 1 + (random.bits() % 20) as i64);
    loop {
        let grid = skewed(dims, random);
        let map = random_labels(grid, random);
        // An empty map is refused.
        if map.labels.iter().any(|&label| label != 0) {
            return map;
        }
    }
}
