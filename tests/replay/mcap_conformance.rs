//! The reader opens every file of MCAP's own conformance tests, and finds in it what its description says; `recorder verify` finds
//! nothing wrong with any of them.

#![allow(clippy::print_stdout, reason = "what was skipped or made by hand, and why")]

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::mcap_groups::{Made, Record, SUMS, crc32, group};
use recorder::read::scan::{self, Item};
use recorder::read::seek::Session;
use recorder::read::verify::verify;
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

/// A record's kind and fields.
type Described = (String, BTreeMap<String, Value>);

/// The records of the data section that carry something.
fn described(path: &Path) -> Vec<Described> {
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

fn check(path: &Path, described: &[Described]) {
    let mut expected = described.iter();
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
        hold(path, kind, fields, &pairs);
    }
    assert_eq!(expected.next(), None, "{}", path.display());
    // From the index, or by walking: every message is found.
    let messages = described.iter().filter(|(kind, _)| kind == "Message").count();
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
    let output = Command::new(crate::support::python()?)
        .arg(script)
        .arg(folder)
        .arg(made)
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", crate::support::stderr(&output));
    Some(made.to_owned())
}

#[test]
fn every_file_of_the_conformance_tests_is_read() {
    let Some(folder) = crate::support::shared("data/mcap-conformance") else {
        return;
    };
    let tmp = tempfile::tempdir().unwrap();
    let Some(folder) = real(folder, tmp.path()) else {
        return;
    };
    let files = files(&folder);
    assert!(files.len() > 100, "only {} files", files.len());
    for path in &files {
        check(path, &described(path));
        let verified = verify(path).unwrap();
        assert_eq!(verified.found, 0, "{}: {:?}", path.display(), verified.findings);
    }
    println!("{} files read", files.len());
}

/// What the scan must find of a record; `None` for those that carry nothing.
fn carried(record: Record) -> Option<Described> {
    let data = ("data", bytes(&[1, 2, 3]));
    let (kind, fields) = match record {
        Record::Schema | Record::Channel(_) => return None,
        Record::Message(log, publish, sequence) => (
            "Message",
            vec![
                data,
                ("channel_id", "1".into()),
                ("log_time", log.to_string().into()),
                ("publish_time", publish.to_string().into()),
                ("sequence", sequence.to_string().into()),
            ],
        ),
        Record::Attachment => (
            "Attachment",
            vec![
                data,
                ("name", "myFile".into()),
                ("media_type", "application/octet-stream".into()),
                ("log_time", "2".into()),
                ("create_time", "1".into()),
            ],
        ),
        Record::Metadata => (
            "Metadata",
            vec![
                ("name", "myMetadata".into()),
                ("metadata", serde_json::json!({"foo": "bar"})),
            ],
        ),
    };
    let fields = fields.into_iter().map(|(name, value)| (name.to_owned(), value));
    Some((kind.to_owned(), fields.collect()))
}

/// What `verify` must say that a file leaves out, by the features in its name.
fn left_out(file: &Made) -> Vec<&'static str> {
    let has = |feature: &str| file.features.contains(&feature);
    let summary = ["chx", "rsh", "rch", "mdx", "ax", "st"];
    if !summary.iter().any(|feature| has(feature)) {
        return vec!["it has no index"];
    }
    let holds = |record: Record| file.records.contains(&record);
    [
        (
            "its index repeats channels without their schemas",
            has("rch") && !has("rsh") && holds(Record::Schema),
        ),
        ("its index counts nothing", !has("st")),
        ("its index lists none of its 1 chunks", has("ch") && !has("chx")),
        (
            "its index lists none of its 1 attachments",
            holds(Record::Attachment) && !has("ax"),
        ),
        (
            "its index lists none of its 1 metadata records",
            holds(Record::Metadata) && !has("mdx"),
        ),
    ]
    .into_iter()
    .filter(|(_, is)| *is)
    .map(|(words, _)| words)
    .collect()
}

#[test]
fn every_group_of_the_conformance_tests_is_read_and_whole() {
    let tmp = tempfile::tempdir().unwrap();
    let mut count = 0;
    for (name, sum, files) in SUMS {
        let made = group(name);
        let all: Vec<u8> = made.iter().flat_map(|file| file.bytes.clone()).collect();
        assert_eq!(
            (crc32(&all), made.len()),
            (sum, files),
            "{name}: not the published bytes"
        );
        for file in made {
            let path = tmp.path().join(format!("{}.mcap", file.name));
            fs::write(&path, &file.bytes).unwrap();
            let expected: Vec<Described> = file.records.iter().filter_map(|record| carried(*record)).collect();
            check(&path, &expected);
            let verified = verify(&path).unwrap();
            assert_eq!(verified.found, 0, "{}: {:?}", file.name, verified.findings);
            assert_eq!(verified.left_out, left_out(&file), "{}", file.name);
            count += 1;
        }
    }
    println!("{count} files read and whole");
}

#[test]
fn a_flipped_bit_in_every_byte_is_found_with_and_without_an_index() {
    let tmp = tempfile::tempdir().unwrap();
    let path = tmp.path().join("flipped.mcap");
    for name in [
        "OneMessage",
        "OneMessage-ch-chx-mx-rch-rsh-st-sum",
        "OneAttachment-ax-pad",
        "TenMessages-ch",
    ] {
        let kind = name.split('-').next().unwrap();
        let file = group(kind).into_iter().find(|file| file.name == name).unwrap();
        for at in 0..file.bytes.len() {
            let mut bytes = file.bytes.clone();
            bytes[at] ^= 1 << (at % 8);
            fs::write(&path, &bytes).unwrap();
            let is_found = verify(&path).map_or(true, |verified| verified.found > 0);
            assert!(is_found, "{name}: bit {} of byte {at}", at % 8);
        }
    }
}
