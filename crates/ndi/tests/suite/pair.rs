//! Client against device: what is shown on one side is seen on the other, by each way of polling.

use ndi::session::{DeviceRules, Notice, Poll, Reason};
use ndi::status::SystemStatus;
use ndi::{Alert, ErrorCode, Frame, Handle, Markers, Why};

use crate::support::{MS, Pair, frame, rom, rules, stray, tool};

fn connected(device: DeviceRules) -> Pair {
    let mut pair = Pair::new(rules(), device);
    pair.event(ndi::session::Event::Connected);
    pair
}

fn devices() -> [(Poll, DeviceRules); 3] {
    let device = |bx2, bx| DeviceRules {
        bx2,
        bx,
        ..DeviceRules::default()
    };
    [
        (Poll::Bx2, device(true, true)),
        (Poll::Bx, device(false, true)),
        (Poll::Tx, device(false, false)),
    ]
}

#[test]
fn the_best_way_of_polling_that_the_device_knows_is_found() {
    for (poll, device) in devices() {
        let pair = connected(device);
        assert!(pair.client.is_tracking());
        assert!(pair.told.contains(&Notice::Tracking(poll)), "{:?}", pair.told);
        let not_known = pair
            .told
            .iter()
            .filter(|notice| matches!(notice, Notice::NotKnown { .. }))
            .count();
        assert_eq!(
            not_known,
            [Poll::Bx2, Poll::Bx, Poll::Tx]
                .iter()
                .position(|one| *one == poll)
                .unwrap()
        );
        assert_eq!(
            (pair.client.handle("ball"), pair.client.handle("reference")),
            (Some(Handle(1)), Some(Handle(2)))
        );
    }
}

#[test]
fn the_set_up_is_the_one_of_the_guide() {
    let pair = connected(DeviceRules::default());
    let names: Vec<&str> = pair.sent.iter().map(|line| line.split(':').next().unwrap()).collect();
    let each = [&["PHRQ"][..], &["PVWR"; 12], &["PINIT", "PENA"]].concat();
    let expected = [&["INIT", "VER", "PHSR"][..], &each, &each, &["TSTART", "BX2"]].concat();
    assert_eq!(names, expected);
    assert_eq!(
        pair.device
            .tools()
            .filter(|tool| tool.enabled && tool.rom == Some(&rom()))
            .count(),
        2
    );
}

/// The first tool seen, the second with this status.
fn shown(device: DeviceRules, status: u16) -> Frame {
    let mut pair = connected(device);
    pair.show(frame(100, vec![tool(1, 0), tool(2, status)]));
    let seen = |frame: &&Frame| frame.number == Some(100);
    pair.published.iter().find(seen).unwrap().clone()
}

#[test]
fn one_pose_by_each_way_of_polling() {
    let frames: Vec<Frame> = devices().map(|(_, device)| shown(device, 0)).to_vec();
    for frame in &frames {
        for handle in [1, 2] {
            let [one, other] = [frame, &frames[0]].map(|frame| frame.tool(Handle(handle)).unwrap().pose().unwrap());
            // TX has four decimals of a quaternion and two of a millimetre; these numbers need no more.
            assert_eq!((one.q, one.t_mm), (other.q, other.t_mm));
            assert!((one.error_mm - 0.125).abs() < 1e-12);
        }
        assert_eq!(frame.markers[0].place_mm(), Ok([0.0, 2.0, -1400.0]));
    }
    // A phantom is told by BX2 alone.
    assert_eq!(frames[0].markers[1].place_mm(), Err(Why::Phantom));
    assert_eq!((frames[1].markers.len(), frames[2].markers.len()), (1, 1));
}

#[test]
fn no_lost_tool_is_valid_by_any_way_of_polling() {
    for status in (0..=40).flat_map(|code| [code, code | 0x100, code | 0x2200]) {
        let expected = status & !0xE200 == 0;
        for (poll, device) in devices() {
            let frame = shown(device, status);
            let sight = frame.tool(Handle(2)).unwrap();
            assert!(
                !sight.why().is_valid() || expected || !known(status),
                "{poll} {status:#x}"
            );
            assert!(poll != Poll::Bx2 || sight.why().is_valid() == expected, "{status:#x}");
            assert!(frame.tool(Handle(1)).unwrap().pose().is_ok());
        }
    }
}

/// What a port or a tool's information can say too.
fn known(status: u16) -> bool {
    [3, 9, 13, 14, 17, 18, 19, 20, 22, 32].contains(&(status & 0xFF)) || status & 0x100 != 0
}

#[test]
fn the_reason_is_the_same_by_each_way_of_polling() {
    for status in [3, 9, 0x10D, 0x10E, 0x111, 0x112, 0x113, 0x114, 0x116, 0x11F, 0x120] {
        let whys = devices().map(|(_, device)| shown(device, status).tool(Handle(2)).unwrap().why());
        assert_eq!((whys[1], whys[2]), (whys[0], whys[0]), "{status:#x}");
    }
}

#[test]
fn a_frame_is_given_once() {
    for (poll, device) in devices() {
        let mut pair = connected(device);
        for number in [7, 8, 9] {
            pair.device.show(frame(number, vec![tool(1, 0), tool(2, 0x11F)]));
            pair.wait(50);
        }
        let numbers: Vec<u32> = pair
            .published
            .iter()
            .filter_map(|frame| frame.number)
            .filter(|n| *n >= 7)
            .collect();
        assert_eq!(numbers, [7, 8, 9], "{poll}");
        let again = |notice: &Notice| matches!(notice, Notice::SameFrame { number: 8 } | Notice::NoFrame);
        assert!(pair.told.iter().any(again));
    }
}

/// A frame that was shown before tools were loaded anew was given with their handles: the pose of one tool under the name of another.
#[test]
fn frames_shown_before_tracking_began_are_never_given_of_other_tools() {
    for (poll, device) in devices() {
        let mut pair = connected(device);
        pair.device.show(frame(7, vec![tool(1, 0), tool(2, 0)]));
        pair.published.clear();
        pair.event(ndi::session::Event::Closed);
        pair.event(ndi::session::Event::Connected);
        pair.wait(50);
        let stale = pair
            .published
            .iter()
            .find(|frame| frame.tool(Handle(1)).is_some_and(|s| s.pose().is_ok()));
        assert_eq!(stale, None, "{poll}");
        pair.show(frame(8, vec![tool(1, 0), tool(2, 0)]));
        assert!(
            pair.published.last().unwrap().tool(Handle(1)).unwrap().pose().is_ok(),
            "{poll}"
        );
    }
}

#[test]
fn an_unplugged_tool_is_told_once_and_never_seen() {
    for (poll, device) in devices() {
        let mut pair = connected(device);
        pair.show(frame(7, vec![tool(1, 0), tool(2, 0)]));
        pair.device.unplug(Handle(2));
        pair.device
            .say(vec![Alert { kind: 2, code: 2 }], SystemStatus(SystemStatus::UNOCCUPIED));
        for number in 8..12 {
            pair.show(frame(number, vec![tool(1, 0), tool(2, 0)]));
        }
        let last = pair.published.last().unwrap();
        assert_eq!(last.tool(Handle(2)).unwrap().why(), Why::Unplugged, "{poll}");
        assert!(last.tool(Handle(1)).unwrap().pose().is_ok());
        let told = |wanted: &Notice| pair.told.iter().filter(|notice| *notice == wanted).count();
        assert_eq!(told(&Notice::Unplugged(Handle(2))), 1);
        let of_itself = match poll {
            Poll::Bx2 => Notice::Alert(Alert { kind: 2, code: 2 }),
            _ => Notice::System(SystemStatus(SystemStatus::UNOCCUPIED)),
        };
        assert_eq!(told(&of_itself), 1);
    }
}

#[test]
fn a_tool_that_is_plugged_in_is_tracked_if_that_is_wanted() {
    let mut wired = rules();
    (wired.wired, wired.tools) = (true, Vec::new());
    let mut pair = Pair::new(wired, DeviceRules::default());
    let handle = pair.device.plug(rom()).unwrap();
    pair.event(ndi::session::Event::Connected);
    assert_eq!(pair.client.handles(), [handle]);
    pair.show(frame(7, vec![tool(handle.0, 0)]));
    assert!(pair.published.last().unwrap().tool(handle).unwrap().pose().is_ok());
}

#[test]
fn a_device_that_only_knows_less_than_what_is_told_is_left() {
    let mut told = rules();
    told.poll = Some(Poll::Bx2);
    let mut pair = Pair::new(
        told,
        DeviceRules {
            bx2: false,
            ..DeviceRules::default()
        },
    );
    pair.event(ndi::session::Event::Connected);
    pair.wait(1000);
    assert!(matches!(pair.closed, Some(Reason::TooManyRefused { count: 5, .. })));
    let refused = |notice: &&Notice| {
        matches!(
            notice,
            Notice::Refused {
                error: ErrorCode(1),
                ..
            }
        )
    };
    assert_eq!(pair.told.iter().filter(refused).count(), 4);
}

#[test]
fn only_what_is_wanted_is_asked_for() {
    let mut none = rules();
    none.markers = Markers::None;
    let mut pair = Pair::new(none, DeviceRules::default());
    pair.event(ndi::session::Event::Connected);
    pair.show(frame(7, vec![tool(1, 0)]));
    assert!(pair.published.last().unwrap().markers.is_empty());
    assert!(pair.now < 100 * MS);
    // Strays alone: not the markers of tools.
    for (_, device) in devices() {
        let mut pair = connected(device);
        let mut seen = frame(7, vec![tool(1, 0)]);
        seen.markers.push(ndi::Bx2Markers {
            handle: Handle(1),
            markers: vec![stray(0, 0)],
        });
        pair.show(seen);
        let markers = &pair.published.last().unwrap().markers;
        assert!(!markers.is_empty() && markers.iter().all(|marker| marker.tool().is_none()));
    }
}

#[test]
fn markers_of_tools_and_of_none_come_with_whose_they_are() {
    let mut all = rules();
    all.markers = Markers::All;
    for (poll, device) in devices() {
        let mut pair = Pair::new(all.clone(), device);
        pair.event(ndi::session::Event::Connected);
        let mut seen = frame(7, vec![tool(1, 0), tool(2, 0)]);
        seen.markers.push(ndi::Bx2Markers {
            handle: Handle(2),
            markers: vec![stray(0, 0), stray(1, 5)],
        });
        pair.show(seen);
        let markers = &pair.published.last().unwrap().markers;
        let of = |handle: Option<Handle>| markers.iter().filter(move |marker| marker.tool() == handle);
        assert!(of(None).next().unwrap().place_mm().is_ok(), "{poll}");
        let of_tool: Vec<_> = of(Some(Handle(2))).map(|marker| marker.place_mm()).collect();
        let expected = [Ok([0.0, 2.0, -1400.0]), Err(Why::OutOfVolume)];
        // TX has no markers of tools.
        assert_eq!(of_tool, if poll == Poll::Tx { &[][..] } else { &expected });
    }
}
