//! All groups of MCAP's own conformance tests, put together as its generator does
//! (<https://github.com/foxglove/mcap>, `tests/conformance`, MIT, Foxglove Technologies): the same inputs, each with every sensible
//! combination of features. The bytes were held against the SHA-256 of the files that are published at commit
//! 95d0673564eac0b27fd9a8616083fdd47c4c2ec7, all 416 of them; `SUMS` holds them since.

mod bytes;

use std::collections::BTreeMap;

pub(crate) use bytes::crc32;
use bytes::{File, map, record, text, u64s};

/// What a file of a group has beside its records, by the names of the published files.
const FEATURES: [&str; 10] = ["ch", "mx", "st", "rsh", "rch", "ax", "mdx", "chx", "sum", "pad"];
/// CRC-32 over each group's files, one after the other in the order of their names, and how many there are.
pub(crate) const SUMS: [(&str, u32, usize); 6] = [
    ("NoData", 0x8aff_7885, 6),
    ("OneAttachment", 0xab65_4689, 14),
    ("OneMessage", 0x3b48_477d, 154),
    ("OneMetadata", 0x9312_31b0, 14),
    ("OneSchemalessMessage", 0x9b37_e079, 74),
    ("TenMessages", 0xb857_380d, 154),
];

/// A record of the data section.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Record {
    Schema,
    /// With a schema or without.
    Channel(bool),
    /// Times of log and publication, and number.
    Message(u64, u64, u32),
    Attachment,
    Metadata,
}

impl Record {
    fn opcode(self) -> u8 {
        match self {
            Self::Schema => 3,
            Self::Channel(_) => 4,
            Self::Message(..) => 5,
            Self::Attachment => 9,
            Self::Metadata => 12,
        }
    }

    fn body(self) -> Vec<u8> {
        match self {
            Self::Schema => [&[1, 0][..], &text("Example"), &text("c"), &[3, 0, 0, 0, 4, 5, 6]].concat(),
            Self::Channel(true) => [&[1, 0, 1, 0][..], &text("example"), &text("a"), &map(&[("foo", "bar")])].concat(),
            Self::Channel(false) => [&[1, 0, 0, 0][..], &text("example"), &text("text"), &map(&[])].concat(),
            Self::Message(log, publish, sequence) => {
                [&[1, 0][..], &sequence.to_le_bytes(), &u64s(&[log, publish]), &[1, 2, 3]].concat()
            }
            Self::Attachment => {
                let names = [text("myFile"), text("application/octet-stream")].concat();
                let body = [&u64s(&[2, 1])[..], &names, &u64s(&[3]), &[1, 2, 3]].concat();
                [&body[..], &crc32(&body).to_le_bytes()].concat()
            }
            Self::Metadata => [text("myMetadata"), map(&[("foo", "bar")])].concat(),
        }
    }
}

fn input(group: &str) -> Vec<Record> {
    let times = [0, 2, 1, 3, 3, 5, 4, 7, 8, 9];
    let ten = times
        .into_iter()
        .zip(0..)
        .map(|(time, number)| Record::Message(time, time, number));
    match group {
        "OneAttachment" => vec![Record::Attachment],
        "OneMetadata" => vec![Record::Metadata],
        "OneMessage" => vec![Record::Schema, Record::Channel(true), Record::Message(2, 1, 10)],
        "OneSchemalessMessage" => vec![Record::Channel(false), Record::Message(2, 1, 10)],
        "TenMessages" => [Record::Schema, Record::Channel(true)].into_iter().chain(ten).collect(),
        _ => Vec::new(),
    }
}

/// Whether a combination makes sense for these records.
fn is_sensible(features: &[&str], records: &[Record]) -> bool {
    let has = |feature: &str| features.contains(&feature);
    let any = |of: fn(&Record) -> bool| records.iter().any(of);
    let chunked = any(|r| matches!(r, Record::Schema | Record::Channel(_) | Record::Message(..)));
    let summed = ["chx", "rsh", "rch", "mdx", "ax", "st"]
        .iter()
        .any(|feature| has(feature));
    (!has("ax") || any(|r| *r == Record::Attachment))
        && (!has("mdx") || any(|r| *r == Record::Metadata))
        && (!has("rsh") || any(|r| *r == Record::Schema))
        && (!has("rch") || any(|r| matches!(r, Record::Channel(_))))
        && (chunked || !(has("ch") || has("chx") || has("mx")))
        && (!has("sum") || summed)
        && (has("ch") || !(has("chx") || has("mx")))
}

/// A file: its name, its features, the records that are in it, and its bytes.
pub(crate) struct Made {
    pub(crate) name: String,
    pub(crate) features: Vec<&'static str>,
    pub(crate) records: Vec<Record>,
    pub(crate) bytes: Vec<u8>,
}

/// The files of a group, in the order of their names.
pub(crate) fn group(name: &str) -> Vec<Made> {
    let records = input(name);
    let mut files = Vec::new();
    for bits in 0..1 << FEATURES.len() {
        let chosen = FEATURES.iter().zip(0..).filter(|(_, bit)| bits >> bit & 1 == 1);
        let mut features: Vec<&str> = chosen.map(|(feature, _)| *feature).collect();
        if !is_sensible(&features, &records) {
            continue;
        }
        features.sort_unstable();
        let parts: Vec<&str> = [name].into_iter().chain(features.iter().copied()).collect();
        files.push(Made {
            name: parts.join("-"),
            bytes: made(&features, &records),
            records: records.clone(),
            features,
        });
    }
    files.sort_by(|a, b| a.name.cmp(&b.name));
    files
}

/// Whether these go into a chunk where there is one.
fn in_chunk(record: Record) -> bool {
    !matches!(record, Record::Attachment | Record::Metadata)
}

fn made(features: &[&str], records: &[Record]) -> Vec<u8> {
    let has = |feature: &str| features.contains(&feature);
    let mut file = File::new(has("pad"));
    let mut indexes: BTreeMap<u8, Vec<u8>> = BTreeMap::new();
    for &each in records.iter().filter(|each| !(has("ch") && in_chunk(**each))) {
        let at = file.length();
        file.put(each.opcode(), &each.body());
        let length = file.length() - at;
        if each == Record::Attachment && has("ax") {
            let names = [text("myFile"), text("application/octet-stream")].concat();
            indexes.insert(10, [u64s(&[at, length, 2, 1, 3]), names].concat());
        } else if each == Record::Metadata && has("mdx") {
            indexes.insert(13, [u64s(&[at, length]), text("myMetadata")].concat());
        }
    }
    if has("ch") {
        let index = chunk(&mut file, records, has("mx"));
        if has("chx") {
            indexes.insert(8, index);
        }
    }
    file.end_data();
    let only = |of: fn(&Record) -> bool| -> Vec<(u8, Vec<u8>)> {
        let chosen = records.iter().filter(|each| of(each));
        chosen.map(|each| (each.opcode(), each.body())).collect()
    };
    let mut groups = Vec::new();
    if has("rsh") {
        groups.push(only(|each| *each == Record::Schema));
    }
    if has("rch") {
        groups.push(only(|each| matches!(each, Record::Channel(_))));
    }
    if has("st") {
        groups.push(vec![(11, statistics(records, has("ch")))]);
    }
    for opcode in [13, 10, 8] {
        groups.extend(indexes.remove(&opcode).map(|body| vec![(opcode, body)]));
    }
    file.finish(&groups, has("sum"))
}

/// One chunk of everything, and the list of its messages; gives its index.
fn chunk(file: &mut File, records: &[Record], listed: bool) -> Vec<u8> {
    let (mut content, mut list, mut times) = (Vec::new(), Vec::new(), Vec::new());
    for &each in records {
        if let Record::Message(log, ..) = each {
            list.extend(u64s(&[log, content.len() as u64]));
            times.push(log);
        }
        content.extend(record(each.opcode(), &each.body()));
    }
    let span = [times.iter().min(), times.iter().max()].map(|time| time.copied().unwrap_or(0));
    let (at, size) = (file.length(), content.len() as u64);
    let body = [
        &u64s(&[span[0], span[1], size])[..],
        &crc32(&content).to_le_bytes(),
        &text(""),
        &u64s(&[size]),
        &content,
    ];
    file.put_bare(6, &body.concat());
    let (length, behind) = (file.length() - at, file.length());
    let mut places = Vec::new();
    if listed {
        file.put(7, &[&[1, 0][..], &(list.len() as u32).to_le_bytes(), &list].concat());
        places.extend([1, 0]);
        places.extend(u64s(&[behind]));
    }
    let lists = file.length() - behind;
    [
        &u64s(&[span[0], span[1], at, length])[..],
        &(places.len() as u32).to_le_bytes(),
        &places,
        &u64s(&[lists]),
        &text(""),
        &u64s(&[size, size]),
    ]
    .concat()
}

fn statistics(records: &[Record], chunked: bool) -> Vec<u8> {
    let count = |of: fn(&Record) -> bool| records.iter().filter(|each| of(each)).count() as u32;
    let messages = count(|each| matches!(each, Record::Message(..)));
    let times = records.iter().filter_map(|each| match each {
        Record::Message(log, ..) => Some(*log),
        _ => None,
    });
    let counts = match messages {
        0 => Vec::new(),
        _ => [&[1, 0][..], &u64s(&[messages.into()])].concat(),
    };
    let schemas = count(|each| *each == Record::Schema) as u16;
    let others = [
        count(|each| matches!(each, Record::Channel(_))),
        count(|each| *each == Record::Attachment),
        count(|each| *each == Record::Metadata),
        u32::from(chunked),
    ];
    [
        &u64s(&[messages.into()])[..],
        &schemas.to_le_bytes(),
        &others.map(u32::to_le_bytes).concat(),
        &u64s(&[times.clone().min().unwrap_or(0), times.max().unwrap_or(0)]),
        &(counts.len() as u32).to_le_bytes(),
        &counts,
    ]
    .concat()
}
