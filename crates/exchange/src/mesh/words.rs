//! The words of a text, with their lines.

use super::MeshError;
use crate::quoted;

/// Words from some place on.
pub(super) struct Words<'a> {
    rest: &'a [u8],
    line: usize,
}

impl<'a> Words<'a> {
    /// Of these bytes, the first of which stands on this line.
    pub(super) const fn new(rest: &'a [u8], line: usize) -> Self {
        Self { rest, line }
    }

    /// The next word; empty at the end.
    pub(super) fn next(&mut self) -> &'a [u8] {
        while let [first, rest @ ..] = self.rest
            && first.is_ascii_whitespace()
        {
            self.line += usize::from(*first == b'\n');
            self.rest = rest;
        }
        let end = self
            .rest
            .iter()
            .position(u8::is_ascii_whitespace)
            .unwrap_or(self.rest.len());
        let (word, rest) = self.rest.split_at(end);
        self.rest = rest;
        word
    }

    /// What follows on this line, and on to the next.
    pub(super) fn line(&mut self) -> &'a [u8] {
        let end = self.rest.iter().position(|byte| *byte == b'\n');
        let (line, rest) = match end {
            Some(end) => (&self.rest[..end], &self.rest[end + 1..]),
            None => (self.rest, &self.rest[self.rest.len()..]),
        };
        self.line += usize::from(end.is_some());
        self.rest = rest;
        line.trim_ascii()
    }

    /// The bytes that are left.
    pub(super) const fn rest(&self) -> &'a [u8] {
        self.rest
    }

    /// Goes on behind so many bytes.
    pub(super) fn skip(&mut self, bytes: usize) {
        self.rest = self.rest.get(bytes..).unwrap_or_default();
    }

    /// Refuses `found`.
    pub(super) fn refused(&self, found: &[u8], expected: &'static str) -> MeshError {
        MeshError::Word {
            line: self.line,
            found: quoted(&String::from_utf8_lossy(&found[..found.len().min(64)])),
            expected,
        }
    }

    /// The next word, which must be this one.
    pub(super) fn expect(&mut self, word: &'static str) -> Result<(), MeshError> {
        let found = self.next();
        match found.eq_ignore_ascii_case(word.as_bytes()) {
            true => Ok(()),
            false => Err(self.refused(found, word)),
        }
    }

    /// The next word as a number.
    pub(super) fn number<T: std::str::FromStr>(&mut self, expected: &'static str) -> Result<T, MeshError> {
        let found = self.next();
        let number = std::str::from_utf8(found).ok().and_then(|word| word.parse().ok());
        number.ok_or_else(|| self.refused(found, expected))
    }

    /// The next three numbers.
    pub(super) fn point(&mut self) -> Result<[f64; 3], MeshError> {
        let mut number = || self.number("a coordinate");
        Ok([number()?, number()?, number()?])
    }
}
