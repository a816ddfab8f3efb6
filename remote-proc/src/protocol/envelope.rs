//! Around each message: of which run it is, from which sender, and its number.

use std::ops::RangeInclusive;

/// Around each message, little-endian.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Envelope {
    /// The run, by 64 bits of the hash of its facts.
    pub run: u64,
    /// Drawn anew by each sender, whose numbers begin at 0.
    pub sender: u64,
    /// Counts the messages of a channel; a gap means that some were lost on the way.
    pub count: u64,
}

/// Bytes that are no message of their channel.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("a message of {found} bytes came on {key}; expected are {least} to {most}")]
pub struct EnvelopeError {
    /// The channel's key.
    pub key: &'static str,
    /// How many bytes came.
    pub found: usize,
    /// The fewest that a message of it has.
    pub least: usize,
    /// The most.
    pub most: usize,
}

impl Envelope {
    /// Its bytes.
    pub const BYTES: usize = 24;

    /// The envelope, and `body` in it.
    pub fn around(&self, body: &[u8]) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(Self::BYTES + body.len());
        for number in [self.run, self.sender, self.count] {
            bytes.extend(number.to_le_bytes());
        }
        bytes.extend_from_slice(body);
        bytes
    }

    /// The envelope and what is in it.
    ///
    /// # Errors
    /// [`EnvelopeError`] unless the body has `allowed` bytes.
    pub fn open<'a>(
        bytes: &'a [u8],
        key: &'static str,
        allowed: RangeInclusive<usize>,
    ) -> Result<(Self, &'a [u8]), EnvelopeError> {
        let error = EnvelopeError {
            key,
            found: bytes.len(),
            least: Self::BYTES + allowed.start(),
            most: Self::BYTES + allowed.end(),
        };
        let Some((head, body)) = bytes.split_first_chunk::<{ Self::BYTES }>() else {
            return Err(error);
        };
        if !allowed.contains(&body.len()) {
            return Err(error);
        }
        let number = |at: usize| {
            head[8 * at..8 * at + 8]
                .iter()
                .rev()
                .fold(0, |n, &b| n << 8 | u64::from(b))
        };
        let envelope = Self {
            run: number(0),
            sender: number(1),
            count: number(2),
        };
        Ok((envelope, body))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comes_back_and_nothing_else_is_taken_for_one() {
        let envelope = Envelope {
            run: 0x0102_0304_0506_0708,
            sender: u64::MAX,
            count: 3,
        };
        let bytes = envelope.around(b"body");
        assert_eq!(Envelope::open(&bytes, "k", 4..=4), Ok((envelope, &b"body"[..])));
        for bad in [&bytes[..27], &bytes[..23], &[][..], &[bytes.clone(), vec![0]].concat()] {
            let error = Envelope::open(bad, "k", 4..=4).unwrap_err();
            assert_eq!((error.found, error.least, error.most), (bad.len(), 28, 28));
        }
        let longer = [&bytes[..], &[9, 9]].concat();
        assert_eq!(Envelope::open(&longer, "k", 4..=6).unwrap().1, b"body\x09\x09");
        assert_eq!(Envelope::open(&longer, "k", 4..=5).unwrap_err().most, 29);
    }
}
