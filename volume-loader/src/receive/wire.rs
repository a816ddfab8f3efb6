//! PDUs over a stream, each within a time and a length (PS3.8 section 9.3). Their content is read by dicom-ul.

use std::fmt;
use std::io::{ErrorKind, Read, Write};

use bus::clock::monotonic_ns;
use dicom_ul::pdu::{
    AbortRQServiceProviderReason, AbortRQSource, PDataValue, PDataValueType, Pdu, read_pdu, write_pdu,
};

/// Bytes of a PDU behind its head: what is announced to a peer, and the most that is taken of a request, too.
pub(crate) const MAX_PDU: u32 = 128 << 10;
/// Type, a reserved byte, and the length.
const HEAD: usize = 6;
/// Of each fragment: its length, context and kind; and of those the ones that its length counts.
const FRAGMENT_HEAD: u32 = 6;
/// After an abort or a release the peer is given so long to close, ns.
pub(super) const CLOSING_NS: i64 = 2_000_000_000;
const A_READ: usize = 64 << 10;

/// Why no PDU came.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum WireError {
    Closed,
    /// It was not there in time.
    Late,
    /// This process is asked to stop.
    Stopped,
    TooLong(u32),
    Malformed(String),
    Io(String),
}

impl fmt::Display for WireError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Closed => write!(f, "the connection was closed"),
            Self::Late => write!(f, "it fell silent, or sent too slowly"),
            Self::Stopped => write!(f, "this program was asked to stop"),
            Self::TooLong(found) => write!(f, "a PDU of {found} bytes, allowed are {MAX_PDU}"),
            Self::Malformed(why) => write!(f, "what it sent is no DICOM: {why}"),
            Self::Io(why) => write!(f, "the connection broke: {why}"),
        }
    }
}

/// A stream of PDUs. A read that waits in vain for a moment (`WouldBlock`, `TimedOut`) lets the limits be looked at.
pub(crate) struct Wire<'a, S> {
    stream: S,
    buffer: Vec<u8>,
    stop: &'a dyn Fn() -> bool,
}

impl<'a, S: Read + Write> Wire<'a, S> {
    pub(crate) fn new(stream: S, stop: &'a dyn Fn() -> bool) -> Self {
        let buffer = Vec::new();
        Self { stream, buffer, stop }
    }

    /// The next PDU, where it is whole before this moment, ns.
    ///
    /// # Errors
    /// [`WireError`].
    pub(crate) fn read(&mut self, until_ns: i64) -> Result<Pdu, WireError> {
        loop {
            if let Some(pdu) = self.take()? {
                return Ok(pdu);
            }
            if (self.stop)() {
                return Err(WireError::Stopped);
            }
            if monotonic_ns() >= until_ns {
                return Err(WireError::Late);
            }
            self.fill()?;
        }
    }

    /// Reads what there is.
    fn fill(&mut self) -> Result<(), WireError> {
        let mut bytes = [0; A_READ];
        match self.stream.read(&mut bytes) {
            Ok(0) => Err(WireError::Closed),
            Ok(read) => {
                self.buffer.extend_from_slice(bytes.get(..read).unwrap_or_default());
                Ok(())
            }
            Err(error) => match error.kind() {
                ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted => Ok(()),
                ErrorKind::ConnectionReset | ErrorKind::BrokenPipe | ErrorKind::ConnectionAborted => {
                    Err(WireError::Closed)
                }
                _ => Err(WireError::Io(error.to_string())),
            },
        }
    }

    /// The PDU at the beginning of what was read, once it is whole. Its length is judged before it is waited for.
    fn take(&mut self) -> Result<Option<Pdu>, WireError> {
        let Some([_, _, a, b, c, d]) = self.buffer.first_chunk::<HEAD>().copied() else {
            return Ok(None);
        };
        let length = u32::from_be_bytes([a, b, c, d]);
        if length > MAX_PDU {
            return Err(WireError::TooLong(length));
        }
        let Some(bytes) = self.buffer.get(..HEAD + length as usize) else {
            return Ok(None);
        };
        let read = read_pdu(bytes, MAX_PDU, true);
        let pdu = read.map_err(|error| WireError::Malformed(error.to_string()))?;
        self.buffer.drain(..HEAD + length as usize);
        pdu.map(Some)
            .ok_or_else(|| WireError::Malformed("a PDU ends before its content".to_owned()))
    }

    /// Sends a PDU.
    ///
    /// # Errors
    /// [`WireError`].
    pub(crate) fn send(&mut self, pdu: &Pdu) -> Result<(), WireError> {
        let mut bytes = Vec::new();
        write_pdu(&mut bytes, pdu).map_err(|error| WireError::Io(error.to_string()))?;
        self.stream.write_all(&bytes).map_err(|error| match error.kind() {
            ErrorKind::WouldBlock | ErrorKind::TimedOut => WireError::Late,
            ErrorKind::ConnectionReset | ErrorKind::BrokenPipe => WireError::Closed,
            _ => WireError::Io(error.to_string()),
        })
    }

    /// Sends a command set in PDUs of at most `most` bytes.
    ///
    /// # Errors
    /// [`WireError`].
    pub(crate) fn send_command(&mut self, context: u8, command: &[u8], most: u32) -> Result<(), WireError> {
        let room = most.min(MAX_PDU).saturating_sub(FRAGMENT_HEAD).max(1);
        let mut parts = command.chunks(room as usize).peekable();
        while let Some(part) = parts.next() {
            let value = PDataValue {
                presentation_context_id: context,
                value_type: PDataValueType::Command,
                is_last: parts.peek().is_none(),
                data: part.to_vec(),
            };
            self.send(&Pdu::PData { data: vec![value] })?;
        }
        Ok(())
    }

    /// Tells the peer that the association is over; whether it hears that does not matter.
    pub(crate) fn abort(&mut self, reason: AbortRQServiceProviderReason) {
        let source = AbortRQSource::ServiceProvider(reason);
        let _ = self.send(&Pdu::AbortRQ { source });
    }

    /// Reads and forgets what still comes, until the peer closes or this moment: closing first would take back what was just sent.
    pub(crate) fn drain(&mut self, until_ns: i64) {
        while monotonic_ns() < until_ns && !(self.stop)() {
            self.buffer.clear();
            if self.fill().is_err() {
                return;
            }
        }
    }
}
