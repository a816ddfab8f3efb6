//! Where voxels come from, and the part of a CT that is worked on.

use geometry::{Affine, Ct, Point, VolumeGrid, Voxel};
use nalgebra::{Matrix3, Vector3};

/// A CT: its place in the patient and its values in whole HU.
pub trait Voxels {
    /// How many voxels there are and where they lie.
    fn grid(&self) -> &VolumeGrid;

    /// The values of row `y` of slice `z`, as many as the grid has columns.
    fn row(&self, y: u32, z: u32, out: &mut [i16]);

    /// The HU that stands where nothing was measured; `None` where there is none.
    fn padding_hu(&self) -> Option<i16> {
        None
    }
}

/// A box of voxels within a CT: the first along each axis and the first beyond.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct VoxelBox {
    /// The first voxel.
    pub first: [u32; 3],
    /// One beyond the last.
    pub end: [u32; 3],
}

impl VoxelBox {
    /// All voxels of a grid.
    pub fn whole(grid: &VolumeGrid) -> Self {
        Self {
            first: [0; 3],
            end: grid.dims(),
        }
    }

    /// Grown by so many voxels to each side, within the grid.
    #[must_use]
    pub fn grown(self, by: [u32; 3], grid: &VolumeGrid) -> Self {
        Self {
            first: [0, 1, 2].map(|k| self.first[k].saturating_sub(by[k])),
            end: [0, 1, 2].map(|k| self.end[k].saturating_add(by[k]).min(grid.dims()[k])),
        }
    }

    /// Voxels along each axis.
    pub fn dims(self) -> [usize; 3] {
        [0, 1, 2].map(|k| (self.end[k] - self.first[k]) as usize)
    }
}

/// A part of a CT in memory, x fastest.
#[derive(Debug, Clone)]
pub(crate) struct Crop {
    pub(crate) place: VoxelBox,
    pub(crate) dims: [usize; 3],
    /// Whether the part ends where the CT ends, at the low and the high side of each axis.
    pub(crate) is_end: [[bool; 2]; 3],
    pub(crate) hu: Vec<i16>,
    /// What nothing measured, and what is beside it, is 1; empty where nobody looked.
    pub(crate) gap: Vec<u8>,
    /// From indices of this part to mm: columns are the voxels' steps.
    pub(crate) steps: Matrix3<f64>,
    pub(crate) origin: Vector3<f64>,
    pub(crate) index_from_mm: Matrix3<f64>,
}

impl Crop {
    pub(crate) fn new(voxels: &dyn Voxels, place: VoxelBox) -> Self {
        let grid = voxels.grid();
        let dims = place.dims();
        let mut row = vec![0; grid.dims()[0] as usize];
        let mut hu = Vec::with_capacity(dims.iter().product());
        for z in place.first[2]..place.end[2] {
            for y in place.first[1]..place.end[1] {
                voxels.row(y, z, &mut row);
                hu.extend_from_slice(&row[place.first[0] as usize..place.end[0] as usize]);
            }
        }
        let affine: Affine<Ct, Voxel> = grid.ct_from_voxel();
        let steps = Matrix3::from_columns(&[0, 1, 2].map(|axis| Vector3::from(affine.step(axis).mm())));
        let [x, y, z] = place.first.map(f64::from);
        Self {
            place,
            dims,
            is_end: [0, 1, 2].map(|k| [place.first[k] == 0, place.end[k] == grid.dims()[k]]),
            hu,
            gap: Vec::new(),
            steps,
            origin: Vector3::from((affine * Point::<Voxel>::new(x, y, z)).mm()),
            // A checked grid has an inverse.
            index_from_mm: steps.try_inverse().unwrap_or_else(Matrix3::zeros),
        }
    }

    pub(crate) fn offset(&self, [x, y, z]: [usize; 3]) -> usize {
        (z * self.dims[1] + y) * self.dims[0] + x
    }

    /// Whether nothing measured a voxel, or one beside it.
    pub(crate) fn is_gap(&self, offset: usize) -> bool {
        self.gap.get(offset) == Some(&1)
    }

    pub(crate) fn mm(&self, index: Vector3<f64>) -> Vector3<f64> {
        self.origin + self.steps * index
    }

    pub(crate) fn index(&self, mm: &Vector3<f64>) -> Vector3<f64> {
        self.index_from_mm * (mm - self.origin)
    }

    /// The HU at a place, linear between the eight voxels around; `None` where one of them is outside, or was not measured.
    pub(crate) fn linear(&self, mm: &Vector3<f64>) -> Option<f64> {
        let index = self.index(mm);
        let low = index.map(f64::floor);
        let inside = (0..3).all(|k| low[k] >= 0.0 && low[k] + 1.0 <= self.dims[k] as f64 - 1.0);
        if !inside {
            return None;
        }
        let (first, part) = ([0, 1, 2].map(|k| low[k] as usize), index - low);
        let mut sum = 0.0;
        for corner in 0..8_usize {
            let far = [0, 1, 2].map(|k| corner >> k & 1);
            let weight: f64 = (0..3)
                .map(|k| if far[k] == 1 { part[k] } else { 1.0 - part[k] })
                .product();
            let offset = self.offset([0, 1, 2].map(|k| first[k] + far[k]));
            if self.is_gap(offset) {
                return None;
            }
            sum += weight * f64::from(self.hu[offset]);
        }
        Some(sum)
    }
}
