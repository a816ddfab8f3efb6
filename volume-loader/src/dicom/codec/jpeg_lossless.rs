//! JPEG lossless, sequential, Huffman (ITU-T T.81, process 14, annex H), one component of 2 to 16 bits.
//!
//! Written here because the decoder that dicom-rs uses goes on with zeros where a stream ends early, and is wrong where
//! there are restarts or a point transform: a picture with a plausible lower half would be shown.

use super::jpeg::{EOI, SOF_LOSSLESS, Segments, segments};
use super::{Image, failed};
use crate::dicom::error::FileError;

const CODEC: &str = "JPEG lossless";

/// Decodes one component. The stream must end where its pixels do.
///
/// # Errors
/// [`FileError::Mismatch`], [`FileError::Codec`].
pub(super) fn decode(data: &[u8], image: &Image) -> Result<Vec<u16>, FileError> {
    let found = segments(data).map_err(|detail| failed(CODEC, detail))?;
    if found.process != SOF_LOSSLESS {
        return Err(failed(
            CODEC,
            format!("a frame of kind FF{:02X}, expected FFC3", found.process),
        ));
    }
    image.check(CODEC, found.claim)?;
    decode_scan(&found, usize::from(image.columns), image.pixels()).map_err(|detail| failed(CODEC, detail))
}

/// How a sample is predicted from the left, upper and upper left neighbour.
#[derive(Debug, Clone, Copy)]
struct Predictor {
    /// Table H.1, 1 to 7.
    selection: u8,
    /// The prediction where there is no neighbour.
    start: i32,
}

impl Predictor {
    fn predict(self, a: i32, b: i32, c: i32) -> i32 {
        match self.selection {
            1 => a,
            2 => b,
            3 => c,
            4 => a + b - c,
            5 => a + ((b - c) >> 1),
            6 => b + ((a - c) >> 1),
            _ => (a + b) >> 1,
        }
    }
}

fn decode_scan(found: &Segments<'_>, columns: usize, pixels: usize) -> Result<Vec<u16>, String> {
    let [count, _, tables, selection, _, approximation] = found.scan;
    let (shift, precision) = (approximation & 15, found.claim.precision as u8);
    if count != 1 || !(1..=7).contains(&selection) || shift >= precision || !(2..=16).contains(&precision) {
        return Err(format!("scan parameters {:?} for {precision} bits", found.scan));
    }
    let restart = usize::from(found.restart);
    if restart % columns != 0 {
        return Err(format!("a restart every {restart} samples, within rows of {columns}"));
    }
    let table = Table::of(&found.tables, tables >> 4)?;
    let (mut bits, mut samples) = (Bits::new(found.coded), vec![0_u16; pixels]);
    let bits_kept = precision - shift;
    let most = (1_u32 << bits_kept) - 1;
    let predictor = Predictor {
        selection,
        start: 1 << (bits_kept - 1),
    };
    let rows_between = restart / columns;
    let mut above: Vec<u16> = Vec::new();
    for (y, row) in samples.chunks_mut(columns).enumerate() {
        if rows_between > 0 && y > 0 && y % rows_between == 0 {
            bits.restart((y / rows_between - 1) as u8 % 8)?;
            above.clear();
        }
        decode_row(&mut bits, &table, predictor, row, &above)
            .and_then(|()| check_row(row, most))
            .map_err(|what| format!("{what} in row {y}"))?;
        above.clear();
        above.extend_from_slice(row);
    }
    bits.finish()?;
    samples.iter_mut().for_each(|sample| *sample <<= shift);
    Ok(samples)
}

/// One row; `above` is empty for the first of the image and after a restart (H.1.2.1).
fn decode_row(
    bits: &mut Bits<'_>,
    table: &Table,
    predictor: Predictor,
    row: &mut [u16],
    above: &[u16],
) -> Result<(), String> {
    let (mut left, mut upper_left) = (0, 0);
    for (x, sample) in row.iter_mut().enumerate() {
        let difference = bits.difference(table)?;
        let upper = above.get(x).copied().map(i32::from);
        let prediction = match (x, upper) {
            (0, None) => predictor.start,
            (_, None) => left,
            (0, Some(upper)) => upper,
            (_, Some(upper)) => predictor.predict(left, upper, upper_left),
        };
        // Modulo 2^16, as the standard asks.
        *sample = (prediction + difference) as u16;
        left = i32::from(*sample);
        upper_left = upper.unwrap_or(0);
    }
    Ok(())
}

/// A sample beyond its precision tells a damaged stream.
fn check_row(row: &[u16], most: u32) -> Result<(), String> {
    match row.iter().find(|&&sample| u32::from(sample) > most) {
        Some(sample) => Err(format!("a sample of {sample}, more than {most},")),
        None => Ok(()),
    }
}

/// A Huffman table: for each 16 bits that may come, the category and the length of its code; length 0 where there is none.
struct Table(Vec<[u8; 2]>);

impl Table {
    /// The last table of class 0 with this number (T.81, B.2.4.2 and annex C).
    fn of(segments: &[&[u8]], number: u8) -> Result<Self, String> {
        let mut found = None;
        for segment in segments {
            let mut rest = *segment;
            while let Some((head, after)) = rest.split_at_checked(17) {
                let total: usize = head.iter().skip(1).map(|&count| usize::from(count)).sum();
                let (symbols, next) = after.split_at_checked(total).ok_or("a short Huffman table")?;
                if head.first() == Some(&number) {
                    found = Some(Self::build(head.get(1..).unwrap_or_default(), symbols)?);
                }
                rest = next;
            }
        }
        found.ok_or_else(|| format!("no Huffman table {number}"))
    }

    fn build(counts: &[u8], symbols: &[u8]) -> Result<Self, String> {
        let (mut lookup, mut symbols) = (Vec::with_capacity(1 << 16), symbols.iter());
        for (length, &count) in (1_u8..).zip(counts) {
            for &symbol in symbols.by_ref().take(usize::from(count)) {
                if symbol > 16 {
                    return Err(format!("Huffman category {symbol}, expected at most 16"));
                }
                lookup.resize(lookup.len() + (1 << (16 - length)), [symbol, length]);
                if lookup.len() > 1 << 16 {
                    return Err("a Huffman table with more codes than bits".to_owned());
                }
            }
        }
        lookup.resize(1 << 16, [0, 0]);
        Ok(Self(lookup))
    }
}

/// Coded bits, most significant first, with stuffed zeros taken out; past the end come ones, which are counted.
struct Bits<'a> {
    coded: &'a [u8],
    at: usize,
    buffer: u64,
    /// Bits in `buffer`, and how many of them are past the end.
    held: u32,
    spare: u32,
}

impl<'a> Bits<'a> {
    fn new(coded: &'a [u8]) -> Self {
        Self {
            coded,
            at: 0,
            buffer: 0,
            held: 0,
            spare: 0,
        }
    }

    fn fill(&mut self) {
        while self.held <= 48 {
            let byte = match (self.coded.get(self.at), self.coded.get(self.at + 1)) {
                (Some(0xFF), Some(0)) => {
                    self.at += 2;
                    0xFF
                }
                (Some(&byte), _) if byte != 0xFF => {
                    self.at += 1;
                    byte
                }
                _ => {
                    self.spare += 8;
                    0xFF
                }
            };
            self.buffer = self.buffer << 8 | u64::from(byte);
            self.held += 8;
        }
    }

    /// The next difference (T.81, H.1.2.2): a category, and as many bits.
    fn difference(&mut self, table: &Table) -> Result<i32, String> {
        if self.held < 32 {
            self.fill();
        }
        let next = (self.buffer >> (self.held - 16)) as u16;
        let [category, length] = table.0.get(usize::from(next)).copied().unwrap_or_default();
        if length == 0 {
            return Err("a code that is in no table".to_owned());
        }
        self.held -= u32::from(length);
        let difference = match category {
            0 => 0,
            16 => 32_768,
            _ => {
                self.held -= u32::from(category);
                let value = (self.buffer >> self.held) as i32 & ((1 << category) - 1);
                let negative = value < 1 << (category - 1);
                if negative { value - (1 << category) + 1 } else { value }
            }
        };
        if self.held < self.spare {
            return Err("the coded pixels end".to_owned());
        }
        Ok(difference)
    }

    /// No more than the bits that fill up a byte may be left.
    fn align(&mut self) -> Result<(), String> {
        let left = self.held.saturating_sub(self.spare);
        if left >= 8 {
            return Err(format!("{} bytes of coded pixels are left over", left / 8));
        }
        (self.buffer, self.held, self.spare) = (0, 0, 0);
        Ok(())
    }

    /// Passes over restart marker `number`, 0 to 7.
    fn restart(&mut self, number: u8) -> Result<(), String> {
        self.align()?;
        let expected = 0xD0 + number;
        if self.coded.get(self.at..self.at + 2) != Some(&[0xFF, expected]) {
            return Err(format!("no restart marker FF{expected:02X} where one must be"));
        }
        self.at += 2;
        Ok(())
    }

    fn finish(&mut self) -> Result<(), String> {
        self.align()?;
        match self.coded.get(self.at..self.at + 2) {
            Some(&[0xFF, EOI]) => Ok(()),
            _ => Err("no end of image after the last pixel".to_owned()),
        }
    }
}
