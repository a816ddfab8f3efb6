//! Bytes of a peer that stores images (DICOM's upper layer): no file of an instance that did not come whole, none under another name than
//! its own, and no series that has its name without a release.

use std::fs;
use std::path::{Path, PathBuf};

use scene::RawPacs;
use volume_loader::receive::{Ended, Limits, Outcome, Rules, Store, serve_bytes};

use crate::{Failure, Folder};

/// Bytes of an instance and of an association: seeds are smaller.
const MOST: u64 = 1 << 16;
const CT: &str = "1.2.840.10008.5.1.4.1.1.2";
const SYNTAX: &str = "1.2.840.10008.1.2";

/// One association, and what it leaves.
pub(crate) fn association(bytes: &[u8]) {
    let Ok(folder) = Folder::new() else { return };
    let path = folder.path().join("in");
    let (Ok(pacs), Ok(store)) = (RawPacs::default().checked(), Store::open(&path)) else {
        return;
    };
    let limits = Limits {
        instance_bytes: MOST,
        association_bytes: MOST,
        instances: 100,
        free_bytes: 0,
        ..Limits::default()
    };
    let outcome = serve_bytes(bytes, &Rules { pacs, limits }, &store);
    let mut files = Vec::new();
    below(&path, &mut files);
    match &outcome {
        Some(outcome) => judged(outcome, &path, &files),
        None => assert!(files.is_empty(), "{files:?} without an association"),
    }
}

fn judged(outcome: &Outcome, folder: &Path, files: &[PathBuf]) {
    assert_eq!(files.len() as u64, outcome.stored(), "{files:?}");
    for file in files {
        let inside = file.strip_prefix(folder).unwrap_or(file);
        let is_name = |part: &str| !part.is_empty() && part.bytes().all(|b| b.is_ascii_digit() || b == b'.');
        let parts: Vec<&str> = inside.iter().filter_map(|part| part.to_str()).collect();
        let [study, series, name] = parts.as_slice() else {
            panic!("{inside:?} lies elsewhere");
        };
        let hidden = series
            .strip_prefix('.')
            .and_then(|rest| rest.strip_suffix(".incomplete"));
        assert!(is_name(study) && is_name(hidden.unwrap_or(series)), "{inside:?}");
        let name = name.strip_suffix(".dcm").unwrap_or_default();
        assert!(is_name(name), "{inside:?}");
        let is_complete = hidden.is_none();
        assert!(
            !is_complete || outcome.ended == Ended::Released,
            "{inside:?} without a release"
        );
        let content = fs::read(file).unwrap_or_default();
        let count = content
            .windows(name.len())
            .filter(|window| *window == name.as_bytes())
            .count();
        // In its File Meta Information and in its data set.
        assert!(content.get(128..132) == Some(b"DICM") && count >= 2, "{inside:?}");
    }
}

fn below(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        match path.is_dir() {
            true => below(&path, found),
            false => found.push(path),
        }
    }
}

fn item(kind: u8, content: &[u8]) -> Vec<u8> {
    let mut bytes = vec![kind, 0];
    bytes.extend((content.len() as u16).to_be_bytes());
    bytes.extend(content);
    bytes
}

fn pdu(kind: u8, content: &[u8]) -> Vec<u8> {
    let mut bytes = vec![kind, 0];
    bytes.extend((content.len() as u32).to_be_bytes());
    bytes.extend(content);
    bytes
}

fn request() -> Vec<u8> {
    let mut content = vec![0, 1, 0, 0];
    content.extend(b"TROCAR          ");
    content.extend(b"FUZZ            ");
    content.extend([0; 32]);
    content.extend(item(0x10, b"1.2.840.10008.3.1.1.1"));
    for (id, class) in [(1, CT), (3, "1.2.840.10008.1.1")] {
        let names = [item(0x30, class.as_bytes()), item(0x40, SYNTAX.as_bytes())].concat();
        content.extend(item(0x20, &[&[id, 0, 0, 0], &names[..]].concat()));
    }
    content.extend(item(0x50, &item(0x51, &[0, 0, 0x40, 0])));
    pdu(0x01, &content)
}

/// 1: a command, 0: a data set; 2: the last of it.
fn fragment(context: u8, control: u8, content: &[u8]) -> Vec<u8> {
    let mut bytes = (content.len() as u32 + 2).to_be_bytes().to_vec();
    bytes.extend([context, control]);
    bytes.extend(content);
    pdu(0x04, &bytes)
}

fn element(group: u16, number: u16, value: &[u8]) -> Vec<u8> {
    let mut bytes = [group.to_le_bytes(), number.to_le_bytes()].concat();
    bytes.extend((value.len().next_multiple_of(2) as u32).to_le_bytes());
    bytes.extend(value);
    bytes.resize(bytes.len().next_multiple_of(2), 0);
    bytes
}

fn command(field: u16, class: &str, instance: Option<&str>) -> Vec<u8> {
    let mut body = [
        element(0, 0x0002, class.as_bytes()),
        element(0, 0x0100, &field.to_le_bytes()),
        element(0, 0x0110, &[7, 0]),
        element(0, 0x0800, if instance.is_some() { &[0, 0] } else { &[1, 1] }),
    ]
    .concat();
    body.extend(instance.into_iter().flat_map(|uid| element(0, 0x1000, uid.as_bytes())));
    [element(0, 0, &(body.len() as u32).to_le_bytes()), body].concat()
}

fn instance(name: &str) -> Vec<u8> {
    let data = [
        element(0x0008, 0x0016, CT.as_bytes()),
        element(0x0008, 0x0018, name.as_bytes()),
        element(0x0020, 0x000D, b"1.2.10"),
        element(0x0020, 0x000E, b"1.2.20"),
        element(0x7FE0, 0x0010, &[1, 2, 3, 4]),
    ]
    .concat();
    let (first, second) = data.split_at(50);
    let command = fragment(1, 3, &command(1, CT, Some(name)));
    [command, fragment(1, 0, first), fragment(1, 2, second)].concat()
}

/// A verification, and series of two instances with and without a release.
pub(crate) fn seeds() -> Result<Vec<Vec<u8>>, Failure> {
    let echo = fragment(3, 3, &command(0x0030, "1.2.840.10008.1.1", None));
    let release = pdu(0x05, &[0; 4]);
    let series = [instance("1.2.31"), instance("1.2.32")].concat();
    let all = |parts: &[&[u8]]| [&[&request()[..]], parts].concat().concat();
    Ok(vec![
        all(&[&echo, &release]),
        all(&[&series, &release]),
        all(&[&echo, &series]),
        all(&[&instance("1.2.31"), &instance("1.2.31"), &release]),
        all(&[&pdu(0x07, &[0; 4])]),
    ])
}
