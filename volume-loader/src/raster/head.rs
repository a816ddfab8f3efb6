//! The text at the beginning of a file, line by line, with numbers for lines and bounds for lengths.

use std::io::Read;
use std::path::Path;

use crate::source::{Place, ReadError};
use crate::stream::open_file;

/// The longest header, bytes: names of 16384 slices fit.
pub(crate) const MAX_HEAD: usize = 1 << 20;

/// The first bytes of a file, at most [`MAX_HEAD`].
pub(crate) struct Head {
    bytes: Vec<u8>,
    at: usize,
    number: usize,
}

/// One line of a header.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Line {
    /// Counted from 1.
    pub number: usize,
    /// Without its end and the spaces before it; bytes that are not UTF-8 are replaced.
    pub text: String,
}

impl Head {
    /// Reads the beginning of `path`.
    ///
    /// # Errors
    /// [`ReadError::Missing`], [`ReadError::NotAFile`], [`ReadError::Empty`], [`ReadError::Unreadable`].
    pub(crate) fn read(path: &Path) -> Result<Self, ReadError> {
        Self::read_some(path, MAX_HEAD as u64)
    }

    /// The same of its first `most` bytes.
    ///
    /// # Errors
    /// As [`Head::read`].
    pub(crate) fn read_some(path: &Path, most: u64) -> Result<Self, ReadError> {
        let (file, _) = open_file(path)?;
        let mut bytes = Vec::new();
        let read = file.take(most).read_to_end(&mut bytes);
        read.map_err(|source| ReadError::Unreadable {
            path: path.to_owned(),
            place: Place::Header,
            byte: 0,
            source,
        })?;
        Ok(Self::of(bytes))
    }

    /// The same from memory.
    pub(crate) fn of(bytes: Vec<u8>) -> Self {
        Self {
            bytes,
            at: 0,
            number: 0,
        }
    }

    /// Byte after the last line given.
    pub(crate) fn position(&self) -> u64 {
        self.at as u64
    }

    /// The first bytes, `count` at most, whatever they are.
    pub(crate) fn first(&self, count: usize) -> &[u8] {
        self.bytes.get(..count).unwrap_or(&self.bytes)
    }

    /// Whether the file may go on where the bytes end.
    pub(crate) fn is_cut(&self) -> bool {
        self.bytes.len() >= MAX_HEAD
    }

    /// The next line, or none at the end.
    pub(crate) fn line(&mut self) -> Option<Line> {
        let rest = self.bytes.get(self.at..).filter(|rest| !rest.is_empty())?;
        let length = rest.iter().position(|&b| b == b'\n');
        let (line, step) = match length {
            Some(length) => (rest.get(..length).unwrap_or(rest), length + 1),
            None => (rest, rest.len()),
        };
        let text = String::from_utf8_lossy(line).trim_end().to_owned();
        self.at += step;
        self.number += 1;
        Some(Line {
            number: self.number,
            text,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_have_numbers_and_positions() {
        let mut head = Head::of(b"one\r\n\ntwo".to_vec());
        let mut seen = Vec::new();
        while let Some(line) = head.line() {
            seen.push((line.number, line.text, head.position()));
        }
        let want = [(1, "one", 5), (2, "", 6), (3, "two", 9)].map(|(n, t, p)| (n, t.to_owned(), p));
        assert_eq!(seen, want);
    }
}
