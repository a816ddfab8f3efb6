//! Bytes as messages: all at once, or as they come.

use crate::fault::Fault;
use crate::header::{HEADER_BYTES, Header, body_of, version_of};
use crate::limits::Limits;
use crate::malformed::{Malformed, Recovery};
use crate::message::Message;
use crate::name::{DeviceName, TypeName};
use crate::wire::long;

/// How much room a body is given before any of it has come: what a peer announces costs it as many bytes as it costs
/// us.
const FIRST_ROOM: usize = 64 << 10;

/// The first message of some bytes, and how many of them it took.
///
/// # Errors
/// Whatever is wrong with it; [`Fault::Truncated`] where they end in the middle of it.
pub fn decode<'a>(bytes: &'a [u8], limits: &Limits) -> Result<(Message<'a>, usize), Malformed> {
    if bytes.len() >= 2 {
        version_of(bytes)?;
    }
    let Some((head, rest)) = bytes.split_first_chunk() else {
        return Err(truncated(bytes.len(), long(HEADER_BYTES), None));
    };
    let header = Header::parse(head, limits)?;
    let body = usize::try_from(header.body).ok().and_then(|body| rest.get(..body));
    let Some(body) = body else {
        let needed = header.body.saturating_add(long(HEADER_BYTES));
        return Err(truncated(bytes.len(), needed, Some(&header)));
    };
    let message = Message::parse(&header, body, limits)?;
    Ok((message, HEADER_BYTES + body.len()))
}

fn truncated(found: usize, needed: u64, header: Option<&Header>) -> Malformed {
    let found = long(found);
    Malformed {
        fault: Fault::Truncated { found, needed },
        at: found,
        kind: header.map_or(TypeName::EMPTY, |header| header.kind),
        device: header.map_or(DeviceName::EMPTY, |header| header.device),
        recovery: Recovery::Close,
    }
}

/// Where a decoder is in its stream.
#[derive(Debug, Clone)]
enum Stage {
    /// In a header.
    Header,
    /// In the body of this one.
    Body(Header),
    /// In a body that is thrown away; so many bytes of it are still to come.
    Skip(u64),
    /// Nothing is read any more.
    Closed(Malformed),
}

/// Takes a stream in pieces of any length and gives its messages, one after the other.
///
/// Either hand it what came ([`Decoder::feed`]), many small messages at a time; or let it be read into the place where
/// it is needed, which copies no byte of a volume:
///
/// ```
/// # fn read(mut stream: impl std::io::Read, mut decoder: igtl::Decoder) -> std::io::Result<()> {
/// loop {
///     while let Some(message) = decoder.take() {
///         // An error with `Recovery::Close` ends both loops.
/// #       drop(message);
///     }
///     let count = stream.read(decoder.space())?;
///     decoder.filled(count);
/// #   if count == 0 { return Ok(()) }
/// }
/// # }
/// ```
///
/// It holds at most a header and one body, and makes room for no more than twice what has come of it, or 64 KiB.
#[derive(Debug, Clone)]
pub struct Decoder {
    limits: Limits,
    /// What has come of the header or of the body, and room behind it.
    held: Vec<u8>,
    filled: usize,
    stage: Stage,
    /// The byte of the stream at which the message begins that is being read.
    start: u64,
    /// The same of the one that was given last.
    began: u64,
}

impl Decoder {
    /// At the start of a stream.
    pub const fn new(limits: Limits) -> Self {
        Self {
            limits,
            held: Vec::new(),
            filled: 0,
            stage: Stage::Header,
            start: 0,
            began: 0,
        }
    }

    /// How many bytes are needed for the next step: the rest of the header, of the body, or of what is thrown away. 0
    /// once the stream is closed, and while a header or a body that is whole waits for [`Decoder::take`].
    pub fn wants(&self) -> u64 {
        let filled = long(self.filled);
        match &self.stage {
            Stage::Header => long(HEADER_BYTES).saturating_sub(filled),
            Stage::Body(header) => header.body.saturating_sub(filled),
            Stage::Skip(left) => *left,
            Stage::Closed(_) => 0,
        }
    }

    /// The byte of the stream at which the message began that was given last, or refused; before the first, 0.
    pub const fn began(&self) -> u64 {
        self.began
    }

    /// Bytes that have come of a message that is not whole; 0 between messages: silence then is the peer's rest.
    pub fn come(&self) -> u64 {
        let filled = long(self.filled);
        match &self.stage {
            Stage::Header => filled,
            Stage::Body(_) => filled + long(HEADER_BYTES),
            Stage::Skip(left) => self.start.saturating_sub(self.began).saturating_sub(*left),
            Stage::Closed(_) => 0,
        }
    }

    /// Room for bytes that come next, at least one and at most [`Decoder::wants`], once [`Decoder::take`] has nothing
    /// more to say; none where the stream is closed.
    pub fn space(&mut self) -> &mut [u8] {
        let wanted = usize::try_from(self.wants()).unwrap_or(usize::MAX);
        let had = self.held.len().saturating_sub(self.filled);
        let room = wanted.min(had.max(self.filled).max(FIRST_ROOM));
        let end = self.filled.saturating_add(room);
        if self.held.len() < end {
            self.held.reserve_exact(end - self.held.len());
            self.held.resize(end, 0);
        }
        self.held.get_mut(self.filled..end).unwrap_or_default()
    }

    /// `count` bytes of [`Decoder::space`] have come.
    pub fn filled(&mut self, count: usize) {
        let wanted = usize::try_from(self.wants()).unwrap_or(usize::MAX);
        let count = count.min(wanted).min(self.held.len().saturating_sub(self.filled));
        match &mut self.stage {
            Stage::Skip(left) => {
                *left -= long(count);
                if *left == 0 {
                    self.stage = Stage::Header;
                }
            }
            _ => self.filled += count,
        }
    }

    /// The message that is whole, or what is wrong with what has come; `None` where more is needed.
    ///
    /// After an error whose [`Malformed::recovery`] is [`Recovery::Close`] it is the same error for ever.
    pub fn take(&mut self) -> Option<Result<Message<'_>, Malformed>> {
        let step = self.advance()?;
        Some(self.given(step))
    }

    /// Takes bytes from the front of `bytes` until there is something to say; `None` once all were taken. Ask again
    /// until it says `None`, or an error whose [`Malformed::recovery`] is [`Recovery::Close`].
    pub fn feed(&mut self, bytes: &mut &[u8]) -> Option<Result<Message<'_>, Malformed>> {
        let step = loop {
            if let Some(step) = self.advance() {
                break step;
            }
            let room = self.space();
            let count = room.len().min(bytes.len());
            let (now, later) = bytes.split_at_checked(count).filter(|(now, _)| !now.is_empty())?;
            room.get_mut(..count)?.copy_from_slice(now);
            *bytes = later;
            self.filled(count);
        };
        Some(self.given(step))
    }

    /// What is wrong with a stream that ends here; `None` between two messages.
    pub fn end(&self) -> Option<Malformed> {
        match &self.stage {
            Stage::Header if self.filled == 0 => None,
            Stage::Header => Some(truncated(self.filled, long(HEADER_BYTES), None)),
            Stage::Body(header) => {
                let needed = header.body.saturating_add(long(HEADER_BYTES));
                Some(truncated(self.filled + HEADER_BYTES, needed, Some(header)))
            }
            // The message was refused already.
            Stage::Skip(_) => None,
            Stage::Closed(malformed) => Some(malformed.clone()),
        }
    }

    /// As far as what has come leads: the header of a whole message, or what is wrong.
    fn advance(&mut self) -> Option<Result<Header, Malformed>> {
        if matches!(self.stage, Stage::Header) {
            let came = self.held.get(..self.filled).unwrap_or_default();
            match parsed(came, &self.limits)? {
                Ok(header) => self.stage = Stage::Body(header),
                Err((malformed, skip)) => {
                    self.next_message(skip.unwrap_or_default());
                    self.stage = match skip {
                        Some(0) => Stage::Header,
                        Some(body) => Stage::Skip(body),
                        None => Stage::Closed(malformed.clone()),
                    };
                    self.filled = 0;
                    return Some(Err(malformed));
                }
            }
            self.filled = 0;
        }
        match &self.stage {
            Stage::Body(header) if long(self.filled) == header.body => Some(Ok(*header)),
            Stage::Closed(malformed) => Some(Err(malformed.clone())),
            _ => None,
        }
    }

    fn next_message(&mut self, body: u64) {
        self.began = self.start;
        self.start = self.start.saturating_add(long(HEADER_BYTES)).saturating_add(body);
    }

    /// The message of a header whose body is whole. From here on the next bytes are those of a header.
    fn given(&mut self, step: Result<Header, Malformed>) -> Result<Message<'_>, Malformed> {
        let header = step?;
        self.next_message(header.body);
        let filled = std::mem::take(&mut self.filled);
        self.stage = Stage::Header;
        let body = self.held.get(..filled).unwrap_or_default();
        Message::parse(&header, body, &self.limits)
    }
}

/// The header in what has come, `None` where that is too little to tell; or what is wrong with it, and the length of
/// the body behind which the stream goes on.
fn parsed(came: &[u8], limits: &Limits) -> Option<Result<Header, (Malformed, Option<u64>)>> {
    if came.len() >= 2
        && let Err(malformed) = version_of(came)
    {
        return Some(Err((malformed, None)));
    }
    let head = came.first_chunk()?;
    Some(Header::parse(head, limits).map_err(|malformed| {
        let skip = match malformed.recovery {
            Recovery::NextMessage => body_of(head, limits),
            Recovery::Close => None,
        };
        (malformed, skip)
    }))
}
