//! Encoders for tests only.

use super::{COLUMNS, ROWS};

/// Packs one byte plane: runs where three bytes are equal, literals elsewhere.
fn pack(plane: &[u8]) -> Vec<u8> {
    let (mut out, mut rest) = (Vec::new(), plane);
    while let Some(&first) = rest.first() {
        let run = rest.iter().take(128).take_while(|&&b| b == first).count();
        if run > 2 {
            out.extend([(257 - run) as u8, first]);
            rest = &rest[run..];
        } else {
            let literal = rest.len().min(5);
            out.push(literal as u8 - 1);
            out.extend(&rest[..literal]);
            rest = &rest[literal..];
        }
    }
    if out.len() % 2 == 1 {
        out.push(0);
    }
    out
}

pub(super) fn rle(pixels: &[u16]) -> Vec<u8> {
    let planes = [8, 0].map(|shift| pack(&pixels.iter().map(|p| (p >> shift) as u8).collect::<Vec<_>>()));
    let mut out = Vec::new();
    for word in [2, 64, 64 + planes[0].len() as u32].into_iter().chain([0; 13]) {
        out.extend(word.to_le_bytes());
    }
    planes.iter().for_each(|plane| out.extend(plane));
    out
}

/// Bits, with a zero after every FF.
#[derive(Default)]
struct BitWriter {
    out: Vec<u8>,
    byte: u8,
    count: u8,
}

impl BitWriter {
    fn put(&mut self, value: u32, bits: u8) {
        for i in (0..bits).rev() {
            self.byte = self.byte << 1 | (value >> i & 1) as u8;
            self.count += 1;
            if self.count == 8 {
                self.out.push(self.byte);
                if self.byte == 0xFF {
                    self.out.push(0);
                }
                (self.byte, self.count) = (0, 0);
            }
        }
    }

    fn flush(&mut self) {
        while self.count > 0 {
            self.put(1, 1);
        }
    }
}

/// An encoder straight from annex H: 17 categories, each with a code of 5 bits.
pub(super) fn jpeg_lossless(pixels: &[u16], precision: u8, selection: u8, shift: u8, rows_between: u16) -> Vec<u8> {
    let (width, restart) = (usize::from(COLUMNS), rows_between * COLUMNS);
    let mut out = vec![0xFF, 0xD8, 0xFF, 0xC3, 0, 11, precision];
    out.extend([0, ROWS as u8, 0, COLUMNS as u8, 1, 1, 0x11, 0]);
    out.extend([0xFF, 0xC4, 0, 36, 0, 0, 0, 0, 0, 17, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]);
    out.extend(0..17);
    if restart > 0 {
        out.extend([0xFF, 0xDD, 0, 4]);
        out.extend(restart.to_be_bytes());
    }
    out.extend([0xFF, 0xDA, 0, 8, 1, 1, 0, selection, 0, shift]);
    let mut bits = BitWriter::default();
    let at = |i: usize| i32::from(pixels[i] >> shift);
    for i in 0..pixels.len() {
        let (x, y) = (i % width, i / width);
        let first_row = y == 0 || (rows_between > 0 && y % usize::from(rows_between) == 0);
        if first_row && x == 0 && y > 0 {
            bits.flush();
            let number = (y / usize::from(rows_between) - 1) % 8;
            bits.out.extend([0xFF, 0xD0 + number as u8]);
        }
        let prediction = match (x, first_row) {
            (0, true) => 1 << (precision - shift - 1),
            (_, true) => at(i - 1),
            (0, false) => at(i - width),
            _ => {
                let (a, b, c) = (at(i - 1), at(i - width), at(i - width - 1));
                [
                    0,
                    a,
                    b,
                    c,
                    a + b - c,
                    a + ((b - c) >> 1),
                    b + ((a - c) >> 1),
                    (a + b) >> 1,
                ][usize::from(selection)]
            }
        };
        // To the nearest modulo 2^16: -32767 to 32768.
        let wrapped = (at(i) - prediction).rem_euclid(1 << 16);
        let difference = if wrapped > 32_768 { wrapped - (1 << 16) } else { wrapped };
        let category = 32 - difference.unsigned_abs().leading_zeros() as u8;
        bits.put(u32::from(category), 5);
        if (1..16).contains(&category) {
            let value = if difference < 0 { difference - 1 } else { difference };
            bits.put(value as u32 & ((1 << category) - 1), category);
        }
    }
    bits.flush();
    out.extend(bits.out);
    out.extend([0xFF, 0xD9]);
    out
}

pub(super) fn jpeg_ls(pixels: &[u16]) -> Vec<u8> {
    let mut out = Vec::new();
    jpegls::encode(pixels, u32::from(COLUMNS), u32::from(ROWS), &mut out).unwrap();
    out
}
