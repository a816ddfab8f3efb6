//! Each bad file by its name, and no bytes at all that make a panic.

use geometry::GridError;
use proptest::prelude::*;

use super::*;
use crate::nifti::HeaderError;
use crate::source::Place;

fn refused(change: impl Fn(&mut Hand) -> &mut Hand) -> HeaderError {
    let mut hand = Hand::counted(false);
    change(&mut hand);
    match open_bytes(&hand.bytes).map(|_| ()) {
        Err(ReadError::Header { source, .. }) => source,
        other => panic!("expected a refused header, found {other:?}"),
    }
}

/// ITK goes by `pixdim` and others by the sform: a slice was 5 mm here and 1.25 mm there, and a negative one took left for right.
#[test]
fn an_sform_whose_steps_are_not_those_of_pixdim_is_refused() {
    for (axis, pixdim) in [(0, 1.25), (1, -1.0), (2, 1.002), (0, f32::NAN)] {
        let found = refused(|h| h.f32(80 + 4 * axis, pixdim));
        assert!(
            matches!(found, HeaderError::Steps { axis: named, .. } if named == axis),
            "{found}"
        );
    }
    // One that rounds to three digits, and one that says nothing.
    for pixdim in [1.0009, 0.0] {
        let mut hand = Hand::counted(false);
        assert!(open_bytes(&hand.f32(84, pixdim).bytes).is_ok(), "{pixdim}");
    }
}

/// Axes that are swapped are opposed nowhere, and yet one form is the other in a mirror.
#[test]
fn forms_of_which_one_is_the_other_in_a_mirror_are_refused() {
    let swapped = |h: &mut Hand| {
        // The sform takes i to +y and j to +x; the qform is the identity.
        for (at, value) in [
            (280, 0.0),
            (284, 1.0),
            (296, 1.0),
            (300, 0.0),
            (256, 0.0),
            (260, 0.0),
            (264, 0.0),
        ] {
            h.f32(at, value);
        }
        h.i16(252, 1);
    };
    let found = refused(|h| {
        swapped(h);
        h
    });
    assert!(matches!(found, HeaderError::Mirrored), "{found}");
}

#[test]
fn headers_are_refused_by_name() {
    use HeaderError as E;
    assert!(matches!(refused(|h| h.i32(0, 347)), E::NotNifti { .. }));
    assert!(matches!(refused(|h| h.raw(344, &[0; 4])), E::Magic { .. }));
    assert!(matches!(refused(|h| h.raw(344, b"ni1\0")), E::TwoFiles));
    assert!(matches!(refused(|h| h.i16(40, 2)), E::Dimensions { .. }));
    assert!(matches!(refused(|h| h.i16(40, -1)), E::Dimensions { .. }));
    assert!(matches!(refused(|h| h.i16(40, 4).i16(48, 2)), E::Dimensions { .. }));
    assert!(matches!(
        refused(|h| h.i16(70, 128).i16(72, 24)),
        E::Datatype { found: 128 }
    ));
    assert!(matches!(
        refused(|h| h.i16(72, 8)),
        E::Bitpix {
            found: 8,
            expected: 16,
            ..
        }
    ));
    for offset in [0.0, 348.0, 352.5, 1e12, -352.0, f32::NAN, f32::INFINITY] {
        assert!(matches!(refused(|h| h.f32(108, offset)), E::Offset { .. }), "{offset}");
    }
    assert!(matches!(refused(|h| h.f32(112, f32::NAN)), E::Scale { .. }));
    for slope in [1e38, -1e38, 1e-40, f32::INFINITY, 1e-6] {
        assert!(matches!(
            refused(|h| h.f32(112, slope)),
            E::Scale { which: "scl_slope", .. }
        ));
    }
    for inter in [1e38, -1e9, f32::NAN] {
        assert!(matches!(
            refused(|h| h.f32(112, 2.0).f32(116, inter)),
            E::Scale { which: "scl_inter", .. }
        ));
    }
    for (sform, qform) in [(6, 0), (-1, 1), (1, 256), (1, -2)] {
        assert!(matches!(refused(|h| h.i16(254, sform).i16(252, qform)), E::Code { .. }));
    }
    assert!(matches!(
        refused(|h| h.f32(112, 2.0).f32(116, f32::INFINITY)),
        E::Scale { .. }
    ));
    assert!(matches!(refused(|h| h.raw(123, &[5])), E::Units { length: 5, .. }));
    assert!(matches!(
        refused(|h| h.i16(254, 0)),
        E::NoOrientation { sform: 0, qform: 0 }
    ));
    assert!(matches!(
        refused(|h| h.i16(254, 0).i16(252, 1).f32(256, 1.1)),
        E::Quaternion { .. }
    ));
    assert!(matches!(
        refused(|h| h.i16(42, 0)),
        E::Grid(GridError::Dim { axis: 0, found: 0 })
    ));
    assert!(matches!(
        refused(|h| h.f32(280, f32::NAN)),
        E::Grid(GridError::NotFinite)
    ));
    assert!(matches!(
        refused(|h| h.f32(280, 0.0)),
        E::Grid(GridError::Spacing { axis: 0, .. })
    ));
    assert!(matches!(
        refused(|h| h.f32(300, 0.0).f32(284, 1.0)),
        E::Grid(GridError::Flat { .. })
    ));
}

#[test]
fn paths_that_are_no_file_are_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let open = |path: &Path| NiftiSource::open(path).map(|_| ()).unwrap_err();
    let missing = open(&folder.path().join("absent.nii"));
    assert!(matches!(missing, ReadError::Missing { .. }) && missing.to_string().contains("absent.nii"));
    assert!(matches!(open(folder.path()), ReadError::NotAFile { .. }));
    assert!(matches!(open(Path::new("/dev/null")), ReadError::NotAFile { .. }));
    assert!(matches!(
        open(&file(&folder, "empty.nii", &[])),
        ReadError::Empty { .. }
    ));
    assert!(matches!(
        open(&file(&folder, "one.nii", &[0x1f])),
        ReadError::Truncated {
            place: Place::Header,
            ..
        }
    ));
}

#[test]
fn a_short_plain_file_is_refused_before_a_voxel_is_read() {
    let bytes = Hand::counted(false).bytes;
    for length in 1..bytes.len() {
        let error = open_bytes(&bytes[..length]).map(|_| ()).unwrap_err();
        assert!(
            matches!(error, ReadError::Truncated { found, .. } if found == length as u64),
            "{length}: {error}"
        );
    }
    let error = open_bytes(&bytes[..370]).map(|_| ()).unwrap_err();
    assert!(
        matches!(
            error,
            ReadError::Truncated {
                place: Place::Slice(1),
                expected: 376,
                found: 370,
                ..
            }
        ),
        "{error}"
    );
}

#[test]
fn a_huge_header_allocates_nothing() {
    let mut hand = Hand::counted(false);
    hand.dims(&[3, 9_000, 9_000, 15, 1, 1, 1, 1]);
    assert!(matches!(open_bytes(&hand.bytes), Err(ReadError::Truncated { .. })));
    // Packed, the length shows only while reading; one row is enough to find out.
    assert!(open_bytes(&gzip(&hand.bytes)).is_ok());
}

#[test]
fn a_packed_file_cut_anywhere_is_refused() {
    let packed = gzip(&Hand::counted(false).bytes);
    for length in 1..packed.len() {
        let error = read_bytes(&packed[..length]).unwrap_err();
        let named = matches!(error, ReadError::BrokenOff { .. }) || length < 2;
        assert!(named, "{length} of {}: {error}", packed.len());
    }
}

#[test]
fn a_proper_stream_with_too_few_voxels_is_refused() {
    let bytes = Hand::counted(false).bytes;
    let error = read_bytes(&gzip(&bytes[..370])).unwrap_err();
    let want = matches!(
        error,
        ReadError::Truncated {
            place: Place::Slice(1),
            expected: 376,
            found: 370,
            ..
        }
    );
    assert!(want, "{error}");
}

/// Up to 64 KiB behind the voxels were passed over in silence: more than a slice of a small volume.
#[test]
fn a_file_longer_than_its_header_says_is_told_of_and_refused_from_a_slice_on() {
    let whole = Hand::counted(false).bytes;
    let longer = |more: usize| [whole.clone(), vec![0; more]].concat();
    let told = |bytes: &[u8]| {
        let mut source = open_bytes(bytes).unwrap();
        drink(&mut source).unwrap();
        [source.facts().warnings, source.remarks()].concat().join("; ")
    };
    for bytes in [whole.clone(), gzip(&whole)] {
        assert_eq!(told(&bytes), "");
    }
    for bytes in [longer(11), gzip(&longer(11))] {
        let said = told(&bytes);
        assert!(said.contains("the voxels end at byte 376 and 11 more follow"), "{said}");
    }
    // A slice has 2 x 3 voxels of 2 bytes.
    for bytes in [longer(12), gzip(&longer(12)), longer(100_000), gzip(&longer(100_000))] {
        assert!(matches!(
            read_bytes(&bytes),
            Err(ReadError::TooLong { expected: 376, .. })
        ));
    }
}

/// A place in kilometres was taken.
#[test]
fn an_origin_where_no_patient_is_is_refused() {
    for (at, value) in [(292, 2e6), (324, -10_001.0)] {
        let found = refused(|h| h.f32(at, value));
        assert!(matches!(found, HeaderError::Grid(GridError::Far { .. })), "{found}");
    }
    // A header in metres.
    let found = refused(|h| {
        h.raw(123, &[1])
            .f32(280, 0.001)
            .f32(300, 0.001)
            .f32(320, 0.001)
            .f32(80, 0.001)
            .f32(84, 0.001)
            .f32(88, 0.001)
            .f32(292, 120.0)
    });
    assert!(matches!(found, HeaderError::Grid(GridError::Far { .. })), "{found}");
}

#[test]
fn flipped_bytes_of_a_packed_file_are_refused_or_harmless() {
    let mut hand = Hand::new(false);
    hand.dims(&[3, 40, 40, 6, 1, 1, 1, 1]);
    let noise = (0..9600_u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 16) as i16 % 1500);
    hand.voxels(&noise.map(i16::to_le_bytes).collect::<Vec<_>>());
    let packed = gzip(&hand.bytes);
    let whole = read_bytes(&packed).unwrap();
    for at in (0..packed.len()).step_by(97).chain(packed.len() - 8..packed.len()) {
        let mut damaged = packed.clone();
        damaged[at] ^= 0x55;
        // Name and time in gzip's own header are under no checksum: those flips change nothing.
        if let Ok(read) = read_bytes(&damaged) {
            assert_eq!(read, whole, "byte {at}");
            assert!(at < 10, "byte {at} is under a checksum");
        }
    }
    let mut damaged = packed.clone();
    let crc = packed.len() - 8;
    damaged[crc] ^= 1;
    assert!(matches!(
        read_bytes(&damaged),
        Err(ReadError::Corrupt { place: Place::End, .. })
    ));
}

proptest! {
    #[test]
    fn random_bytes_never_panic(mut bytes in prop::collection::vec(any::<u8>(), 400), plausible in 0..3_u8) {
        // Random bytes alone would never get past the length and the magic.
        if plausible > 0 {
            bytes[..4].copy_from_slice(&348_i32.to_le_bytes());
            bytes[344..348].copy_from_slice(b"n+1\0");
        }
        if plausible > 1 {
            bytes[40..50].copy_from_slice(&[3, 0, 4, 0, 5, 0, 1, 0, 1, 0]);
            bytes[70..74].copy_from_slice(&[4, 0, 16, 0]);
            bytes[108..112].copy_from_slice(&352.0_f32.to_le_bytes());
            bytes[123] = 2;
        }
        let _ = read_bytes(&bytes);
    }

    #[test]
    fn one_wrong_byte_never_panics(at in 0..376_usize, value in any::<u8>()) {
        let mut bytes = Hand::counted(false).bytes;
        bytes[at] = value;
        let _ = read_bytes(&bytes);
    }
}
