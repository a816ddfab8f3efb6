//! Messages to begin with, and what is done to their bytes.

use std::path::{Path, PathBuf};

use igtl::{Body, Decoder, DeviceName, Limits, Malformed, Matrix, Message, Stamp, Text, Version, crc::crc64};

/// The golden messages by name; empty, with the reason printed, where they are not to be had.
pub(crate) fn golden() -> Vec<(String, Vec<u8>)> {
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared");
    let path = std::env::var_os("TROCAR_SHARED")
        .map_or(beside, PathBuf::from)
        .join("data/openigtlink-vectors/upstream-fixtures.json");
    if !path.exists() {
        println!(
            "skipped: {} is not there (set TROCAR_SHARED to the folder that holds it)",
            path.display()
        );
        return Vec::new();
    }
    let file: serde_json::Value = serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap();
    let all = file["fixtures"].as_object().unwrap();
    all.iter()
        .map(|(name, one)| (name.clone(), unhexed(one["wire_hex"].as_str().unwrap())))
        .collect()
}

fn unhexed(hex: &str) -> Vec<u8> {
    let pairs = hex.as_bytes().as_chunks::<2>().0.iter();
    let one = |pair: &[u8; 2]| u8::from_str_radix(std::str::from_utf8(pair).unwrap(), 16).unwrap();
    pairs.map(one).collect()
}

pub(crate) fn name<const N: usize>(text: &str) -> igtl::Name<N> {
    igtl::Name::new(text).unwrap()
}

/// A TRANSFORM of version 2 with a status.
pub(crate) fn transform() -> Message<'static> {
    let matrix = Matrix {
        translation: [1.5, -2.0, 300.25],
        ..Matrix::IDENTITY
    };
    let mut message = Message::new(name("StylusToTracker"), Body::Transform(matrix));
    message.version = Version::Two;
    message.stamp = Stamp::of_ns(1_700_000_000_123_456_789).unwrap();
    message.number = 7;
    message.metadata = igtl::Metadata::EMPTY.with("TransformStatus", Text::new("OK"));
    message
}

/// A message of version 1 as a sender makes it who follows no rule but that of the CRC.
pub(crate) fn raw(kind: &str, content: &[u8]) -> Vec<u8> {
    framed(1, kind.as_bytes(), b"Device", content)
}

pub(crate) fn framed(version: u16, kind: &[u8], device: &[u8], body: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::from(version.to_be_bytes());
    bytes.extend(kind);
    bytes.resize(14, 0);
    bytes.extend(device);
    bytes.resize(34, 0);
    bytes.extend(0x4996_02d4_0000_0000_u64.to_be_bytes());
    bytes.extend((body.len() as u64).to_be_bytes());
    bytes.extend(crc64(body).to_be_bytes());
    bytes.extend(body);
    bytes
}

/// A body of version 2: extended header of these numbers, content, index and values.
pub(crate) fn extended(sizes: (u16, u16, u32), content: &[u8], index: &[u8], values: &[u8]) -> Vec<u8> {
    let mut body = Vec::from(sizes.0.to_be_bytes());
    body.extend(sizes.1.to_be_bytes());
    body.extend(sizes.2.to_be_bytes());
    body.extend(7_u32.to_be_bytes());
    [&body[..], content, index, values].concat()
}

/// The error of these bytes, which must be the same in one piece and byte by byte.
pub(crate) fn refused(bytes: &[u8]) -> Malformed {
    let whole = igtl::decode(bytes, &Limits::default()).unwrap_err();
    let mut decoder = Decoder::new(Limits::default());
    let mut found = None;
    for byte in bytes {
        if let Some(result) = decoder.feed(&mut std::slice::from_ref(byte)) {
            found = Some(result.unwrap_err());
            break;
        }
    }
    assert_eq!(found.or_else(|| decoder.end()).as_ref(), Some(&whole));
    whole
}

/// Everything that a stream says, handed over in pieces of these lengths, over and over; ends with an error that closes
/// it.
pub(crate) fn stream(bytes: &[u8], pieces: &[usize], limits: Limits) -> Vec<Result<Message<'static>, Malformed>> {
    let mut decoder = Decoder::new(limits);
    let (mut said, mut rest) = (Vec::new(), bytes);
    for length in pieces.iter().cycle() {
        let (now, later) = rest.split_at((*length).min(rest.len()));
        let mut now = now;
        while let Some(result) = decoder.feed(&mut now) {
            let closes = matches!(&result, Err(e) if e.recovery == igtl::Recovery::Close);
            said.push(result.map(Message::into_owned));
            if closes {
                return said;
            }
        }
        rest = later;
        if rest.is_empty() {
            break;
        }
    }
    said.extend(decoder.end().map(Err));
    said
}

/// A device that has a name.
pub(crate) fn device() -> DeviceName {
    name("Device")
}
