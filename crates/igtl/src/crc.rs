//! CRC-64 of ECMA-182 over the body of a message: polynomial `0x42F0E1EBA9EA3693`, most significant bit first, register
//! 0 at the start, nothing added at the end. The check value of `123456789` is `0x6C40DF5F0B497347`.
//!
//! [`Crc64`] takes sixteen bytes at a time by sixteen tables (32 KiB): table `k` holds the CRC of one byte with `k`
//! zero bytes behind it, so the sixteen contributions of a block are independent and add up by exclusive or. One block
//! still waits for the one before; so longer bodies are taken on two lanes at once, whose CRCs are joined by tables of
//! what 2048 zero bytes do. Equal to the definition bit by bit ([`bitwise`]), which the tests hold it against.

const POLYNOMIAL: u64 = 0x42F0_E1EB_A9EA_3693;
const SLICES: usize = 16;
/// Bytes of a lane.
const LANE: usize = 2048;

/// `TABLES[k][b]`: the CRC of byte `b` followed by `k` zero bytes.
static TABLES: [[u64; 256]; SLICES] = tables();

const fn shifted_by_a_byte(mut crc: u64) -> u64 {
    let mut bit = 0;
    while bit < 8 {
        crc = if crc >> 63 == 1 {
            (crc << 1) ^ POLYNOMIAL
        } else {
            crc << 1
        };
        bit += 1;
    }
    crc
}

const fn tables() -> [[u64; 256]; SLICES] {
    let mut tables = [[0; 256]; SLICES];
    let mut byte = 0;
    while byte < 256 {
        let mut crc = (byte as u64) << 56;
        let mut zeros = 0;
        while zeros < SLICES {
            crc = shifted_by_a_byte(crc);
            tables[zeros][byte] = crc;
            zeros += 1;
        }
        byte += 1;
    }
    tables
}

/// `LANE_TABLES[k][b]`: what becomes of byte `k` of a register, `b`, once `LANE` zero bytes were taken.
static LANE_TABLES: [[u64; 256]; 8] = lane_tables();

const fn lane_tables() -> [[u64; 256]; 8] {
    let one_byte = tables();
    let mut tables = [[0; 256]; 8];
    let mut bit = 0;
    while bit < 64 {
        let mut crc = 1_u64 << (63 - bit);
        let mut zeros = 0;
        while zeros < LANE {
            let [top, ..] = crc.to_be_bytes();
            crc = (crc << 8) ^ one_byte[0][top as usize];
            zeros += 1;
        }
        // Taking zeros is linear: the entry of a byte is the sum of those of its bits.
        let (byte, mask) = (bit / 8, 0x80 >> (bit % 8));
        let mut value = 0;
        while value < 256 {
            if value & mask != 0 {
                tables[byte][value] ^= crc;
            }
            value += 1;
        }
        bit += 1;
    }
    tables
}

/// A CRC in the making, over bytes that come in pieces.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Crc64(u64);

impl Crc64 {
    /// Of no bytes.
    pub const fn new() -> Self {
        Self(0)
    }

    /// With `bytes` behind those before.
    #[must_use]
    pub fn with(self, bytes: &[u8]) -> Self {
        let (pairs, rest) = bytes.as_chunks::<{ 2 * LANE }>();
        let crc = pairs.iter().fold(self.0, two_lanes);
        let (blocks, rest) = rest.as_chunks::<SLICES>();
        let crc = blocks.iter().fold(crc, one_block);
        Self(bytewise_from(crc, rest))
    }

    /// The CRC of all bytes so far.
    pub const fn value(self) -> u64 {
        self.0
    }
}

/// Every index is a byte and every table is named by a constant: no bound is left to be checked.
#[inline]
fn one_block(crc: u64, block: &[u8; SLICES]) -> u64 {
    let [a, b, c, d, e, f, g, h, tail @ ..] = *block;
    // What came before is ahead of the block's first eight bytes, and is carried by the same tables as they are.
    let head = (u64::from_be_bytes([a, b, c, d, e, f, g, h]) ^ crc).to_be_bytes();
    let entry = |table: usize, byte: u8| TABLES[table][usize::from(byte)];
    let first = entry(15, head[0]) ^ entry(14, head[1]) ^ entry(13, head[2]) ^ entry(12, head[3]);
    let second = entry(11, head[4]) ^ entry(10, head[5]) ^ entry(9, head[6]) ^ entry(8, head[7]);
    let third = entry(7, tail[0]) ^ entry(6, tail[1]) ^ entry(5, tail[2]) ^ entry(4, tail[3]);
    let fourth = entry(3, tail[4]) ^ entry(2, tail[5]) ^ entry(1, tail[6]) ^ entry(0, tail[7]);
    (first ^ second) ^ (third ^ fourth)
}

/// The first half goes on from what came before, the second from 0; then the first is carried over the second.
fn two_lanes(crc: u64, pair: &[u8; 2 * LANE]) -> u64 {
    let (first, second) = pair.split_at(LANE);
    let blocks = first.as_chunks().0.iter().zip(second.as_chunks().0);
    let (first, second) = blocks.fold((crc, 0), |(a, b), (one, other)| {
        (one_block(a, one), one_block(b, other))
    });
    let bytes = first.to_be_bytes().into_iter().zip(&LANE_TABLES);
    bytes.fold(second, |crc, (byte, table)| crc ^ table[usize::from(byte)])
}

fn bytewise_from(crc: u64, bytes: &[u8]) -> u64 {
    bytes.iter().fold(crc, |crc, byte| {
        let [top, ..] = crc.to_be_bytes();
        (crc << 8) ^ TABLES[0][usize::from(top ^ byte)]
    })
}

/// The CRC of `bytes`.
pub fn crc64(bytes: &[u8]) -> u64 {
    Crc64::new().with(bytes).value()
}

/// The same by one table, a byte at a time: what [`crc64`] is timed against.
pub fn bytewise(bytes: &[u8]) -> u64 {
    bytewise_from(0, bytes)
}

/// The same by its definition, a bit at a time: what [`crc64`] is checked against.
pub fn bitwise(bytes: &[u8]) -> u64 {
    bytes
        .iter()
        .fold(0, |crc, byte| shifted_by_a_byte(crc ^ (u64::from(*byte) << 56)))
}
