//! Bits one after the other into bytes, the lowest first, on from frame to frame without a gap (PS3.5 section 8.1.1).

/// Packs bits; what makes no whole byte yet waits for the next.
#[derive(Debug, Default)]
pub(super) struct Bits {
    byte: u8,
    /// Bits in `byte`, 0 to 7.
    count: u8,
}

impl Bits {
    /// Appends these bits to `out`, as far as they make whole bytes.
    pub(super) fn push(&mut self, bits: impl Iterator<Item = bool>, out: &mut Vec<u8>) {
        for bit in bits {
            self.byte |= u8::from(bit) << self.count;
            self.count += 1;
            if self.count == 8 {
                out.push(self.byte);
                *self = Self::default();
            }
        }
    }

    /// Appends the last bits, filled up with zeros.
    pub(super) fn finish(self, out: &mut Vec<u8>) {
        if self.count > 0 {
            out.push(self.byte);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_go_on_from_one_frame_to_the_next() {
        let (mut bits, mut bytes) = (Bits::default(), Vec::new());
        for frame in [[true, false, true, true, false], [false, true, true, false, true]] {
            bits.push(frame.into_iter(), &mut bytes);
        }
        bits.finish(&mut bytes);
        assert_eq!(bytes, [0b1100_1101, 0b10]);
        let mut whole = Vec::new();
        let mut bits = Bits::default();
        bits.push([true; 8].into_iter(), &mut whole);
        bits.finish(&mut whole);
        assert_eq!(whole, [255]);
    }
}
