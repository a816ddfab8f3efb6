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

    /// The smallest and the largest number.
    pub(crate) fn range(self) -> [f64; 2] {
        match self {
            Self::U8 => [0.0, f64::from(u8::MAX)],
            Self::I8 => [i8::MIN, i8::MAX].map(f64::from),
            Self::U16 => [0.0, f64::from(u16::MAX)],
            Self::I16 => [i16::MIN, i16::MAX].map(f64::from),
            Self::U32 => [0.0, f64::from(u32::MAX)],
            Self::I32 => [i32::MIN, i32::MAX].map(f64::from),
            Self::U64 => [0.0, u64::MAX as f64],
            Self::I64 => [i64::MIN as f64, i64::MAX as f64],
            Self::F32 => [f32::MIN, f32::MAX].map(f64::from),
            Self::F64 => [f64::MIN, f64::MAX],
        }
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
        match self.scale {
            None if !matches!(self.sample, Sample::F32 | Sample::F64) => self.decode_whole(bytes, out),
            _ => self.decode_real(bytes, out),
        }
    }

    /// The HU of one stored number.
    pub(crate) fn hu(&mut self, stored: f64) -> i16 {
        let hu = self.scale.map_or(stored, |[slope, inter]| slope * stored + inter);
        self.conversion.voxel(hu, self.padding_hu)
    }

    /// Whole numbers that are HU already: nothing to round, so no real number on the way.
    fn decode_whole(&mut self, bytes: &[u8], out: &mut [i16]) {
        match self.sample {
            Sample::U8 => self.each_whole(bytes, out, |b: [u8; 1]| i64::from(b[0])),
            Sample::I8 => self.each_whole(bytes, out, |b| i64::from(i8::from_le_bytes(b))),
            Sample::I16 => self.each_whole(bytes, out, |b| i64::from(i16::from_le_bytes(b))),
            Sample::U16 => self.each_whole(bytes, out, |b| i64::from(u16::from_le_bytes(b))),
            Sample::I32 => self.each_whole(bytes, out, |b| i64::from(i32::from_le_bytes(b))),
            Sample::U32 => self.each_whole(bytes, out, |b| i64::from(u32::from_le_bytes(b))),
            Sample::U64 => self.each_whole(bytes, out, |b| {
                // Far outside an i16 either way.
                i64::try_from(u64::from_le_bytes(b)).unwrap_or(i64::MAX)
            }),
            Sample::I64 | Sample::F32 | Sample::F64 => self.each_whole(bytes, out, i64::from_le_bytes),
        }
    }

    fn each_whole<const N: usize>(&mut self, bytes: &[u8], out: &mut [i16], stored: impl Fn([u8; N]) -> i64) {
        const LOW: i64 = i16::MIN as i64;
        const HIGH: i64 = i16::MAX as i64;
        let (voxels, _) = bytes.as_chunks::<N>();
        let (mut low, mut high) = (0_u64, 0_u64);
        for (raw, voxel) in voxels.iter().zip(out) {
            let mut raw = *raw;
            if self.big_endian {
                raw.reverse();
            }
            let value = stored(raw);
            low += u64::from(value < LOW);
            high += u64::from(value > HIGH);
            // In range after the clamp: `as` cuts nothing off.
            *voxel = value.clamp(LOW, HIGH) as i16;
        }
        self.conversion.clamped_low += low;
        self.conversion.clamped_high += high;
    }

    fn decode_real(&mut self, bytes: &[u8], out: &mut [i16]) {
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
            *voxel = self.hu(stored(raw));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const SAMPLES: [Sample; 8] = [
        Sample::U8,
        Sample::I8,
        Sample::I16,
        Sample::U16,
        Sample::I32,
        Sample::U32,
        Sample::I64,
        Sample::U64,
    ];

    proptest! {
        #[test]
        fn whole_numbers_become_the_same_without_real_ones(
            which in 0..SAMPLES.len(),
            big_endian: bool,
            bytes in prop::collection::vec(prop_oneof![Just(0_u8), Just(255), any::<u8>()], 0..64),
        ) {
            let sample = SAMPLES[which];
            let decoder = Decoder { sample, big_endian, scale: None, padding_hu: -1024, conversion: Conversion::default() };
            let (mut whole, mut real) = (decoder.clone(), decoder);
            let count = bytes.len() / sample.bytes();
            let (mut a, mut b) = (vec![0; count], vec![1; count]);
            whole.decode(&bytes, &mut a);
            real.decode_real(&bytes, &mut b);
            prop_assert_eq!(a, b);
            prop_assert_eq!(whole.conversion, real.conversion);
        }
    }
}
