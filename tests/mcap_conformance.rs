//! The reader opens every file of MCAP's own conformance tests, and finds in it what its description says.

#![allow(clippy::print_stdout, reason = "what was skipped or made by hand, and why")]
#![allow(clippy::unwrap_used, reason = "a step that fails here is a test that fails")]

mod support;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use recorder::scan::{self, Item};
use recorder::seek::Session;
use serde_json::Value;

/// The `.mcap` files below a folder.
fn files(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(files(&path));
        } else if path.extension().is_some_and(|extension| extension == "mcap") {
            found.push(path);
        }
    }
    found.sort();
    found
}

/// The records of the data section that carry something: kind and fields.
fn described(path: &Path) -> Vec<(String, BTreeMap<String, Value>)> {
    let description: Value = serde_json::from_slice(&fs::read(path.with_extension("json")).unwrap()).unwrap();
    let records = description["records"].as_array().unwrap();
    let data = records.iter().take_while(|record| record["type"] != "DataEnd");
    let carrying = data.filter(|record| {
        ["Message", "Attachment", "Metadata"]
            .iter()
            .any(|kind| record["type"] == *kind)
    });
    let fields = |record: &Value| -> BTreeMap<String, Value> {
        let pairs = record["fields"].as_array().unwrap().iter();
        pairs
            .map(|pair| (pair[0].as_str().unwrap().to_owned(), pair[1].clone()))
            .collect()
    };
    carrying
        .map(|record| (record["type"].as_str().unwrap().to_owned(), fields(record)))
        .collect()
}

/// Bytes and numbers are text in the descriptions.
fn bytes(data: &[u8]) -> Value {
    Value::from(data.iter().map(ToString::to_string).collect::<Vec<_>>())
}

fn hold(path: &Path, kind: &str, fields: &BTreeMap<String, Value>, pairs: &[(&str, Value)]) {
    for (name, found) in pairs {
        assert_eq!(&fields[*name], found, "{}: {name} of a {kind}", path.display());
    }
}

fn check(path: &Path) {
    let mut expected = described(path).into_iter();
    for item in scan::open(path).unwrap() {
        let item = item.unwrap_or_else(|damage| panic!("{}: {damage}", path.display()));
        let (kind, pairs) = match item {
            Item::Channel(_) => continue,
            Item::Message(m) => (
                "Message",
                vec![
                    ("data", bytes(&m.data)),
                    ("channel_id", m.channel.id.to_string().into()),
                    ("log_time", m.log_time.to_string().into()),
                    ("publish_time", m.publish_time.to_string().into()),
                    ("sequence", m.sequence.to_string().into()),
                ],
            ),
            Item::Attachment(a) => (
                "Attachment",
                vec![
                    ("data", bytes(&a.data)),
                    ("name", a.name.into()),
                    ("media_type", a.media_type.into()),
                    ("log_time", a.log_time.to_string().into()),
                    ("create_time", a.create_time.to_string().into()),
                ],
            ),
            Item::Metadata(m) => (
                "Metadata",
                vec![("name", m.name.into()), ("metadata", serde_json::json!(m.metadata))],
            ),
        };
        let (expected_kind, fields) = expected
            .next()
            .unwrap_or_else(|| panic!("{}: one more {kind}", path.display()));
        assert_eq!(kind, expected_kind, "{}", path.display());
        hold(path, kind, &fields, &pairs);
    }
    assert_eq!(expected.next(), None, "{}", path.display());
    // From the index, or by walking: every message is found.
    let messages = described(path).iter().filter(|(kind, _)| kind == "Message").count();
    let items = Session::open(path).unwrap().items_from(0).unwrap();
    let found = items.filter(|item| matches!(item, Ok(Item::Message(_)))).count();
    assert_eq!(found, messages, "{} from its index", path.display());
}

/// The files themselves: where only Git LFS pointers are there, those that Python puts together and checks by their hashes.
#[expect(
    clippy::disallowed_methods,
    reason = "the bytes are made by another program than the one tested"
)]
fn real(folder: PathBuf, made: &Path) -> Option<PathBuf> {
    let is_pointer = |path: &PathBuf| fs::read(path).unwrap().starts_with(b"version https://git-lfs");
    if !files(&folder).iter().any(is_pointer) {
        return Some(folder);
    }
    println!("{} holds Git LFS pointers", folder.display());
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/python/check_mcap_conformance.py");
    let output = Command::new(support::python()?)
        .arg(script)
        .arg(folder)
        .arg(made)
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", support::stderr(&output));
    Some(made.to_owned())
}

#[test]
fn every_file_of_the_conformance_tests_is_read() {
    let Some(folder) = support::shared("data/mcap-conformance") else {
        return;
    };
    let tmp = tempfile::tempdir().unwrap();
    let Some(folder) = real(folder, tmp.path()) else {
        return;
    };
    let files = files(&folder);
    assert!(files.len() > 100, "only {} files", files.len());
    files.iter().for_each(|path| check(path));
    println!("{} files read", files.len());
}
