//! The label map in axes of its own, in which cubes lie, and the way to the patient's.

use geometry::VolumeGrid;
use nalgebra::{Matrix3, Vector3};
use simulation::space::cells::LabelMap;

/// Axes are orthogonal below this cosine between two: over a patient of 500 mm a place is off by 0.005 mm.
const SKEW: f64 = 1e-5;
/// Voxels around a place that are looked at, at most, for the nearest of a label.
const MOST_LOOKED_AT: f64 = 1e6;

/// Why a volume is no label map for solids.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NoLabels {
    /// Two axes that are not at right angles.
    #[error(
        "its axes are not orthogonal: the cosine between axis {axes:?} is {cosine:.3e}, at most {SKEW:e} is allowed; resample it to a grid of right angles"
    )]
    Oblique {
        /// Numbers of the two, from 0.
        axes: [usize; 2],
        /// Of the angle between them.
        cosine: f64,
    },
    /// A voxel below 0.
    #[error("a voxel is {found}; labels are 0 and more")]
    Negative {
        /// What it is.
        found: i16,
    },
}

/// A label map in its own axes: voxel `(i, j, k)` is at `spacing * (i, j, k)` there, mm. The axes are right-handed: where the
/// file's are not, its first axis is taken backwards.
#[derive(Debug, Clone)]
pub struct Labels {
    /// Voxels along each axis.
    pub size: [usize; 3],
    /// From voxel to voxel along each axis, mm.
    pub spacing: Vector3<f64>,
    labels: Vec<u16>,
    /// Takes directions to the patient's axes, LPS: orthogonal, determinant 1.
    turn: Matrix3<f64>,
    /// Where the first voxel is there, mm.
    first: Vector3<f64>,
    /// Names what was read.
    pub hash: String,
}

impl Labels {
    /// The label map on a grid: `slice` writes slice `z`, `dims[0] * dims[1]` labels row by row; `hash` names what was read.
    ///
    /// # Errors
    /// [`NoLabels`].
    pub fn new(grid: &VolumeGrid, hash: String, mut slice: impl FnMut(u32, &mut [i16])) -> Result<Self, NoLabels> {
        let (map, spacing) = (grid.ct_from_voxel(), Vector3::from(grid.spacing_mm()));
        let mut steps = [0, 1, 2].map(|axis| Vector3::from(map.step(axis).mm()) / spacing[axis]);
        for axes in [[0, 1], [0, 2], [1, 2]] {
            let cosine = steps[axes[0]].dot(&steps[axes[1]]);
            if cosine.abs() > SKEW {
                return Err(NoLabels::Oblique { axes, cosine });
            }
        }
        let rows = map.rows();
        let mut first = Vector3::from_fn(|r, _| rows[r][3]);
        let size = grid.dims().map(|n| n as usize);
        let backwards = Matrix3::from_columns(&steps).determinant() < 0.0;
        if backwards {
            first += steps[0] * (spacing[0] * (size[0] - 1) as f64);
            steps[0] = -steps[0];
        }
        let mut labels = Vec::with_capacity(size.iter().product());
        let mut voxels = vec![0_i16; size[0] * size[1]];
        for z in 0..grid.dims()[2] {
            slice(z, &mut voxels);
            for row in voxels.chunks_exact_mut(size[0]) {
                if backwards {
                    row.reverse();
                }
                for voxel in row {
                    labels.push(u16::try_from(*voxel).map_err(|_| NoLabels::Negative { found: *voxel })?);
                }
            }
        }
        Ok(Self {
            size,
            spacing,
            labels,
            turn: Matrix3::from_columns(&steps),
            first,
            hash,
        })
    }

    /// For meshing.
    pub fn map(&self) -> LabelMap<'_> {
        LabelMap {
            size: self.size,
            origin: Vector3::zeros(),
            spacing: self.spacing,
            labels: &self.labels,
        }
    }

    /// A place of the map's axes in the patient's.
    pub fn patient(&self, at: &Vector3<f64>) -> Vector3<f64> {
        self.first + self.turn * at
    }

    /// A direction, a force, or (as both axes are right-handed) a moment of the map's axes in the patient's.
    pub fn turned(&self, direction: &Vector3<f64>) -> Vector3<f64> {
        self.turn * direction
    }

    /// A place of the patient in the map's axes.
    pub fn own(&self, at: &Vector3<f64>) -> Vector3<f64> {
        self.turn.tr_mul(&(at - self.first))
    }

    /// A direction of the patient in the map's axes.
    pub fn own_direction(&self, direction: &Vector3<f64>) -> Vector3<f64> {
        self.turn.tr_mul(direction)
    }

    /// The label of the voxel that a place of the map's axes lies in; 0 outside.
    pub fn at(&self, place: &Vector3<f64>) -> u16 {
        let voxel = [0, 1, 2].map(|k| (place[k] / self.spacing[k] + 0.5).floor());
        let inside = (0..3).all(|k| voxel[k] >= 0.0 && voxel[k] < self.size[k] as f64);
        if inside {
            self.voxel(voxel.map(|v| v as usize))
        } else {
            0
        }
    }

    fn voxel(&self, [i, j, k]: [usize; 3]) -> u16 {
        self.labels[(k * self.size[1] + j) * self.size[0] + i]
    }

    /// Voxels about a box, from the first to before the last along each axis.
    fn range(&self, [low, high]: [&Vector3<f64>; 2]) -> [std::ops::Range<usize>; 3] {
        [0, 1, 2].map(|k| {
            let last = self.size[k] as f64;
            let ends = [
                (low[k] / self.spacing[k]).floor(),
                (high[k] / self.spacing[k]).ceil() + 1.0,
            ];
            let [first, end] = ends.map(|at| at.clamp(0.0, last) as usize);
            first..end.max(first)
        })
    }

    /// Calls `visit` with the middle and the label of each voxel about a box of the map's axes, x fastest.
    pub fn each(&self, corners: [&Vector3<f64>; 2], visit: &mut dyn FnMut(Vector3<f64>, u16)) {
        let [xs, ys, zs] = self.range(corners);
        for z in zs {
            for y in ys.clone() {
                for x in xs.clone() {
                    let at = Vector3::new(x as f64, y as f64, z as f64).component_mul(&self.spacing);
                    visit(at, self.voxel([x, y, z]));
                }
            }
        }
    }

    /// The part of the map about a box, with 1 in the place of some labels and 0 of all others: the map without its labels, and these.
    pub(crate) fn around(&self, corners: [&Vector3<f64>; 2], of: &[u16]) -> (LabelMap<'static>, Vec<u16>) {
        let range = self.range(corners);
        let mut voxels = Vec::new();
        self.each(corners, &mut |_, label| voxels.push(u16::from(of.contains(&label))));
        let map = LabelMap {
            size: range.clone().map(|range| range.len()),
            origin: Vector3::from(range.map(|range| range.start as f64)).component_mul(&self.spacing),
            spacing: self.spacing,
            labels: &[],
        };
        (map, voxels)
    }

    /// All labels of the map but 0, each once, in their order.
    pub fn all(&self) -> Vec<u16> {
        let mut is_there = vec![false; 1 << 16];
        self.labels
            .iter()
            .for_each(|label| is_there[usize::from(*label)] = true);
        (1..=u16::MAX).filter(|label| is_there[usize::from(*label)]).collect()
    }

    /// How many voxels have a label.
    pub fn count(&self, label: u16) -> usize {
        self.labels.iter().filter(|l| **l == label).count()
    }

    /// Whether a distance takes no more voxels to look at than can be looked at for thousands of places.
    pub fn can_look(&self, distance: f64) -> bool {
        let voxels = self.spacing.map(|s| 2.0 * (distance / s).ceil() + 1.0);
        voxels.product() <= MOST_LOOKED_AT
    }

    /// Whether a voxel of one of some labels, the whole box of it, is within a distance of a place.
    pub fn is_near(&self, place: &Vector3<f64>, distance: f64, of: &[u16]) -> bool {
        let range = [0, 1, 2].map(|k| {
            let (low, high) = (
                (place[k] - distance) / self.spacing[k],
                (place[k] + distance) / self.spacing[k],
            );
            let last = self.size[k] as f64 - 1.0;
            let [low, high] = [(low - 0.5).ceil(), (high + 0.5).floor()].map(|v| v.clamp(-1.0, last + 1.0));
            low.max(0.0) as usize..(high.min(last) + 1.0).max(0.0) as usize
        });
        let away = |k: usize, voxel: usize| {
            let half = 0.5 * self.spacing[k];
            ((place[k] - self.spacing[k] * voxel as f64).abs() - half).max(0.0)
        };
        for k in range[2].clone() {
            for j in range[1].clone() {
                for i in range[0].clone() {
                    let way = Vector3::new(away(0, i), away(1, j), away(2, k));
                    if way.norm_squared() <= distance * distance && of.contains(&self.voxel([i, j, k])) {
                        return true;
                    }
                }
            }
        }
        false
    }
}
