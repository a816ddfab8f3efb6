//! Contents that are wrong, each refused by name and with the byte.

use igtl::{Body, Fault, Limits, Recovery, SizeRule, decode};

use crate::support::{name, raw, refused};

fn fault(kind: &str, content: &[u8]) -> Fault {
    let error = refused(&raw(kind, content));
    assert_eq!(error.recovery, Recovery::NextMessage);
    assert_eq!(error.kind, name(kind));
    error.fault
}

fn accepted(kind: &str, content: &[u8]) -> Body<'static> {
    let bytes = raw(kind, content);
    decode(&bytes, &Limits::default()).unwrap().0.body.into_owned()
}

/// A tool of a TDATA.
fn tool(name: &str, kind: u8) -> Vec<u8> {
    let mut bytes = name.as_bytes().to_vec();
    bytes.resize(20, 0);
    bytes.extend([kind, 0]);
    bytes.extend([0; 48]);
    bytes
}

/// Numbers of a matrix with this one in its place.
fn matrix_with(place: usize, number: f32) -> Vec<u8> {
    (0..12)
        .flat_map(|at| if at == place { number } else { 0.0 }.to_be_bytes())
        .collect()
}

#[test]
fn a_content_of_another_length_is_refused_with_both_numbers() {
    for (kind, found, rule) in [
        ("TRANSFORM", 0, SizeRule::Exactly(48)),
        ("TRANSFORM", 47, SizeRule::Exactly(48)),
        ("TRANSFORM", 49, SizeRule::Exactly(48)),
        ("TDATA", 69, SizeRule::MultipleOf(70)),
        ("QTDATA", 51, SizeRule::MultipleOf(50)),
        ("POSITION", 16, SizeRule::OneOf(&[12, 24, 28])),
        ("STATUS", 29, SizeRule::AtLeast(30)),
        ("STRING", 3, SizeRule::AtLeast(4)),
        ("POINT", 135, SizeRule::MultipleOf(136)),
        ("IMAGE", 71, SizeRule::AtLeast(72)),
        ("IMGMETA", 259, SizeRule::MultipleOf(260)),
        ("POLYDATA", 39, SizeRule::AtLeast(40)),
        ("CAPABILITY", 13, SizeRule::MultipleOf(12)),
        ("COMMAND", 137, SizeRule::AtLeast(138)),
        ("RTS_COMMAND", 0, SizeRule::AtLeast(138)),
        ("GET_STATUS", 1, SizeRule::Exactly(0)),
        ("STT_TDATA", 0, SizeRule::Exactly(36)),
        ("STP_QTDATA", 36, SizeRule::Exactly(0)),
        ("RTS_TDATA", 0, SizeRule::Exactly(1)),
        ("LBMETA", 115, SizeRule::MultipleOf(116)),
        ("TRAJ", 151, SizeRule::MultipleOf(150)),
        ("SENSOR", 9, SizeRule::AtLeast(10)),
    ] {
        let content = vec![0; found];
        let found = found as u64;
        assert_eq!(fault(kind, &content), Fault::Size { found, rule }, "{kind}");
    }
}

#[test]
fn numbers_that_are_none_are_refused_where_they_stand() {
    for (number, value) in [(f32::NAN, "NaN"), (f32::INFINITY, "inf"), (f32::NEG_INFINITY, "-inf")] {
        for place in 0..12 {
            let error = refused(&raw("TRANSFORM", &matrix_with(place, number)));
            assert_eq!(
                error.fault,
                Fault::NotFinite {
                    field: "a matrix",
                    value
                }
            );
            assert_eq!(error.at, 58 + 4 * place as u64);
        }
    }
    let mut tools = [tool("a", 2), tool("b", 2)].concat();
    tools[70 + 22..70 + 26].copy_from_slice(&f32::NAN.to_be_bytes());
    assert!(matches!(fault("TDATA", &tools), Fault::NotFinite { .. }));
    let numbers = |count| f32::NAN.to_be_bytes().repeat(count);
    assert!(matches!(fault("POSITION", &numbers(7)), Fault::NotFinite { .. }));
    let mut point = vec![0; 136];
    point[112..116].copy_from_slice(&f32::INFINITY.to_be_bytes());
    let field = "the diameter of a point";
    assert_eq!(fault("POINT", &point), Fault::NotFinite { field, value: "inf" });
}

#[test]
fn a_tool_stands_once() {
    let twice = [tool("Stylus", 2), tool("Needle", 2), tool("Stylus", 2)].concat();
    let error = refused(&raw("TDATA", &twice));
    assert!(matches!(&error.fault, Fault::Twice { shown, .. } if shown == "Stylus"));
    assert_eq!(error.at, 58 + 140);
    // Two names that a sender cut to twenty bytes.
    let cut = [tool("StylusTipToReference", 2), tool("StylusTipToReferenceA", 2)].map(|t| t[..70].to_vec());
    assert_eq!(cut[1].len(), 70);
    let equal = [&cut[0][..], &cut[0]].concat();
    assert!(matches!(fault("TDATA", &equal), Fault::Twice { .. }));
}

#[test]
fn tools_are_bounded_and_may_be_none() {
    assert_eq!(accepted("TDATA", &[]), Body::Tdata(Vec::new()));
    let many: Vec<u8> = (0..100_000).flat_map(|number| tool(&format!("t{number}"), 2)).collect();
    assert_eq!(
        fault("TDATA", &many),
        Fault::TooMany {
            what: "tools",
            found: 100_000,
            most: 4096
        }
    );
}

#[test]
fn kinds_and_names_of_tools_are_checked() {
    for kind in [0, 5, 255] {
        let fault = fault("TDATA", &tool("a", kind));
        assert!(matches!(fault, Fault::Value { field: "the kind of a tool", found, .. } if found == u64::from(kind)));
    }
    let fault = fault("TDATA", &tool("a\nb", 2));
    assert!(matches!(fault, Fault::NameByte { byte: b'\n', .. }));
}

#[test]
fn texts_end_where_they_say() {
    for (length, allowed) in [(0_u16, 2), (3, 2), (u16::MAX, 2)] {
        let mut content = vec![0, 3];
        content.extend(length.to_be_bytes());
        content.extend(b"ab");
        let found = length.into();
        assert_eq!(fault("STRING", &content), Fault::TextLength { found, allowed });
    }
    let mut command = vec![0; 134];
    command.extend(u32::MAX.to_be_bytes());
    assert!(matches!(
        fault("COMMAND", &command),
        Fault::TextLength { allowed: 0, .. }
    ));
}

#[test]
fn a_text_of_other_characters_is_kept_and_shown_in_one_line() {
    let latin = accepted("STRING", b"\0\x04\0\x07Pr\xfcf\x1b\nx");
    let Body::String(text) = latin else { panic!() };
    assert_eq!(
        (text.as_str(), text.to_string()),
        (None, "Pr\u{fffd}f\\u{1b}\\nx".to_owned())
    );
    // Bytes that are not of the character set that is stated are no text of it.
    let text = |encoding: u8, bytes: &[u8]| {
        let content = [&[0, encoding, 0, bytes.len() as u8][..], bytes].concat();
        let Body::String(text) = accepted("STRING", &content) else {
            panic!()
        };
        text.as_str().map(str::to_owned)
    };
    assert_eq!((text(3, "ä".as_bytes()), text(3, b"a")), (None, Some("a".to_owned())));
    assert_eq!(
        (text(106, "ä".as_bytes()), text(106, b"\xe4")),
        (Some("ä".to_owned()), None)
    );
    let Body::Status(status) = accepted("STATUS", &[&[0; 30][..], b"all is well"].concat()) else {
        panic!()
    };
    assert_eq!(status.words, b"all is well");
}

#[test]
fn what_is_not_read_is_held_against_what_it_says_of_itself() {
    for (kind, content) in [
        ("SENSOR", &[6, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1][..]),
        ("COLORT", &[3, 19, 1, 2, 3]),
        ("NDARRAY", &[11, 1, 0, 2, 0, 0]),
        ("NDARRAY", &[11, 200, 0, 2, 0, 0]),
    ] {
        assert!(matches!(fault(kind, content), Fault::Size { .. }), "{kind}");
    }
    assert_eq!(accepted("VIDEO", b"anything").kind(), name("VIDEO"));
    assert_eq!(accepted("GET_LBMETA", b"").kind(), name("GET_LBMETA"));
}
