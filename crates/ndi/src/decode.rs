//! The bytes of a device as replies: all at once, or as they come.

mod framing;

pub use framing::{binary_reply, text_reply};

use crate::crc::crc16;
use crate::fault::Fault;
use crate::limits::Limits;
use crate::malformed::{Malformed, Recovery};
use crate::wire::long;
use framing::{checked_body, checked_text, error_inside};

/// Start sequence of a binary reply, as it lies on the wire; then u16 length, u16 CRC of these four bytes, body, u16
/// CRC of the body.
const SHORT: [u8; 2] = [0xC4, 0xA5];
/// The same of a long one, whose length has 32 bits.
const LONG: [u8; 2] = [0xC8, 0xA5];
/// The end of a text.
const CR: u8 = b'\r';
/// Bytes of the CRC behind a body.
const BODY_CRC: usize = 2;

/// A reply whose CRCs are right, without them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reply<'a> {
    /// A text: printable ASCII and line feeds.
    Text(&'a str),
    /// The body of a binary reply.
    Binary(&'a [u8]),
}

/// What is held so far.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Stage {
    /// Nothing, or a first byte that tells too little.
    Start,
    /// A text without its end.
    Text,
    /// A header of this length.
    Header(usize),
    /// A header of the first length, then a body and its CRC of the second.
    Body(usize, usize),
    /// The stream has lost its place: all is dropped until [`Decoder::restart`].
    Lost,
}

/// Takes a stream in pieces of any length and gives its replies, one after the other.
///
/// It holds at most one reply, within [`Limits`], and no more than twice what has come of it.
#[derive(Debug, Clone)]
pub struct Decoder {
    limits: Limits,
    held: Vec<u8>,
    stage: Stage,
    /// What is held was given away and goes when more comes.
    given: bool,
}

impl Decoder {
    /// At the start of a stream.
    pub const fn new(limits: Limits) -> Self {
        Self {
            limits,
            held: Vec::new(),
            stage: Stage::Start,
            given: false,
        }
    }

    /// Bytes that have come of a reply that is not whole; 0 between replies.
    pub const fn come(&self) -> usize {
        if self.given { 0 } else { self.held.len() }
    }

    /// Forgets what is held: the next byte begins a reply. For after a silence.
    pub fn restart(&mut self) {
        self.held.clear();
        self.stage = Stage::Start;
        self.given = false;
    }

    /// Takes bytes from the front of `bytes` until there is something to say; `None` once all were taken.
    ///
    /// After a refusal with [`Recovery::Silence`] everything is taken and dropped until [`Decoder::restart`].
    pub fn feed(&mut self, bytes: &mut &[u8]) -> Option<Result<Reply<'_>, Malformed>> {
        if self.given {
            self.restart();
        }
        loop {
            if self.stage == Stage::Lost {
                *bytes = &[];
                return None;
            }
            let wanted = self.wants();
            let (now, later) = bytes.split_at_checked(wanted.min(bytes.len()))?;
            if now.is_empty() {
                return None;
            }
            self.held.extend(now);
            *bytes = later;
            match self.advance() {
                Ok(false) => {}
                Ok(true) => {
                    self.given = true;
                    return Some(self.whole());
                }
                Err(malformed) => {
                    self.restart();
                    if malformed.recovery == Recovery::Silence {
                        self.stage = Stage::Lost;
                    }
                    return Some(Err(malformed));
                }
            }
        }
    }

    /// What is wrong with a stream that ends here; `None` between two replies.
    pub fn end(&self) -> Option<Malformed> {
        let found = self.come();
        if found == 0 {
            return None;
        }
        if let (Stage::Body(header, _), Some(code)) = (self.stage, error_inside(&self.held)) {
            return Some(lost(Fault::ErrorInside { code }, header, "a binary reply"));
        }
        let (needed, what) = match self.stage {
            Stage::Body(header, rest) => (header.saturating_add(rest), "a binary reply"),
            Stage::Header(header) => (header, "a binary reply"),
            _ => (found + 1, "a reply"),
        };
        let fault = Fault::Truncated {
            found: long(found),
            needed: long(needed),
        };
        Some(lost(fault, found, what))
    }

    /// How many bytes may be taken at once without taking one of the next reply.
    fn wants(&self) -> usize {
        let needed = match self.stage {
            Stage::Header(header) => header,
            Stage::Body(header, rest) => header.saturating_add(rest),
            Stage::Start | Stage::Text | Stage::Lost => self.held.len() + 1,
        };
        needed.saturating_sub(self.held.len()).max(1)
    }

    /// Looks at what has come; whether it is a whole reply.
    fn advance(&mut self) -> Result<bool, Malformed> {
        match self.stage {
            Stage::Start => self.start(),
            Stage::Text => self.text(),
            Stage::Header(header) if self.held.len() >= header => self.header(header).map(|()| false),
            Stage::Body(header, rest) => Ok(self.held.len() >= header.saturating_add(rest)),
            Stage::Header(_) | Stage::Lost => Ok(false),
        }
    }

    fn start(&mut self) -> Result<bool, Malformed> {
        match self.held.as_slice() {
            [first] if [SHORT[0], LONG[0]].contains(first) => return Ok(false),
            bytes if bytes == SHORT => self.stage = Stage::Header(6),
            bytes if bytes == LONG => self.stage = Stage::Header(8),
            [_, second] => return Err(lost(Fault::Byte { byte: *second }, 1, "a binary reply")),
            _ => {
                self.stage = Stage::Text;
                return self.text();
            }
        }
        Ok(false)
    }

    /// A text has grown by one byte.
    fn text(&self) -> Result<bool, Malformed> {
        let at = self.held.len().saturating_sub(1);
        match self.held.last() {
            Some(&CR) => Ok(true),
            Some(&byte) if byte != b'\n' && !(0x20..0x7f).contains(&byte) => {
                Err(lost(Fault::Byte { byte }, at, "a text"))
            }
            _ if self.held.len() > self.limits.text => {
                let most = long(self.limits.text);
                Err(lost(Fault::TextLimit { most }, at, "a text"))
            }
            _ => Ok(false),
        }
    }

    fn header(&mut self, header: usize) -> Result<(), Malformed> {
        let (said, found) = self.held.split_at_checked(header - 2).unwrap_or_default();
        let found = found.first_chunk().copied().map_or(0, u16::from_le_bytes);
        let computed = crc16(said);
        if found != computed {
            let fault = Fault::HeaderCrc { found, computed };
            return Err(lost(fault, header - 2, "a binary reply"));
        }
        let length = match said {
            [_, _, a, b] => u32::from(u16::from_le_bytes([*a, *b])),
            [_, _, a, b, c, d] => u32::from_le_bytes([*a, *b, *c, *d]),
            _ => 0,
        };
        let most = self.limits.body;
        match usize::try_from(length) {
            Ok(body) if length <= most => {
                self.stage = Stage::Body(header, body.saturating_add(BODY_CRC));
                Ok(())
            }
            _ => {
                let (found, most) = (length.into(), most.into());
                Err(lost(Fault::BodyLimit { found, most }, 2, "a binary reply"))
            }
        }
    }

    fn whole(&self) -> Result<Reply<'_>, Malformed> {
        match self.stage {
            Stage::Body(header, _) => checked_body(self.held.get(header..).unwrap_or_default()),
            _ => checked_text(self.held.strip_suffix(&[CR]).unwrap_or_default()),
        }
    }
}

fn lost(fault: Fault, at: usize, what: &'static str) -> Malformed {
    Malformed {
        fault,
        at: long(at),
        what,
        recovery: Recovery::Silence,
    }
}
