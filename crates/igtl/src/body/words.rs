//! STATUS, STRING and COMMAND: words for a person, or for a program on the other side.

use crate::fault::{Fault, SizeRule};
use crate::fields::Fields;
use crate::malformed::Refusal;
use crate::name::{DeviceName, Name, shown};
use crate::text::Text;
use crate::wire::{Reader, counted, long};

const STATUS_BYTES: u64 = 30;
const STRING_BYTES: u64 = 4;
const COMMAND_BYTES: u64 = 138;

/// STATUS: how the sender is. `u16` code, `i64` code of the device, name of the error (20), words up to a zero.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Status {
    /// 1 is "OK", others are errors: [`Status::meaning`].
    pub code: u16,
    /// What the device means by it.
    pub subcode: i64,
    /// The error's name, control characters made `?`: the C++ library (1.11) leaves the field as it finds it where its user sets none, and
    /// such a STATUS is as good a sign of life as another.
    pub name: DeviceName,
    /// Words, without the zero that ends them on the wire.
    pub words: Vec<u8>,
}

impl Status {
    /// The code of "OK".
    pub const OK: u16 = 1;
    /// The code of an instruction that is not known.
    pub const ILLEGAL_INSTRUCTION: u16 = 12;

    /// What a code means by the protocol; `None` for codes that it does not have.
    pub const fn meaning(code: u16) -> Option<&'static str> {
        Some(match code {
            0 => "invalid packet",
            1 => "OK",
            2 => "unknown error",
            3 => "panic mode",
            4 => "not found",
            5 => "access denied",
            6 => "busy",
            7 => "time out or connection lost",
            8 => "overflow, cannot be reached",
            9 => "checksum error",
            10 => "configuration error",
            11 => "not enough of a resource",
            12 => "illegal or unknown instruction",
            13 => "not ready",
            14 => "manual mode",
            15 => "disabled",
            16 => "not present",
            17 => "unknown version",
            18 => "hardware failure",
            19 => "shutting down",
            _ => return None,
        })
    }

    /// With these words.
    pub fn new(code: u16, words: &str) -> Self {
        Self {
            code,
            subcode: 0,
            name: DeviceName::EMPTY,
            words: words.into(),
        }
    }

    pub(crate) fn read(reader: &mut Reader<'_>) -> Result<Self, Refusal> {
        reader.sized(SizeRule::AtLeast(STATUS_BYTES))?;
        Ok(Self {
            code: reader.u16()?,
            subcode: reader.i64()?,
            name: reader.scrubbed()?,
            words: reader
                .rest()
                .split(|byte| *byte == 0)
                .next()
                .unwrap_or_default()
                .to_vec(),
        })
    }

    pub(crate) fn write(&self, out: &mut Vec<u8>) -> Result<(), Fault> {
        if let Some(place) = self.words.iter().position(|byte| *byte == 0) {
            return Err(Fault::TextLength {
                found: long(self.words.len()),
                allowed: long(place),
            });
        }
        out.extend(self.code.to_be_bytes());
        out.extend(self.subcode.to_be_bytes());
        out.extend(self.name.field());
        out.extend(&self.words);
        out.push(0);
        Ok(())
    }

    pub(crate) fn fields(&self, fields: &mut Fields) {
        fields.add("code", self.code);
        fields.add("meaning", Self::meaning(self.code).unwrap_or("not in the protocol"));
        fields.add("subcode", self.subcode);
        fields.add("error", &self.name);
        fields.add("words", shown(&self.words));
    }
}

/// The text behind a length; nothing may stand behind it.
fn whole_text(reader: &mut Reader<'_>, encoding: u16, length: u64) -> Result<Text, Refusal> {
    if length != reader.left() {
        return Err(reader.refuse(Fault::TextLength {
            found: length,
            allowed: reader.left(),
        }));
    }
    Ok(Text {
        encoding,
        bytes: reader.rest().to_vec(),
    })
}

/// STRING: `u16` character set, `u16` bytes, text.
pub(crate) fn read_string(reader: &mut Reader<'_>) -> Result<Text, Refusal> {
    reader.sized(SizeRule::AtLeast(STRING_BYTES))?;
    let (encoding, length) = (reader.u16()?, reader.u16()?);
    whole_text(reader, encoding, length.into())
}

pub(crate) fn write_string(text: &Text, out: &mut Vec<u8>) -> Result<(), Fault> {
    let length: u16 = counted(text.bytes.len(), "bytes of a text", u16::MAX.into())?;
    out.extend(text.encoding.to_be_bytes());
    out.extend(length.to_be_bytes());
    out.extend(&text.bytes);
    Ok(())
}

pub(crate) fn text_fields(text: &Text, fields: &mut Fields) {
    fields.add("encoding", text.encoding);
    fields.add("text", text.to_string());
}

/// COMMAND, and RTS_COMMAND, which answers one of the same number: `u32` number, name (128), `u16` character set, `u32`
/// bytes, text.
///
/// In an answer the C++ library puts words about an error in the place of the name; further answers are in the
/// metadata.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Command {
    /// The asker's number of it.
    pub number: u32,
    /// Its name.
    pub name: Name<128>,
    /// What is to be done, often XML.
    pub content: Text,
}

impl Command {
    pub(crate) fn read(reader: &mut Reader<'_>) -> Result<Self, Refusal> {
        reader.sized(SizeRule::AtLeast(COMMAND_BYTES))?;
        let (number, name) = (reader.u32()?, reader.label("the name of a command")?);
        let (encoding, length) = (reader.u16()?, reader.u32()?);
        Ok(Self {
            number,
            name,
            content: whole_text(reader, encoding, length.into())?,
        })
    }

    pub(crate) fn write(&self, out: &mut Vec<u8>) -> Result<(), Fault> {
        let length: u32 = counted(self.content.bytes.len(), "bytes of a text", u32::MAX.into())?;
        out.extend(self.number.to_be_bytes());
        out.extend(self.name.field());
        out.extend(self.content.encoding.to_be_bytes());
        out.extend(length.to_be_bytes());
        out.extend(&self.content.bytes);
        Ok(())
    }

    pub(crate) fn fields(&self, fields: &mut Fields) {
        fields.add("number", self.number);
        fields.add("name", &self.name);
        text_fields(&self.content, fields);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The C++ library's own STATUS was refused where its user had set no name: three of them ended the connection.
    #[test]
    fn a_status_whose_name_was_never_set_is_read() {
        let mut bytes = vec![0; 30];
        bytes[1] = 1;
        bytes[10..15].copy_from_slice(b"\n\x80a\x1b\x00");
        bytes[16] = 7;
        let status = Status::read(&mut Reader::new(&bytes, 0)).unwrap();
        assert_eq!(status.code, Status::OK);
        assert_eq!(status.name.as_bytes(), b"?\x80a?");
    }
}
