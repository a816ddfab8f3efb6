//! Binary numbers, whose count is held against the bytes that are there before anything is held for them.

use super::MeshError;

/// Bytes from some place on.
pub(super) struct Bytes<'a> {
    pub(super) rest: &'a [u8],
    pub(super) is_big: bool,
}

impl<'a> Bytes<'a> {
    /// The next so many records of so many bytes; refused before anything is held where they are not there.
    pub(super) fn take(&mut self, what: &'static str, count: u64, size: u64) -> Result<&'a [u8], MeshError> {
        let left = self.rest.len();
        let needed = count.saturating_mul(size);
        let bytes = usize::try_from(needed)
            .ok()
            .and_then(|needed| self.rest.split_at_checked(needed));
        let (taken, rest) = bytes.ok_or(MeshError::CutOff { what, needed, left })?;
        self.rest = rest;
        Ok(taken)
    }

    /// The next number of this type.
    pub(super) fn number(&mut self, what: &'static str, of: Scalar) -> Result<f64, MeshError> {
        let bytes = self.take(what, 1, of.size())?;
        Ok(of.read(bytes, self.is_big))
    }
}

/// A type of numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    F32,
    F64,
}

impl Scalar {
    /// Bytes of one.
    pub(super) const fn size(self) -> u64 {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::F64 => 8,
        }
    }

    /// Whether it holds whole numbers alone.
    pub(super) const fn is_whole(self) -> bool {
        !matches!(self, Self::F32 | Self::F64)
    }

    /// One of so many bytes as it has, most significant first where `is_big`; 0 where there are fewer.
    pub(super) fn read(self, bytes: &[u8], is_big: bool) -> f64 {
        let mut eight = [0_u8; 8];
        let size = (self.size() as usize).min(bytes.len());
        // Into the low end, least significant first.
        for (i, byte) in bytes.iter().take(size).enumerate() {
            eight[if is_big { size - 1 - i } else { i }] = *byte;
        }
        let whole = u64::from_le_bytes(eight);
        match self {
            Self::U8 | Self::U16 | Self::U32 => whole as f64,
            Self::I8 => f64::from(whole as i8),
            Self::I16 => f64::from(whole as i16),
            Self::I32 => f64::from(whole as i32),
            Self::I64 => whole as i64 as f64,
            Self::F32 => f64::from(f32::from_bits(whole as u32)),
            Self::F64 => f64::from_bits(whole),
        }
    }
}

/// The place of a point, where it may be one.
pub(super) fn corner(number: f64, place: usize) -> Result<u32, MeshError> {
    let whole = number >= 0.0 && number <= f64::from(u32::MAX) && number.fract() == 0.0;
    match whole {
        true => Ok(number as u32),
        false => Err(MeshError::Head {
            found: format!("a corner {number} of polygon {place}"),
            expected: "the place of a point, from 0",
        }),
    }
}
