//! Messages of every type, written and read again.

use igtl::{Body, Cells, Fault, Limits, Matrix, Message, Name, PolyData, Status, Text, Tool, ToolKind, decode};
use proptest::prelude::*;

use crate::any_message::message;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4000))]

    #[test]
    fn what_is_written_is_read_again(message in message()) {
        let bytes = message.to_vec().unwrap();
        let (read, taken) = decode(&bytes, &Limits::default()).unwrap();
        prop_assert_eq!(taken, bytes.len());
        prop_assert_eq!(&read, &message);
        prop_assert_eq!(read.to_vec().unwrap(), bytes);
        let fields = message.fields();
        let json: serde_json::Value = serde_json::from_str(&fields.json()).unwrap();
        prop_assert_eq!(json.as_object().unwrap().len(), fields.all().len());
        prop_assert!(fields.to_string().lines().all(|line| !line.chars().any(char::is_control)));
    }

    /// Damage that its sender has given the right CRC is refused or read; it makes no panic.
    #[test]
    fn what_is_read_can_be_written(message in message(), at in any::<prop::sample::Index>(), byte in any::<u8>()) {
        let mut bytes = message.to_vec().unwrap();
        prop_assume!(bytes.len() > 58);
        let at = 58 + at.index(bytes.len() - 58);
        bytes[at] = byte;
        let crc = igtl::crc::crc64(&bytes[58..]).to_be_bytes();
        bytes[50..58].copy_from_slice(&crc);
        if let Ok((read, _)) = decode(&bytes, &Limits::default()) {
            let again = read.to_vec().unwrap();
            prop_assert_eq!(decode(&again, &Limits::default()).unwrap().0, read);
        }
    }
}

#[test]
fn what_a_reader_would_refuse_is_not_written() {
    let of = |body| Message::new(Name::EMPTY, body).to_vec().unwrap_err();
    let nan = Matrix {
        translation: [f32::NAN, 0.0, 0.0],
        ..Matrix::IDENTITY
    };
    assert!(matches!(of(Body::Transform(nan)), Fault::NotFinite { .. }));
    let tool = Tool {
        name: Name::EMPTY,
        kind: ToolKind::Six,
        pose: Matrix::IDENTITY,
    };
    assert!(matches!(of(Body::Tdata(vec![tool, tool])), Fault::Twice { .. }));
    let long = Text::new(&"a".repeat(65536));
    assert!(matches!(of(Body::String(long)), Fault::TooMany { found: 65536, .. }));
    let zero = Status::new(1, "a\0b");
    assert!(matches!(of(Body::Status(zero)), Fault::TextLength { .. }));
    let mut one = Message::new(Name::EMPTY, Body::Transform(Matrix::IDENTITY));
    one.number = 1;
    assert_eq!(one.to_vec(), Err(Fault::NeedsVersionTwo));
    let odd = PolyData {
        polygons: Cells::new([&[1_u32][..]]).unwrap(),
        ..PolyData::default()
    };
    assert!(matches!(of(Body::PolyData(odd)), Fault::PointIndex { .. }));
}

#[test]
fn names_are_refused_where_they_do_not_fit() {
    assert!(matches!(
        Name::<4>::new("abcde"),
        Err(igtl::NameError::TooLong { found: 5, most: 4, .. })
    ));
    assert!(matches!(
        Name::<4>::new("ä"),
        Err(igtl::NameError::Byte { place: 0, .. })
    ));
    assert!(matches!(
        Name::<4>::label("a\n"),
        Err(igtl::NameError::Byte { place: 1, .. })
    ));
    assert_eq!(Name::<4>::label("ä").unwrap().to_string(), "ä");
}
