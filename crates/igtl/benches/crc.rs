//! CRC-64 by sixteen bytes at a time against one byte at a time, on the same bytes in turn: `cargo bench -p igtl`.

#![allow(clippy::disallowed_methods, reason = "measures wall time")]
#![allow(clippy::print_stdout, reason = "prints its result")]

use std::hint::black_box;
use std::time::Instant;

use igtl::crc::{bytewise, crc64};

/// Longer than any cache, as a volume is.
const VOLUME_BYTES: usize = 64 << 20;
/// An image of 512 x 512 voxels of 8 bits.
const IMAGE_BYTES: usize = 256 << 10;
/// The best of so many is told: others share the machine.
const TURNS: u32 = 9;

/// GB/s of one call.
fn speed(crc: fn(&[u8]) -> u64, bytes: &[u8]) -> f64 {
    let repeats = VOLUME_BYTES / bytes.len();
    let start = Instant::now();
    for _ in 0..repeats {
        black_box(crc(black_box(bytes)));
    }
    (repeats * bytes.len()) as f64 / start.elapsed().as_secs_f64() / 1e9
}

fn main() {
    let volume: Vec<u8> = (0..VOLUME_BYTES).map(|at| (at * 31 + (at >> 9)) as u8).collect();
    assert_eq!(crc64(&volume), bytewise(&volume));
    for bytes in [&volume[..], &volume[..IMAGE_BYTES]] {
        let (mut by_sixteen, mut by_one) = (0.0_f64, 0.0_f64);
        for _ in 0..TURNS {
            by_sixteen = by_sixteen.max(speed(crc64, bytes));
            by_one = by_one.max(speed(bytewise, bytes));
        }
        let times = by_sixteen / by_one;
        println!(
            "{:>9} bytes: by sixteen {by_sixteen:.2} GB/s, by one {by_one:.2} GB/s: {times:.1} times",
            bytes.len()
        );
    }
}
