//! What is in the files.

use std::collections::BTreeSet;
use std::fs;

use proptest::prelude::*;

use super::*;

#[test]
fn every_voxel_and_every_attribute_comes_back() {
    let (_tmp, objects) = written(Made::boxed(), &Options::default());
    assert_eq!(objects.len(), 4);
    for (k, object) in objects.iter().enumerate() {
        let voxels = voxels(object);
        assert_eq!(voxels, Made::boxed().slice(k as u32));
        let position = numbers(object, tags::IMAGE_POSITION_PATIENT);
        assert_eq!(position, [-100.3, 30.1, [-700.2, -697.7, -695.2, -692.7][k]]);
        assert_eq!(
            numbers(object, tags::IMAGE_ORIENTATION_PATIENT),
            [1.0, 0.0, 0.0, 0.0, 1.0, 0.0]
        );
        // From row to row first.
        assert_eq!(numbers(object, tags::PIXEL_SPACING), [0.6, 0.7]);
        assert_eq!(numbers(object, tags::SLICE_THICKNESS), [2.5]);
        assert_eq!(text(object, tags::INSTANCE_NUMBER), (k + 1).to_string());
        assert_eq!(
            (numbers(object, tags::ROWS), numbers(object, tags::COLUMNS)),
            (vec![5.0], vec![7.0])
        );
        assert_eq!(text(object, tags::SOP_CLASS_UID), "1.2.840.10008.5.1.4.1.1.2");
        assert_eq!(
            object.meta().media_storage_sop_instance_uid(),
            text(object, tags::SOP_INSTANCE_UID)
        );
        assert!(object.get(tags::GANTRY_DETECTOR_TILT).is_none() && object.get(tags::PIXEL_PADDING_VALUE).is_none());
        for empty in [
            tags::PATIENT_NAME,
            tags::PATIENT_ID,
            tags::STUDY_DATE,
            tags::ACCESSION_NUMBER,
        ] {
            assert_eq!(text(object, empty), "");
        }
    }
    let distinct = |tag| objects.iter().map(|o| text(o, tag)).collect::<BTreeSet<_>>();
    assert_eq!(distinct(tags::SOP_INSTANCE_UID).len(), 4);
    for one in [
        tags::STUDY_INSTANCE_UID,
        tags::SERIES_INSTANCE_UID,
        tags::FRAME_OF_REFERENCE_UID,
    ] {
        let ids = distinct(one);
        assert!(
            ids.len() == 1 && ids.iter().all(|id| id.starts_with("2.25.") && !id.contains("11111111")),
            "{ids:?}"
        );
    }
}

#[test]
fn every_syntax_holds_the_same() {
    for syntax in [Syntax::ImplicitLittle, Syntax::ExplicitBig] {
        let options = Options {
            syntax,
            shuffle_names: None,
        };
        let (_tmp, objects) = written(Made::boxed(), &options);
        for (k, object) in objects.iter().enumerate() {
            let voxels = voxels(object);
            assert_eq!(voxels, Made::boxed().slice(k as u32), "{syntax:?}");
            assert_eq!(numbers(object, tags::PIXEL_SPACING), [0.6, 0.7], "{syntax:?}");
        }
    }
    let options = Options {
        syntax: Syntax::Rle,
        shuffle_names: None,
    };
    let (_tmp, objects) = written(Made::boxed(), &options);
    let fragments = objects[2].element(tags::PIXEL_DATA).unwrap().fragments().unwrap();
    assert_eq!(fragments, [super::super::rle::frame(&Made::boxed().slice(2), 7)]);
}

#[test]
fn the_same_volume_gives_the_same_bytes_and_another_one_others() {
    let bytes = |source: Made, options: &Options| -> Vec<Vec<u8>> {
        let (tmp, _) = written(source, options);
        files(&tmp.path().join("series"))
            .iter()
            .map(|f| fs::read(f).unwrap())
            .collect()
    };
    let plain = bytes(Made::boxed(), &Options::default());
    assert_eq!(plain, bytes(Made::boxed(), &Options::default()));
    let moved = Made::new(
        [7, 5, 4],
        [[0.7, 0.0, 0.0, -100.3], [0.0, 0.6, 0.0, 30.1], [0.0, 0.0, 2.5, -700.0]],
    );
    let shuffled = Options {
        shuffle_names: Some(1),
        ..Options::default()
    };
    let uid = |object: &DefaultDicomObject, tag| text(object, tag);
    let [(_a, a), (_b, b), (_c, c)] = [
        (moved, Options::default()),
        (Made::boxed(), Options::default()),
        (Made::boxed(), shuffled),
    ]
    .map(|(source, options)| written(source, &options));
    for tag in [
        tags::STUDY_INSTANCE_UID,
        tags::SERIES_INSTANCE_UID,
        tags::FRAME_OF_REFERENCE_UID,
        tags::SOP_INSTANCE_UID,
    ] {
        assert_ne!(uid(&a[0], tag), uid(&b[0], tag));
    }
    // Other numbers are another series of the same study, in the same frame.
    assert_ne!(
        uid(&b[0], tags::SERIES_INSTANCE_UID),
        uid(&c[0], tags::SERIES_INSTANCE_UID)
    );
    for tag in [tags::STUDY_INSTANCE_UID, tags::FRAME_OF_REFERENCE_UID] {
        assert_eq!(uid(&b[0], tag), uid(&c[0], tag));
    }
}

#[test]
fn shuffled_files_hold_the_same_slices() {
    let mut source = Made::new(
        [2, 2, 40],
        [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]],
    );
    source.padding_hu = -2000;
    source.marks = Marks::REGRIDDED.and(Marks::PART);
    let options = Options {
        shuffle_names: Some(9),
        ..Options::default()
    };
    let (_tmp, mut objects) = written(source, &options);
    let z = |object: &DefaultDicomObject| numbers(object, tags::IMAGE_POSITION_PATIENT)[2];
    assert!(!objects.iter().map(z).is_sorted());
    let by_instance = |object: &DefaultDicomObject| text(object, tags::INSTANCE_NUMBER).parse::<u32>().unwrap();
    objects.sort_by_key(by_instance);
    assert!(!objects.iter().map(z).is_sorted());
    assert_eq!(
        objects.iter().map(by_instance).collect::<Vec<_>>(),
        (1..=40).collect::<Vec<_>>()
    );
    objects.sort_by(|a, b| z(a).total_cmp(&z(b)));
    for (k, object) in objects.iter().enumerate() {
        let voxels = voxels(object);
        assert_eq!(voxels[3], Made::voxel([1, 1, k as u32]));
        assert_eq!(numbers(object, tags::PIXEL_PADDING_VALUE), [-2000.0]);
        assert_eq!(
            text(object, tags::DERIVATION_DESCRIPTION),
            "Exported volume: REGRIDDED, PART OF CT"
        );
    }
}

#[test]
fn a_tilted_gantry_is_told_as_scanners_tell_it() {
    // A series of a Philips scanner, tilt tag -18.5, steps of 2.5 mm along the table.
    let (c, s) = (0.948_323_7, -0.317_304_7);
    let rows = |dz: f64| {
        [
            [0.5, 0.0, 0.0, -123.5],
            [0.0, 0.5 * c, 0.0, -15.6],
            [0.0, 0.5 * s, dz, 742.3],
        ]
    };
    for dz in [2.5, -2.5] {
        let (_tmp, objects) = written(Made::new([4, 4, 3], rows(dz)), &Options::default());
        let tilt = numbers(&objects[0], tags::GANTRY_DETECTOR_TILT)[0];
        assert!((tilt + 18.5).abs() < 1e-4, "{tilt}");
        assert!((numbers(&objects[0], tags::SLICE_THICKNESS)[0] - 2.5 * c).abs() < 1e-6);
        assert!((numbers(&objects[2], tags::IMAGE_POSITION_PATIENT)[2] - (742.3 + 2.0 * dz)).abs() < 1e-9);
    }
    // Shifted along the rows: no gantry does that, and the positions say it all.
    let sideways = [[0.5, 0.0, 0.3, 0.0], [0.0, 0.5, 0.0, 0.0], [0.0, 0.0, 2.0, 0.0]];
    let (_tmp, objects) = written(Made::new([4, 4, 3], sideways), &Options::default());
    assert!(objects[0].get(tags::GANTRY_DETECTOR_TILT).is_none());
    assert_eq!(numbers(&objects[2], tags::IMAGE_POSITION_PATIENT), [0.6, 0.0, 4.0]);
}

/// Rotations, by the axis' angle.
fn turned(angles: [f64; 3], spacing: [f64; 3], shear: f64, mirrored: bool, origin: [f64; 3]) -> [[f64; 4]; 3] {
    use geometry::rotation::{Rotation, RotationVector};
    let m = Rotation::from_vector(RotationVector::new(angles).unwrap())
        .matrix()
        .rows();
    let along = if mirrored { -spacing[2] } else { spacing[2] };
    std::array::from_fn(|r| {
        let third = m[r][2] * along + m[r][1] * shear * spacing[2];
        [m[r][0] * spacing[0], m[r][1] * spacing[1], third, origin[r]]
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn the_files_put_every_corner_where_the_grid_does(
        angles in prop::array::uniform3(-2.0..2.0),
        spacing in prop::array::uniform3(0.2..6.0),
        shear in -0.6..0.6,
        mirrored in any::<bool>(),
        origin in prop::array::uniform3(-2000.0..2000.0),
    ) {
        let source = Made::new([5, 4, 3], turned(angles, spacing, shear, mirrored, origin));
        let grid = source.grid;
        let (_tmp, objects) = written(source, &Options::default());
        for (k, object) in objects.iter().enumerate() {
            let (p, o) = (numbers(object, tags::IMAGE_POSITION_PATIENT), numbers(object, tags::IMAGE_ORIENTATION_PATIENT));
            let s = numbers(object, tags::PIXEL_SPACING);
            // As if it had 512 columns and rows.
            for (i, j) in [(0.0, 0.0), (511.0, 0.0), (0.0, 511.0), (511.0, 511.0)] {
                let want = (grid.ct_from_voxel() * geometry::Point::new(i, j, k as f64)).mm();
                for axis in 0..3 {
                    let found = p[axis] + o[axis] * s[1] * i + o[3 + axis] * s[0] * j;
                    prop_assert!((found - want[axis]).abs() < 1e-6, "{} for {}", found, want[axis]);
                }
            }
        }
    }
}
