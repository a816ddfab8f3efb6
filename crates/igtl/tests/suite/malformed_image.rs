//! IMAGEs and IMGMETAs that are wrong.

use igtl::{Fault, Limits, SizeRule, decode};

use crate::support::{raw, refused};

/// 4 x 3 x 2 voxels of 16 bits.
fn image() -> Vec<u8> {
    let mut bytes = vec![0, 1, 1, 5, 2, 1, 0, 4, 0, 3, 0, 2];
    for number in [1.0_f32, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 5.0, 6.0, 7.0] {
        bytes.extend(number.to_be_bytes());
    }
    bytes.extend([0, 0, 0, 0, 0, 0, 0, 4, 0, 3, 0, 2]);
    bytes.resize(72 + 48, 9);
    bytes
}

fn fault_with(change: impl Fn(&mut Vec<u8>)) -> Fault {
    let mut bytes = image();
    change(&mut bytes);
    refused(&raw("IMAGE", &bytes)).fault
}

#[test]
fn a_good_one_is_read() {
    let bytes = raw("IMAGE", &image());
    assert_eq!(decode(&bytes, &Limits::default()).unwrap().0.to_vec().unwrap(), bytes);
}

#[test]
fn numbers_that_mean_nothing_are_named_with_what_is_allowed() {
    for (at, byte, field, allowed) in [
        (1, 2, "the version of the image header", "1"),
        (0, 1, "the version of the image header", "1"),
        (2, 0, "the number of components", "1 to 255"),
        (3, 12, "the type of a voxel", "2 to 7, 10 and 11"),
        (3, 0, "the type of a voxel", "2 to 7, 10 and 11"),
        (4, 0, "the byte order of the voxels", "1 and 2"),
        (4, 3, "the byte order of the voxels", "1 and 2"),
        (5, 0, "the space of the image", "1 and 2"),
        (5, 3, "the space of the image", "1 and 2"),
    ] {
        let fault = fault_with(|bytes| bytes[at] = byte);
        assert!(
            matches!(fault, Fault::Value { field: f, allowed: a, .. } if f == field && a == allowed),
            "{fault}"
        );
    }
}

#[test]
fn an_image_has_voxels() {
    for axis in [6, 8, 10] {
        assert!(matches!(fault_with(|bytes| bytes[axis + 1] = 0), Fault::Dimensions(_)));
    }
}

#[test]
fn a_part_lies_inside() {
    for (at, number) in [(61, 1), (63, 1), (65, 1), (67, 5), (69, 4), (71, 3), (67, 0), (60, 255)] {
        let fault = fault_with(|bytes| bytes[at] = number);
        assert!(
            matches!(
                fault,
                Fault::Subvolume {
                    dimensions: [4, 3, 2],
                    ..
                }
            ),
            "{at}: {fault}"
        );
    }
    // One that does is read.
    let mut bytes = image();
    (bytes[61], bytes[67]) = (1, 3);
    bytes.truncate(72 + 36);
    assert!(decode(&raw("IMAGE", &bytes), &Limits::default()).is_ok());
}

#[test]
fn voxels_are_as_many_as_it_says() {
    for length in [72, 119, 121] {
        let fault = fault_with(|bytes| bytes.resize(length, 0));
        assert_eq!(
            fault,
            Fault::Size {
                found: length as u64,
                rule: SizeRule::Exactly(120)
            }
        );
    }
    let huge = fault_with(|bytes| {
        bytes[6..12].fill(0xff);
        bytes[66..72].fill(0xff);
        (bytes[2], bytes[3]) = (255, 11);
    });
    let needed = 65535_u64.pow(3) * 255 * 8 + 72;
    assert_eq!(
        huge,
        Fault::Size {
            found: 120,
            rule: SizeRule::Exactly(needed)
        }
    );
}

#[test]
fn its_steps_are_numbers() {
    for at in (12..60).step_by(4) {
        let fault = fault_with(|bytes| bytes[at..at + 4].copy_from_slice(&f32::NAN.to_be_bytes()));
        assert!(matches!(fault, Fault::NotFinite { value: "NaN", .. }));
    }
}

#[test]
fn a_list_of_images_has_types_of_voxels_that_there_are() {
    let mut entry = vec![0; 260];
    assert!(matches!(
        refused(&raw("IMGMETA", &entry)).fault,
        Fault::Value { found: 0, .. }
    ));
    entry[258] = 5;
    assert!(decode(&raw("IMGMETA", &entry), &Limits::default()).is_ok());
    entry[0] = b'\n';
    assert!(matches!(refused(&raw("IMGMETA", &entry)).fault, Fault::NameByte { .. }));
}
