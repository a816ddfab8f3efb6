//! Where voxels come from: a trait, and volumes in plain memory.

use geometry::VolumeGrid;

/// A volume to be searched: its place in the patient and its values in whole HU.
pub trait Voxels {
    /// How many voxels there are and where they lie.
    fn grid(&self) -> &VolumeGrid;

    /// The value of a voxel within the grid.
    fn at(&self, voxel: [u32; 3]) -> i16;

    /// The values of row `y` of slice `z`, as many as the grid has columns.
    fn row(&self, y: u32, z: u32, out: &mut [i16]) {
        for (x, value) in (0..).zip(out) {
            *value = self.at([x, y, z]);
        }
    }
}

/// Why values are no volume.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum DenseError {
    /// There are more or fewer values than voxels.
    #[error("{found} values for a volume of {expected} voxels")]
    Length {
        /// Values given.
        found: usize,
        /// Voxels of the grid.
        expected: u64,
    },
    /// A value is NaN or infinite.
    #[error("voxel {voxel:?} is {found}, which is not finite")]
    NotFinite {
        /// Column, row, slice.
        voxel: [u32; 3],
        /// The value.
        found: f32,
    },
}

/// Voxels in rows, x fastest, one slice after another.
#[derive(Debug, Clone)]
pub struct Dense {
    grid: VolumeGrid,
    values: Vec<i16>,
}

impl Dense {
    /// Whole HU.
    ///
    /// # Errors
    /// [`DenseError::Length`].
    pub fn new(grid: VolumeGrid, values: Vec<i16>) -> Result<Self, DenseError> {
        if grid.voxels() != values.len() as u64 {
            return Err(DenseError::Length {
                found: values.len(),
                expected: grid.voxels(),
            });
        }
        Ok(Self { grid, values })
    }

    /// HU with fractions, which are rounded to the nearest whole HU and held to what an `i16` holds: the search sums
    /// whole numbers, so that its sums are exact.
    ///
    /// # Errors
    /// [`DenseError`].
    pub fn from_f32(grid: VolumeGrid, values: &[f32]) -> Result<Self, DenseError> {
        if let Some(at) = values.iter().position(|v| !v.is_finite()) {
            let [nx, ny, _] = grid.dims().map(|d| d as usize);
            return Err(DenseError::NotFinite {
                voxel: [at % nx, at / nx % ny, at / nx / ny].map(|i| i as u32),
                found: values[at],
            });
        }
        // The cast saturates.
        Self::new(grid, values.iter().map(|v| v.round() as i16).collect())
    }

    fn offset(&self, [x, y, z]: [u32; 3]) -> usize {
        let [nx, ny, _] = self.grid.dims().map(|d| d as usize);
        (z as usize * ny + y as usize) * nx + x as usize
    }
}

impl Voxels for Dense {
    fn grid(&self) -> &VolumeGrid {
        &self.grid
    }

    fn at(&self, voxel: [u32; 3]) -> i16 {
        self.values[self.offset(voxel)]
    }

    fn row(&self, y: u32, z: u32, out: &mut [i16]) {
        let start = self.offset([0, y, z]);
        out.copy_from_slice(&self.values[start..start + out.len()]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::Affine;

    #[test]
    fn what_is_no_volume_is_refused() {
        let unit = Affine::from_rows([[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]);
        let grid = VolumeGrid::checked([3, 2, 2], unit).unwrap();
        let length = DenseError::Length {
            found: 11,
            expected: 12,
        };
        assert_eq!(Dense::new(grid, vec![0; 11]).unwrap_err(), length);
        let mut values = vec![0.4_f32; 12];
        values[1] = -1e9;
        let volume = Dense::from_f32(grid, &values).unwrap();
        assert_eq!((volume.at([0, 0, 0]), volume.at([1, 0, 0])), (0, i16::MIN));
        values[10] = f32::NAN;
        let error = Dense::from_f32(grid, &values).unwrap_err().to_string();
        assert_eq!(error, "voxel [1, 1, 1] is NaN, which is not finite");
    }
}
