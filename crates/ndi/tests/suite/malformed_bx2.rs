//! Containers that are not what they say, each by name.

use ndi::{Bx2, Fault, Malformed, bx2_body, parse_bx2};

use crate::support::{frame, tool};

/// A component with these numbers in its header.
fn component(kind: u16, size: u32, items: u32, content: &[u8]) -> Vec<u8> {
    let mut bytes = kind.to_le_bytes().to_vec();
    bytes.extend(size.to_le_bytes());
    bytes.extend([0, 0]);
    bytes.extend(items.to_le_bytes());
    bytes.extend(content);
    bytes
}

fn sized(kind: u16, items: u32, content: &[u8]) -> Vec<u8> {
    component(kind, 12 + content.len() as u32, items, content)
}

fn container(components: &[Vec<u8>]) -> Vec<u8> {
    let mut bytes = vec![1, 0];
    bytes.extend((components.len() as u16).to_le_bytes());
    components.iter().for_each(|one| bytes.extend(one));
    bytes
}

/// A frame item with this container.
fn item(nanoseconds: u32, inner: &[u8]) -> Vec<u8> {
    let mut bytes = vec![2, 0, 0, 0];
    [7, 1, nanoseconds]
        .iter()
        .for_each(|n: &u32| bytes.extend(n.to_le_bytes()));
    bytes.extend(inner);
    bytes
}

fn in_frame(one: Vec<u8>) -> Vec<u8> {
    container(&[sized(1, 1, &item(0, &container(&[one])))])
}

fn refused(body: &[u8]) -> Malformed {
    parse_bx2(body).unwrap_err()
}

#[test]
fn two_thousand_million_items_are_refused() {
    for kind in [2, 3, 0x12] {
        let Fault::TooMany { found, most, .. } = refused(&in_frame(component(kind, 12, 1 << 31, &[]))).fault else {
            panic!()
        };
        assert_eq!((found, most), (1 << 31, 0));
    }
    let body = container(&[component(1, 12, 1 << 31, &[])]);
    assert!(matches!(refused(&body).fault, Fault::TooMany { what: "frames", .. }));
    let mut body = container(&[]);
    body[2..4].fill(0xFF);
    assert!(matches!(
        refused(&body).fault,
        Fault::TooMany {
            what: "components",
            found: 65535,
            most: 0
        }
    ));
}

#[test]
fn a_component_of_size_zero_is_refused() {
    let error = refused(&in_frame(component(2, 0, 0, &[])));
    assert_eq!(error.fault, Fault::ComponentSize { found: 0 });
    assert_eq!(
        error.to_string(),
        "byte 38 of BX2: a component of 0 bytes; its header alone has 12"
    );
    let error = refused(&in_frame(component(2, 1000, 0, &[])));
    assert!(matches!(error.fault, Fault::Ends { needed: 988, .. }));
}

#[test]
fn a_thousand_nested_frames_are_refused_at_the_third() {
    let mut inner = container(&[]);
    for _ in 0..1000 {
        inner = container(&[sized(1, 1, &item(0, &inner))]);
    }
    assert_eq!(refused(&inner).fault, Fault::Nested { found: 3, most: 2 });
    let frames: Vec<u8> = (0..65).flat_map(|_| item(0, &container(&[]))).collect();
    let error = refused(&container(&[sized(1, 65, &frames)]));
    assert!(matches!(
        error.fault,
        Fault::TooMany {
            what: "frames",
            found: 65,
            most: 64
        }
    ));
}

#[test]
fn nanoseconds_of_a_second_and_more_are_refused() {
    for found in [1_000_000_000, 2_000_000_000, u32::MAX] {
        let body = container(&[sized(1, 1, &item(found, &container(&[])))]);
        let error = refused(&body);
        assert_eq!((error.fault, error.at), (Fault::Nanoseconds { found }, 28));
    }
    let body = container(&[sized(1, 1, &item(999_999_999, &container(&[])))]);
    assert_eq!(parse_bx2(&body).unwrap().frames[0].device_ns, 1_999_999_999);
}

#[test]
fn what_is_left_over_or_missing_is_refused() {
    let good = bx2_body(&Bx2 {
        frames: vec![frame(7, vec![tool(1, 0)])],
        ..Bx2::default()
    });
    assert!(parse_bx2(&good).is_ok());
    let error = refused(&[&good[..], &[0]].concat());
    assert!(matches!(error.fault, Fault::Trailing { found: 1, .. }));
    let error = refused(&in_frame(sized(2, 1, &[1, 0, 0, 1, 9])));
    assert!(matches!(
        error.fault,
        Fault::Trailing {
            field: "the last tool",
            found: 1
        }
    ));
    let error = refused(&in_frame(sized(2, 1, &[1, 0, 0, 0])));
    assert!(matches!(
        error.fault,
        Fault::Ends {
            field: "a transform",
            ..
        }
    ));
    let error = refused(&in_frame(sized(3, 1, &[1, 0, 0xFF, 0xFF])));
    assert!(matches!(
        error.fault,
        Fault::TooMany {
            what: "markers",
            found: 65535,
            most: 0
        }
    ));
    let mut version = good.clone();
    version[0] = 2;
    assert_eq!(refused(&version).fault, Fault::GbfVersion { found: 2 });
}

#[test]
fn more_tools_than_a_device_has_are_refused() {
    let tools: Vec<u8> = (0..300_u16)
        .flat_map(|handle| [handle.to_le_bytes(), [31, 1]].concat())
        .collect();
    let error = refused(&in_frame(sized(2, 300, &tools)));
    assert!(matches!(
        error.fault,
        Fault::TooMany {
            what: "tools",
            found: 300,
            most: 257
        }
    ));
    let lists = sized(3, 200, &[0; 800]);
    let body = container(&[sized(1, 1, &item(0, &container(&[lists.clone(), lists])))]);
    assert!(matches!(
        refused(&body).fault,
        Fault::TooMany {
            what: "lists of markers",
            found: 400,
            ..
        }
    ));
}

#[test]
fn a_tool_twice_is_refused() {
    let reply = Bx2 {
        frames: vec![frame(7, vec![tool(5, 0), tool(5, 0x100)])],
        ..Bx2::default()
    };
    assert_eq!(refused(&bx2_body(&reply)).fault, Fault::Twice { handle: 5 });
}

#[test]
fn what_is_not_known_is_skipped_and_counted() {
    let unknown = sized(0x77, 3, &[9; 40]);
    let buttons = sized(4, 1, &[1, 0, 1, 0, 1]);
    let inner = container(&[unknown.clone(), buttons, sized(2, 1, &[1, 0, 31, 1])]);
    let reply = parse_bx2(&container(&[unknown, sized(1, 1, &item(0, &inner))])).unwrap();
    assert_eq!((reply.skipped, reply.frames[0].tools.len()), (3, 1));
    // Errors of markers in a layout that is not known.
    let reply = parse_bx2(&in_frame(sized(9, 1, &[1, 0, 2, 0, 0]))).unwrap();
    assert_eq!((reply.skipped, reply.frames[0].errors.len()), (1, 0));
}

#[test]
fn alerts_are_told_in_words() {
    let body = container(&[sized(0x12, 3, &[0, 0, 7, 0, 2, 0, 2, 0, 9, 0, 1, 0])]);
    let words: Vec<String> = parse_bx2(&body)
        .unwrap()
        .alerts
        .iter()
        .map(|alert| alert.words())
        .collect();
    assert_eq!(
        words,
        [
            "fault: temperature of the first sensor",
            "event: a tool was unplugged",
            "message 1 of the unknown kind 9"
        ]
    );
}
