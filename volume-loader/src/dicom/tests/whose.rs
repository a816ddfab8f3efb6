//! Whose examination it is: read for the bus as the file writes it, and in nothing else.

use super::*;
use crate::source::Whose;
use bus::message::{Identity, IdentitySource, VolumeHash};
use writer::Coding;

const CHARACTER_SET: (u16, u16) = (0x0008, 0x0005);
const STUDY_DATE: (u16, u16) = (0x0008, 0x0020);
const STUDY: (u16, u16) = (0x0008, 0x1030);
const SERIES: (u16, u16) = (0x0008, 0x103E);
const NAME: (u16, u16) = (0x0010, 0x0010);
const ID: (u16, u16) = (0x0010, 0x0020);
const BIRTH: (u16, u16) = (0x0010, 0x0030);

/// A series of three slices, each changed so.
fn folder(change: impl Fn(&mut File)) -> Folder {
    let mut files = stack(3);
    files.iter_mut().for_each(change);
    Folder::of(&files)
}

fn whose(folder: &Folder) -> Whose {
    folder.open().unwrap().whose().unwrap()
}

/// As it is on the bus.
fn words(folder: &Folder) -> [String; 5] {
    let whose = whose(folder);
    let words = whose.words.each_ref().map(String::as_str);
    Identity::new(VolumeHash([0; 32]), whose.source, words).words()
}

fn said(file: &mut File) {
    file.text(NAME, "PN", "SECRET^NAME")
        .text(ID, "LO", "0042")
        .text(BIRTH, "DA", "19520229")
        .text(STUDY_DATE, "DA", "20261120")
        .text(STUDY, "LO", "Thorax with contrast")
        .text(SERIES, "LO", "1 mm");
}

#[test]
fn a_file_says_whose_it_is_in_every_coding() {
    for coding in [Coding::Implicit, Coding::Explicit, Coding::Big] {
        let files: Vec<File> = stack(3)
            .into_iter()
            .map(|mut file| {
                said(&mut file);
                file.coded(coding)
            })
            .collect();
        let folder = Folder::of(&files);
        assert_eq!(whose(&folder).source, IdentitySource::Examination);
        let expected = [
            "SECRET^NAME",
            "0042",
            "1952-02-29",
            "2026-11-20",
            "Thorax with contrast",
        ];
        assert_eq!(words(&folder), expected, "{coding:?}");
    }
    let series_alone = folder(|file| {
        said(file);
        file.text(STUDY, "LO", " ");
    });
    assert_eq!(words(&series_alone)[4], "1 mm");
}

#[test]
fn a_japanese_name_and_forty_wide_characters_arrive_whole() {
    let japanese = folder(|file| {
        file.text(CHARACTER_SET, "CS", "\\ISO 2022 IR 87");
        file.raw(
            NAME,
            "PN",
            b"Yamada^Tarou=\x1B$B;3ED\x1B(B^\x1B$BB@O:\x1B(B=\x1B$B$d$^$@\x1B(B^\x1B$B$?$m$&\x1B(B ",
        );
    });
    assert_eq!(words(&japanese)[0], "Yamada^Tarou=山田^太郎=やまだ^たろう");
    let wide = "文".repeat(40);
    let forty = folder(|file| {
        file.text(CHARACTER_SET, "CS", "ISO_IR 192").text(NAME, "PN", &wide);
    });
    assert_eq!(words(&forty)[0], wide);
    let latin = folder(|file| {
        file.text(CHARACTER_SET, "CS", "ISO_IR 100");
        file.raw(NAME, "PN", b"M\xFCller^J\xF6rg ");
    });
    assert_eq!(words(&latin)[0], "Müller^Jörg");
}

#[test]
fn what_is_hostile_in_a_name_reaches_no_screen() {
    let control = folder(|file| {
        file.raw(NAME, "PN", b"A\x1B[2J\x07^B\x00\x00")
            .text(BIRTH, "DA", "00000000");
    });
    let found = words(&control);
    assert!(found[0].starts_with('A') && found[0].contains("^B") && !found[0].contains(char::is_control));
    assert_eq!(found[2], "");
    let long = folder(|file| {
        file.raw(NAME, "PN", &[b'N'; 10_000]).raw(ID, "LO", &[b'7'; 10_000]);
    });
    let found = words(&long);
    assert_eq!(found[0], format!("{}…", "N".repeat(253)));
    assert_eq!(found[1], format!("{}…", "7".repeat(61)));
}

#[test]
fn a_file_that_says_nothing_is_of_nobody_and_one_that_cannot_say_it_is_loaded_all_the_same() {
    let nobody = folder(|file| {
        file.remove(NAME);
    });
    assert_eq!(whose(&nobody), Whose::default());
    // Longer than any value that is read: the voxels are read, the name is not.
    let endless = folder(|file| {
        file.coding = Coding::Implicit;
        file.syntax = "1.2.840.10008.1.2".to_owned();
        file.raw(NAME, "PN", &[b'S'; 70_000]);
    });
    let mut source = endless.open().unwrap();
    drink(&mut source).unwrap();
    let error = source.whose().unwrap_err().to_string();
    assert!(error.contains("(0010,0010)") && !error.contains("SS"), "{error}");
}

#[test]
fn nothing_that_is_said_for_people_names_the_patient() {
    let mut files = stack(3);
    files.iter_mut().for_each(said);
    let folder = Folder::of(&files);
    let source = folder.open().unwrap();
    let facts = source.facts();
    let all = format!(
        "{} {:?} {:?} {:?} {source:?} {:?}",
        source.describe(),
        facts.warnings,
        facts.extra,
        source.remarks(),
        source.whose().unwrap()
    );
    for secret in ["SECRET", "0042", "1952", "2026-11-20", "20261120", "Thorax"] {
        assert!(!all.contains(secret), "{secret}: {all}");
    }
}
