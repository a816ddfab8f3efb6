//! What lies at a pixel, as one byte.

use super::image::Pixel;

/// Codes; organs follow.
pub(super) const OUTSIDE: u8 = 0;
pub(super) const TWICE: u8 = 1;
pub(super) const VACATED: u8 = 2;
pub(super) const FIRST: u8 = 3;

/// Eight bytes of one value.
pub(super) const fn eight(kind: u8) -> u64 {
    u64::from_ne_bytes([kind; 8])
}

/// Writes a row; how many more than one claims.
#[inline(always)]
pub(super) fn decode(kinds: &[u8], pixels: &mut [Pixel]) -> usize {
    let pixel = |kind: u8| match kind {
        OUTSIDE => Pixel::Outside,
        TWICE => Pixel::Twice,
        VACATED => Pixel::Vacated,
        organ => Pixel::Inside(organ - FIRST),
    };
    let mut twice = 0;
    let (many, rest) = kinds.as_chunks::<MANY>();
    let (own, last) = pixels.as_chunks_mut::<MANY>();
    // The same pixel many times is copied at once.
    let (mut like, mut copies) = (OUTSIDE, [Pixel::Outside; MANY]);
    for (kinds, pixels) in many.iter().zip(own) {
        let first = eight(kinds[0]);
        if kinds
            .as_chunks()
            .0
            .iter()
            .all(|word| u64::from_ne_bytes(*word) == first)
        {
            if like != kinds[0] {
                (like, copies) = (kinds[0], [pixel(kinds[0]); MANY]);
            }
            *pixels = copies;
            twice += if like == TWICE { MANY } else { 0 };
        } else {
            for (kind, own) in kinds.iter().zip(pixels) {
                *own = pixel(*kind);
                twice += usize::from(*kind == TWICE);
            }
        }
    }
    for (kind, own) in rest.iter().zip(last) {
        *own = pixel(*kind);
        twice += usize::from(*kind == TWICE);
    }
    twice
}

/// Pixels that are written at a time where they are alike.
const MANY: usize = 32;
