//! Whose slices they are, and where they lie in that patient: the closed form of PS3.3 C.7.6.2.1.1, or a refusal by name.

use super::places::{place, rotation};
use super::*;
use crate::dicom::GeometryError;
use geometry::{Point, Voxel};
use proptest::prelude::*;

const SPACING: (u16, u16) = (0x0028, 0x0030);
const PATIENT_ID: (u16, u16) = (0x0010, 0x0020);
const STUDY: (u16, u16) = (0x0020, 0x000D);
const SERIES: (u16, u16) = (0x0020, 0x000E);
const FRAME: (u16, u16) = (0x0020, 0x0052);

fn all(files: &mut [File], tag: (u16, u16), vr: &'static str, text: &str) {
    files.iter_mut().for_each(|file| {
        file.text(tag, vr, text);
    });
}

#[test]
fn a_spacing_that_mirrors_or_turns_the_patient_is_refused_by_file() {
    for spacing in [
        "-0.75\\0.5",
        "0.75\\-0.5",
        "-0.75\\-0.5",
        "0\\0.5",
        "0.75\\-0",
        "0.75\\-1e-300",
    ] {
        let mut files = stack(4);
        all(&mut files, SPACING, "DS", spacing);
        let said = Folder::of(&files).refused();
        assert!(
            said.contains("PixelSpacing is") && said.contains(".dcm"),
            "{spacing}: {said}"
        );
        // One slice alone makes no series of its own beside the others.
        let mut files = stack(5);
        all(&mut files[4..], SPACING, "DS", spacing);
        let said = Folder::of(&files).refused();
        assert!(
            said.contains("(0028,0030) PixelSpacing is") && said.contains("mirror"),
            "{said}"
        );
    }
    for (spacing, words) in [
        ("1e300\\0.5", "voxel spacing along axis 1"),
        ("0.75\\1e9", "voxel spacing along axis 0"),
        ("1e-9\\0.5", "voxel spacing along axis 1"),
        ("inf\\0.5", "not numbers"),
        ("nan\\0.5", "not numbers"),
        ("0.75\\1e999", "finite"),
    ] {
        let mut files = stack(4);
        all(&mut files, SPACING, "DS", spacing);
        let said = Folder::of(&files).refused();
        assert!(said.contains(words), "{spacing}: {said}");
    }
}

#[test]
fn a_scout_may_have_any_spacing_beside_the_slices() {
    let mut files = stack(4);
    let mut scout = File::slice(0, 0.0);
    scout
        .text((0x0008, 0x0008), "CS", "DERIVED\\PRIMARY\\LOCALIZER")
        .text(SPACING, "DS", "0\\0");
    files.push(scout);
    let found = Series::scan(Folder::of(&files).path()).unwrap();
    assert_eq!(found.series.len(), 2);
}

#[test]
fn a_slice_of_another_patient_study_or_frame_is_refused_by_file_and_without_values() {
    for (tag, vr, name) in [
        (PATIENT_ID, "LO", "(0010,0020) PatientID"),
        (STUDY, "UI", "(0020,000D) StudyInstanceUID"),
        (FRAME, "UI", "(0020,0052) FrameOfReferenceUID"),
    ] {
        for (other, found) in [("1.99.SECRET", "another"), ("", "none")] {
            let mut files = stack(5);
            all(&mut files, tag, vr, "1.42.SECRET");
            files[3].text(tag, vr, other);
            let folder = Folder::new();
            for (k, file) in files.iter().enumerate() {
                folder.put(&format!("slice{k}.dcm"), &file.bytes());
            }
            let said = folder.refused();
            let words = format!("slice3.dcm: {name}: found {found} in 1 slices, expected the one in 4 slices such as ");
            assert!(said.contains(&words) && said.contains("slice0.dcm"), "{said}");
            assert!(!said.contains("SECRET") && !said.contains("1.42"), "{said}");
            // The same at an end of the stack, where no gap shows that it is missing.
            files.swap(3, 4);
            files[4].text(tag, vr, other);
            assert!(Folder::of(&files).refused().contains(name));
        }
        // What differs by its padding alone is the same.
        let mut files = stack(4);
        all(&mut files, tag, vr, "1.42");
        files[1].text(tag, vr, "1.42 ");
        Folder::of(&files).open().unwrap();
    }
}

/// Two persons of one PatientID, and two positions, were one volume.
#[test]
fn a_slice_of_another_person_or_position_is_refused_by_file_and_without_values() {
    let name = (0x0010, 0x0010);
    for (tag, vr, said, other, words) in [
        (name, "PN", "DOE^SECRET", "ROE^SECRET", "(0010,0010) PatientName"),
        (name, "PN", "DOE^SECRET", "DOE SECRET", "(0010,0010) PatientName"),
        (
            (0x0010, 0x0021),
            "LO",
            "SECRET A",
            "SECRET B",
            "(0010,0021) IssuerOfPatientID",
        ),
        (
            (0x0010, 0x0030),
            "DA",
            "19520229",
            "19520228",
            "(0010,0030) PatientBirthDate",
        ),
        ((0x0010, 0x0040), "CS", "F", "M", "(0010,0040) PatientSex"),
        ((0x0018, 0x5100), "CS", "HFS", "FFS", "(0018,5100) PatientPosition"),
    ] {
        let mut files = stack(5);
        all(&mut files, tag, vr, said);
        files[3].text(tag, vr, other);
        let folder = Folder::new();
        for (k, file) in files.iter().enumerate() {
            folder.put(&format!("slice{k}.dcm"), &file.bytes());
        }
        let refused = folder.refused();
        let expected = format!("slice3.dcm: {words}: found another in 1 slices, expected the one in 4 slices");
        assert!(refused.contains(&expected), "{refused}");
        // One letter is in every sentence.
        assert!(
            !refused.contains("SECRET") && (said.len() == 1 || !refused.contains(said)),
            "{refused}"
        );
        // A file that does not say it is of any.
        files[3].text(tag, vr, "");
        Folder::of(&files).open().unwrap();
        files[3].remove(tag);
        Folder::of(&files).open().unwrap();
    }
    // Padding, and components at the end that are empty, are no other name.
    let mut files = stack(6);
    for (file, same) in files.iter_mut().zip([
        "DOE^ANN",
        "DOE^ANN ",
        "DOE^ANN^^^",
        "DOE ^ANN^ =",
        " DOE^ ANN",
        "DOE^ANN==^",
    ]) {
        file.text(name, "PN", same);
    }
    Folder::of(&files).open().unwrap();
    files[5].text(name, "PN", "DOE^^ANN");
    assert!(Folder::of(&files).refused().contains("PatientName"));
}

#[test]
fn halves_of_two_patients_are_refused_and_the_words_are_always_the_same() {
    let mut files = stack(6);
    for (k, file) in files.iter_mut().enumerate() {
        file.text(PATIENT_ID, "LO", if k % 2 == 0 { "A" } else { "B" });
    }
    let folder = Folder::of(&files);
    let said = folder.refused();
    assert!(said.contains("in 3 slices"), "{said}");
    assert!((0..5).all(|_| folder.refused() == said));
}

#[test]
fn slices_without_a_series_are_one_by_study_frame_orientation_and_size() {
    for uid in [None, Some("")] {
        let unnamed = |mut files: Vec<File>| {
            for file in &mut files {
                match uid {
                    None => file.remove(SERIES),
                    Some(uid) => file.text(SERIES, "UI", uid),
                };
            }
            files
        };
        let source = Folder::of(&unnamed(stack(5))).open().unwrap();
        assert_eq!(source.grid().dims(), [4, 3, 5]);
        let warnings = &source.series_facts().warnings;
        assert!(
            warnings.len() == 1 && warnings[0].contains("have no SeriesInstanceUID"),
            "{warnings:?}"
        );
        // Whatever tells two of them apart keeps them apart.
        let others: [((u16, u16), &'static str, &str); 6] = [
            (STUDY, "UI", "1.2.3.9"),
            (FRAME, "UI", "1.2.3.9"),
            ((0x0020, 0x0037), "DS", "0\\1\\0\\0\\0\\-1"),
            ((0x0018, 0x1210), "SH", "B70f"),
            ((0x0020, 0x0011), "IS", "4"),
            (SERIES, "UI", "1.2.3.4.5"),
        ];
        for (tag, vr, text) in others {
            let mut files = unnamed(stack(4));
            // Between the slices of the first: one even stack, were they put together.
            let mut more: Vec<File> = unnamed((0..4).map(|k| File::slice(k, 1.25 + 2.5 * k as f64)).collect());
            all(&mut more, tag, vr, text);
            files.extend(more);
            let error = Folder::of(&files).open().unwrap_err();
            assert!(
                matches!(error, DicomError::Several { count: 2.., .. }),
                "{text}: {error}"
            );
        }
        let mut sizes = unnamed(stack(4));
        let mut other = unnamed(stack(1));
        other[0].us((0x0028, 0x0010), 2).pixels(&[7; 8]);
        sizes.extend(other);
        assert!(matches!(
            Folder::of(&sizes).open(),
            Err(DicomError::Several { count: 2, .. })
        ));
        // Of two patients they are one group, which is refused.
        let mut files = unnamed(stack(4));
        files[0].text(PATIENT_ID, "LO", "A");
        assert!(Folder::of(&files).refused().contains("PatientID"));
    }
}

#[test]
fn a_mirrored_stack_is_refused_whoever_hands_it_over() {
    use crate::dicom::geometry::Stack;
    use crate::dicom::header::Placed;
    let placed = |spacing| {
        let slice = |k: usize| Placed {
            position: [0.0, 0.0, k as f64],
            orientation: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0],
            spacing,
        };
        Stack::of(&(0..4).map(slice).collect::<Vec<_>>()).map(|_| ())
    };
    placed([1.0, 1.0]).unwrap();
    for spacing in [[-1.0, 1.0], [1.0, -1.0], [0.0, 1.0], [f64::NAN, 1.0]] {
        let error = placed(spacing).unwrap_err();
        assert!(matches!(error, GeometryError::Mirrored { .. }), "{error}");
    }
}

#[test]
fn regridding_hides_no_crooked_axes() {
    let mut files: Vec<File> = [0.0, 1.0, 2.0, 4.0]
        .iter()
        .enumerate()
        .map(|(k, &z)| File::slice(k, z))
        .collect();
    // Lengths off by a part in a thousand, over 4 x 40 mm pixels: 0.12 mm at the far corner.
    all(&mut files, (0x0020, 0x0037), "DS", "1.0009\\0\\0\\0\\1\\0");
    all(&mut files, SPACING, "DS", "40\\45");
    let error = Folder::of(&files).open_with(Options { regrid: true }).unwrap_err();
    let askew = matches!(
        &error,
        DicomError::Geometry {
            source: GeometryError::Askew { .. },
            ..
        }
    );
    assert!(askew && error.to_string().contains("axes differ"), "{error}");
}

/// A series as it is drawn.
#[derive(Debug, Clone)]
struct Drawn {
    angles: [f64; 3],
    /// Whether rows run along +x and columns along +y of the turned axes.
    forth: [bool; 2],
    spacing: [f64; 2],
    first: [f64; 3],
    step: f64,
    shear: [f64; 2],
    /// Lengths of the cosines, and their scalar product.
    crooked: [f64; 3],
    decimals: usize,
    order: Vec<usize>,
}

impl Drawn {
    /// ImageOrientationPatient.
    fn cosines(&self) -> [f64; 6] {
        let [x, y, _] = self.axes();
        let [length_x, length_y, product] = self.crooked;
        let row = x.map(|v| v * (1.0 + length_x));
        let column: [f64; 3] = std::array::from_fn(|i| y[i] * (1.0 + length_y) + product * x[i]);
        [row[0], row[1], row[2], column[0], column[1], column[2]]
    }

    fn axes(&self) -> [[f64; 3]; 3] {
        let [x, y, z] = rotation(self.angles);
        let sign = |forth: bool| if forth { 1.0 } else { -1.0 };
        [
            x.map(|v| v * sign(self.forth[0])),
            y.map(|v| v * sign(self.forth[1])),
            z,
        ]
    }

    /// ImagePositionPatient of slice `k`, as it is written.
    fn position(&self, k: usize) -> [f64; 3] {
        let [x, y, z] = self.axes();
        let along = |i: usize| z[i] + self.shear[0] * x[i] + self.shear[1] * y[i];
        std::array::from_fn(|i| {
            let exact = self.first[i] + k as f64 * self.step * along(i);
            format!("{exact:.*}", self.decimals).parse().unwrap()
        })
    }

    fn files(&self) -> Vec<File> {
        let text = |numbers: &[f64]| numbers.iter().map(f64::to_string).collect::<Vec<_>>().join("\\");
        let file = |&k: &usize| {
            let mut file = File::slice(k, 0.0);
            place(&mut file, self.position(k));
            file.text((0x0020, 0x0037), "DS", &text(&self.cosines()));
            file.text(SPACING, "DS", &text(&self.spacing));
            file
        };
        self.order.iter().map(file).collect()
    }

    /// PS3.3 C.7.6.2.1.1, equation C.7.6.2.1-1: the middle of the pixel in this column and row of slice `k`.
    fn closed_form(&self, [column, row]: [usize; 2], k: usize) -> [f64; 3] {
        let [xx, xy, xz, yx, yy, yz] = self.cosines();
        let [down, right] = self.spacing;
        let (x, y, s) = ([xx, xy, xz], [yx, yy, yz], self.position(k));
        std::array::from_fn(|i| x[i] * right * column as f64 + y[i] * down * row as f64 + s[i])
    }

    /// How far a voxel may be from the closed form, mm: positions rounded to so many decimals, each slice's own and the two that the
    /// even step is made of (half a unit each, in three coordinates); axes that were made exact, over 1.5 times the spacings;
    /// and arithmetic on numbers below 1000.
    fn bound(&self) -> f64 {
        let rounding = 3.0_f64.sqrt() * 10.0_f64.powi(-(self.decimals as i32));
        let crooked: f64 = self.crooked.iter().map(|v| v.abs()).sum();
        let extent = 3.0 * self.spacing[1].abs() + 2.0 * self.spacing[0].abs();
        rounding + 1.5 * crooked * extent + 1e-9
    }
}

fn drawn() -> impl Strategy<Value = Drawn> {
    let crooked = || prop_oneof![6 => Just(0.0), 1 => Just(4e-7), 1 => Just(-3e-4), 1 => Just(5e-3)];
    let spacing = || prop_oneof![4 => 0.2..2.0_f64, 1 => -2.0..-0.2_f64, 1 => Just(0.0)];
    let place = (
        prop::array::uniform3(-3.0..3.0_f64),
        prop::array::uniform2(any::<bool>()),
        prop::array::uniform2(spacing()),
        prop::array::uniform3(-500.0..500.0_f64),
    );
    let steps = (
        prop_oneof![0.5..6.0_f64, -6.0..-0.5_f64],
        prop::array::uniform2(-0.6..0.6_f64),
        prop::array::uniform3(crooked()),
        3_usize..9,
        (3_usize..9).prop_flat_map(|count| Just((0..count).collect::<Vec<_>>()).prop_shuffle()),
    );
    (place, steps).prop_map(
        |((angles, forth, spacing, first), (step, shear, crooked, decimals, order))| Drawn {
            angles,
            forth,
            spacing,
            first,
            step,
            shear,
            crooked,
            decimals,
            order,
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 512, ..ProptestConfig::default() })]
    #[test]
    fn a_series_lies_where_the_standard_puts_it_or_is_refused(drawn in drawn()) {
        let folder = Folder::of(&drawn.files());
        let opened = folder.open();
        if drawn.spacing.iter().any(|&mm| mm <= 0.0) {
            let said = opened.unwrap_err().to_string();
            prop_assert!(said.contains("PixelSpacing is"), "{said}");
            return Ok(());
        }
        if drawn.crooked.iter().any(|v| v.abs() > 1e-3) {
            let said = opened.unwrap_err().to_string();
            prop_assert!(said.contains("ImageOrientationPatient"), "{said}");
            return Ok(());
        }
        let mut source = opened.unwrap();
        let map = source.grid().ct_from_voxel();
        prop_assert!(map.determinant() > 0.0);
        let (voxels, _) = drink(&mut source).unwrap();
        let mut worst: f64 = 0.0;
        for (at, hu) in voxels.iter().enumerate() {
            // Which pixel of which file it is shows in its number.
            let stored = (hu + 1024) as usize;
            let (k, pixel) = (stored / 100, stored % 100);
            let want = drawn.closed_form([pixel % 4, pixel / 4], k);
            let voxel = Point::<Voxel>::new((at % 4) as f64, (at / 4 % 3) as f64, (at / 12) as f64);
            let apart = (map * voxel).distance(Point::new(want[0], want[1], want[2]));
            prop_assert!(apart <= drawn.bound(), "{apart} mm, at most {}", drawn.bound());
            worst = worst.max(apart);
        }
        let told = source.series_facts().worst_corner_mm;
        prop_assert!((told - worst).abs() < 1e-9, "{told} mm are told, {worst} found");
    }
}
