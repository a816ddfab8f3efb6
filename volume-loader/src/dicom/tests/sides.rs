//! Slices that say in letters and in cosines where their rows and columns point.

use super::*;

const AXES: (u16, u16) = (0x0020, 0x0037);
const SIDES: (u16, u16) = (0x0020, 0x0020);

/// A patient whose left is her right by the letters was shown by the cosines without a word.
#[test]
fn letters_that_contradict_the_cosines_are_refused_with_both() {
    let axial = "1\\0\\0\\0\\1\\0";
    let oblique = "0.866025\\0.5\\0\\-0.5\\0.866025\\0";
    for (cosines, letters, expected) in [
        (axial, "R\\P", "\"L\\P\""),
        (axial, "L\\A", "\"L\\P\""),
        (axial, "R\\A", "\"L\\P\""),
        (axial, "P\\L", "\"L\\P\""),
        (axial, "L\\F", "\"L\\P\""),
        (axial, "LR\\P", "\"L\\P\""),
        (axial, "H\\P", "\"L\\P\""),
        ("1\\0\\0\\0\\0\\-1", "L\\P", "\"L\\F\""),
        ("1\\0\\0\\0\\0\\-1", "L\\H", "\"L\\F\""),
        (oblique, "LA\\PR", "\"LP\\PR\""),
        (oblique, "LP\\PL", "\"LP\\PR\""),
    ] {
        let mut files = stack(4);
        for file in &mut files {
            file.text(AXES, "DS", cosines);
        }
        // One is enough.
        files[2].text(SIDES, "CS", letters);
        let said = Folder::of(&files).refused();
        let words =
            format!("(0020,0020) PatientOrientation is \"{letters}\", expected {expected} by ImageOrientationPatient");
        assert!(said.contains(&words) && said.contains(".dcm: "), "{said}");
    }
}

#[test]
fn letters_that_the_cosines_bear_out_are_taken_and_others_are_told() {
    let oblique = "0.866025\\0.5\\0\\-0.5\\0.866025\\0";
    let slight = "0.99999\\0.004472\\0\\-0.004472\\0.99999\\0";
    let with = |cosines: &str, letters: &str, kind: &str| {
        let mut files = stack(4);
        for file in &mut files {
            file.text(AXES, "DS", cosines)
                .text(SIDES, "CS", letters)
                .text((0x0010, 0x2210), "CS", kind);
        }
        Folder::of(&files).open().unwrap().series_facts().warnings.clone()
    };
    for (cosines, letters) in [
        ("1\\0\\0\\0\\1\\0", "L\\P"),
        ("1\\0\\0\\0\\1\\0", "L\\P "),
        ("-1\\0\\0\\0\\-1\\0", "R\\A"),
        (oblique, "L\\P"),
        (oblique, "LP\\PR"),
        (oblique, "LPH\\PRF"),
        (slight, "LA\\PL"),
        ("1\\0\\0\\0\\1\\0", ""),
    ] {
        let warnings = with(cosines, letters, "");
        assert!(
            !warnings.iter().any(|said| said.contains("PatientOrientation of")),
            "{letters}: {warnings:?}"
        );
    }
    for (letters, kind) in [
        ("L", ""),
        ("L\\P\\H", ""),
        ("LE\\V", ""),
        ("R\\P", "QUADRUPED"),
        ("\\P", ""),
        ("LPHA\\P", ""),
    ] {
        let warnings = with("1\\0\\0\\0\\1\\0", letters, kind);
        let words = "PatientOrientation of 4 of 4 slices is not two directions";
        assert!(
            warnings.len() == 1 && warnings[0].contains(words),
            "{letters}: {warnings:?}"
        );
    }
}
