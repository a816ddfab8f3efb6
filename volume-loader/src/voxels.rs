//! Stored numbers to HU.

use crate::source::Conversion;

/// How one voxel is stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Sample {
    U8,
    I8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

impl Sample {
    /// The sample of NIfTI's `datatype`.
    pub(crate) fn of(datatype: i64) -> Option<Self> {
        Some(match datatype {
            2 => Self::U8,
            4 => Self::I16,
            8 => Self::I32,
            16 => Self::F32,
            64 => Self::F64,
            256 => Self::I8,
            512 => Self::U16,
            768 => Self::U32,
            1024 => Self::I64,
            1280 => Self::U64,
            _ => return None,
        })
    }

    /// Bytes per voxel.
    pub(crate) fn bytes(self) -> usize {
        match self {
            Self::U8 | Self::I8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }
}

/// All that turns bytes into HU, and what was changed on the way.
#[derive(Debug, Clone)]
pub(crate) struct Decoder {
    pub sample: Sample,
    pub big_endian: bool,
    pub scale: Option<[f64; 2]>,
    pub padding_hu: i16,
    pub conversion: Conversion,
}

impl Decoder {
    /// Turns `bytes` into `out`, voxel by voxel, as far as both reach.
    pub(crate) fn decode(&mut self, bytes: &[u8], out: &mut [i16]) {
        match self.sample {
            Sample::U8 => self.each(bytes, out, |b: [u8; 1]| f64::from(b[0])),
            Sample::I8 => self.each(bytes, out, |b| f64::from(i8::from_le_bytes(b))),
            Sample::I16 => self.each(bytes, out, |b| f64::from(i16::from_le_bytes(b))),
            Sample::U16 => self.each(bytes, out, |b| f64::from(u16::from_le_bytes(b))),
            Sample::I32 => self.each(bytes, out, |b| f64::from(i32::from_le_bytes(b))),
            Sample::U32 => self.each(bytes, out, |b| f64::from(u32::from_le_bytes(b))),
            // Beyond 2^53 the nearest double: far outside an i16 anyway.
            Sample::I64 => self.each(bytes, out, |b| i64::from_le_bytes(b) as f64),
            Sample::U64 => self.each(bytes, out, |b| u64::from_le_bytes(b) as f64),
            Sample::F32 => self.each(bytes, out, |b| f64::from(f32::from_le_bytes(b))),
            Sample::F64 => self.each(bytes, out, f64::from_le_bytes),
        }
    }

    fn each<const N: usize>(&mut self, bytes: &[u8], out: &mut [i16], stored: impl Fn([u8; N]) -> f64) {
        let (voxels, _) = bytes.as_chunks::<N>();
        for (raw, voxel) in voxels.iter().zip(out) {
            let mut raw = *raw;
            if self.big_endian {
                raw.reverse();
            }
            let value = stored(raw);
            let hu = self.scale.map_or(value, |[slope, inter]| slope * value + inter);
            *voxel = self.conversion.voxel(hu, self.padding_hu);
        }
    }
}
