//! Stored pixels to HU: HU = slope * stored + intercept (DICOM PS3.3, C.11.1.1.2), pixel cells after PS3.5 section 8.1.1.

use super::error::FileError;
use super::header::Header;
use super::syntax::PixelCoding;
use super::tag as el;
use super::tag::Tag;
use crate::source::Conversion;

/// How a pixel cell holds its number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Cell {
    /// 8, 16 or 32.
    pub allocated: u16,
    /// Bits of the number, at least 1.
    pub stored: u16,
    /// The highest of them, at least `stored - 1`, below `allocated`.
    pub high_bit: u16,
    /// Two's complement.
    pub signed: bool,
    pub big_endian: bool,
}

impl Cell {
    /// The cell that a header describes.
    ///
    /// # Errors
    /// [`FileError::Value`].
    pub(crate) fn of(header: &Header) -> Result<Self, FileError> {
        let refused = |tag: Tag, found: u16, expected| {
            let found = found.to_string();
            Err(FileError::Value { tag, found, expected })
        };
        let (allocated, stored, high_bit) = (header.bits_allocated, header.bits_stored, header.high_bit);
        let native = header.syntax.pixels == PixelCoding::Native;
        match (allocated, header.big_endian(), native) {
            (16, _, _) | (8 | 32, false, true) | (8, _, false) => {}
            (_, true, _) => return refused(el::BITS_ALLOCATED, allocated, "16 in big endian"),
            (_, _, false) => return refused(el::BITS_ALLOCATED, allocated, "8 or 16 where pixels are compressed"),
            _ => return refused(el::BITS_ALLOCATED, allocated, "8, 16 or 32"),
        }
        if stored == 0 || stored > allocated {
            return refused(el::BITS_STORED, stored, "from 1 to BitsAllocated");
        }
        if high_bit >= allocated || high_bit + 1 < stored {
            return refused(el::HIGH_BIT, high_bit, "from BitsStored - 1 to BitsAllocated - 1");
        }
        if header.representation > 1 {
            return refused(el::REPRESENTATION, header.representation, "0 (unsigned) or 1 (signed)");
        }
        Ok(Self {
            allocated,
            stored,
            high_bit,
            signed: header.representation == 1,
            big_endian: header.big_endian(),
        })
    }

    /// Bytes per pixel.
    pub(crate) fn bytes(self) -> usize {
        usize::from(self.allocated / 8)
    }

    /// The smallest and the largest number.
    pub(crate) fn range(self) -> [i64; 2] {
        match self.signed {
            true => [-(1 << (self.stored - 1)), (1 << (self.stored - 1)) - 1],
            false => [0, (1 << self.stored) - 1],
        }
    }

    /// The number in a cell of up to 32 bits.
    fn number(self, raw: u32) -> i64 {
        let top = raw << (31 - self.high_bit);
        match self.signed {
            true => i64::from(top as i32 >> (32 - self.stored)),
            false => i64::from(top >> (32 - self.stored)),
        }
    }
}

/// Turns one slice's pixels into HU.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ToHu {
    pub cell: Cell,
    pub slope: f64,
    pub intercept: f64,
    way: Way,
}

/// How much arithmetic a slice needs; each way gives the same numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Way {
    /// Every HU fits 16 bits, so that arithmetic modulo 2^16 is exact.
    Narrow([i16; 2]),
    /// Every HU fits 32 bits.
    Wide([i32; 2]),
    Real,
}

impl ToHu {
    /// For cells and a finite slope and intercept.
    pub(crate) fn new(cell: Cell, slope: f64, intercept: f64) -> Self {
        let way = way(cell, slope, intercept);
        Self {
            cell,
            slope,
            intercept,
            way,
        }
    }

    /// HU of one number, before it is rounded.
    pub(crate) fn hu(&self, number: i64) -> f64 {
        self.slope * number as f64 + self.intercept
    }

    /// Turns `bytes` into `out`, pixel by pixel, as far as both reach.
    pub(crate) fn convert(&self, bytes: &[u8], out: &mut [i16], conversion: &mut Conversion) {
        match (self.cell.allocated, self.cell.big_endian) {
            (8, _) => {
                let raws = bytes.iter().map(|&b| u32::from(b));
                self.real(raws, out, conversion);
            }
            (16, false) => {
                let raws = bytes.as_chunks().0.iter().map(|b| u16::from_le_bytes(*b));
                self.convert16(raws, out, conversion);
            }
            (16, true) => {
                let raws = bytes.as_chunks().0.iter().map(|b| u16::from_be_bytes(*b));
                self.convert16(raws, out, conversion);
            }
            _ => {
                let raws = bytes.as_chunks().0.iter().map(|b| u32::from_le_bytes(*b));
                self.real(raws, out, conversion);
            }
        }
    }

    /// The same for cells of 16 bits, or of 8 in 16.
    pub(crate) fn convert16(&self, raws: impl Iterator<Item = u16>, out: &mut [i16], conversion: &mut Conversion) {
        // Cells of 8 bits that a decoder widened have their high bit below 8 all the same.
        let (up, down) = (15 - self.cell.high_bit.min(15), 16 - self.cell.stored.min(16));
        let signed = |raw: u16| (raw << up) as i16 >> down;
        let unsigned = |raw: u16| (raw << up) >> down;
        match (self.way, self.cell.signed) {
            (Way::Narrow(scale), true) => narrow(raws.map(signed), scale, out),
            (Way::Narrow(scale), false) => narrow(raws.map(|raw| unsigned(raw) as i16), scale, out),
            (Way::Wide(scale), true) => wide(raws.map(|raw| i32::from(signed(raw))), scale, out, conversion),
            (Way::Wide(scale), false) => wide(raws.map(|raw| i32::from(unsigned(raw))), scale, out, conversion),
            (Way::Real, _) => self.real(raws.map(u32::from), out, conversion),
        }
    }

    fn real(&self, raws: impl Iterator<Item = u32>, out: &mut [i16], conversion: &mut Conversion) {
        for (raw, voxel) in raws.zip(out) {
            // Finite times finite plus finite may overflow to infinity, never to NaN: held to the range like any other.
            let hu = self.hu(self.cell.number(raw)).clamp(-1e9, 1e9);
            *voxel = conversion.voxel(hu, 0);
        }
    }
}

/// Whole slopes and intercepts need no floating point.
fn way(cell: Cell, slope: f64, intercept: f64) -> Way {
    let whole = |v: f64| (v.fract() == 0.0 && v.abs() <= f64::from(i32::MAX)).then_some(v as i64);
    let (Some(slope), Some(intercept)) = (whole(slope), whole(intercept)) else {
        return Way::Real;
    };
    if cell.allocated == 32 {
        return Way::Real;
    }
    let ends = cell.range().map(|number| number * slope + intercept);
    let narrow = [slope, intercept].map(i16::try_from);
    if let ([Ok(slope), Ok(intercept)], true) = (narrow, ends.iter().all(|&hu| i16::try_from(hu).is_ok())) {
        return Way::Narrow([slope, intercept]);
    }
    let wide = [slope, intercept].map(i32::try_from);
    // The product by itself must fit too.
    let fits = |hu: i64| i32::try_from(hu).is_ok() && i32::try_from(hu - intercept).is_ok();
    match wide {
        [Ok(slope), Ok(intercept)] if ends.iter().all(|&hu| fits(hu)) => Way::Wide([slope, intercept]),
        _ => Way::Real,
    }
}

fn narrow(numbers: impl Iterator<Item = i16>, [slope, intercept]: [i16; 2], out: &mut [i16]) {
    for (number, voxel) in numbers.zip(out) {
        *voxel = number.wrapping_mul(slope).wrapping_add(intercept);
    }
}

fn wide(
    numbers: impl Iterator<Item = i32>,
    [slope, intercept]: [i32; 2],
    out: &mut [i16],
    conversion: &mut Conversion,
) {
    let (mut low, mut high) = (0_u32, 0_u32);
    for (number, voxel) in numbers.zip(out) {
        let hu = slope * number + intercept;
        low += u32::from(hu < i32::from(i16::MIN));
        high += u32::from(hu > i32::from(i16::MAX));
        *voxel = hu.clamp(i32::from(i16::MIN), i32::from(i16::MAX)) as i16;
    }
    conversion.clamped_low += u64::from(low);
    conversion.clamped_high += u64::from(high);
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn real(to_hu: ToHu) -> ToHu {
        ToHu {
            way: Way::Real,
            ..to_hu
        }
    }

    proptest! {
        #[test]
        fn whole_numbers_take_the_same_way_as_real_ones(
            stored in 1_u16..=16,
            spare in 0_u16..16,
            signed: bool,
            big_endian: bool,
            slope in prop_oneof![Just(1), Just(-1), -40..40_i32, -70_000..70_000_i32],
            intercept in prop_oneof![Just(-1024), -70_000..70_000_i32],
            bytes in prop::collection::vec(any::<u8>(), 64),
        ) {
            let high_bit = (stored - 1 + spare).min(15);
            let cell = Cell { allocated: 16, stored, high_bit, signed, big_endian };
            let to_hu = ToHu::new(cell, f64::from(slope), f64::from(intercept));
            let (mut fast, mut slow) = ([0; 32], [0; 32]);
            let (mut changed, mut changed_slow) = (Conversion::default(), Conversion::default());
            to_hu.convert(&bytes, &mut fast, &mut changed);
            real(to_hu).convert(&bytes, &mut slow, &mut changed_slow);
            prop_assert_eq!((fast, changed), (slow, changed_slow));
        }
    }

    #[test]
    fn the_usual_cells_are_narrow() {
        let cell = |stored, signed| Cell {
            allocated: 16,
            stored,
            high_bit: stored - 1,
            signed,
            big_endian: false,
        };
        assert_eq!(ToHu::new(cell(12, false), 1.0, -1024.0).way, Way::Narrow([1, -1024]));
        assert_eq!(ToHu::new(cell(16, true), 1.0, 0.0).way, Way::Narrow([1, 0]));
        assert_eq!(ToHu::new(cell(16, true), 1.0, -1024.0).way, Way::Wide([1, -1024]));
        assert_eq!(ToHu::new(cell(12, false), 0.5, 0.0).way, Way::Real);
    }
}
