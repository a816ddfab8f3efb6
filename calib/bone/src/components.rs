//! Bodies of voxels that hang together by their faces, by runs along rows: memory goes with the surface, not with the volume.

use crate::component::Component;
use crate::error::Refused;
use crate::voxels::{Crop, VoxelBox};

/// More runs are noise.
const MOST_RUNS: usize = 60_000_000;

/// Voxels `start..end` of a row.
#[derive(Debug, Clone, Copy)]
struct Run {
    row: u32,
    start: u32,
    end: u32,
    parent: u32,
}

/// The bodies of a part of a CT, the largest first.
pub(crate) struct Bodies {
    runs: Vec<Run>,
    /// The first run of each body, as in `list`.
    roots: Vec<u32>,
    pub(crate) list: Vec<Component>,
}

#[derive(Debug, Clone, Copy)]
struct Sums {
    voxels: u64,
    index: [u64; 3],
    hu: i64,
    low: [u32; 3],
    high: [u32; 3],
}

impl Bodies {
    /// Of all voxels for which `is_in` holds, by their number in the part.
    pub(crate) fn new(crop: &Crop, is_in: impl Fn(usize) -> bool) -> Result<Self, Refused> {
        let mut runs = runs(crop, is_in)?;
        join(&mut runs, crop.dims[1] as u32);
        let (roots, list) = list(crop, &mut runs);
        Ok(Self { runs, roots, list })
    }

    /// Sets what belongs to a body; `mask` is as long as the part.
    pub(crate) fn paint(&mut self, crop: &Crop, body: usize, mask: &mut [u8]) {
        let root = self.roots[body];
        for i in 0..self.runs.len() as u32 {
            if find(&mut self.runs, i) == root {
                let Run { row, start, end, .. } = self.runs[i as usize];
                let first = row as usize * crop.dims[0];
                mask[first + start as usize..first + end as usize].fill(1);
            }
        }
    }

    /// Which body holds a voxel.
    pub(crate) fn body_at(&mut self, crop: &Crop, [x, y, z]: [usize; 3]) -> Option<usize> {
        let row = (z * crop.dims[1] + y) as u32;
        let after = self.runs.partition_point(|run| (run.row, run.start) <= (row, x as u32));
        let run = after.checked_sub(1)?;
        let found = self.runs[run];
        if found.row != row || found.end <= x as u32 {
            return None;
        }
        let root = find(&mut self.runs, run as u32);
        self.roots.iter().position(|r| *r == root)
    }
}

fn runs(crop: &Crop, is_in: impl Fn(usize) -> bool) -> Result<Vec<Run>, Refused> {
    let mut runs: Vec<Run> = Vec::new();
    let [nx, ny, nz] = crop.dims;
    for row in 0..ny * nz {
        let mut start = None;
        for x in 0..=nx {
            let inside = x < nx && is_in(row * nx + x);
            match (start, inside) {
                (None, true) => start = Some(x as u32),
                (Some(first), false) => {
                    if runs.len() >= MOST_RUNS {
                        return Err(Refused::TooRough { most: MOST_RUNS });
                    }
                    runs.push(Run {
                        row: row as u32,
                        start: first,
                        end: x as u32,
                        parent: runs.len() as u32,
                    });
                    start = None;
                }
                _ => {}
            }
        }
    }
    Ok(runs)
}

fn find(runs: &mut [Run], mut i: u32) -> u32 {
    while runs[i as usize].parent != i {
        // Path halving keeps the trees flat without a second pass.
        let up = runs[runs[i as usize].parent as usize].parent;
        runs[i as usize].parent = up;
        i = up;
    }
    i
}

/// Joins runs of neighbouring rows that share a voxel's face.
fn join(runs: &mut [Run], rows: u32) {
    for back in [1, rows] {
        let mut behind = 0;
        for i in 0..runs.len() {
            let Run { row, start, end, .. } = runs[i];
            // The row before the first of a slice is none of this slice.
            if row < back || (back == 1 && row % rows == 0) {
                continue;
            }
            let before = row - back;
            while (runs[behind].row, runs[behind].end) <= (before, start) {
                behind += 1;
            }
            let mut k = behind;
            while runs[k].row == before && runs[k].start < end {
                let (a, b) = (find(runs, i as u32), find(runs, k as u32));
                let (least, other) = (a.min(b), a.max(b));
                runs[other as usize].parent = least;
                k += 1;
            }
        }
    }
}

fn list(crop: &Crop, runs: &mut [Run]) -> (Vec<u32>, Vec<Component>) {
    let empty = Sums {
        voxels: 0,
        index: [0; 3],
        hu: 0,
        low: [u32::MAX; 3],
        high: [0; 3],
    };
    let mut sums: std::collections::BTreeMap<u32, Sums> = std::collections::BTreeMap::new();
    for i in 0..runs.len() {
        let root = find(runs, i as u32);
        let Run { row, start, end, .. } = runs[i];
        let (y, z) = (row % crop.dims[1] as u32, row / crop.dims[1] as u32);
        let n = u64::from(end - start);
        let first = row as usize * crop.dims[0];
        let values = &crop.hu[first + start as usize..first + end as usize];
        let sum = sums.entry(root).or_insert(empty);
        sum.voxels += n;
        sum.index[0] += n * u64::from(start + end - 1) / 2;
        sum.index[1] += n * u64::from(y);
        sum.index[2] += n * u64::from(z);
        sum.hu += values.iter().map(|v| i64::from(*v)).sum::<i64>();
        for (k, (low, high)) in [(start, end - 1), (y, y), (z, z)].into_iter().enumerate() {
            sum.low[k] = sum.low[k].min(low);
            sum.high[k] = sum.high[k].max(high);
        }
    }
    let cell = crop.steps.determinant().abs() * 1e-3;
    let mut all: Vec<(u32, Component)> = sums
        .into_iter()
        .map(|(root, sum)| {
            let n = sum.voxels as f64;
            let index = nalgebra::Vector3::from(sum.index.map(|s| s as f64 / n));
            let component = Component {
                voxels: sum.voxels,
                volume_ml: n * cell,
                centre_mm: crop.mm(index).into(),
                mean_hu: sum.hu as f64 / n,
                place: VoxelBox {
                    first: [0, 1, 2].map(|k| crop.place.first[k] + sum.low[k]),
                    end: [0, 1, 2].map(|k| crop.place.first[k] + sum.high[k] + 1),
                },
            };
            (root, component)
        })
        .collect();
    all.sort_by_key(|(root, component)| (std::cmp::Reverse(component.voxels), *root));
    all.into_iter().unzip()
}
