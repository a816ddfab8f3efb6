//! Tool definitions made by hand, damaged in every place.

use super::*;
use proptest::prelude::*;

/// A tool of three markers with its checksum.
pub(crate) fn bytes(places: &[[f32; 3]]) -> Vec<u8> {
    let mut bytes = vec![0; BYTES];
    bytes[..4].copy_from_slice(b"NDI\0");
    bytes[24] = 90;
    bytes[28] = places.len() as u8;
    bytes[32] = 3;
    bytes[36..40].copy_from_slice(&2.0_f32.to_le_bytes());
    for (i, place) in places.iter().enumerate() {
        for (k, x) in place.iter().enumerate() {
            bytes[72 + 12 * i + 4 * k..][..4].copy_from_slice(&x.to_le_bytes());
        }
        bytes[320 + 12 * i..][..4].copy_from_slice(&1.0_f32.to_le_bytes());
        bytes[613 + i] = 1;
    }
    bytes[580..585].copy_from_slice(b"Maker");
    bytes[592..596].copy_from_slice(b"Part");
    bytes[664..668].copy_from_slice(&1.0_f32.to_le_bytes());
    sealed(bytes)
}

fn sealed(mut bytes: Vec<u8>) -> Vec<u8> {
    let sum = bytes[6..].iter().fold(0_u16, |sum, b| sum.wrapping_add(u16::from(*b)));
    bytes[4..6].copy_from_slice(&sum.to_le_bytes());
    bytes
}

fn parse(bytes: &[u8]) -> Result<Rom, String> {
    let path = Path::new("t.rom");
    Bytes { path, bytes }.rom().map_err(|error| error.to_string())
}

const PLACES: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [50.0, 0.5, 0.0], [0.0, 70.0, -2.0]];

#[test]
fn a_tool_is_read() {
    let rom = parse(&bytes(&PLACES)).unwrap();
    assert_eq!((rom.maker.as_str(), rom.part.as_str()), ("Maker", "Part"));
    assert_eq!((rom.max_angle_deg, rom.min_markers, rom.max_error_mm), (90, 3, 2.0));
    assert_eq!(rom.faces, [(1, [0.0, 0.0, 1.0])]);
    assert_eq!(rom.markers[1].at_mm, [50.0, 0.5, 0.0]);
    assert!(
        rom.markers
            .iter()
            .all(|m| m.faces == [1] && m.normal == Some([0.0, 0.0, 1.0]))
    );
}

#[test]
fn what_is_wrong_is_told_with_its_byte() {
    let good = bytes(&PLACES);
    let with = |at: usize, new: &[u8]| {
        let mut bytes = good.clone();
        bytes[at..at + new.len()].copy_from_slice(new);
        bytes
    };
    for (bytes, words) in [
        (with(0, b"NDJ"), "byte 0 (magic): found \"NDJ\\0\""),
        (with(100, &[1]), "byte 4 (checksum)"),
        (
            sealed(with(28, &[0])),
            "byte 28 (number of markers): found 0, expected 1 to 20",
        ),
        (sealed(with(28, &[21])), "byte 28 (number of markers): found 21"),
        (
            sealed(with(88, &f32::NAN.to_le_bytes())),
            "byte 88 (place of a marker, mm): found NaN",
        ),
        (
            sealed(with(96, &1e9_f32.to_le_bytes())),
            "byte 96 (place of a marker, mm): found 1000000000",
        ),
        (
            sealed(with(312, &2.0_f32.to_le_bytes())),
            "byte 312 (normal of a marker)",
        ),
        (
            sealed(with(36, &f32::INFINITY.to_le_bytes())),
            "byte 36 (largest 3-D error): found inf",
        ),
    ] {
        let error = parse(&bytes).unwrap_err();
        assert!(error.contains(words), "{words}: {error}");
    }
}

#[test]
fn every_length_but_one_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("t.rom");
    let good = bytes(&PLACES);
    for length in [0, 1, 3, 751] {
        fs::write(&path, &good[..length]).unwrap();
        let error = Rom::read(&path).unwrap_err().to_string();
        assert!(error.contains(&format!("found {length} bytes")), "{error}");
    }
    fs::write(&path, [good.as_slice(), &[0; 1000]].concat()).unwrap();
    assert!(Rom::read(&path).unwrap_err().to_string().contains("found 1752 bytes"));
    fs::write(&path, &good).unwrap();
    assert_eq!(Rom::read(&path).unwrap().markers.len(), 3);
    assert!(Rom::read(folder.path()).unwrap_err().to_string().contains("not a file"));
}

proptest! {
    /// Whatever stands anywhere, with the checksum put right: read or refused.
    #[test]
    fn no_byte_panics(changes in prop::collection::vec((6_usize..BYTES, any::<u8>()), 0..40)) {
        let mut bytes = bytes(&PLACES);
        changes.iter().for_each(|(at, value)| bytes[*at] = *value);
        let _ = parse(&sealed(bytes));
    }
}
