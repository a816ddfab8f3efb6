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
fn pieces_add_up_to_the_whole() {
    let mut random = SplitMix64::new(2);
    for _ in 0..200 {
        let length = random.bits() as usize % 5000;
        let all = bytes(&mut random, length);
        let (mut crc, mut rest) = (Crc64::new(), &all[..]);
        while !rest.is_empty() {
            let (now, later) = rest.split_at((1 + random.bits() as usize % 70).min(rest.len()));
            crc = crc.with(now);
            rest = later;
        }
        assert_eq!(crc.value(), bitwise(&all));
    }
}
