//! The CRCs of replies: checked, and written.

use super::{BODY_CRC, CR, LONG, Reply, SHORT};
use crate::crc::crc16;
use crate::fault::Fault;
use crate::malformed::{Malformed, Recovery};
use crate::wire::long;

/// Characters of the CRC at the end of a text.
const TEXT_CRC: usize = 4;

pub(super) fn checked_text(text: &[u8]) -> Result<Reply<'_>, Malformed> {
    let next = |fault, at| Malformed {
        fault,
        at: long(at),
        what: "a text",
        recovery: Recovery::NextReply,
    };
    let split = text.len().checked_sub(TEXT_CRC);
    let Some((words, crc)) = split.and_then(|at| text.split_at_checked(at)) else {
        let found = long(text.len());
        return Err(next(Fault::TextShort { found }, text.len()));
    };
    let computed = crc16(words);
    let mut found = 0_u16;
    for (byte, at) in crc.iter().zip(words.len()..) {
        let Some(digit) = char::from(*byte).to_digit(16) else {
            let field = "the CRC of a text";
            return Err(next(Fault::NotHex { field, byte: *byte }, at));
        };
        found = found << 4 | u16::try_from(digit).unwrap_or_default();
    }
    if found != computed {
        return Err(next(Fault::TextCrc { found, computed }, words.len()));
    }
    // The bytes were looked at as they came.
    Ok(Reply::Text(std::str::from_utf8(words).unwrap_or_default()))
}

pub(super) fn checked_body(held: &[u8]) -> Result<Reply<'_>, Malformed> {
    let split = held.len().saturating_sub(BODY_CRC);
    let (body, crc) = held.split_at_checked(split).unwrap_or_default();
    let found = crc.first_chunk().copied().map_or(0, u16::from_le_bytes);
    let computed = crc16(body);
    if found == computed {
        return Ok(Reply::Binary(body));
    }
    let fault = match error_inside(held) {
        Some(code) => Fault::ErrorInside { code },
        None => Fault::BodyCrc { found, computed },
    };
    Err(Malformed {
        fault,
        at: long(body.len()),
        what: "a binary reply",
        recovery: Recovery::NextReply,
    })
}

/// The error that a device wrote in the middle of a body: `ERRORnn`, its CRC, a carriage return.
pub(super) fn error_inside(bytes: &[u8]) -> Option<u8> {
    const LENGTH: usize = 12;
    bytes.windows(LENGTH).find_map(|window| {
        let text = window.strip_suffix(&[CR])?;
        let Ok(Reply::Text(words)) = checked_text(text) else {
            return None;
        };
        u8::from_str_radix(words.strip_prefix("ERROR")?, 16).ok()
    })
}

/// A text as a device sends it: with its CRC and a carriage return.
pub fn text_reply(words: &str) -> Vec<u8> {
    format!("{words}{:04X}\r", crc16(words.as_bytes())).into_bytes()
}

/// A body as a device sends it: in a short reply where its length has 16 bits, else in a long one.
pub fn binary_reply(body: &[u8]) -> Vec<u8> {
    let mut reply = match u16::try_from(body.len()) {
        Ok(length) => [&SHORT[..], &length.to_le_bytes()].concat(),
        Err(_) => {
            let length = u32::try_from(body.len()).unwrap_or(u32::MAX);
            [&LONG[..], &length.to_le_bytes()].concat()
        }
    };
    reply.extend(crc16(&reply).to_le_bytes());
    reply.extend(body);
    reply.extend(crc16(body).to_le_bytes());
    reply
}
