//! What no peer should send, and what must come of it.

use bus::message::Lost;
use igtl::{
    Body, DeviceName, Kind, Matrix, Message, Metadata, Pace, Placed, Query, Stamp, Status, TRANSFORM_STATUS, Text,
    Tool, ToolKind, US_ASCII, Version, crc,
};

/// Some day in 2026, ns.
pub(super) const DAY_NS: u64 = 1_790_000_000_000_000_000;

/// What must come of it.
#[derive(Debug)]
pub(super) enum Then {
    /// The connection ends, for this reason.
    Closes(&'static str),
    /// These words, and a good pose behind it is shown.
    GoesOn(&'static str),
    /// A frame without a pose for this reason, with these words, or `none`.
    Lost(Lost, &'static str),
    /// It cannot be told from a good pose: what the page says.
    Unseen,
}

/// A TRANSFORM of version 2 at x.
pub(super) fn transform(name: &str, matrix: Matrix, stamp_ns: u64, status: &str) -> Message<'static> {
    let mut message = Message::new(DeviceName::new(name).unwrap(), Body::Transform(matrix)).in_version(Version::Two);
    message.stamp = Stamp::of_ns(stamp_ns).unwrap();
    message.metadata = Metadata::EMPTY.with(TRANSFORM_STATUS, words(status));
    message
}

fn words(text: &str) -> Text {
    Text {
        encoding: US_ASCII,
        bytes: text.into(),
    }
}

pub(super) fn at(x: f32) -> Matrix {
    Matrix {
        translation: [x, 2.0, -1500.0],
        ..Matrix::IDENTITY
    }
}

/// Where a good pose lies, and where one that must never be shown.
pub(super) const GOOD: f32 = 10.0;
pub(super) const BAD: f32 = 666.0;

pub(super) fn bad() -> Vec<u8> {
    transform("T", at(BAD), DAY_NS, "OK").to_vec().unwrap()
}

fn stated(status: &str) -> Vec<u8> {
    transform("T", at(BAD), DAY_NS, status).to_vec().unwrap()
}

fn turned(columns: [[f32; 3]; 3]) -> Vec<u8> {
    let translation = [BAD, 2.0, -1500.0];
    transform("T", Matrix { columns, translation }, DAY_NS, "OK")
        .to_vec()
        .unwrap()
}

/// The same with other bytes in its header.
pub(super) fn header(mut bytes: Vec<u8>, at: usize, with: &[u8]) -> Vec<u8> {
    bytes[at..at + with.len()].copy_from_slice(with);
    bytes
}

/// The same with other bytes in its body, whose CRC is right.
fn body(mut bytes: Vec<u8>, at: usize, with: &[u8]) -> Vec<u8> {
    bytes[58 + at..58 + at + with.len()].copy_from_slice(with);
    sealed(bytes)
}

/// With the length and the CRC of its body.
fn sealed(mut bytes: Vec<u8>) -> Vec<u8> {
    let length = bytes.len() as u64 - 58;
    let crc = crc::crc64(&bytes[58..]);
    bytes[42..50].copy_from_slice(&length.to_be_bytes());
    bytes[50..58].copy_from_slice(&crc.to_be_bytes());
    bytes
}

/// A message of this type with this body.
fn of_type(kind: &[u8], content: &[u8]) -> Vec<u8> {
    let mut head = vec![0; 58];
    head[1] = 1;
    head[2..2 + kind.len()].copy_from_slice(kind);
    sealed([&head, content].concat())
}

fn list(tools: Vec<Tool<Matrix>>, statuses: &[(&str, &str)]) -> Vec<u8> {
    let mut message = Message::new(DeviceName::EMPTY, Body::Tdata(tools)).in_version(Version::Two);
    message.stamp = Stamp::of_ns(DAY_NS).unwrap();
    for (key, status) in statuses {
        message.metadata = message.metadata.with(key, words(status));
    }
    message.to_vec().unwrap()
}

fn of_list(name: &str) -> Tool<Matrix> {
    Tool {
        name: DeviceName::new(name).unwrap(),
        kind: ToolKind::Six,
        pose: at(BAD),
    }
}

fn query(query: Query) -> Vec<u8> {
    Message::new(DeviceName::EMPTY, Body::Query(query)).to_vec().unwrap()
}

fn repeated(count: usize) -> Vec<u8> {
    let one = list(vec![of_list("A")], &[]);
    let tool = &one[58 + 12..58 + 12 + 70];
    of_type(b"TDATA", &tool.repeat(count))
}

/// A metadata index with one entry that says other sizes than it has; behind the content of a TRANSFORM.
fn metadata(at: usize, with: &[u8]) -> Vec<u8> {
    // Extended header 12, matrix 48, then the index: count 2, key 2, encoding 2, value 4.
    body(bad(), 60 + at, with)
}

pub(super) fn headers() -> Vec<(&'static str, Vec<u8>, Then)> {
    use Then::{Closes, GoesOn};
    vec![
        ("version 0", header(bad(), 0, &[0, 0]), Closes("header version 0")),
        ("version 3", header(bad(), 0, &[0, 3]), Closes("header version 3")),
        (
            "version 65535",
            header(bad(), 0, &[255; 2]),
            Closes("header version 65535"),
        ),
        (
            "body 2^31",
            header(bad(), 42, &(1_u64 << 31).to_be_bytes()),
            Closes("a body of 2147483648 bytes"),
        ),
        (
            "body 2^40",
            header(bad(), 42, &(1_u64 << 40).to_be_bytes()),
            Closes("a body of 1099511627776 bytes"),
        ),
        (
            "body 2^63",
            header(bad(), 42, &(1_u64 << 63).to_be_bytes()),
            Closes("a body of 9223372036854775808 bytes"),
        ),
        (
            "CRC 0",
            header(bad(), 50, &[0; 8]),
            GoesOn("its header says 0000000000000000"),
        ),
        (
            "CRC wrong",
            body(bad(), 20, &[9]).into_iter().rev().collect(),
            Closes("header version"),
        ),
        (
            "damaged body",
            header(bad(), 58 + 20, &[0x7f]),
            GoesOn("the body has CRC"),
        ),
        (
            "type not ASCII",
            header(bad(), 2, &[0xC3]),
            Closes("byte 0xc3 in the name of the type"),
        ),
        (
            "type not terminated",
            of_type(b"ABCDEFGHIJKL", &[]),
            GoesOn("a message of type ABCDEFGHIJKL was skipped"),
        ),
        (
            "name with a line feed",
            header(bad(), 14, b"T\n"),
            GoesOn("byte 0x0a in the device's name"),
        ),
        (
            "name with an escape",
            header(bad(), 14, b"\x1b[2J"),
            GoesOn("byte 0x1b in the device's name"),
        ),
        (
            "name of 20 bytes",
            header(bad(), 14, &[b'T'; 20]),
            GoesOn("the peer sends TTTTTTTTTTTTTTTTTTTT, which"),
        ),
        (
            "name with a slash",
            header(bad(), 14, b"T/.."),
            GoesOn("the peer sends T/.., which"),
        ),
        (
            "no name",
            header(bad(), 14, &[0]),
            GoesOn("the peer sends , which the scene does not name"),
        ),
        (
            "HTTP",
            b"HTTP/1.1 400 Bad Request\r\nServer: x\r\n\r\nand a body that is long enough for it".to_vec(),
            Closes("HTTP"),
        ),
        (
            "TLS",
            [&[0x16, 3, 1, 2, 0, 1, 0, 1, 0xfc, 3, 3][..], &[7; 80]].concat(),
            Closes("TLS"),
        ),
        ("1 MiB of status", stated_long(), Closes("allowed are 65536")),
    ]
}

fn stated_long() -> Vec<u8> {
    stated(&"O".repeat(1 << 20))
}

pub(super) fn contents() -> Vec<(&'static str, Vec<u8>, Then)> {
    use Then::{GoesOn, Lost as No, Unseen};
    let diagonal = |x: f32, y: f32, z: f32| turned([[x, 0.0, 0.0], [0.0, y, 0.0], [0.0, 0.0, z]]);
    let short = of_type(b"TRANSFORM", &[0; 47]);
    let one = |name: &str| list(vec![of_list(name)], &[("TStatus", "OK")]);
    let twice = [of_list("T"), of_list("T")]
        .map(|tool| list(vec![tool], &[])[70..140].to_vec())
        .concat();
    let cell = [0_u8; 72];
    vec![
        ("47 bytes of a matrix", short, GoesOn("a content of 47 bytes")),
        (
            "extended header of 0",
            body(bad(), 0, &[0, 0]),
            GoesOn("an extended header of 0 bytes"),
        ),
        (
            "extended header of 11",
            body(bad(), 0, &[0, 11]),
            GoesOn("an extended header of 11 bytes"),
        ),
        (
            "extended header of 60000",
            body(bad(), 0, &[0xEA, 0x60]),
            GoesOn("an extended header of 60000 bytes"),
        ),
        ("65535 keys", metadata(0, &[255; 2]), GoesOn("metadata")),
        (
            "value past the end",
            metadata(6, &[0, 0, 9, 9]),
            GoesOn("keys and values of"),
        ),
        ("key not ASCII", metadata(10, &[0xC3]), GoesOn("key")),
        (
            "ok",
            stated("ok"),
            No(Lost::Refused, "the peer states \"ok\", which is not OK"),
        ),
        (
            "Ok with a space",
            stated("Ok "),
            No(Lost::Refused, "the peer states \"Ok \", which is not OK"),
        ),
        (
            "an empty status",
            stated(""),
            No(Lost::Refused, "the peer states \"\", which is not OK"),
        ),
        (
            "an escape as status",
            stated("\x1b[2J"),
            No(Lost::Refused, "the peer states"),
        ),
        ("MISSING", stated("MISSING"), No(Lost::NotSeen, "none")),
        ("NaN", body(bad(), 12, &f32::NAN.to_be_bytes()), GoesOn("NaN in")),
        ("zeros", diagonal(0.0, 0.0, 0.0), No(Lost::Refused, "T: ")),
        ("metres", diagonal(1000.0, 1000.0, 1000.0), No(Lost::Refused, "T: ")),
        ("a reflection", diagonal(1.0, 1.0, -1.0), No(Lost::Refused, "T: ")),
        (
            "transposed",
            turned([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]),
            Unseen,
        ),
        ("no tool", list(Vec::new(), &[]), No(Lost::NotSeen, "none")),
        (
            "69 bytes of a tool",
            of_type(b"TDATA", &[0; 69]),
            GoesOn("a content of 69 bytes"),
        ),
        ("10 000 tools", repeated(10_000), Then::Closes("a body of 700000 bytes")),
        (
            "900 tools of one name",
            repeated(900),
            GoesOn("twice; each may stand once"),
        ),
        (
            "one tool twice",
            of_type(b"TDATA", &twice),
            GoesOn("the tool \"T\" twice"),
        ),
        (
            "another tool alone",
            one("A"),
            No(Lost::NotSeen, "the peer sends A, which the scene does not name"),
        ),
        ("zero quaternion", zero_quaternion(), No(Lost::Refused, "T: ")),
        (
            "IMAGE of no voxel",
            of_type(b"IMAGE", &[&[0, 1, 1, 3, 1, 1][..], &cell[6..]].concat()),
            GoesOn("IMAGE"),
        ),
        (
            "an answer first",
            query(Query::Answer(Kind::Tdata, 0)),
            GoesOn("an answer for TDATA that nothing waits for"),
        ),
        (
            "STT",
            query(Query::Start(Kind::Tdata, pace(0))),
            GoesOn("a message of type STT_TDATA was skipped"),
        ),
        (
            "STT of 2^32 - 1",
            query(Query::Start(Kind::Tdata, pace(u32::MAX))),
            GoesOn("type STT_TDATA was skipped"),
        ),
        (
            "STP",
            query(Query::Stop(Kind::Tdata)),
            GoesOn("a message of type STP_TDATA was skipped"),
        ),
        (
            "words that steer",
            status(b"\x1b[2Jgone"),
            GoesOn("the peer's STATUS is 13 : \\u{1b}[2Jgone"),
        ),
        (
            "two tools of one name",
            two(),
            No(Lost::Refused, "two tools with one name have no pose"),
        ),
        (
            "no status after one",
            unstated(),
            No(Lost::Refused, "the peer states no status"),
        ),
    ]
}

fn pace(resolution_ms: u32) -> Pace {
    Pace {
        resolution_ms,
        frame: igtl::Name::EMPTY,
    }
}

fn status(text: &[u8]) -> Vec<u8> {
    let mut status = Status::new(13, "");
    status.words = text.to_vec();
    Message::new(DeviceName::EMPTY, Body::Status(status)).to_vec().unwrap()
}

/// Two at one time.
fn two() -> Vec<u8> {
    [at(GOOD), at(BAD)]
        .map(|matrix| transform("T", matrix, DAY_NS + 77, "OK").to_vec().unwrap())
        .concat()
}

/// Version 1 behind version 2.
fn unstated() -> Vec<u8> {
    Message::new(DeviceName::new("T").unwrap(), Body::Transform(at(BAD)))
        .to_vec()
        .unwrap()
}

fn zero_quaternion() -> Vec<u8> {
    let tool = Tool {
        name: DeviceName::new("T").unwrap(),
        kind: ToolKind::Six,
        pose: Placed {
            place: [BAD, 0.0, -1500.0],
            quaternion: [0.0; 4],
        },
    };
    let mut message = Message::new(DeviceName::EMPTY, Body::Qtdata(vec![tool])).in_version(Version::Two);
    message.metadata = Metadata::EMPTY.with("TStatus", words("OK"));
    message.to_vec().unwrap()
}
