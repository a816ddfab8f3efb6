//! Frames: what is in which, and how they follow one another.

use ndi::status::{HandleStatus, PortStatus};
use ndi::{
    Bx2, Frame, FrameKind, FrameStep, FrameWatch, Handle, Polled, PolledTool, PoseError, Spot, Spots, Value, Why,
};

use crate::support::{frame, tool, transform};

fn of(frames: Vec<ndi::Bx2Frame>) -> Vec<Frame> {
    let reply = Bx2 {
        frames,
        ..Bx2::default()
    };
    Frame::of_bx2(&ndi::parse_bx2(&ndi::bx2_body(&reply)).unwrap(), 1e-3)
}

fn polled(handle: u16, frame: u32) -> PolledTool {
    let mut tool = PolledTool::new(Handle(handle), HandleStatus::VALID);
    (tool.port, tool.frame, tool.transform) = (Some(PortStatus::GOOD), Some(frame), Some(transform(1.0)));
    tool
}

#[test]
fn a_tool_of_another_kind_is_not_in_this_frame_and_not_lost() {
    let active = ndi::Bx2Frame {
        kind: FrameKind(3),
        ..frame(11, vec![tool(2, 0)])
    };
    let mut frames = of(vec![frame(10, vec![tool(1, 0)]), active]);
    for frame in &mut frames {
        frame.expect([Handle(1), Handle(2)]);
    }
    let why = |frame: usize, handle| frames[frame].tool(Handle(handle)).unwrap().why();
    assert_eq!((why(0, 1), why(0, 2)), (Why::Valid, Why::NotInFrame));
    assert_eq!((why(1, 1), why(1, 2)), (Why::NotInFrame, Why::Valid));
    // The same of BX, where a frame's number stands at each tool.
    let reply = Polled {
        tools: vec![
            polled(1, 10),
            polled(2, 11),
            PolledTool::new(Handle(3), HandleStatus::DISABLED),
        ],
        strays: Some(Spots(vec![Spot {
            out_of_volume: false,
            place_mm: Some([1.0; 3]),
        }])),
        ..Polled::default()
    };
    let frames = Frame::of_polled(&reply, 1e-3);
    let handles = |frame: &Frame| frame.tools.iter().map(|sight| sight.handle().0).collect::<Vec<_>>();
    assert_eq!((handles(&frames[0]), handles(&frames[1])), (vec![1, 3], vec![2, 3]));
    assert_eq!((frames[0].number, frames[1].number), (Some(10), Some(11)));
    assert_eq!((frames[0].markers.len(), frames[1].markers.len()), (0, 1));
}

#[test]
fn strays_have_a_place_or_a_reason() {
    let frames = of(vec![frame(1, vec![])]);
    let markers = &frames[0].markers;
    assert_eq!(markers[0].place_mm(), Ok([0.0, 2.0, -1400.0]));
    assert_eq!(markers[1].place_mm(), Err(Why::Phantom));
    assert_eq!((markers[1].tool(), markers[1].index()), (None, 1));
    let mut nan = frame(1, vec![]);
    nan.markers[0].markers[0].place_mm[1] = f64::NAN;
    let not_finite = PoseError::NotFinite {
        field: "place",
        value: "NaN",
    };
    assert_eq!(of(vec![nan])[0].markers[0].place_mm(), Err(Why::Refused(not_finite)));
    let strays = Polled {
        strays: Some(Spots(vec![Spot {
            out_of_volume: true,
            place_mm: Some([1.0; 3]),
        }])),
        ..Polled::default()
    };
    let frame = &Frame::of_polled(&strays, 1e-3)[0];
    assert_eq!(
        (frame.number, frame.markers[0].place_mm()),
        (None, Err(Why::OutOfVolume))
    );
}

#[test]
fn a_pose_that_cannot_be_used_is_refused_and_its_neighbour_is_not() {
    let mut bad = tool(1, 0);
    bad.transform.as_mut().unwrap().q = [f64::NAN; 4];
    let mut zero = tool(2, 0);
    zero.transform.as_mut().unwrap().q = [0.0; 4];
    let frame = &of(vec![frame(1, vec![bad, zero, tool(3, 0)])])[0];
    let why = |at: usize| frame.tools[at].why();
    assert!(matches!(why(0), Why::Refused(PoseError::NotFinite { .. })));
    assert_eq!((why(1), why(2)), (Why::Refused(PoseError::ZeroQuaternion), Why::Valid));
    let fields = frame.fields();
    assert_eq!(
        fields.get("tools[1].why"),
        Some(&Value::Text("refused: a quaternion of zeros".to_owned()))
    );
    assert!(fields.get("tools[1].mm").is_none() && fields.get("tools[2].mm").is_some());
    let _: serde_json::Value = serde_json::from_str(&fields.json()).unwrap();
}

#[test]
fn a_handle_that_stands_twice_in_bx_has_no_pose() {
    let reply = Polled {
        tools: vec![polled(1, 5), polled(1, 5), polled(2, 5)],
        ..Polled::default()
    };
    let frame = &Frame::of_polled(&reply, 1e-3)[0];
    assert_eq!(frame.tools.len(), 2);
    assert!(frame.tools[0].pose().is_err() && frame.tools[1].pose().is_ok());
}

#[test]
fn valid_without_a_transform_is_refused() {
    let mut tool = polled(1, 5);
    tool.transform = None;
    let reply = Polled {
        tools: vec![tool],
        ..Polled::default()
    };
    let why = Frame::of_polled(&reply, 1e-3)[0].tools[0].why();
    assert_eq!(why, Why::Refused(PoseError::Absent));
}

#[test]
fn the_same_frame_a_wrap_and_a_jump_are_told() {
    let mut watch = FrameWatch::default();
    let mut judge = |number: u32| watch.judge(&of(vec![frame(number, vec![tool(1, 0)])])[0], 0);
    let next = |missed, wrapped| FrameStep::Next { missed, wrapped };
    assert_eq!(judge(100), FrameStep::First);
    assert_eq!(judge(100), FrameStep::Same);
    assert_eq!((judge(101), judge(104)), (next(0, false), next(2, false)));
    let to = u32::MAX;
    assert_eq!(judge(to), FrameStep::Jump { from: 104, to });
}

/// Of TX and BX, which say no time: the number alone tells.
fn judged(watch: &mut FrameWatch, number: u32) -> FrameStep {
    let reply = Polled {
        tools: vec![polled(1, number)],
        ..Polled::default()
    };
    watch.judge(&Frame::of_polled(&reply, 1e-3)[0], 0)
}

/// A reply of two seconds before was a jump, and its poses were live.
#[test]
fn what_goes_back_is_not_the_last_one_and_what_follows_it_is_counted() {
    let mut watch = FrameWatch::default();
    let mut judge = |number| judged(&mut watch, number);
    let next = |missed, wrapped| FrameStep::Next { missed, wrapped };
    let back = |from, to, in_a_row| FrameStep::Back { from, to, in_a_row };
    assert_eq!((judge(500), judge(380)), (FrameStep::First, back(500, 380, 1)));
    assert_eq!((judge(501), judge(381)), (next(0, false), back(501, 381, 1)));
    assert_eq!((judge(383), judge(383)), (back(501, 383, 2), FrameStep::Same));
    assert_eq!((judge(384), judge(200)), (back(501, 384, 3), back(501, 200, 1)));
    assert_eq!((judge(501), judge(502)), (FrameStep::Same, next(0, false)));
    // Round the largest number it is not the smaller one that is of before.
    assert_eq!(judge(u32::MAX), back(502, u32::MAX, 1));
    let mut watch = FrameWatch::default();
    let mut judge = |number| judged(&mut watch, number);
    assert_eq!((judge(u32::MAX), judge(1)), (FrameStep::First, next(1, true)));
    assert_eq!(judge(u32::MAX - 5), back(1, u32::MAX - 5, 1));
}

#[test]
fn by_the_devices_time_a_frame_of_before_is_told_from_a_device_that_counts_otherwise() {
    let mut watch = FrameWatch::default();
    let mut judge = |number, device_ns| {
        let frame = ndi::Bx2Frame {
            device_ns,
            ..frame(number, vec![tool(1, 0)])
        };
        watch.judge(&of(vec![frame])[0], 0)
    };
    assert_eq!(judge(500, 9_000_000_000), FrameStep::First);
    let jump = |from, to| FrameStep::Jump { from, to };
    assert_eq!(judge(3, 9_020_000_000), jump(500, 3));
    // What one device was seen to do.
    assert_eq!(
        judge(4_294_967_170, 9_040_000_000),
        FrameStep::Jump {
            from: 3,
            to: 4_294_967_170
        }
    );
    assert_eq!(judge(16_767, 9_060_000_000), jump(4_294_967_170, 16_767));
    let (from, to) = (16_767, 4_294_967_170);
    for device_ns in [9_040_000_000, 9_060_000_000] {
        assert!(matches!(judge(to, device_ns), FrameStep::Back { .. } | FrameStep::Same));
    }
    assert_eq!(judge(to, 9_080_000_000), jump(from, to));
}

/// A port without a number that is listed first gave frames of two kinds one key: each was new again and again.
#[test]
fn a_disabled_port_in_front_makes_no_frame_new_again() {
    let reply = Polled {
        tools: vec![
            PolledTool::new(Handle(1), HandleStatus::DISABLED),
            polled(2, 100),
            polled(3, 101),
        ],
        ..Polled::default()
    };
    let mut watch = FrameWatch::default();
    let mut judge = || {
        let frames = Frame::of_polled(&reply, 1e-3);
        frames.iter().map(|frame| watch.judge(frame, 0)).collect::<Vec<_>>()
    };
    assert_eq!(judge(), [FrameStep::First; 2]);
    assert_eq!(judge(), [FrameStep::Same; 2]);
}

#[test]
fn kinds_of_frames_are_counted_apart() {
    let mut watch = FrameWatch::default();
    let of_kind = |kind, number| ndi::Bx2Frame {
        kind: FrameKind(kind),
        ..frame(number, vec![])
    };
    let mut judge = |kind, number| watch.judge(&of(vec![of_kind(kind, number)])[0], 0);
    assert_eq!((judge(2, 10), judge(3, 11)), (FrameStep::First, FrameStep::First));
    assert_eq!(judge(2, 10), FrameStep::Same);
    assert_eq!(
        judge(3, 13),
        FrameStep::Next {
            missed: 1,
            wrapped: false
        }
    );
    for kind in 0..=255 {
        judge(kind, 1);
    }
}
