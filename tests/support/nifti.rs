//! NIfTI files made by hand, to be good or bad in one place.

use std::io::Write;

/// A NIfTI-1 file by hand: 12 x 10 x 8 voxels of 20 mm in RAS, i16, placed by its sform.
#[derive(Clone)]
pub struct Nifti(pub Vec<u8>);

pub const VOXELS: usize = 12 * 10 * 8;

impl Nifti {
    pub fn header() -> Self {
        let mut nifti = Self(vec![0; 352]).dims([12, 10, 8]).i16(70, 4).i16(72, 16);
        nifti.0[..4].copy_from_slice(&348_i32.to_le_bytes());
        nifti.0[123] = 2;
        nifti.0[344..348].copy_from_slice(b"n+1\0");
        for axis in 0..3 {
            nifti = nifti.f32(80 + 4 * axis, 20.0).f32(280 + 20 * axis, 20.0);
        }
        nifti.i16(254, 1).f32(76, 1.0).f32(108, 352.0)
    }

    /// With voxels that do not compress.
    pub fn noise() -> Self {
        let mut state = 1_u64;
        let mut next = |_| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            ((state >> 40) as i16).to_le_bytes()
        };
        Self::header().with((0..VOXELS).flat_map(&mut next))
    }

    pub fn i16(mut self, at: usize, value: i16) -> Self {
        self.0[at..at + 2].copy_from_slice(&value.to_le_bytes());
        self
    }

    pub fn f32(mut self, at: usize, value: f32) -> Self {
        self.0[at..at + 4].copy_from_slice(&value.to_le_bytes());
        self
    }

    pub fn dims(self, [x, y, z]: [i16; 3]) -> Self {
        let all = [3, x, y, z, 1, 1, 1, 1];
        (0..8).fold(self, |nifti, i| nifti.i16(40 + 2 * i, all[i]))
    }

    pub fn with(mut self, voxels: impl IntoIterator<Item = u8>) -> Self {
        self.0.extend(voxels);
        self
    }

    pub fn gzip(&self) -> Vec<u8> {
        let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
        encoder.write_all(&self.0).unwrap();
        encoder.finish().unwrap()
    }
}

impl From<Nifti> for Vec<u8> {
    fn from(nifti: Nifti) -> Self {
        nifti.0
    }
}
