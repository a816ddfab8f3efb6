//! What is written is read as it was.

use ndi::status::{MarkerStatus, ToolStatus};
use ndi::{
    Alert, Bx2, Bx2Frame, Bx2Marker, Bx2Markers, Bx2Tool, FrameKind, Handle, ReplyOption, Transform, binary_reply,
    bx2_body, parse_bx, parse_bx2, parse_phinf, parse_phsr, parse_tx, text_reply,
};
use proptest::collection::{btree_map, vec};
use proptest::prelude::*;

use crate::support::{Owned, stream};

fn real() -> impl Strategy<Value = f64> {
    prop::num::f32::NORMAL.prop_map(f64::from)
}

fn transforms() -> impl Strategy<Value = Transform> {
    (prop::array::uniform4(real()), prop::array::uniform3(real()), real()).prop_map(|(q, t_mm, error_mm)| Transform {
        q,
        t_mm,
        error_mm,
    })
}

fn tools() -> impl Strategy<Value = Vec<Bx2Tool>> {
    btree_map(any::<u16>(), (any::<u16>(), transforms()), 0..5).prop_map(|tools| {
        let tool = |(handle, (status, transform)): (u16, (u16, Transform))| {
            let status = ToolStatus(status);
            Bx2Tool {
                handle: Handle(handle),
                status,
                transform: (!status.is_missing()).then_some(transform),
            }
        };
        tools.into_iter().map(tool).collect()
    })
}

fn markers() -> impl Strategy<Value = Bx2Markers> {
    let marker =
        (any::<u8>(), any::<u16>(), prop::array::uniform3(real())).prop_map(|(status, index, place_mm)| Bx2Marker {
            status: MarkerStatus(status),
            index,
            place_mm,
        });
    (any::<u16>(), vec(marker, 0..6)).prop_map(|(handle, markers)| Bx2Markers {
        handle: Handle(handle),
        markers,
    })
}

fn frames() -> impl Strategy<Value = Bx2Frame> {
    let head = (
        any::<u8>(),
        any::<u8>(),
        any::<u16>(),
        any::<u32>(),
        any::<u32>(),
        0..1_000_000_000_i64,
    );
    let errors = vec((any::<u16>().prop_map(Handle), vec(real(), 0..4)), 0..3);
    (head, tools(), vec(markers(), 0..3), errors).prop_map(|(head, tools, markers, errors)| Bx2Frame {
        kind: FrameKind(head.0),
        index: head.1,
        status: ToolStatus(head.2),
        number: head.3,
        device_ns: i64::from(head.4) * 1_000_000_000 + head.5,
        tools,
        markers,
        errors,
    })
}

proptest! {
    #[test]
    fn bx2_comes_back(frames in vec(frames(), 0..4), alerts in vec((any::<u16>(), any::<u16>()), 0..4)) {
        let alerts = alerts.into_iter().map(|(kind, code)| Alert { kind, code }).collect();
        let reply = Bx2 { frames, alerts, skipped: 0 };
        let bytes = binary_reply(&bx2_body(&reply));
        let said = stream(&bytes, 100);
        let [Ok(Owned::Binary(body))] = &said[..] else { panic!("{said:?}") };
        let again = parse_bx2(body).unwrap();
        prop_assert_eq!(&again, &reply);
        let _: serde_json::Value = serde_json::from_str(&again.fields().json()).unwrap();
    }

    #[test]
    fn texts_come_back(text in "[ -~\n]{0,200}", piece in 1..300_usize) {
        let bytes = text_reply(&text);
        prop_assert_eq!(stream(&bytes, piece), [Ok(Owned::Text(text))]);
    }

    #[test]
    fn no_bytes_are_too_much(bytes: Vec<u8>, text in "[0-9A-Z+\n-]{0,120}", options: u16) {
        prop_assert_eq!(stream(&bytes, 1), stream(&bytes, bytes.len().max(1)));
        let _ = parse_bx(&bytes, ReplyOption(options));
        let _ = parse_bx2(&bytes);
        let _ = parse_tx(&text, ReplyOption(options));
        let _ = parse_phsr(&text);
        let _ = parse_phinf(&text, options);
        let _ = ndi::Rom::parse(&bytes);
    }
}
