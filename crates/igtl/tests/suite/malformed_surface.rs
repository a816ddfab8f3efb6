//! POLYDATAs that are wrong.

use igtl::{Fault, Limits, SizeRule, decode};

use crate::support::{raw, refused};

/// Three points, a triangle, and an attribute of one number each.
fn surface() -> Vec<u32> {
    let head = [3, 0, 0, 0, 0, 1, 16, 0, 0, 1];
    let points = [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0].map(f32::to_bits);
    [&head[..], &points, &[3, 0, 1, 2]].concat()
}

/// Its bytes, with the attribute behind it: scalars of one component, `name`, three numbers.
fn bytes(words: &[u32], kind: u8, components: u8, name: &[u8]) -> Vec<u8> {
    let mut bytes: Vec<u8> = words.iter().flat_map(|word| word.to_be_bytes()).collect();
    bytes.extend([kind, components, 0, 0, 0, 3]);
    bytes.extend(name);
    bytes.extend([0; 12]);
    bytes
}

fn fault_of(words: &[u32]) -> Fault {
    refused(&raw("POLYDATA", &bytes(words, 0, 1, b"heat\0\0"))).fault
}

fn changed(at: usize, word: u32) -> Fault {
    let mut words = surface();
    words[at] = word;
    fault_of(&words)
}

#[test]
fn a_good_one_is_read() {
    let bytes = raw("POLYDATA", &bytes(&surface(), 0, 1, b"heat\0\0"));
    assert_eq!(decode(&bytes, &Limits::default()).unwrap().0.to_vec().unwrap(), bytes);
}

#[test]
fn more_than_has_come_is_not_made_room_for() {
    for (at, word) in [(0, u32::MAX), (6, !3), (4, 0x4000_0000)] {
        assert!(matches!(changed(at, word), Fault::Size { .. }), "{at}");
    }
    assert!(matches!(
        changed(9, u32::MAX),
        Fault::TooMany { what: "attributes", .. }
    ));
    assert_eq!(
        changed(6, 15),
        Fault::Size {
            found: 15,
            rule: SizeRule::MultipleOf(4)
        }
    );
}

#[test]
fn places_are_numbers() {
    for number in [f32::NAN, f32::INFINITY] {
        let fault = changed(12, number.to_bits());
        assert!(
            matches!(
                fault,
                Fault::NotFinite {
                    field: "the place of a point",
                    ..
                }
            ),
            "{fault}"
        );
    }
    let mut bytes = bytes(&surface(), 0, 1, b"heat\0\0");
    let last = bytes.len() - 4;
    bytes[last..].copy_from_slice(&f32::NAN.to_be_bytes());
    let fault = refused(&raw("POLYDATA", &bytes)).fault;
    assert!(
        matches!(
            fault,
            Fault::NotFinite {
                field: "an attribute",
                ..
            }
        ),
        "{fault}"
    );
}

#[test]
fn cells_name_points_that_are_there_and_are_as_many_as_is_said() {
    assert_eq!(changed(22, 3), Fault::PointIndex { found: 3, points: 3 });
    assert!(matches!(changed(5, 2), Fault::Cells { found: 1, said: 2, .. }));
    assert!(matches!(changed(19, 4), Fault::Cells { found: 0, said: 1, .. }));
    assert!(matches!(changed(19, u32::MAX), Fault::Cells { found: 0, said: 1, .. }));
    assert!(matches!(changed(19, 0), Fault::Cells { found: 3, said: 1, .. }));
}

#[test]
fn attributes_are_checked() {
    let fault =
        |kind, components, name: &[u8]| refused(&raw("POLYDATA", &bytes(&surface(), kind, components, name))).fault;
    assert!(matches!(
        fault(6, 1, b"a\0"),
        Fault::Value {
            field: "the kind of an attribute",
            ..
        }
    ));
    for (kind, components) in [(0, 0), (1, 2), (0x12, 4), (3, 3), (4, 3)] {
        let fault = fault(kind, components, b"a\0");
        assert!(
            matches!(
                fault,
                Fault::Value {
                    field: "the components of an attribute",
                    ..
                }
            ),
            "{fault}"
        );
    }
    assert!(matches!(fault(0, 1, b"a\nb\0"), Fault::NameByte { .. }));
    let long = [&[b'a'; 256][..], &[0]].concat();
    assert!(matches!(fault(0, 1, &long), Fault::TextLength { found: 256, .. }));
    // Numbers that are missing, and bytes that are left.
    assert!(matches!(fault(0, 2, b"a\0"), Fault::Size { .. }));
    assert!(matches!(fault(0, 1, b"a\0\0\0"), Fault::Size { .. }));
    let endless = surface()
        .iter()
        .flat_map(|word| word.to_be_bytes())
        .chain([0, 1, 0, 0, 0, 0, b'a'])
        .collect::<Vec<u8>>();
    assert!(matches!(
        refused(&raw("POLYDATA", &endless)).fault,
        Fault::TextLength { .. }
    ));
}
