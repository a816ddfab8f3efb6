//! TX and BX: what each option brings, and what is refused.

use ndi::status::{HandleStatus, MarkerUse, PortStatus, SystemStatus, ToolInformation};
use ndi::{
    Fault, Handle, Information, Polled, PolledTool, ReplyOption, Single, Spot, Spots, Transform, Value, bx_body,
    parse_bx, parse_tx, tx_text,
};

use crate::support::transform;

fn spots() -> Spots {
    let spot = |x: f64, out_of_volume| Spot {
        out_of_volume,
        place_mm: Some([x, -0.5, -1200.25]),
    };
    Spots((0..11).map(|n| spot(f64::from(n), n == 1 || n == 9)).collect())
}

/// A seen tool, a missing one and a disabled one, with all that a reply can have.
pub(crate) fn full() -> Polled {
    let tool = |handle, status| {
        let mut tool = PolledTool::new(Handle(handle), HandleStatus(status));
        if status == 4 {
            return tool;
        }
        tool.transform = (status == 1).then(|| transform(1.0));
        tool.port = Some(PortStatus(0x33));
        tool.frame = Some(0x1234_5678);
        let mut markers = [MarkerUse(0); 20];
        markers[0] = MarkerUse(3);
        markers[19] = MarkerUse(5);
        tool.information = Some(Information {
            tool: ToolInformation(0x20),
            markers,
        });
        tool.single = Some(Single {
            status: 1,
            place_mm: Some([1.0, 2.0, 3.0]),
        });
        tool.markers = Some(spots());
        tool
    };
    Polled {
        tools: vec![tool(1, 1), tool(2, 2), tool(3, 4)],
        strays: Some(spots()),
        system: SystemStatus(0x0080),
    }
}

/// What is left of it with these options.
pub(crate) fn reduced(mut polled: Polled, options: ReplyOption) -> Polled {
    let reduce = |spots: &mut Option<Spots>, bit: u16| {
        if !options.has(bit) {
            *spots = None;
        } else if let (Some(spots), false) = (spots, options.has(ReplyOption::OUT_OF_VOLUME)) {
            spots
                .0
                .iter_mut()
                .filter(|spot| spot.out_of_volume)
                .for_each(|spot| spot.place_mm = None);
        }
    };
    reduce(&mut polled.strays, ReplyOption::STRAYS);
    for tool in &mut polled.tools {
        reduce(&mut tool.markers, ReplyOption::MARKERS);
        if !options.has(ReplyOption::TRANSFORMS) {
            (tool.transform, tool.port, tool.frame) = (None, None, None);
        }
        if !options.has(ReplyOption::INFORMATION) {
            tool.information = None;
        }
        if !options.has(ReplyOption::SINGLE_STRAY) {
            tool.single = None;
        }
    }
    polled
}

#[test]
fn bx_comes_back_with_every_combination_of_options() {
    for bits in 0..=ReplyOption::OF_BX {
        let options = ReplyOption(bits & ReplyOption::OF_BX);
        let body = bx_body(&full(), options);
        assert_eq!(parse_bx(&body, options), Ok(reduced(full(), options)), "{bits:04X}");
    }
}

#[test]
fn tx_comes_back_with_every_combination_of_options() {
    for bits in (0..8).flat_map(|bits| [bits, bits | 0x0800, bits | 0x1000, bits | 0x1800]) {
        let options = ReplyOption(bits);
        let mut expected = reduced(full(), options);
        expected.tools.iter_mut().for_each(|tool| tool.markers = None);
        // A disabled tool has its port and frame in TX, and all that follows.
        let mut sent = full();
        for polled in [&mut sent, &mut expected] {
            if options.has(ReplyOption::TRANSFORMS) {
                polled.tools[2].port = Some(PortStatus(0x11));
                polled.tools[2].frame = Some(7);
            }
            if options.has(ReplyOption::INFORMATION) {
                polled.tools[2].information = polled.tools[0].information;
            }
            if options.has(ReplyOption::SINGLE_STRAY) {
                polled.tools[2].single = polled.tools[0].single;
            }
        }
        if !options.has(ReplyOption::TRANSFORMS) {
            expected
                .tools
                .iter_mut()
                .for_each(|tool| tool.status = HandleStatus::MISSING);
        }
        assert_eq!(parse_tx(&tx_text(&sent, options), options), Ok(expected), "{bits:04X}");
    }
}

#[test]
fn a_text_of_a_device_is_read() {
    let text = "0401+07279-00000+06857-00003+001234-000567-180001+00770000000310000ABCD\n\
                02MISSING0000007100000001\n03DISABLED0000001100000001\n0AUNOCCUPIED\n0000";
    let polled = parse_tx(text, ReplyOption(1)).unwrap();
    let expected = Transform {
        q: [0.7279, 0.0, 0.6857, -0.0003],
        t_mm: [12.34, -5.67, -1800.01],
        error_mm: 0.077,
    };
    assert_eq!(polled.tools[0].transform, Some(expected));
    assert!(polled.tools[0].transform.unwrap().q[1].is_sign_positive());
    assert_eq!(polled.tools[0].frame, Some(0xABCD));
    let why: Vec<String> = polled.tools.iter().map(|tool| tool.why().to_string()).collect();
    assert_eq!(why, ["valid", "out of volume", "disabled", "unplugged"]);
    let fields = polled.fields("TX");
    assert_eq!(fields.get("tools[0].frame"), Some(&Value::Whole(0xABCD)));
    let _: serde_json::Value = serde_json::from_str(&fields.json()).unwrap();
}

#[test]
fn a_reply_to_other_options_is_refused_and_not_misread() {
    let body = bx_body(&full(), ReplyOption(0x0801));
    for other in [0x0003, 0x0009, 0x1801, 0x0800] {
        assert!(parse_bx(&body, ReplyOption(other)).is_err(), "{other:04X}");
    }
    assert!(matches!(
        parse_bx(&[], ReplyOption(1)).unwrap_err().fault,
        Fault::Ends { .. }
    ));
    assert!(matches!(
        parse_bx(&[200, 1, 1], ReplyOption(1)).unwrap_err().fault,
        Fault::TooMany { .. }
    ));
    let more = [&body[..], &[0]].concat();
    assert!(matches!(
        parse_bx(&more, ReplyOption(0x0801)).unwrap_err().fault,
        Fault::Trailing { .. }
    ));
    let fault = |text: &str| parse_tx(text, ReplyOption(1)).unwrap_err().fault;
    assert!(matches!(fault("0101MISSING0000003100000001"), Fault::Word { .. }));
    assert!(matches!(fault("0101+0727x"), Fault::NotDecimal { byte: b'x', .. }));
    assert!(matches!(fault("0101 07279"), Fault::NotDecimal { byte: b' ', .. }));
    assert!(matches!(fault("00000"), Fault::Ends { .. }));
    assert!(matches!(fault("00000012"), Fault::Trailing { found: 2, .. }));
    let error = parse_tx("0G", ReplyOption(1)).unwrap_err();
    assert_eq!(
        error.to_string(),
        "byte 0 of TX: byte 0x47 in number of handles; allowed are hexadecimal digits"
    );
}
