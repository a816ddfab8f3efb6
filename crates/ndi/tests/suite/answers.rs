//! Texts: what they say, and the lists among them.

use ndi::status::PortStatus;
use ndi::{
    Answer, ErrorCode, Fault, Handle, Port, PortInfo, ToolInfo, Value, parse_phinf, parse_phrq, parse_phsr,
    phsr_fields, phsr_text,
};

#[test]
fn a_text_is_told_by_its_first_word() {
    let answers = [
        ("OKAY", Answer::Okay),
        ("RESET", Answer::Reset),
        ("WARNING", Answer::Warning(None)),
        ("WARNING05", Answer::Warning(Some(5))),
        ("ERROR0C", Answer::Error(ErrorCode::BAD_MODE)),
        ("ERRORF1", Answer::Error(ErrorCode(0xF1))),
        ("ERROR", Answer::Words("ERROR".to_owned())),
        ("ERRORXY", Answer::Words("ERRORXY".to_owned())),
        ("01", Answer::Words("01".to_owned())),
    ];
    for (text, answer) in answers {
        assert_eq!(Answer::of(text), answer);
        assert_eq!(answer.text(), text);
        let _: serde_json::Value = serde_json::from_str(&answer.fields().json()).unwrap();
    }
    assert_eq!(ErrorCode::BAD_CRC.to_string(), "ERROR04: the command has a wrong CRC");
    assert_eq!(ErrorCode(0xEE).words(), "an error without a known name");
}

#[test]
fn lines_are_fields_without_control_characters() {
    let fields = Answer::of("Simulated\nNDI S/N: \"1\"").fields();
    assert_eq!(fields.get("lines[1]"), Some(&Value::Text("NDI S/N: \"1\"".to_owned())));
    assert_eq!(
        fields.to_string(),
        "reply: text\nlines[0]: Simulated\nlines[1]: NDI S/N: \"1\"\n"
    );
}

#[test]
fn handles_and_lists_are_read_and_written() {
    assert_eq!(parse_phrq("0A"), Ok(Handle(10)));
    for bad in ["", "1", "0G", "011"] {
        assert!(parse_phrq(bad).is_err(), "{bad}");
    }
    let ports = [(1, 0x031), (2, 0x001), (255, 0xFFF)].map(|(handle, status)| Port {
        handle: Handle(handle),
        status: PortStatus(status),
    });
    assert_eq!(phsr_text(&ports), "030103102001FFFFF");
    assert_eq!(parse_phsr("030103102001FFFFF").unwrap(), ports);
    assert_eq!(parse_phsr("00").unwrap(), []);
    assert_eq!(
        phsr_fields(&ports).get("ports[1].means"),
        Some(&Value::Text("not initialised".to_owned()))
    );
    let fault = |text: &str| parse_phsr(text).unwrap_err().fault;
    assert!(matches!(fault("FF01031"), Fault::Ends { .. }));
    assert!(matches!(fault("0101031x"), Fault::Trailing { found: 1, .. }));
    assert!(matches!(fault("010103g"), Fault::NotHex { byte: b'g', .. }));
}

#[test]
fn what_is_known_of_a_tool_comes_back_for_all_options() {
    for options in 0..0x80 {
        let has = |bit: u16| options & bit != 0;
        let tool = ToolInfo {
            kind: "02000000".to_owned(),
            maker: "NDI".to_owned(),
            revision: "001".to_owned(),
            serial: "34802401".to_owned(),
            status: PortStatus(0x31),
        };
        let info = PortInfo {
            tool: has(1).then_some(tool),
            currents: has(2).then_some(0x1234_5678),
            part: has(4).then(|| "8700340".to_owned()),
            accessories: has(8).then_some(3),
            marker_kind: has(0x10).then_some(0x29),
            location: has(0x20).then(|| "00000000000001".to_owned()),
            lines: has(0x40).then_some(7),
        };
        assert_eq!(parse_phinf(&info.text(), options), Ok(Some(info.clone())));
        if options > 0 {
            assert!(parse_phinf(&info.text(), 0).is_err());
            let _: serde_json::Value = serde_json::from_str(&info.fields().json()).unwrap();
        }
    }
    assert_eq!(parse_phinf("UNOCCUPIED", 1), Ok(None));
}
