//! Every reader of volumes, and every kind of thing that is no volume's file: an answer by name, at once, in bounded memory.

use std::os::unix::fs::symlink;
use std::os::unix::net::UnixListener;
use std::path::{Path, PathBuf};
use std::time::Duration;

use bus::clock::Clock;
use rustix::fs::{CWD, FileType, Mode, mknodat};
use scene::VolumeSpec;

use crate::load;

/// What each kind is called, and what the answer must say.
const KINDS: [(&str, &str); 9] = [
    ("pipe", "this is a pipe, expected a file"),
    ("socket", "this is a socket, expected a file"),
    ("zeros", "this is a device, expected a file"),
    ("null", "this is a device, expected a file"),
    ("folder", "this is a folder, expected a file"),
    ("dangling", "this is a link to a file that is not there"),
    ("circle", "Too many levels of symbolic links"),
    ("absent", "there is no such file"),
    ("empty", "the file is empty (0 bytes)"),
];

/// Puts something of this kind at `path`; a socket goes on as long as it is held.
fn make(kind: &str, path: &Path) -> Option<UnixListener> {
    match kind {
        "pipe" => mknodat(CWD, path, FileType::Fifo, Mode::RUSR | Mode::WUSR, 0).unwrap(),
        "socket" => return Some(UnixListener::bind(path).unwrap()),
        "zeros" => symlink("/dev/zero", path).unwrap(),
        "null" => symlink("/dev/null", path).unwrap(),
        "folder" => std::fs::create_dir(path).unwrap(),
        "dangling" => symlink("nowhere", path).unwrap(),
        "circle" => symlink(path.file_name().unwrap(), path).unwrap(),
        "empty" => std::fs::write(path, "").unwrap(),
        _ => {}
    }
    None
}

/// What loading says, which comes at once.
fn refused(path: PathBuf) -> String {
    let clock = Clock::monotonic(0);
    let since = clock.now_ns();
    let said = load::load(&VolumeSpec::of_path(path))
        .map(|_| ())
        .unwrap_err()
        .to_string();
    let took = Duration::from_nanos((clock.now_ns() - since) as u64);
    assert!(took < Duration::from_secs(20), "{said}");
    said
}

#[test]
fn every_reader_answers_to_every_kind_by_name() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["a.nii", "a.nii.gz", "a.nrrd", "a.nhdr", "a.mha", "a.mhd", "a", "a.dcm"] {
        for (kind, words) in KINDS {
            let path = folder.path().join(format!("{kind}-{name}"));
            let _held = make(kind, &path);
            let said = refused(path);
            // A folder is looked through for a series, and an empty file of that name is no slice.
            let words = match (kind, name) {
                ("folder", _) => "no DICOM image in this folder",
                ("empty", "a.dcm") => "not a DICOM file",
                _ => words,
            };
            assert!(
                said.contains(words) && said.contains(&format!("{kind}-{name}")),
                "{said}"
            );
        }
    }
}

/// A header of two slices that names its voxels' file or files.
fn headers(files: &str, list: bool) -> [(&'static str, String); 2] {
    let nrrd = "NRRD0004\ntype: short\ndimension: 3\nspace: lps\nsizes: 2 3 2\nspace directions: (1,0,0) (0,1,0) (0,0,1)\n\
                endian: little\nencoding: raw\nspace origin: (0,0,0)\n";
    let mha = "NDims = 3\nBinaryDataByteOrderMSB = False\nTransformMatrix = 1 0 0 0 1 0 0 0 1\nOffset = 0 0 0\nElementSpacing = 1 1 1\n\
               DimSize = 2 3 2\nElementType = MET_SHORT\n";
    let (named, listed) = match list {
        true => (format!("LIST\n{files}"), format!("LIST\n{files}\n")),
        false => (files.to_owned(), format!("{files}\n")),
    };
    [
        ("a.nhdr", format!("{nrrd}data file: {named}\n")),
        ("a.mhd", format!("{mha}ElementDataFile = {listed}")),
    ]
}

#[test]
fn every_named_voxel_file_of_every_kind_is_refused_by_name() {
    for (kind, words) in KINDS {
        for (name, header) in headers("voxels.raw", false) {
            let folder = tempfile::tempdir().unwrap();
            let _held = make(kind, &folder.path().join("voxels.raw"));
            let path = folder.path().join(name);
            std::fs::write(&path, header).unwrap();
            let said = refused(path);
            assert!(
                said.contains(words) && said.contains("voxels.raw"),
                "{kind}, {name}: {said}"
            );
        }
    }
}

#[test]
fn a_header_that_names_itself_is_refused_through_every_way_to_it() {
    for itself in ["a.nhdr", "./a.nhdr", "link", "hard", "far/a.nhdr"] {
        for (name, header) in headers(itself, false) {
            // Long enough to be taken for the voxels.
            let header = header.replace("a.nhdr", name);
            let comment = if name == "a.nhdr" { "#" } else { "Comment = " };
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join(name);
            let (first, rest) = header.split_once('\n').unwrap();
            std::fs::write(&path, format!("{first}\n{comment}{}\n{rest}", "x".repeat(24))).unwrap();
            symlink(name, folder.path().join("link")).unwrap();
            std::fs::hard_link(&path, folder.path().join("hard")).unwrap();
            symlink(".", folder.path().join("far")).unwrap();
            let said = refused(path);
            assert!(said.contains("this is the same file as"), "{itself}, {name}: {said}");
        }
    }
    for (name, header) in headers("x/../a.nhdr", false) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        std::fs::write(&path, header).unwrap();
        let said = refused(path);
        assert!(said.contains("not inside the header's folder"), "{said}");
    }
}

#[test]
fn a_file_named_twice_is_refused_and_two_are_read() {
    for (second, words) in [("one.raw", "same file"), ("link", "same file"), ("two.raw", "")] {
        for (name, header) in headers(&format!("one.raw\n{second}"), true) {
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join(name);
            std::fs::write(&path, header).unwrap();
            std::fs::write(folder.path().join("one.raw"), [1; 12]).unwrap();
            std::fs::write(folder.path().join("two.raw"), [2; 12]).unwrap();
            symlink("one.raw", folder.path().join("link")).unwrap();
            match words {
                "" => drop(load::load(&VolumeSpec::of_path(path)).unwrap()),
                words => assert!(refused(path).contains(words), "{name}, {second}"),
            }
        }
    }
}

#[test]
fn what_is_nothing_known_is_told_what_is() {
    let folder = tempfile::tempdir().unwrap();
    let text = b"What is this? Not a volume.".repeat(20);
    let nrrd = b"NRRD0004\ntype: short\n\n".to_vec();
    let packed = crate::raster::test_files::gzip(&text);
    for (name, bytes, words) in [
        (
            "a.tif",
            &text,
            "this is no volume that is read: its first bytes are [57, 68, 61, 74",
        ),
        ("a", &text, "this is no volume that is read"),
        (
            "short",
            &b"abc".to_vec(),
            "this is no volume that is read: its first bytes are [61, 62, 63]",
        ),
        ("packed", &packed, "this is no volume that is read"),
        ("damaged", &packed[..12].to_vec(), "this is no volume that is read"),
        ("a.vol", &nrrd, "as of an NRRD file: name it .nrrd"),
        (
            "b.vol",
            &b"ObjectType = Image\n".to_vec(),
            "as of a MetaImage file: name it .mha",
        ),
        ("a.nii", &text, "not a NIfTI file"),
        ("a.nii.gz", &packed, "not a NIfTI file"),
        ("a.nrrd", &text, "not an NRRD file"),
        ("a.mha", &text, "not a MetaImage file"),
    ] {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        let said = refused(path);
        let known = "known are NIfTI (.nii, .nii.gz), NRRD (.nrrd, .nhdr), MetaImage (.mha, .mhd), and a folder with a DICOM series";
        assert!(said.contains(words) && said.contains(known), "{name}: {said}");
    }
}

#[test]
fn a_hole_of_any_length_is_no_volume() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["a.nii", "a.nii.gz", "a.nrrd", "a.nhdr", "a.mha", "a.mhd", "a", "a.dcm"] {
        let path = folder.path().join(name);
        std::fs::File::create(&path).unwrap().set_len(1 << 40).unwrap();
        refused(path);
    }
    // A header of one line without end, and voxels in text without end.
    for name in ["b.nrrd", "b.mha"] {
        let path = folder.path().join(name);
        let head = headers("", false).map(|(_, head)| head);
        let head = match name {
            "b.nrrd" => head[0].replace("data file: \n", "").replace("raw", "ascii") + "\n",
            _ => head[1].replace("ElementDataFile = ", "BinaryData = False\nElementDataFile = LOCAL"),
        };
        std::fs::write(&path, head).unwrap();
        std::fs::File::options()
            .append(true)
            .open(&path)
            .unwrap()
            .set_len(1 << 40)
            .unwrap();
        let said = refused(path);
        assert!(said.contains("slice 0 has"), "{said}");
    }
}
