//! Voxels written as text: numbers, or bytes in hexadecimal digits.

use super::quote::quote;
use crate::source::{Place, ReadError};
use crate::stream::Stream;
use crate::voxels::{Decoder, Sample};

const BUFFER_BYTES: usize = 1 << 16;
/// The longest number, bytes: the longest double without an exponent is shorter.
const MAX_WORD: usize = 400;

/// A stream of words between spaces, commas and line ends.
pub(crate) struct Words {
    stream: Stream,
    buffer: Vec<u8>,
    at: usize,
    /// Position in the file of the buffer's first byte.
    start: u64,
    word: String,
}

impl Words {
    /// The words of a plain stream.
    pub(crate) fn new(stream: Stream) -> Self {
        Self {
            start: stream.position(),
            stream,
            buffer: Vec::new(),
            at: 0,
            word: String::new(),
        }
    }

    /// The next `out.len()` numbers as HU.
    ///
    /// # Errors
    /// [`ReadError::Word`], [`ReadError::Truncated`], [`ReadError::Unreadable`].
    pub(crate) fn numbers(&mut self, out: &mut [i16], place: Place, decoder: &mut Decoder) -> Result<(), ReadError> {
        let count = out.len() as u64;
        for (done, voxel) in (0..).zip(out) {
            self.next_word(place)?;
            if self.word.is_empty() {
                // A digit and something between, for each that is missing.
                return Err(self.ended(place, 2 * (count - done) - 1));
            }
            let Some(value) = number(decoder.sample, &self.word) else {
                return Err(self.refused(place, "a number of the header's type"));
            };
            *voxel = decoder.hu(value);
        }
        Ok(())
    }

    /// The next `out.len()` bytes, two digits each.
    ///
    /// # Errors
    /// As [`Words::numbers`].
    pub(crate) fn hex(&mut self, out: &mut [u8], place: Place) -> Result<(), ReadError> {
        let count = out.len() as u64;
        for (done, byte) in (0..).zip(out) {
            *byte = 0;
            for digit in 0..2 {
                let Some(found) = self.next_solid(place)? else {
                    return Err(self.ended(place, 2 * (count - done) - digit));
                };
                let Some(value) = char::from(found).to_digit(16) else {
                    self.word = char::from(found).to_string();
                    return Err(self.refused(place, "hexadecimal digits"));
                };
                *byte = *byte << 4 | value as u8;
            }
        }
        Ok(())
    }

    /// Passes where nothing but spaces is left.
    ///
    /// # Errors
    /// [`ReadError::Word`], [`ReadError::Unreadable`].
    pub(crate) fn end(&mut self) -> Result<(), ReadError> {
        match self.next_solid(Place::End)? {
            None => Ok(()),
            Some(found) => {
                self.word = char::from(found).to_string();
                Err(self.refused(Place::End, "nothing after the last voxel"))
            }
        }
    }

    /// The next word; empty at the end.
    fn next_word(&mut self, place: Place) -> Result<(), ReadError> {
        self.word.clear();
        let mut next = self.next_solid(place)?;
        while let Some(byte) = next.filter(|&byte| !is_space(byte)) {
            self.word.push(char::from(byte));
            if self.word.len() > MAX_WORD {
                return Err(self.refused(place, "a number"));
            }
            next = self.next_byte(place)?;
        }
        Ok(())
    }

    fn next_solid(&mut self, place: Place) -> Result<Option<u8>, ReadError> {
        loop {
            match self.next_byte(place)? {
                Some(byte) if is_space(byte) => {}
                other => return Ok(other),
            }
        }
    }

    fn next_byte(&mut self, place: Place) -> Result<Option<u8>, ReadError> {
        if self.at >= self.buffer.len() {
            self.start = self.stream.position();
            self.at = 0;
            self.buffer.resize(BUFFER_BYTES, 0);
            let count = self.stream.read(&mut self.buffer, place, self.start)?;
            self.buffer.truncate(count);
        }
        let byte = self.buffer.get(self.at).copied();
        self.at += usize::from(byte.is_some());
        Ok(byte)
    }

    fn position(&self) -> u64 {
        self.start + self.at as u64
    }

    fn ended(&self, place: Place, missing: u64) -> ReadError {
        let found = self.position();
        ReadError::Truncated {
            path: self.stream.path().to_owned(),
            place,
            expected: found + missing,
            found,
        }
    }

    fn refused(&self, place: Place, expected: &'static str) -> ReadError {
        ReadError::Word {
            path: self.stream.path().to_owned(),
            place,
            byte: self.position(),
            found: quote(&self.word),
            expected,
        }
    }
}

/// Numbers may be parted by commas too.
fn is_space(byte: u8) -> bool {
    byte.is_ascii_whitespace() || byte == b','
}

/// The number that `word` is, if the type can hold it.
fn number(sample: Sample, word: &str) -> Option<f64> {
    let (low, high) = match sample {
        Sample::U8 => (0, i128::from(u8::MAX)),
        Sample::I8 => (i128::from(i8::MIN), i128::from(i8::MAX)),
        Sample::I16 => (i128::from(i16::MIN), i128::from(i16::MAX)),
        Sample::U16 => (0, i128::from(u16::MAX)),
        Sample::I32 => (i128::from(i32::MIN), i128::from(i32::MAX)),
        Sample::U32 => (0, i128::from(u32::MAX)),
        Sample::I64 => (i128::from(i64::MIN), i128::from(i64::MAX)),
        Sample::U64 => (0, i128::from(u64::MAX)),
        Sample::F32 => return word.parse::<f32>().ok().map(f64::from),
        Sample::F64 => return word.parse().ok(),
    };
    let value: i128 = word.parse().ok()?;
    (low..=high).contains(&value).then_some(value as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_fit_their_type() {
        assert_eq!(number(Sample::U8, "255"), Some(255.0));
        assert_eq!(number(Sample::U8, "256"), None);
        assert_eq!(number(Sample::I16, "-32768"), Some(-32768.0));
        assert_eq!(number(Sample::I16, "1.5"), None);
        assert_eq!(number(Sample::F32, "1.5e2"), Some(150.0));
        assert!(number(Sample::F64, "-nan").is_some_and(f64::is_nan));
        assert_eq!(
            number(Sample::U64, "18446744073709551615"),
            Some(18_446_744_073_709_552_000.0)
        );
        assert_eq!(number(Sample::F64, "twelve"), None);
    }
}
