//! Every status, row by row; and that nothing lost is ever valid.

use ndi::status::{HandleStatus, MarkerStatus, MarkerUse, PortStatus, SystemStatus, ToolInformation, ToolStatus};
use ndi::{Bx2, Frame, Handle, Polled, PolledTool, Why};

use crate::support::{frame, tool, transform};

#[test]
fn each_code_of_a_tool_has_its_reason() {
    let rows = [
        (0, "valid"),
        (3, "partly out of volume"),
        (5, "partly averaged"),
        (9, "out of volume"),
        (13, "too few markers"),
        (14, "interference"),
        (17, "bad fit"),
        (18, "too much data"),
        (19, "too much to compute"),
        (20, "the device is behind"),
        (21, "sensors out of step"),
        (22, "processing error"),
        (31, "missing"),
        (32, "disabled"),
        (33, "unplugged"),
    ];
    for code in 0..=255_u16 {
        let row = rows.iter().find(|(known, _)| *known == code);
        let why = ToolStatus(code).why();
        match row {
            Some((_, words)) => assert_eq!(why.to_string(), *words),
            None => assert_eq!(why.to_string(), format!("tool status {code:#x} is not known")),
        }
    }
    let all = ToolStatus(0b1010_0011_0000_0000);
    assert!(all.is_missing() && all.is_averaged());
    assert_eq!((all.face(), all.code(), all.why()), (5, 0, Why::Missing));
}

/// The rule once more, in words of its own: only a code of 0 with nothing but the bit of averaging and the face.
#[test]
fn no_lost_tool_is_valid_whatever_its_status() {
    for status in 0..=u16::MAX {
        let is_good = status & !0b1110_0010_0000_0000 == 0;
        let reply = Bx2 {
            frames: vec![frame(1, vec![tool(1, status)])],
            ..Bx2::default()
        };
        let again = ndi::parse_bx2(&ndi::bx2_body(&reply)).unwrap();
        let sight = Frame::of_bx2(&again, 1e-3)[0].tools[0];
        assert_eq!(sight.pose().is_ok(), is_good, "{status:#06x}");
        assert_eq!(sight.why().is_valid(), is_good, "{status:#06x}");
        // The same status of the whole frame.
        let mut whole = reply.clone();
        whole.frames[0].tools = vec![tool(1, 0)];
        whole.frames[0].status = ToolStatus(status);
        let frame = &Frame::of_bx2(&whole, 1e-3)[0];
        assert_eq!(frame.tools[0].pose().is_ok(), is_good, "frame {status:#06x}");
        assert_eq!(frame.markers[0].place_mm().is_ok(), is_good, "frame {status:#06x}");
    }
}

#[test]
fn each_bit_of_a_port_has_its_reason() {
    let rows = [
        (0, "unplugged"),
        (1, "valid"),
        (2, "valid"),
        (3, "valid"),
        (4, "not initialised"),
        (5, "disabled"),
        (6, "out of volume"),
        (7, "partly out of volume"),
        (8, "too much to compute"),
        (9, "interference"),
        (12, "processing error"),
        (14, "the device is behind"),
        (15, "too much data"),
    ];
    for bit in 0..32 {
        let status = 0x31_u32 ^ 1 << bit;
        let why = PortStatus(status).why();
        match rows.iter().find(|(known, _)| *known == bit) {
            Some((_, words)) => assert_eq!(why.to_string(), *words, "{bit}"),
            None => assert_eq!(why.to_string(), format!("port status {status:#x} is not known")),
        }
    }
}

/// Again in words of its own: bits 0, 4 and 5, and beside them the three switches alone.
#[test]
fn no_lost_handle_is_valid_whatever_its_statuses() {
    for handle in 0..=255_u8 {
        for port in (0..=u16::MAX)
            .step_by(if handle == 1 { 1 } else { 251 })
            .map(u32::from)
            .chain([0x8000_0031])
        {
            let is_good = handle == 1 && port & !0b1110 == 0b11_0001;
            let mut tool = PolledTool::new(Handle(1), HandleStatus(handle));
            (tool.port, tool.frame, tool.transform) = (Some(PortStatus(port)), Some(7), Some(transform(1.0)));
            let polled = Polled {
                tools: vec![tool],
                ..Polled::default()
            };
            let frame = &Frame::of_polled(&polled, 1e-3)[0];
            assert_eq!(frame.tools[0].pose().is_ok(), is_good, "{handle} {port:#x}");
        }
    }
}

#[test]
fn each_status_of_a_handle_has_its_reason() {
    assert_eq!(HandleStatus(1).why(PortStatus::GOOD), Why::Valid);
    assert_eq!(HandleStatus(2).why(PortStatus::GOOD), Why::Missing);
    assert_eq!(HandleStatus(2).why(PortStatus(0x71)), Why::OutOfVolume);
    assert_eq!(HandleStatus(4).why(PortStatus::GOOD), Why::Disabled);
    let unknown = HandleStatus(3).why(PortStatus::GOOD);
    assert_eq!(unknown.to_string(), "handle status 0x3 is not known");
}

#[test]
fn each_status_of_a_marker_has_its_reason() {
    let words = [
        "valid",
        "missing",
        "seen too steeply",
        "marker off its place",
        "out of volume",
        "out of volume",
        "possible phantom",
        "saturated",
        "saturated, out of volume",
    ];
    for code in 0..=255_u8 {
        let why = MarkerStatus(code).why().to_string();
        match words.get(usize::from(code)) {
            Some(words) => assert_eq!(why, *words),
            None => assert_eq!(why, format!("marker status {code:#x} is not known")),
        }
        assert_eq!(MarkerStatus(code).why().is_valid(), code == 0);
        assert_eq!(MarkerUse(code).why().is_valid(), code == 3);
    }
}

#[test]
fn each_bit_of_a_tools_information_has_its_reason() {
    let rows = [
        (0, "bad fit"),
        (1, "too few markers"),
        (2, "interference"),
        (3, "the device is behind"),
        (7, "processing error"),
    ];
    for bit in 0..8 {
        let why = ToolInformation(1 << bit).why().to_string();
        let row = rows.iter().find(|(known, _)| *known == bit);
        assert_eq!(why, row.map_or("valid", |(_, words)| words));
    }
    assert_eq!(ToolInformation(0x70).face(), 7);
}

#[test]
fn what_is_said_of_a_tool_goes_before_its_transform() {
    let mut tool = PolledTool::new(Handle(1), HandleStatus::VALID);
    tool.port = Some(PortStatus::GOOD);
    assert_eq!(tool.why(), Why::Valid);
    tool.information = Some(ndi::Information {
        tool: ToolInformation(1),
        markers: [MarkerUse(0); 20],
    });
    assert_eq!(tool.why(), Why::BadFit);
    // A pose whose port's status was not asked for is not known to be valid.
    tool.port = None;
    assert_eq!(tool.why(), Why::Unplugged);
}

#[test]
fn each_bit_of_the_system_has_words() {
    for bit in 0..16 {
        assert_eq!(SystemStatus(1 << bit).words().len(), 1, "{bit}");
    }
    assert_eq!(SystemStatus(0).words().len(), 0);
    assert_eq!(SystemStatus(0x8000).words(), ["a status that is not known"]);
}
