//! Files made by hand, byte by byte: what must be read, and what must be refused by which name.

mod bad_files;
mod hand_made;
mod real_file;
mod round_trip;

use std::path::Path;

use super::NiftiSource;
use crate::raster::test_files::{drink, drink_both, file, gzip};
use crate::source::{Conversion, ReadError, VoxelSource};

/// A NIfTI-1 header by hand: little- or big-endian, 2 x 3 x 2 voxels of i16, 1 mm, with an sform.
#[derive(Debug, Clone)]
struct Hand {
    bytes: Vec<u8>,
    big_endian: bool,
}

impl Hand {
    fn new(big_endian: bool) -> Self {
        let mut hand = Self {
            bytes: vec![0; 352],
            big_endian,
        };
        hand.i32(0, 348);
        hand.dims(&[3, 2, 3, 2, 1, 1, 1, 1]);
        hand.i16(70, 4).i16(72, 16);
        for i in 0..4 {
            hand.f32(76 + 4 * i, 1.0);
        }
        hand.f32(108, 352.0);
        hand.bytes[123] = 2;
        hand.i16(254, 1);
        for i in 0..3 {
            hand.f32(280 + 20 * i, 1.0);
        }
        hand.bytes[344..348].copy_from_slice(b"n+1\0");
        hand
    }

    fn put<const N: usize>(&mut self, at: usize, mut little: [u8; N]) -> &mut Self {
        if self.big_endian {
            little.reverse();
        }
        self.bytes[at..at + N].copy_from_slice(&little);
        self
    }
    fn raw(&mut self, at: usize, bytes: &[u8]) -> &mut Self {
        self.bytes[at..at + bytes.len()].copy_from_slice(bytes);
        self
    }
    fn i16(&mut self, at: usize, value: i16) -> &mut Self {
        self.put(at, value.to_le_bytes())
    }
    fn i32(&mut self, at: usize, value: i32) -> &mut Self {
        self.put(at, value.to_le_bytes())
    }
    fn f32(&mut self, at: usize, value: f32) -> &mut Self {
        self.put(at, value.to_le_bytes())
    }
    fn dims(&mut self, dim: &[i16; 8]) -> &mut Self {
        for (i, &length) in dim.iter().enumerate() {
            self.i16(40 + 2 * i, length);
        }
        self
    }
    fn voxels<const N: usize>(&mut self, little: &[[u8; N]]) -> &mut Self {
        for raw in little {
            let mut raw = *raw;
            if self.big_endian {
                raw.reverse();
            }
            self.bytes.extend(raw);
        }
        self
    }
    /// With the twelve voxels 0 to 11.
    fn counted(big_endian: bool) -> Self {
        let mut hand = Self::new(big_endian);
        hand.voxels(&std::array::from_fn::<_, 12, _>(|i| (i as i16).to_le_bytes()));
        hand
    }
}

fn read(path: &Path) -> Result<(Vec<i16>, Conversion), ReadError> {
    drink_both(&mut NiftiSource::open(path)?)
}

/// `bytes` as a file's content.
fn read_bytes(bytes: &[u8]) -> Result<(Vec<i16>, Conversion), ReadError> {
    let folder = tempfile::tempdir().unwrap();
    read(&file(&folder, "hand.nii", bytes))
}

fn open_bytes(bytes: &[u8]) -> Result<NiftiSource, ReadError> {
    let folder = tempfile::tempdir().unwrap();
    NiftiSource::open(&file(&folder, "hand.nii", bytes))
}
