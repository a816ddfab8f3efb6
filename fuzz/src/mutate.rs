//! Mutations of good bytes, the same for the same seed.

/// Damages bytes in one to four places.
pub struct Mutator(u64);

/// Numbers at which lengths, counts and signs go wrong, of four and eight bytes.
const EDGES: [u64; 8] = [0, 1, 0x7f, 0xff, 0xffff, 0x7fff_ffff, 0xff00_0000, u64::MAX];

impl Mutator {
    /// For a seed other than 0.
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1)
    }

    /// xorshift64*.
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        self.0.wrapping_mul(0x2545_f491_4f6c_dd1d)
    }

    fn below(&mut self, most: usize) -> usize {
        (self.next() >> 11) as usize % most.max(1)
    }

    /// `good` with some damage.
    pub fn damaged(&mut self, good: &[u8]) -> Vec<u8> {
        let mut bytes = good.to_vec();
        for _ in 0..=self.below(4) {
            self.once(&mut bytes);
        }
        bytes
    }

    fn once(&mut self, bytes: &mut Vec<u8>) {
        let (length, at) = (bytes.len(), self.below(bytes.len()));
        match self.below(7) {
            0 => bytes.truncate(at),
            1 if length > 0 => bytes[at] ^= 1 << self.below(8),
            2 => {
                let end = (at + 1 + self.below(16)).min(length);
                bytes.drain(at..end);
            }
            3 => {
                let (from, many) = (self.below(length), 1 + self.below(32));
                let piece: Vec<u8> = bytes[from..(from + many).min(length)].to_vec();
                bytes.splice(at..at, piece);
            }
            4 | 5 => {
                let (edge, wide) = (
                    EDGES[self.below(EDGES.len())].to_le_bytes(),
                    [1, 2, 4, 8][self.below(4)],
                );
                let room = wide.min(length - at);
                bytes[at..at + room].copy_from_slice(&edge[..room]);
            }
            _ => self.number(bytes, at),
        }
    }

    /// Writes another number in the place of one that is written in digits, at or behind a place.
    fn number(&mut self, bytes: &mut Vec<u8>, at: usize) {
        const WORDS: [&str; 10] = [
            "0",
            "-1",
            "1e308",
            "1e-320",
            "nan",
            "inf",
            "4294967296",
            "18446744073709551615",
            "1e5",
            "",
        ];
        let Some(from) = bytes[at..].iter().position(u8::is_ascii_digit).map(|i| at + i) else {
            return;
        };
        let digits = bytes[from..].iter().take_while(|b| b.is_ascii_digit()).count();
        let word = WORDS[self.below(WORDS.len())];
        bytes.splice(from..from + digits, word.bytes());
    }
}
