//! Places of slices: what is derived, what is refused, what is put on an even grid.

use super::*;
use crate::dicom::GeometryError;
use bus::message::Marks;
use geometry::{Point, Voxel};
use proptest::prelude::*;

pub(super) fn place(file: &mut File, [x, y, z]: [f64; 3]) {
    file.text((0x0020, 0x0032), "DS", &format!("{x}\\{y}\\{z}"));
}

fn at_heights(heights: &[f64]) -> Folder {
    let files: Vec<File> = heights.iter().enumerate().map(|(k, &z)| File::slice(k, z)).collect();
    Folder::of(&files)
}

fn refused(folder: &Folder) -> GeometryError {
    match folder.open().map(|_| ()) {
        Err(DicomError::Geometry { source, .. }) => source,
        other => panic!("expected refused places, found {other:?}"),
    }
}

fn corner(source: &DicomSource, voxel: [f64; 3]) -> [f64; 3] {
    let [x, y, z] = voxel;
    (source.grid().ct_from_voxel() * Point::<Voxel>::new(x, y, z)).mm()
}

fn assert_near(found: [f64; 3], want: [f64; 3]) {
    assert!(
        (0..3).all(|i| (found[i] - want[i]).abs() < 1e-9),
        "{found:?}, expected {want:?}"
    );
}

#[test]
fn slices_are_sorted_by_position_whatever_their_names_and_numbers() {
    let mut files = stack(5);
    for (i, file) in files.iter_mut().enumerate() {
        file.text((0x0020, 0x0013), "IS", &(99 - 7 * i).to_string());
    }
    files.swap(0, 3);
    files.swap(1, 4);
    let folder = Folder::of(&files);
    let mut source = folder.open().unwrap();
    // Rows are 0.75 mm apart, columns 0.5 mm; SliceThickness (0.6 mm) is not used.
    assert_near(corner(&source, [0.0, 0.0, 0.0]), [-10.0, 20.0, 0.0]);
    assert_near(corner(&source, [2.0, 1.0, 4.0]), [-9.0, 20.75, 10.0]);
    let (voxels, _) = drink(&mut source).unwrap();
    let firsts: Vec<i16> = voxels.iter().step_by(12).copied().collect();
    assert_eq!(firsts, [-1024, -924, -824, -724, -624]);
    assert!(
        source.series_facts().worst_corner_mm < 1e-9 && source.series_facts().warnings.is_empty(),
        "{:?}",
        source.series_facts()
    );
    assert!(
        source
            .describe()
            .contains("axial: columns to the left, rows to the back, slices to the head")
    );
}

#[test]
fn a_tilted_gantry_is_a_sheared_map_with_and_without_its_tag() {
    let (sine, cosine) = 15.0_f64.to_radians().sin_cos();
    for tag in [None, Some("-15.0"), Some("3")] {
        let mut files = stack(4);
        for file in &mut files {
            file.text(
                (0x0020, 0x0037),
                "DS",
                &format!("1\\0\\0\\0\\{cosine:.12}\\{:.12}", -sine),
            );
            if let Some(tag) = tag {
                file.text((0x0018, 0x1120), "DS", tag);
            }
        }
        let source = Folder::of(&files).open().unwrap();
        let facts = source.series_facts();
        assert!((facts.tilt_deg - 15.0).abs() < 1e-6, "{}", facts.tilt_deg);
        assert_eq!(
            facts.warnings.len(),
            usize::from(tag == Some("3")),
            "{:?}",
            facts.warnings
        );
        let found = corner(&source, [3.0, 2.0, 3.0]);
        let want = [-8.5, 20.0 + 1.5 * cosine, 7.5 - 1.5 * sine];
        assert!((0..3).all(|i| (found[i] - want[i]).abs() < 1e-9), "{found:?} {want:?}");
        assert!(facts.worst_corner_mm < 1e-9);
    }
}

#[test]
fn too_few_slices_and_slices_at_one_place_are_refused() {
    assert_eq!(refused(&at_heights(&[0.0, 1.0])), GeometryError::TooFew { found: 2 });
    let (groups, total) = (vec![4], 4);
    let error = refused(&at_heights(&[5.0; 4]));
    assert_eq!(error, GeometryError::Duplicates { groups, total });
    assert!(
        error.to_string().contains("not a volume: 4 slices at one place"),
        "{error}"
    );
    let error = refused(&at_heights(&[0.0, 1.0, 1.0, 2.0, 2.0005, 3.0]));
    assert!(
        matches!(&error, GeometryError::Duplicates { groups, .. } if *groups == [2, 2]),
        "{error}"
    );
}

/// A file that lies there twice, or a second point in time: both files are named, wherever they are in the folder.
#[test]
fn two_slices_at_one_place_are_named_by_their_files() {
    let folder = at_heights(&[0.0, 2.0, 4.0, 2.0, 6.0]);
    let error = folder.open().map(|_| ()).unwrap_err();
    let said = error.to_string();
    // The second and the fourth file, as a folder names them.
    let [one, other] = ["021.dcm", "048.dcm"].map(|name| folder.path().join(name).display().to_string());
    assert!(said.contains(&format!("(two of them: {one} and {other})")), "{said}");
}

#[test]
fn uneven_steps_are_refused_with_the_list_of_gaps() {
    let error = refused(&at_heights(&[0.0, 2.0, 4.0, 8.0, 10.0, 20.0]));
    let GeometryError::Uneven { step_mm, gaps, .. } = &error else {
        panic!("{error}")
    };
    assert_eq!((*step_mm, gaps.len()), (2.0, 2));
    assert_eq!(
        (gaps[0].after, gaps[0].position_mm, gaps[0].found_mm, gaps[0].missing),
        (2, 4.0, 4.0, 1)
    );
    assert_eq!((gaps[1].after, gaps[1].missing), (4, 4));
    let text = error.to_string();
    assert!(
        text.contains("after slice 2 at 4.000 mm") && text.contains("--regrid"),
        "{text}"
    );
}

#[test]
fn small_deviations_pass_and_are_reported() {
    let folder = at_heights(&[0.0, 2.504, 4.998, 7.5]);
    let source = folder.open().unwrap();
    assert!(
        (source.series_facts().worst_corner_mm - 0.004).abs() < 1e-9,
        "{:?}",
        source.series_facts()
    );
    assert!(matches!(
        refused(&at_heights(&[0.0, 2.55, 5.0, 7.5])),
        GeometryError::Uneven { .. }
    ));
    // A thousandth short each step in the first half: every step passes, their sum does not.
    let mut heights = vec![0.0];
    for k in 0..80 {
        heights.push(heights[k] + if k < 40 { 2.48 } else { 2.5 });
    }
    assert!(matches!(refused(&at_heights(&heights)), GeometryError::Corner { .. }));
}

#[test]
fn slices_beside_the_line_and_crooked_axes_are_refused() {
    let mut files = stack(5);
    place(&mut files[2], [-9.9, 20.0, 5.0]);
    assert!(matches!(
        refused(&Folder::of(&files)),
        GeometryError::NotOnALine { slice: 2, .. }
    ));
    let oriented = |cosines: &str| {
        let mut files = stack(4);
        files.iter_mut().for_each(|file| {
            file.text((0x0020, 0x0037), "DS", cosines);
        });
        Folder::of(&files)
    };
    assert!(matches!(
        refused(&oriented("1\\0\\0\\0.1\\1\\0")),
        GeometryError::Orientation { .. }
    ));
    assert!(matches!(
        refused(&oriented("0\\0\\0\\0\\0\\0")),
        GeometryError::Orientation { .. }
    ));
    let source = oriented("1\\0.0002\\0\\0\\1\\0").open().unwrap();
    assert!(
        source.series_facts().warnings[0].contains("made exact"),
        "{:?}",
        source.series_facts().warnings
    );
    let [x, y] = [0, 1].map(|axis| source.grid().ct_from_voxel().step(axis));
    assert!(x.dot(y).abs() < 1e-15);
}

#[test]
fn places_beyond_any_patient_are_refused() {
    for far in [1e300, 1e9, 1e-9] {
        let heights = [0.0, far, 2.0 * far, 3.0 * far];
        at_heights(&heights).open().unwrap_err();
        at_heights(&heights).open_with(Options { regrid: true }).unwrap_err();
    }
    // One slice far away: the even grid would have a million slices.
    let far = at_heights(&[0.0, 1.0, 2.0, 1e6]);
    assert!(matches!(
        far.open_with(Options { regrid: true }),
        Err(DicomError::Grid { .. })
    ));
}

#[test]
fn regridding_interpolates_by_position_and_leaves_holes() {
    let folder = at_heights(&[0.0, 2.0, 4.0, 6.0, 10.0, 12.0, 20.0]);
    let mut source = folder.open_with(Options { regrid: true }).unwrap();
    assert_eq!(source.grid().dims(), [4, 3, 11]);
    assert_eq!(
        (source.marks(), source.series_facts().regridded),
        (Marks::REGRIDDED, Some([1, 3]))
    );
    assert!(
        source.describe().contains("1 slices interpolated, 3 a hole"),
        "{}",
        source.describe()
    );
    let (voxels, _) = drink(&mut source).unwrap();
    let firsts: Vec<i16> = voxels.iter().step_by(12).copied().collect();
    let hu = [0, 100, 200, 300, 350, 400, 500, 0, 0, 0, 600].map(|stored| stored - 1024);
    assert_eq!(firsts, hu);
    // Any slice at any time gives the same.
    let (mut out, mut scratch) = (vec![0; 12], Scratch::default());
    source.read(4, &mut out, &mut scratch).unwrap();
    assert_eq!(out, voxels[48..60]);
    // An even stack stays what it is.
    let even = Folder::of(&stack(4)).open_with(Options { regrid: true }).unwrap();
    assert_eq!((even.marks(), even.series_facts().regridded), (Marks::NONE, None));
}

/// Rows of the rotation by these angles about z, y and x.
pub(super) fn rotation([a, b, c]: [f64; 3]) -> [[f64; 3]; 3] {
    let ([sa, sb, sc], [ca, cb, cc]) = ([a.sin(), b.sin(), c.sin()], [a.cos(), b.cos(), c.cos()]);
    [
        [ca * cb, sa * cb, -sb],
        [ca * sb * sc - sa * cc, sa * sb * sc + ca * cc, cb * sc],
        [ca * sb * cc + sa * sc, sa * sb * cc - ca * sc, cb * cc],
    ]
}

proptest! {
    #[test]
    fn any_stack_is_found_again(
        angles in prop::array::uniform3(-3.0..3.0_f64),
        shear in prop::array::uniform2(-0.8..0.8_f64),
        step in 0.3..6.0_f64,
        first in prop::array::uniform3(-500.0..500.0_f64),
        count in 3_usize..9,
    ) {
        let [row, column, normal] = rotation(angles);
        let line: [f64; 3] = std::array::from_fn(|i| step * (normal[i] + shear[0] * row[i] + shear[1] * column[i]));
        let mut files: Vec<File> = (0..count).map(|k| File::slice(k, 0.0)).collect();
        for (k, file) in files.iter_mut().enumerate() {
            place(file, std::array::from_fn(|i| first[i] + k as f64 * line[i]));
            let cosines: Vec<String> = row.iter().chain(&column).map(f64::to_string).collect();
            file.text((0x0020, 0x0037), "DS", &cosines.join("\\"));
        }
        let folder = Folder::of(&files);
        let mut source = folder.open().unwrap();
        prop_assert!(source.series_facts().worst_corner_mm < 1e-9);
        let far = [3.0, 2.0, count as f64 - 1.0];
        let found = corner(&source, far);
        for i in 0..3 {
            let want = first[i] + far[0] * 0.5 * row[i] + far[1] * 0.75 * column[i] + far[2] * line[i];
            prop_assert!((found[i] - want).abs() < 1e-9, "{found:?}");
        }
        let tilt = shear[0].hypot(shear[1]).atan().to_degrees();
        prop_assert!((source.series_facts().tilt_deg - tilt).abs() < 1e-6);
        let firsts: Vec<i16> = drink(&mut source).unwrap().0.iter().step_by(12).copied().collect();
        prop_assert_eq!(firsts, (0..count as i16).map(|k| 100 * k - 1024).collect::<Vec<_>>());
    }
}
