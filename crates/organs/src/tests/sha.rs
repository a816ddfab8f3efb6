//! Digests of files, and the label map that a scene names by one.

use std::path::Path;

use crate::sha::{of, of_file, of_labels, pinned};

/// The standard's own example: the SHA-256 of "abc".
const ABC: &str = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";

#[test]
fn files_have_the_digest_of_their_bytes_and_what_is_no_one_file_has_none() {
    let folder = tempfile::tempdir().unwrap();
    let with = |name: &str, bytes: &[u8]| {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        path
    };
    assert_eq!(of_labels(&with("map.nii", b"abc")).unwrap().as_deref(), Some(ABC));
    // Longer than what is read at once.
    let long: Vec<u8> = (0..200_000_u32).map(|k| (k % 251) as u8).collect();
    assert_eq!(of_file(&with("long.nii", &long)).unwrap(), Some(of(&long)));
    assert_eq!(of_labels(folder.path()).unwrap(), None);
    assert_eq!(of_labels(&with("map.NHDR", b"abc")).unwrap(), None);
}

#[test]
fn another_label_map_than_the_named_one_is_refused() {
    let path = Path::new("map.nii");
    assert!(pinned(None, path, None).is_ok());
    assert!(pinned(Some(ABC), path, Some(ABC)).is_ok());
    let other = of(b"abd");
    let refused = pinned(Some(ABC), path, Some(&other)).unwrap_err();
    assert_eq!(refused.key, "space.labels_sha256");
    assert!(refused.found.contains(&other) && refused.allowed.contains(ABC));
    let refused = pinned(Some(ABC), path, None).unwrap_err();
    assert!(refused.found.contains("not one file"));
}

/// By its ending a header named as a whole file was one: its digest pinned no voxel.
#[test]
fn a_header_that_names_the_file_of_its_voxels_has_no_digest_whatever_its_ending() {
    let folder = tempfile::tempdir().unwrap();
    let digest = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        of_labels(&path).unwrap()
    };
    let long = "# filler\n".repeat(200_000);
    for (name, text) in [
        ("a.nrrd", "NRRD0004\ntype: short\ndata file: lab.raw\n\n"),
        ("b.nrrd", "NRRD0004\r\nDataFile: lab.raw\r\n"),
        ("c.nrrd", "NRRD0004\nDATA FILE:LIST\na.raw\nb.raw\n"),
        ("d.nrrd", &format!("NRRD0004\n{long}\n")),
        ("e.mha", "ObjectType = Image\nElementDataFile = lab.raw\n"),
        ("f.mha", "ObjectType = Image\n ElementDataFile=LIST\na.raw\n"),
        ("g.nii", "ObjectType = Image\nElementDataFile = lab.raw\n"),
    ] {
        assert_eq!(digest(name, text), None, "{name}");
    }
    for (name, text) in [
        (
            "a.nrrd",
            "NRRD0004\ntype: short\nkey:=data file: x\n# data file: x\n\ndata file: x\n",
        ),
        (
            "e.mha",
            "ObjectType = Image\nElementDataFile = LOCAL\nElementDataFile = lab.raw\n",
        ),
    ] {
        assert_eq!(digest(name, text), Some(of(text.as_bytes())), "{name}");
    }
    // The generated patient is no file, and one of its name in this folder is not its voxels.
    assert_eq!(of_labels(Path::new("phantom")).unwrap(), None);
}
