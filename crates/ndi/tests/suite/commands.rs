//! Commands as bytes, and read back.

use ndi::crc::{bitwise, crc16};
use ndi::{Bx2Options, Command, Fault, Handle, Markers, ReplyOption, WIRELESS};
use proptest::prelude::*;

fn all() -> Vec<Command> {
    let bx2 = |markers| {
        Command::Bx2(Bx2Options {
            markers,
            ..Bx2Options::default()
        })
    };
    vec![
        Command::Init,
        Command::Comm("50001".to_owned()),
        Command::Ver(4),
        Command::Phsr(0),
        Command::Phrq(WIRELESS.to_owned()),
        Command::Phf(Handle(3)),
        Command::Phinf(Handle(0xA1), 0x0025),
        Command::Pvwr(Handle(2), 0x02C0, Box::new([0x5A; 64])),
        Command::Pinit(Handle(1)),
        Command::Pena(Handle(1), 'D'),
        Command::Pdis(Handle(1)),
        Command::Tstart,
        Command::Tstop,
        Command::Tx(ReplyOption(0x1801)),
        Command::Bx(ReplyOption(0x0801)),
        bx2(Markers::None),
        bx2(Markers::Strays),
        bx2(Markers::All),
        Command::Beep(2),
        Command::Other("GET".to_owned(), "Info.Status.Alerts".to_owned()),
    ]
}

#[test]
fn the_crc_is_that_of_the_guide() {
    assert_eq!(Command::Init.to_bytes(true), b"INIT:E3A5\r");
    assert_eq!(Command::Ver(0).to_bytes(true), b"VER:065EE\r");
    assert_eq!((crc16(b"OKAY"), crc16(b"RESET")), (0xA896, 0xBE6F));
    assert_eq!(crc16(b"123456789"), 0xBB3D);
}

#[test]
fn commands_come_back_with_and_without_a_crc() {
    for command in all() {
        for with_crc in [true, false] {
            let bytes = command.to_bytes(with_crc);
            let line = bytes.strip_suffix(b"\r").unwrap();
            assert_eq!(Command::parse(line).as_ref(), Ok(&command), "{}", bytes.escape_ascii());
        }
    }
    assert_eq!(Command::Bx(ReplyOption(0x0801)).to_bytes(false), b"BX 0801\r");
    assert_eq!(Command::parse(b"BX"), Ok(Command::Bx(ReplyOption(1))));
    assert_eq!(Command::parse(b"INIT"), Ok(Command::Init));
}

#[test]
fn a_command_with_a_wrong_crc_or_wrong_arguments_is_refused_by_name() {
    let fault = |line: &[u8]| Command::parse(line).unwrap_err().fault;
    assert!(matches!(
        fault(b"INIT:E3A6"),
        Fault::TextCrc {
            found: 0xE3A6,
            computed: 0xE3A5
        }
    ));
    assert!(matches!(fault(b"INIT:E3G5"), Fault::NotHex { byte: b'G', .. }));
    assert!(matches!(fault(b"A:"), Fault::TextShort { found: 2 }));
    assert!(matches!(
        fault(b"BX 08"),
        Fault::Ends {
            needed: 4,
            found: 2,
            ..
        }
    ));
    assert!(matches!(fault(b"BX 08011"), Fault::Trailing { found: 1, .. }));
    assert!(matches!(fault(b"PENA 01X"), Fault::Word { .. }));
    assert!(matches!(fault(b"BX2 --3d=some"), Fault::Word { .. }));
    assert!(matches!(fault(b"VER \x00"), Fault::Byte { byte: 0 }));
    let malformed = Command::parse(b"PVWR 01000G").unwrap_err();
    assert_eq!(
        malformed.to_string(),
        "byte 7 of a command: byte 0x47 in an address; allowed are hexadecimal digits"
    );
}

#[test]
fn every_changed_byte_of_a_command_with_a_crc_is_refused_or_another_command() {
    for command in all() {
        let good = command.to_bytes(true);
        let good = good.strip_suffix(b"\r").unwrap();
        for at in 0..good.len() {
            for change in [1, 4, 32, 255] {
                let mut bytes = good.to_vec();
                bytes[at] ^= change;
                // Without its colon it is a command without a CRC, and then has too many arguments or another name.
                if Command::parse(&bytes) == Ok(command.clone()) {
                    assert!(bytes.eq_ignore_ascii_case(good), "{}", bytes.escape_ascii());
                }
            }
        }
    }
}

proptest! {
    #[test]
    fn the_table_agrees_with_the_bits(bytes: Vec<u8>) {
        prop_assert_eq!(crc16(&bytes), bitwise(&bytes));
    }

    #[test]
    fn no_line_is_too_much(bytes: Vec<u8>, name in "BX2?|TX|PVWR|PENA|PHSR|VER|PHINF") {
        let _ = Command::parse(&bytes);
        let _ = Command::parse(&[name.as_bytes(), b" ", &bytes].concat());
    }
}
