//! A stream that is not what it should be, each kind by name.

use ndi::{Decoder, Fault, Limits, Malformed, Recovery, Reply, binary_reply, crc::crc16, text_reply};

use crate::support::{Owned, stream};

/// The only thing that is said, the same in pieces of any length.
fn refused(bytes: &[u8]) -> Malformed {
    let said = stream(bytes, bytes.len().max(1));
    assert_eq!(stream(bytes, 1), said);
    assert_eq!(said.len(), 1, "{said:?}");
    said[0].clone().unwrap_err()
}

fn long(body: &[u8]) -> Vec<u8> {
    let mut bytes = vec![0xC8, 0xA5];
    bytes.extend((body.len() as u32).to_le_bytes());
    bytes.extend(crc16(&bytes).to_le_bytes());
    bytes.extend(body);
    bytes.extend(crc16(body).to_le_bytes());
    bytes
}

#[test]
fn texts_and_bodies_come_in_pieces_of_any_length() {
    let bytes = [
        text_reply("OKAY"),
        binary_reply(&[1, 2, 3]),
        long(&[0xC4; 300]),
        text_reply("two\nlines"),
        binary_reply(&[]),
    ]
    .concat();
    let expected = [
        Owned::Text("OKAY".to_owned()),
        Owned::Binary(vec![1, 2, 3]),
        Owned::Binary(vec![0xC4; 300]),
        Owned::Text("two\nlines".to_owned()),
        Owned::Binary(Vec::new()),
    ];
    for piece in 1..bytes.len() {
        let said: Vec<_> = stream(&bytes, piece).into_iter().map(Result::unwrap).collect();
        assert_eq!(said, expected, "{piece}");
    }
    let body = vec![7; 70_000];
    assert_eq!(binary_reply(&body), long(&body));
    assert_eq!(stream(&long(&body), 4096), [Ok(Owned::Binary(body))]);
}

#[test]
fn wrong_crcs_are_named() {
    assert_eq!(
        refused(b"OKAYA897\r").fault,
        Fault::TextCrc {
            found: 0xA897,
            computed: 0xA896
        }
    );
    assert_eq!(
        refused(b"OKAYA8G6\r").fault,
        Fault::NotHex {
            field: "the CRC of a text",
            byte: b'G'
        }
    );
    assert_eq!(refused(b"OK\r").fault, Fault::TextShort { found: 2 });
    let mut body = binary_reply(&[1, 2, 3]);
    body[7] ^= 1;
    assert!(matches!(refused(&body).fault, Fault::BodyCrc { .. }));
    assert_eq!(refused(&body).recovery, Recovery::NextReply);
    let mut header = binary_reply(&[1, 2, 3]);
    header[4] ^= 1;
    assert!(matches!(refused(&header).fault, Fault::HeaderCrc { .. }));
    assert_eq!(refused(&header).recovery, Recovery::Silence);
}

#[test]
fn a_length_of_ffff_with_a_wrong_crc_is_not_waited_for() {
    let mut bytes = binary_reply(&[0; 8]);
    bytes[2..4].fill(0xFF);
    assert!(matches!(refused(&bytes[..6]).fault, Fault::HeaderCrc { .. }));
    // With a right one it is waited for, and cut off.
    let mut bytes = vec![0xC4, 0xA5, 0xFF, 0xFF];
    bytes.extend(crc16(&bytes).to_le_bytes());
    bytes.extend([0; 100]);
    assert_eq!(
        refused(&bytes).fault,
        Fault::Truncated {
            found: 106,
            needed: 6 + 65535 + 2
        }
    );
}

#[test]
fn what_is_too_long_is_refused_before_it_is_held() {
    let mut bytes = vec![0xC8, 0xA5, 0xFF, 0xFF, 0xFF, 0xFF];
    bytes.extend(crc16(&bytes).to_le_bytes());
    let fault = Fault::BodyLimit {
        found: u32::MAX.into(),
        most: 1 << 20,
    };
    assert_eq!(refused(&bytes).fault, fault);
    let limits = Limits { text: 100, body: 10 };
    let mut decoder = Decoder::new(limits);
    let mut endless = &[b'A'; 5000][..];
    let said = decoder.feed(&mut endless).unwrap().unwrap_err();
    assert_eq!(said.fault, Fault::TextLimit { most: 100 });
    for _ in 0..1000 {
        assert!(decoder.feed(&mut &[b'A'; 5000][..]).is_none());
        assert_eq!(decoder.come(), 0);
    }
    decoder.restart();
    assert_eq!(decoder.feed(&mut &b"OKAYA896\r"[..]), Some(Ok(Reply::Text("OKAY"))));
}

#[test]
fn bytes_of_no_text_are_refused() {
    for (bytes, at) in [
        (&b"OK\0AY"[..], 2),
        (b"\xC4\xC4", 1),
        (b"\x16\x03\x01", 0),
        (b"\xC5", 0),
    ] {
        let error = refused(bytes);
        assert!(matches!(error.fault, Fault::Byte { .. }));
        assert_eq!((error.at, error.recovery), (at, Recovery::Silence));
        assert!(error.advice().is_some() && error.fields().json().contains("needs silence"));
    }
}

#[test]
fn an_error_in_the_middle_of_a_body_is_named() {
    let mut bytes = binary_reply(&[1; 60]);
    let error = text_reply("ERROR02");
    bytes[20..20 + error.len()].copy_from_slice(&error);
    assert_eq!(refused(&bytes).fault, Fault::ErrorInside { code: 2 });
    // Where the body ends with it, it is found once the time is up.
    let broken = [&binary_reply(&[1; 60])[..20], &error[..]].concat();
    assert_eq!(refused(&broken).fault, Fault::ErrorInside { code: 2 });
    // In a body whose CRC is right it is data.
    let body = [&[0; 5][..], &error].concat();
    assert_eq!(stream(&binary_reply(&body), 3), [Ok(Owned::Binary(body))]);
}
