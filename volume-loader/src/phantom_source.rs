//! The generated patient as an examination.

use bus::message::IdentitySource;
use geometry::{GridError, VolumeGrid};
use phantom::Phantom;

use crate::source::{Conversion, ReadError, Turn, VoxelSource, Whose};

/// A [`Phantom`] sampled on a grid along the patient's axes.
#[derive(Debug, Clone)]
pub struct PhantomSource {
    phantom: Phantom,
    seed: u64,
    grid: VolumeGrid,
    turn: Turn,
}

impl PhantomSource {
    /// The patient of `seed` with voxels `spacing_mm` apart along x, y and z.
    ///
    /// # Errors
    /// [`GridError`] where the spacing is not usable.
    pub fn new(seed: u64, spacing_mm: [f64; 3]) -> Result<Self, GridError> {
        let phantom = Phantom::new(seed);
        let grid = phantom.grid(spacing_mm)?;
        Ok(Self {
            phantom,
            seed,
            grid,
            turn: Turn::default(),
        })
    }

    /// The patient, whose true HU and landmarks are known.
    pub fn phantom(&self) -> &Phantom {
        &self.phantom
    }
}

impl VoxelSource for PhantomSource {
    fn grid(&self) -> &VolumeGrid {
        &self.grid
    }

    fn padding_hu(&self) -> i16 {
        // Exact: a whole number far inside i16.
        phantom::AIR_HU as i16
    }

    fn describe(&self) -> String {
        let ([nx, ny, nz], [sx, sy, sz]) = (self.grid.dims(), self.grid.spacing_mm());
        format!(
            "generated patient, seed {}, {nx} x {ny} x {nz} voxels of {sx} x {sy} x {sz} mm",
            self.seed
        )
    }

    fn whose(&self) -> Result<Whose, ReadError> {
        let words = ["PHANTOM", "", "", "", ""].map(str::to_owned);
        Ok(Whose::said(IdentitySource::Phantom, words))
    }

    fn read_slice(&mut self, k: u32, out: &mut [i16]) -> Result<(), ReadError> {
        self.turn.take(&self.grid, k, out)?;
        self.phantom.fill_slice(&self.grid, k, out);
        Ok(())
    }

    /// Nothing is counted: the patient's HU are fractions by nature, and none is out of range.
    fn finish(&mut self) -> Result<Conversion, ReadError> {
        self.turn.done(&self.grid)?;
        Ok(Conversion::default())
    }
}

/// The generated patient's structures as a label map, on the voxels of the examination.
#[derive(Debug, Clone)]
pub struct PhantomLabels(PhantomSource);

impl PhantomLabels {
    /// Those of the patient of `seed` with voxels `spacing_mm` apart along x, y and z.
    ///
    /// # Errors
    /// [`GridError`] where the spacing is not usable.
    pub fn new(seed: u64, spacing_mm: [f64; 3]) -> Result<Self, GridError> {
        PhantomSource::new(seed, spacing_mm).map(Self)
    }
}

impl VoxelSource for PhantomLabels {
    fn grid(&self) -> &VolumeGrid {
        &self.0.grid
    }

    fn padding_hu(&self) -> i16 {
        0
    }

    fn describe(&self) -> String {
        format!("structures of the {}", self.0.describe())
    }

    fn whose(&self) -> Result<Whose, ReadError> {
        self.0.whose()
    }

    fn read_slice(&mut self, k: u32, out: &mut [i16]) -> Result<(), ReadError> {
        self.0.turn.take(&self.0.grid, k, out)?;
        self.0.phantom.fill_structures(&self.0.grid, k, out);
        Ok(())
    }

    fn finish(&mut self) -> Result<Conversion, ReadError> {
        self.0.finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slices_come_in_order_only() {
        let mut source = PhantomSource::new(1, [30.0; 3]).unwrap();
        let [nx, ny, nz] = source.grid().dims();
        let mut out = vec![0; (nx * ny) as usize];
        assert!(matches!(
            source.read_slice(1, &mut out),
            Err(ReadError::Order {
                expected: 0,
                found: 1,
                ..
            })
        ));
        assert!(matches!(
            source.read_slice(0, &mut out[1..]),
            Err(ReadError::Buffer { slice: 0, .. })
        ));
        assert!(source.finish().is_err());
        for k in 0..nz {
            source.read_slice(k, &mut out).unwrap();
        }
        assert!(matches!(source.read_slice(nz, &mut out), Err(ReadError::Order { .. })));
        assert_eq!(source.finish().unwrap(), Conversion::default());
    }

    #[test]
    fn refuses_an_unusable_spacing() {
        assert!(PhantomSource::new(1, [0.0, 1.0, 1.0]).is_err());
    }
}
