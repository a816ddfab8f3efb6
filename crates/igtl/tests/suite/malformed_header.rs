//! Headers, extended headers and metadata that are wrong, each refused by name.

use igtl::{Fault, Limits, MOST_BODY, Recovery, Text, decode};

use crate::support::{device, extended, framed, name, raw, refused, transform};

const MATRIX: [u8; 48] = [0; 48];

fn version_two(sizes: (u16, u16, u32), index: &[u8], values: &[u8]) -> Vec<u8> {
    framed(2, b"TRANSFORM", b"Device", &extended(sizes, &MATRIX, index, values))
}

/// An index of entries, each of lengths of key and value.
fn index(entries: &[(u16, u32)]) -> Vec<u8> {
    let mut index = Vec::from((entries.len() as u16).to_be_bytes());
    for (key, value) in entries {
        index.extend(key.to_be_bytes());
        index.extend(3_u16.to_be_bytes());
        index.extend(value.to_be_bytes());
    }
    index
}

fn with_metadata(entries: &[(u16, u32)], values: &[u8]) -> Vec<u8> {
    let index = index(entries);
    version_two((12, index.len() as u16, values.len() as u32), &index, values)
}

#[test]
fn a_header_of_57_bytes_is_no_header() {
    let error = refused(&raw("TRANSFORM", &MATRIX)[..57]);
    assert_eq!(
        (error.fault, error.at),
        (Fault::Truncated { found: 57, needed: 58 }, 57)
    );
}

#[test]
fn other_versions_close_the_stream() {
    for found in [0, 3, 65535] {
        let error = refused(&framed(found, b"TRANSFORM", b"", &MATRIX));
        assert_eq!(error.fault, Fault::Version { found });
        assert_eq!((error.at, error.recovery), (0, Recovery::Close));
        assert!(error.to_string().contains("allowed are 1 and 2"), "{error}");
    }
}

#[test]
fn other_protocols_are_named_by_their_first_bytes() {
    for (bytes, protocol) in [
        (&b"GET / HTTP/1.1\r\n\r\n"[..], "HTTP"),
        (&[0x16, 3, 1, 2, 0, 1, 0][..], "TLS"),
        (b"SSH-2.0-OpenSSH_9.2\r\n", "SSH"),
    ] {
        let error = refused(bytes);
        assert_eq!(error.fault, Fault::Protocol(protocol));
        assert_eq!(error.recovery, Recovery::Close);
        assert!(error.advice().is_some());
    }
}

#[test]
fn a_body_beyond_the_limit_is_refused_before_it_comes() {
    for body in [1_u64 << 31, 1 << 40, 1 << 63, u64::MAX, (512 << 20) + 1] {
        let mut bytes = raw("TRANSFORM", &[]);
        bytes[42..50].copy_from_slice(&body.to_be_bytes());
        let error = refused(&bytes);
        assert!(matches!(error.fault, Fault::BodyLimit { found, most } if found == body && most == 512 << 20));
        assert_eq!((error.at, error.recovery), (42, Recovery::Close));
        // No limit of ours is above that of the sockets of others.
        let all = Limits {
            body: u64::MAX,
            ..Limits::default()
        };
        let most = body.min(MOST_BODY);
        let error = decode(&bytes, &all).unwrap_err();
        assert_eq!(matches!(error.fault, Fault::BodyLimit { .. }), body > most, "{error}");
    }
}

#[test]
fn a_type_that_is_not_printable_closes_the_stream() {
    for (kind, byte) in [(&b"TRANS\xe4"[..], 0xe4), (b"TRANS\n", b'\n'), (b"", 0)] {
        let error = refused(&framed(1, kind, b"Device", &MATRIX));
        assert_eq!(
            (error.fault, error.recovery),
            (Fault::TypeName { byte }, Recovery::Close)
        );
    }
}

#[test]
fn names_may_fill_their_field() {
    let bytes = framed(1, b"ABCDEFGHIJKL", b"a/name of 20 bytes..", b"12");
    let (message, _) = decode(&bytes, &Limits::default()).unwrap();
    assert_eq!(message.body.kind(), name("ABCDEFGHIJKL"));
    assert_eq!(message.device, "a/name of 20 bytes..");
    assert!(
        decode(&framed(1, b"X", b"", b""), &Limits::default())
            .unwrap()
            .0
            .device
            .is_empty()
    );
}

#[test]
fn a_device_that_would_write_into_a_log_is_refused_and_the_stream_goes_on() {
    for (device, at, byte) in [
        (&b"Tool\nOK"[..], 18, b'\n'),
        (b"\x1b[2JTool", 14, 0x1b),
        (b"T\xfcl", 15, 0xfc),
    ] {
        let error = refused(&framed(1, b"TRANSFORM", device, &MATRIX));
        assert!(
            matches!(error.fault, Fault::NameByte { byte: found, .. } if found == byte),
            "{error}"
        );
        assert_eq!((error.at, error.recovery), (at, Recovery::NextMessage));
    }
}

#[test]
fn a_wrong_crc_is_refused_and_the_stream_goes_on() {
    for said in [0, 1, u64::MAX] {
        let mut bytes = raw("STRING", &[0, 3, 0, 1, b'a']);
        bytes[50..58].copy_from_slice(&said.to_be_bytes());
        let error = refused(&bytes);
        assert!(matches!(error.fault, Fault::Crc { found, .. } if found == said));
        assert_eq!((error.at, error.recovery), (50, Recovery::NextMessage));
        assert_eq!((error.kind, error.device), (name("STRING"), device()));
    }
}

#[test]
fn an_extended_header_must_fit() {
    for said in [0, 11, 61, 65535] {
        let error = refused(&version_two((said, 0, 0), &[], &[]));
        assert_eq!(
            error.fault,
            Fault::ExtendedHeader {
                found: said.into(),
                least: 12,
                most: 60
            }
        );
        assert_eq!((error.at, error.recovery), (58, Recovery::NextMessage));
    }
    let error = refused(&framed(2, b"TRANSFORM", b"", &[0; 11]));
    assert!(matches!(error.fault, Fault::ExtendedHeader { found: 11, .. }));
    // A longer one is a later protocol's.
    let body = [&[0, 14, 0, 0, 0, 0, 0, 0, 0, 0, 0, 9, 1, 2][..], &MATRIX].concat();
    assert_eq!(
        decode(&framed(2, b"TRANSFORM", b"", &body), &Limits::default())
            .unwrap()
            .0
            .number,
        9
    );
}

#[test]
fn metadata_must_fit() {
    let error = refused(&version_two((12, 40, 9), &[], &[]));
    assert_eq!(error.fault, Fault::MetadataSize { found: 49, most: 48 });
    // A count that its index has no room for.
    let error = refused(&version_two((12, 2, 0), &[0xff, 0xff], &[]));
    assert!(
        matches!(
            error.fault,
            Fault::MetadataIndex {
                found: 2,
                count: 65535,
                needed: 524_282
            }
        ),
        "{error}"
    );
    // Values past the end, and bytes that belong to none.
    for (value, values) in [(100, &b"keyvalue"[..]), (u32::MAX, b"keyvalue"), (4, b"keyvalue")] {
        let error = refused(&with_metadata(&[(3, value)], values));
        assert!(matches!(error.fault, Fault::MetadataSpan { allowed: 8, .. }), "{error}");
    }
}

#[test]
fn a_key_stands_once_and_is_ascii() {
    let error = refused(&with_metadata(&[(1, 1), (1, 1)], b"k1k2"));
    assert!(
        matches!(&error.fault, Fault::Twice { shown, .. } if shown == "k"),
        "{error}"
    );
    for (key, byte) in [("größe", 0xc3), ("a\nb", b'\n'), ("\u{1b}[31m", 0x1b)] {
        let error = refused(&with_metadata(&[(key.len() as u16, 0)], key.as_bytes()));
        assert!(
            matches!(error.fault, Fault::NameByte { byte: found, .. } if found == byte),
            "{error}"
        );
    }
}

#[test]
fn metadata_is_bounded() {
    let many: Vec<(u16, u32)> = vec![(0, 0); 257];
    let error = refused(&with_metadata(&many, &[]));
    assert!(
        matches!(
            error.fault,
            Fault::TooMany {
                found: 257,
                most: 256,
                ..
            }
        ),
        "{error}"
    );
    let mut message = transform();
    message.metadata = message
        .metadata
        .with("TransformStatus", Text::new(&"O".repeat(1 << 20)));
    let error = refused(&message.to_vec().unwrap());
    assert!(
        matches!(
            error.fault,
            Fault::TooMany {
                what: "bytes of metadata",
                most: 65536,
                ..
            }
        ),
        "{error}"
    );
}

#[test]
fn errors_say_whose_message_it_was_and_where() {
    let error = refused(&raw("TRANSFORM", &[0; 47]));
    assert_eq!(
        error.to_string(),
        "TRANSFORM from \"Device\", byte 58 of the message: a content of 47 bytes; it must have 48"
    );
    let fields = error.fields();
    assert_eq!(
        fields.json(),
        "{\"error\":\"a content of 47 bytes; it must have 48\",\"type\":\"TRANSFORM\",\"device\":\"Device\",\
         \"byte\":58,\"stream\":\"goes on\"}"
    );
    assert!(
        fields
            .to_string()
            .starts_with("error: a content of 47 bytes; it must have 48\n")
    );
}
