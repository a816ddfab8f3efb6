//! What stands in a folder beside slices: pipes, links, what nobody may read.

use std::os::unix::fs::{PermissionsExt, symlink};
use std::os::unix::net::UnixListener;

use rustix::fs::{CWD, FileType, Mode, mknodat};

use super::*;
use crate::dicom::open_path;

fn pipe(path: &Path) {
    mknodat(CWD, path, FileType::Fifo, Mode::RUSR | Mode::WUSR, 0).unwrap();
}

#[test]
fn what_is_no_file_is_left_out_by_name_and_never_waited_for() {
    let folder = Folder::of(&stack(4));
    let path = |name: &str| folder.path().join(name);
    pipe(&path("a-pipe.dcm"));
    let _socket = UnixListener::bind(path("b-socket.dcm")).unwrap();
    symlink("/dev/zero", path("c-zeros.dcm")).unwrap();
    symlink("a-pipe.dcm", path("d-link.dcm")).unwrap();
    symlink(".", path("e-circle")).unwrap();
    pipe(&path("f-pipe"));
    pipe(&path(".hidden"));
    let source = folder.open().unwrap();
    assert_eq!(source.grid().dims()[2], 4);
    let warning = &source.series_facts().warnings[0];
    for words in [
        "a-pipe.dcm (a pipe)",
        "b-socket.dcm (a socket)",
        "c-zeros.dcm (a device)",
        "d-link.dcm (a pipe)",
        "e-circle (a link to a folder)",
        " and 1 more",
    ] {
        assert!(warning.contains(words), "{words}: {warning}");
    }
    let empty = Folder::new();
    pipe(&empty.path().join("only"));
    let said = empty.refused();
    assert!(
        said.contains("no DICOM image") && said.contains("only (a pipe)"),
        "{said}"
    );
}

#[test]
fn what_may_be_a_slice_and_cannot_be_read_is_refused_by_name() {
    for (target, words) in [
        ("nowhere/slice", "lost.dcm: this is a link to a file that is not there"),
        (
            "lost.dcm",
            "lost.dcm: cannot be read: Too many levels of symbolic links",
        ),
    ] {
        let folder = Folder::of(&stack(4));
        symlink(target, folder.path().join("lost.dcm")).unwrap();
        let said = folder.refused();
        assert!(said.contains(words) && said.contains("out of the folder"), "{said}");
    }
    let folder = Folder::of(&stack(4));
    folder.put("locked", &File::slice(4, 10.0).bytes());
    let locked = folder.path().join("locked");
    std::fs::set_permissions(&locked, std::fs::Permissions::from_mode(0o000)).unwrap();
    if std::fs::File::open(&locked).is_ok() {
        println!("skipped: this user may read whatever there is");
        return;
    }
    let said = folder.refused();
    assert!(said.contains("locked: cannot be read: Permission denied"), "{said}");
}

#[test]
fn a_slice_through_a_link_is_a_slice() {
    let (elsewhere, folder) = (Folder::of(&stack(4)), Folder::new());
    for entry in std::fs::read_dir(elsewhere.path()).unwrap() {
        let entry = entry.unwrap();
        symlink(entry.path(), folder.path().join(entry.file_name())).unwrap();
    }
    assert_eq!(folder.open().unwrap().grid().dims()[2], 4);
}

#[test]
fn a_single_file_with_the_name_alone_is_no_slice() {
    let folder = Folder::new();
    folder.put("text.dcm", b"What is this? Not DICOM.");
    let error = open_path(&folder.path().join("text.dcm"), None, Options::default()).unwrap_err();
    assert!(error.to_string().contains("not a DICOM file"), "{error}");
}

#[test]
fn no_more_of_a_compressed_slice_is_read_than_a_slice_can_have() {
    // One fragment of 2 GiB in a file that is one hole.
    let mut files = stack(3);
    let mut bytes = writer::item(&[]);
    bytes.extend([0xFE, 0xFF, 0x00, 0xE0]);
    bytes.extend(0x8000_0000_u32.to_le_bytes());
    for file in &mut files {
        file.syntax = "1.2.840.10008.1.2.5".to_owned();
        file.set((0x7FE0, 0x0010), Value::Raw("OB", bytes.clone(), u32::MAX));
    }
    let folder = Folder::of(&files);
    for entry in std::fs::read_dir(folder.path()).unwrap() {
        let file = std::fs::OpenOptions::new()
            .write(true)
            .open(entry.unwrap().path())
            .unwrap();
        file.set_len(3 << 30).unwrap();
    }
    let said = folder.refused();
    assert!(
        said.contains("PixelData") && said.contains("2147483648 bytes long, expected at most 10"),
        "{said}"
    );
}
