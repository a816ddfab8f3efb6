//! The hash of a file that is read anyway.

use std::io::{self, Read};

/// Reads, and hashes what was read.
#[derive(Debug)]
pub(super) struct Hashed<R> {
    input: R,
    hasher: blake3::Hasher,
}

impl<R: Read> Hashed<R> {
    pub(super) fn new(input: R) -> Self {
        Self {
            input,
            hasher: blake3::Hasher::new(),
        }
    }

    /// BLAKE3 of all that is there, in hexadecimal digits; reads what was not read yet.
    ///
    /// # Errors
    /// Those of reading.
    pub(super) fn finish(mut self) -> io::Result<String> {
        let mut rest = vec![0; 1 << 16];
        while self.read(&mut rest)? > 0 {}
        Ok(self.hasher.finalize().to_hex().to_string())
    }
}

impl<R: Read> Read for Hashed<R> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        let read = self.input.read(bytes)?;
        self.hasher.update(&bytes[..read]);
        Ok(read)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hash_is_that_of_all_bytes_whoever_read_them() {
        let bytes: Vec<u8> = (0..200_000_u32).map(|i| (i % 251) as u8).collect();
        let mut hashed = Hashed::new(bytes.as_slice());
        hashed.read_exact(&mut [0; 777]).unwrap();
        assert_eq!(hashed.finish().unwrap(), blake3::hash(&bytes).to_hex().to_string());
    }
}
