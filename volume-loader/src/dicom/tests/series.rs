//! Several series, other files, and single files.

use super::*;
use scene::VolumeSpec;

use crate::dicom::{Options, open_path};

fn with_series(files: &mut [File], uid: &str) {
    files.iter_mut().for_each(|file| {
        file.text((0x0020, 0x000E), "UI", uid);
    });
}

fn listed(folder: &Folder) -> String {
    match folder.open() {
        Err(error @ DicomError::Several { .. }) => error.to_string(),
        other => panic!("expected several series, found {other:?}"),
    }
}

#[test]
fn other_files_are_ignored_and_counted() {
    let folder = Folder::of(&stack(3));
    folder.put("README.txt", b"not DICOM");
    folder.put("LICENSE", &[b'x'; 500]);
    folder.put(".hidden.dcm", b"left out");
    let mut report = File::slice(0, 0.0);
    report.elements.clear();
    report.text((0x0008, 0x0016), "UI", "1.2.840.10008.1.3.10");
    folder.put("DICOMDIR", &report.bytes());
    std::fs::create_dir_all(folder.path().join("a/b")).unwrap();
    folder.put("a/b/more", &File::slice(3, 7.5).bytes());
    let source = folder.open().unwrap();
    assert_eq!((source.grid().dims()[2], source.series_facts().ignored), (4, 3));
}

#[test]
fn two_series_are_listed_and_chosen_by_number() {
    let mut files = stack(3);
    let mut other = stack(5);
    with_series(&mut other, "1.2.3.4.1");
    other.iter_mut().for_each(|file| {
        file.text((0x0018, 0x1210), "SH", "B70f");
    });
    files.extend(other);
    let folder = Folder::of(&files);
    let text = listed(&folder);
    assert!(
        text.contains("1: CT, 5 slices of 4 x 3, axial, step 2.500 mm, kernel B70f"),
        "{text}"
    );
    assert!(
        text.contains("2: CT, 3 slices of 4 x 3, axial, step 2.500 mm"),
        "{text}"
    );
    assert!(text.contains("--series N") && !text.contains("1.2.3.4"), "{text}");
    let choose = |number| Series::scan(folder.path()).unwrap().choose(Some(number));
    let source = DicomSource::open(&choose(1).unwrap(), Options::default()).unwrap();
    assert_eq!(source.grid().dims()[2], 5);
    for number in [0, 3] {
        assert!(matches!(choose(number), Err(DicomError::NoSuchSeries { count: 2, .. })));
    }
}

#[test]
fn orientations_and_localizers_are_kept_apart() {
    let mut files = stack(4);
    let mut sagittal = stack(3);
    for (k, file) in sagittal.iter_mut().enumerate() {
        file.text((0x0020, 0x0037), "DS", "0\\1\\0\\0\\0\\-1");
        file.text((0x0020, 0x0032), "DS", &format!("{k}\\0\\0"));
    }
    let mut scout = vec![File::slice(0, 0.0)];
    scout[0].text((0x0008, 0x0008), "CS", "ORIGINAL\\PRIMARY\\LOCALIZER");
    files.extend(sagittal);
    files.extend(scout);
    let text = listed(&Folder::of(&files));
    for line in ["4 slices", "sagittal", "1 slices of 4 x 3, axial, localizer"] {
        assert!(text.contains(line), "{line}: {text}");
    }
    assert_eq!(text.lines().count(), 4, "{text}");
}

#[test]
fn the_only_stack_of_ct_slices_is_suggested_and_not_taken() {
    let mut files = stack(4);
    let mut scout = vec![File::slice(0, 0.0)];
    scout[0].text((0x0008, 0x0008), "CS", "ORIGINAL\\PRIMARY\\LOCALIZER");
    with_series(&mut scout, "1.1");
    files.extend(scout);
    let text = listed(&Folder::of(&files));
    assert!(
        text.contains("the only stack of CT slices among them is --series 2"),
        "{text}"
    );
}

#[test]
fn a_frame_of_reference_for_each_slice_is_none() {
    let mut files = stack(4);
    for (k, file) in files.iter_mut().enumerate() {
        file.text((0x0020, 0x0052), "UI", &format!("1.2.9.{}", 7 * k % 5));
    }
    let source = Folder::of(&files).open().unwrap();
    assert_eq!(source.grid().dims()[2], 4);
    assert!(
        source.series_facts().warnings[0].contains("frame of reference"),
        "{:?}",
        source.series_facts().warnings
    );
}

#[test]
fn a_localizer_alone_is_no_volume() {
    let mut files = stack(3);
    files.iter_mut().for_each(|file| {
        file.text((0x0008, 0x0008), "CS", "ORIGINAL\\PRIMARY\\LOCALIZER");
    });
    let error = Folder::of(&files).refused();
    assert!(error.contains("localizers (scouts)"), "{error}");
}

#[test]
fn another_modality_is_read_with_a_warning() {
    let mut files = stack(3);
    for file in &mut files {
        file.text((0x0008, 0x0060), "CS", "MR")
            .remove((0x0028, 0x1052))
            .remove((0x0028, 0x1053));
    }
    let folder = Folder::of(&files);
    let mut source = folder.open().unwrap();
    assert!(
        source.describe().contains("not a CT (MR): its numbers are not HU"),
        "{}",
        source.describe()
    );
    assert_eq!(drink(&mut source).unwrap().0[13], 101);
}

#[test]
fn single_files_empty_folders_and_strangers_end_by_name() {
    let folder = Folder::of(&stack(3));
    let file = std::fs::read_dir(folder.path())
        .unwrap()
        .next()
        .unwrap()
        .unwrap()
        .path();
    let error = open_path(&file, None, Options::default()).unwrap_err();
    assert!(matches!(error, DicomError::OneFile { .. }));
    assert!(
        error.to_string().contains(&folder.path().display().to_string()),
        "{error}"
    );
    let other = Folder::new();
    assert!(matches!(
        open_path(other.path(), None, Options::default()),
        Err(DicomError::None { ignored: 0, .. })
    ));
    other.put("volume.nii", b"something else");
    assert!(
        open_path(&other.path().join("volume.nii"), None, Options::default())
            .unwrap()
            .is_none()
    );
    assert!(
        open_path(&other.path().join("absent"), None, Options::default())
            .unwrap()
            .is_none()
    );
    let deep = Folder::new();
    let path = deep.path().join("1/2/3/4/5/6/7/8/9/10");
    std::fs::create_dir_all(path).unwrap();
    assert!(matches!(
        open_path(deep.path(), None, Options::default()),
        Err(DicomError::TooMuch { .. })
    ));
}

#[test]
fn a_folder_is_loaded_by_several_threads_as_by_one() {
    let folder = Folder::of(&stack(11));
    let volume = crate::load(&VolumeSpec::of_path(folder.path().to_owned())).unwrap();
    let (voxels, _) = drink(&mut folder.open().unwrap()).unwrap();
    let at = |i: usize| volume.view().at([i % 4, i / 4 % 3, i / 12].map(|index| index as u32));
    assert_eq!((0..voxels.len()).map(at).collect::<Vec<_>>(), voxels);
    let mut broken = stack(11);
    broken[7].us((0x0028, 0x0103), 5);
    let error = crate::load(&VolumeSpec::of_path(Folder::of(&broken).path().to_owned()))
        .unwrap_err()
        .to_string();
    assert!(error.contains("PixelRepresentation is 5"), "{error}");
}

#[test]
fn whom_a_series_is_of_is_told_only_when_asked() {
    const SECRETS: [&str; 5] = ["DOE^JANE", "PAT-4711", "19610203", "ACC-99", "St. Elsewhere"];
    let mut files = stack(4);
    for file in &mut files {
        for (tag, vr, text) in [
            ((0x0010, 0x0010), "PN", SECRETS[0]),
            ((0x0010, 0x0020), "LO", SECRETS[1]),
            ((0x0010, 0x0030), "DA", SECRETS[2]),
            ((0x0008, 0x0050), "SH", SECRETS[3]),
            ((0x0008, 0x0080), "LO", SECRETS[4]),
        ] {
            file.text(tag, vr, text);
        }
    }
    let folder = Folder::of(&files);
    let source = folder.open().unwrap();
    let mut said = format!("{} {:?} {:?}", source.describe(), source.facts(), source.series_facts());
    // Refusals say nothing either: a gap, and files of two series.
    let gap: Vec<File> = files
        .iter()
        .enumerate()
        .filter(|(k, _)| *k != 2)
        .map(|(_, file)| file.clone())
        .collect();
    said += &Folder::of(&gap).refused();
    let mut two = files.clone();
    with_series(&mut two[2..], "1.2.3.4.1");
    said += &listed(&Folder::of(&two));
    for secret in SECRETS {
        assert!(!said.contains(secret), "{secret}: {said}");
    }
    let identity = Series::scan(folder.path())
        .unwrap()
        .choose(None)
        .unwrap()
        .identity()
        .unwrap();
    for secret in SECRETS {
        assert!(
            identity.iter().any(|(_, text)| text == secret),
            "{secret}: {identity:?}"
        );
    }
}

#[test]
fn slices_of_two_kernels_in_one_series_are_told_of() {
    let mut files = stack(4);
    for (file, kernel) in files.iter_mut().zip(["B30f", "B30f ", "B70f", "B30f"]) {
        file.text((0x0018, 0x1210), "SH", kernel);
    }
    let warnings = Folder::of(&files).open().unwrap().series_facts().warnings.clone();
    assert!(
        warnings.len() == 1 && warnings[0].contains("the kernel is B30f in ") && warnings[0].contains(" and B70f in "),
        "{warnings:?}"
    );
    files[2].text((0x0018, 0x1210), "SH", "B30f");
    assert!(Folder::of(&files).open().unwrap().series_facts().warnings.is_empty());
}
