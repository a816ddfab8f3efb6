//! CRC-64 by sixteen bytes at a time, against its definition.

use chance::SplitMix64;
use igtl::crc::{Crc64, bitwise, bytewise, crc64};

fn bytes(random: &mut SplitMix64, length: usize) -> Vec<u8> {
    (0..length).map(|_| random.bits().to_be_bytes()[0]).collect()
}

#[test]
fn the_check_value_is_that_of_ecma_182() {
    assert_eq!(crc64(b"123456789"), 0x6C40_DF5F_0B49_7347);
    assert_eq!(crc64(b""), 0);
}

#[test]
fn all_ways_agree_at_every_length_and_offset() {
    let mut random = SplitMix64::new(1);
    let all = bytes(&mut random, 400);
    for start in 0..20 {
        for end in start..all.len() {
            let part = &all[start..end];
            assert_eq!(crc64(part), bitwise(part), "{start}..{end}");
            assert_eq!(bytewise(part), bitwise(part), "{start}..{end}");
        }
    }
}

#[test]
fn all_ways_agree_where_two_lanes_are_taken() {
    let mut random = SplitMix64::new(3);
    let all = bytes(&mut random, 40_000);
    for _ in 0..300 {
        let start = random.bits() as usize % 9000;
        let end = start + random.bits() as usize % (all.len() - start);
        let part = &all[start..end];
        assert_eq!(crc64(part), bitwise(part), "{start}..{end}");
    }
    for length in [2047, 2048, 4095, 4096, 4097, 4112, 8192, 8208] {
        assert_eq!(crc64(&all[..length]), bitwise(&all[..length]), "{length}");
    }
}

#[test]
fn pieces_add_up_to_the_whole() {
    let mut random = SplitMix64::new(2);
    for _ in 0..200 {
        let length = random.bits() as usize % 50_000;
        let all = bytes(&mut random, length);
        let (mut crc, mut rest) = (Crc64::new(), &all[..]);
        while !rest.is_empty() {
            let (now, later) = rest.split_at((1 + random.bits() as usize % 20_000).min(rest.len()));
            crc = crc.with(now);
            rest = later;
        }
        assert_eq!(crc.value(), bitwise(&all));
    }
}
