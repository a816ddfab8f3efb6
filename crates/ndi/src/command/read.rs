//! A line as a command.

use super::Command;
use crate::crc::crc16;
use crate::fault::{Fault, shown};
use crate::handle::Handle;
use crate::malformed::{Malformed, Recovery, Refusal};
use crate::options::{Bx2Options, ReplyOption};
use crate::rom::PIECE;
use crate::text::Text;
use crate::wire::long;

/// Characters of a request of PHRQ: hardware 8, system 1, tool 1, port 2, spare 2.
const REQUEST: usize = 14;

pub(super) fn command(line: &[u8]) -> Result<Command, Malformed> {
    let line = printable(line)?;
    let end = line.find(|c: char| !c.is_ascii_alphanumeric()).unwrap_or(line.len());
    let (name, rest) = line.split_at_checked(end).unwrap_or_default();
    let arguments = match rest.as_bytes().first() {
        Some(b':') => checked(line)?.get(end + 1..).unwrap_or_default(),
        Some(b' ') => rest.get(1..).unwrap_or_default(),
        None => "",
        Some(_) => {
            let found = shown(rest.as_bytes());
            let (field, allowed) = ("the end of a command's name", "a colon or a space");
            return Err(refused(Fault::Word { field, found, allowed }, end));
        }
    };
    let mut text = Text::new(arguments);
    match known(name, &mut text) {
        None => Ok(Command::Other(name.to_owned(), arguments.to_owned())),
        Some(Ok(command)) => Ok(command),
        Some(Err(mut refusal)) => {
            refusal.at += long(end) + 1;
            Err(refusal.of("a command"))
        }
    }
}

fn printable(line: &[u8]) -> Result<&str, Malformed> {
    let bad = line.iter().position(|byte| !(0x20..0x7f).contains(byte));
    match (bad, std::str::from_utf8(line)) {
        (None, Ok(line)) => Ok(line),
        _ => {
            let at = bad.unwrap_or_default();
            let byte = line.get(at).copied().unwrap_or_default();
            Err(refused(Fault::Byte { byte }, at))
        }
    }
}

/// The line without its CRC, which must be right.
fn checked(line: &str) -> Result<&str, Malformed> {
    let split = line.len().checked_sub(4).and_then(|at| line.split_at_checked(at));
    let Some((words, crc)) = split else {
        let found = long(line.len());
        return Err(refused(Fault::TextShort { found }, line.len()));
    };
    let computed = crc16(words.as_bytes());
    let found = Text::new(crc).hex16("the CRC of a command");
    let found = found.map_err(|refusal| refusal.of("a command"))?;
    if found != computed {
        return Err(refused(Fault::TextCrc { found, computed }, words.len()));
    }
    Ok(words)
}

/// The command of this name, if it is one of those that are known.
fn known(name: &str, text: &mut Text<'_>) -> Option<Result<Command, Refusal>> {
    let command = match name {
        "INIT" => Ok(Command::Init),
        "TSTART" => which(text).map(|_| Command::Tstart),
        "TSTOP" => Ok(Command::Tstop),
        "COMM" => rest(text).map(Command::Comm),
        "VER" => digit(text).map(Command::Ver),
        "BEEP" => digit(text).map(Command::Beep),
        "PHSR" => which(text).map(Command::Phsr),
        "PHRQ" => request(text).map(Command::Phrq),
        "PHF" => handle(text).map(Command::Phf),
        "PHINF" => handle(text).and_then(|handle| Ok(Command::Phinf(handle, options(text, 0x0001)?))),
        "PVWR" => piece(text),
        "PINIT" => handle(text).map(Command::Pinit),
        "PENA" => handle(text).and_then(|handle| Ok(Command::Pena(handle, priority(text)?))),
        "PDIS" => handle(text).map(Command::Pdis),
        "TX" => options(text, ReplyOption::TRANSFORMS).map(|bits| Command::Tx(ReplyOption(bits))),
        "BX" => options(text, ReplyOption::TRANSFORMS).map(|bits| Command::Bx(ReplyOption(bits))),
        "BX2" => bx2(text).map(Command::Bx2),
        _ => return None,
    };
    Some(command.and_then(|command| text.done("the last argument").map(|()| command)))
}

fn rest(text: &mut Text<'_>) -> Result<String, Refusal> {
    let all = text.take(text.rest().len(), "arguments")?;
    Ok(all.iter().map(|byte| char::from(*byte)).collect())
}

fn digit(text: &mut Text<'_>) -> Result<u8, Refusal> {
    text.hex(1, "a number")
        .map(|number| u8::try_from(number).unwrap_or_default())
}

fn which(text: &mut Text<'_>) -> Result<u8, Refusal> {
    if text.rest().is_empty() {
        Ok(0)
    } else {
        text.hex8("which handles")
    }
}

fn handle(text: &mut Text<'_>) -> Result<Handle, Refusal> {
    text.hex8("a handle").map(|handle| Handle(handle.into()))
}

fn options(text: &mut Text<'_>, default: u16) -> Result<u16, Refusal> {
    if text.rest().is_empty() {
        return Ok(default);
    }
    text.hex16("reply options")
}

fn request(text: &mut Text<'_>) -> Result<String, Refusal> {
    let request = text.take(REQUEST, "a request for a handle")?;
    Ok(request.iter().map(|byte| char::from(*byte)).collect())
}

fn priority(text: &mut Text<'_>) -> Result<char, Refusal> {
    let before = text.clone();
    match text.take(1, "a priority")? {
        [priority @ (b'S' | b'D' | b'B')] => Ok(char::from(*priority)),
        other => Err(before.refuse(Fault::Word {
            field: "a priority",
            found: shown(other),
            allowed: "S, D or B",
        })),
    }
}

fn piece(text: &mut Text<'_>) -> Result<Command, Refusal> {
    let handle = handle(text)?;
    let address = text.hex16("an address")?;
    let mut piece = Box::new([0; PIECE]);
    for byte in piece.iter_mut() {
        *byte = text.hex8("a piece of a definition")?;
    }
    Ok(Command::Pvwr(handle, address, piece))
}

fn bx2(text: &mut Text<'_>) -> Result<Bx2Options, Refusal> {
    let before = text.clone();
    Bx2Options::parse(&rest(text)?).map_err(|found| {
        before.refuse(Fault::Word {
            field: "options of BX2",
            found: shown(found.as_bytes()),
            allowed: "--6d, --3d and --1d with their words",
        })
    })
}

fn refused(fault: Fault, at: usize) -> Malformed {
    Malformed {
        fault,
        at: long(at),
        what: "a command",
        recovery: Recovery::NextReply,
    }
}
