//! Real examinations and their known facts, where this machine has them.

use super::*;
use crate::dicom::GeometryError;
use bus::message::Marks;

fn open(folder: &Path, options: Options) -> Result<DicomSource, DicomError> {
    DicomSource::open(&Series::scan(folder)?.choose(None)?, options)
}

fn refused(folder: &Path) -> GeometryError {
    match open(folder, Options::default()).map(|_| ()) {
        Err(DicomError::Geometry { source, .. }) => source,
        other => panic!("expected refused places, found {other:?}"),
    }
}

/// Smallest, largest and sum of the voxels: what pydicom gives for the same files.
fn extent(voxels: &[i16]) -> (i16, i16, i64) {
    let low = voxels.iter().copied().min().unwrap_or(0);
    let high = voxels.iter().copied().max().unwrap_or(0);
    (low, high, voxels.iter().map(|&v| i64::from(v)).sum())
}

#[test]
fn the_chest_has_its_known_facts() {
    let Some(folder) = shared("ct-chest-lidc-dicom") else {
        return;
    };
    let mut source = open(&folder, Options::default()).unwrap();
    assert_eq!(source.grid().dims(), [512, 512, 90]);
    let [x, y, z] = source.grid().spacing_mm();
    assert!((x - 0.78125).abs() < 1e-9 && (y - 0.78125).abs() < 1e-9 && (z - 1.0).abs() < 1e-6);
    let facts = source.series_facts().clone();
    assert_eq!((facts.ignored, facts.kernel.as_deref()), (3, Some("D")));
    assert!(facts.worst_corner_mm < 1e-3 && facts.tilt_deg < 1e-6, "{facts:?}");
    let (voxels, conversion) = drink(&mut source).unwrap();
    assert_eq!(conversion, Conversion::default());
    assert_eq!(extent(&voxels), (-1000, 1979, -14_271_405_502));
}

#[test]
fn the_tilted_phantom_is_sheared_as_its_positions_say() {
    let Some(folder) = shared("ct-head-phantom-tilt-dicom") else {
        return;
    };
    let mut source = open(&folder, Options::default()).unwrap();
    assert_eq!(source.grid().dims(), [512, 512, 54]);
    let [right, down, up] = [0, 1, 2].map(|axis| source.grid().ct_from_voxel().step(axis).mm());
    assert_eq!(right, [0.482421875, 0.0, 0.0]);
    assert!((down[1] - 0.482421875 * 0.9483237).abs() < 1e-9 && (down[2] + 0.482421875 * 0.3173047).abs() < 1e-9);
    assert!(
        up[0].abs() < 1e-9 && up[1].abs() < 1e-9 && (up[2] - 2.5).abs() < 1e-9,
        "{up:?}"
    );
    let facts = source.series_facts();
    assert!(
        (facts.tilt_deg - 18.5).abs() < 1e-3 && facts.tilt_tag_deg == Some(-18.5),
        "{facts:?}"
    );
    assert!(facts.worst_corner_mm < 1e-3 && facts.warnings.is_empty(), "{facts:?}");
    assert_eq!(extent(&drink(&mut source).unwrap().0), (-1024, 793, -12_113_670_364));
}

#[test]
fn the_toy_phantom_is_refused_for_its_hole_and_regridded_around_it() {
    let Some(folder) = shared("ct-lego-phantom-dicom") else {
        return;
    };
    let error = refused(&folder);
    let GeometryError::Uneven { step_mm, gaps, .. } = &error else {
        panic!("{error}")
    };
    assert!((step_mm - 1.875).abs() < 1e-9 && gaps.len() == 1, "{error}");
    assert!(
        (gaps[0].found_mm - 90.0).abs() < 1e-9 && gaps[0].missing == 47,
        "{error}"
    );
    let mut source = open(&folder, Options { regrid: true }).unwrap();
    let facts = source.series_facts().clone();
    assert_eq!(
        (source.marks(), facts.regridded.map(|[between, _]| between)),
        (Marks::REGRIDDED, Some(0))
    );
    assert_eq!((facts.padding_hu, facts.padding_known), (-3024, true));
    assert!(
        facts.warnings[0].contains("0.6250 mm, the positions 1.8750 mm"),
        "{facts:?}"
    );
    let slices = source.grid().dims()[2] as usize;
    let (voxels, _) = drink(&mut source).unwrap();
    let holes = voxels
        .chunks(512 * 512)
        .filter(|slice| slice.iter().all(|&hu| hu == -3024))
        .count();
    assert_eq!(holes, slices - 10);
}

#[test]
fn each_bad_folder_ends_as_its_name_says() {
    let Some(folder) = shared("dicom-bad-inputs") else {
        return;
    };
    assert_eq!(refused(&folder.join("slicecount")), GeometryError::TooFew { found: 2 });
    let (groups, total) = (vec![4], 4);
    assert_eq!(
        refused(&folder.join("notavolume")),
        GeometryError::Duplicates { groups, total }
    );
    let GeometryError::Uneven { gaps, .. } = refused(&folder.join("sliceincrement")) else {
        panic!("uneven steps were not seen")
    };
    assert_eq!((gaps.len(), gaps[0].after, gaps[0].missing), (1, 2, 1));
    // A tilt without its tag is no reason to refuse: the map is sheared.
    let source = open(&folder.join("gantrytilting"), Options::default()).unwrap();
    let facts = source.series_facts();
    assert!(
        (facts.tilt_deg - 14.0).abs() < 1e-3 && facts.tilt_tag_deg.is_none(),
        "{facts:?}"
    );
    assert!(facts.worst_corner_mm < 1e-3);
    // All of them together are several series, of which nobody chose.
    let error = open(&folder, Options::default()).unwrap_err().to_string();
    assert!(error.contains("--series N") && error.contains("MR"), "{error}");
}

/// The pixels are noise: the four compressed folders hold the same, each of the uncompressed ones another, as pydicom finds
/// too.
#[test]
fn each_transfer_syntax_gives_the_pixels_that_are_in_it() {
    let Some(folder) = shared("dicom-bad-inputs/compressed") else {
        return;
    };
    let sums = [
        ("uncompressed_explicit", 33_296_710),
        ("uncompressed_implicit", 33_313_126),
        ("compressed_rle", 33_304_746),
        ("compressed_jpeg", 33_304_746),
        ("compressed_jpegls", 33_304_746),
        ("compressed_j2k", 33_304_746),
    ];
    let mut compressed = None;
    for (name, sum) in sums {
        let mut source = open(&folder.join(name), Options::default()).unwrap();
        let told = source.describe();
        assert!(told.contains("not a CT (MR)") && !told.contains("with loss"), "{told}");
        let (volume, grid) = (drink(&mut source).unwrap().0, *source.grid());
        assert_eq!((grid.dims(), extent(&volume)), ([256, 256, 4], (0, 254, sum)), "{name}");
        if name.starts_with("compressed") {
            let (want, want_grid) = compressed.get_or_insert_with(|| (volume.clone(), grid));
            assert!(volume == *want && grid == *want_grid, "{name}");
        }
    }
}
