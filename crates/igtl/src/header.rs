//! The header before every body: 58 bytes, the same in both versions.
//!
//! | bytes | what |
//! |---|---|
//! | 0..2 | version, 1 or 2 |
//! | 2..14 | type |
//! | 14..34 | device |
//! | 34..42 | stamp |
//! | 42..50 | bytes of the body |
//! | 50..58 | CRC of the body |
//!
//! Version 2 (protocol 3) has an extended header and metadata inside the body. A reader of version 1 alone cannot skip
//! such a message: which version a peer is sent is a property of the peer.

use crate::fault::Fault;
use crate::limits::{Limits, MOST_BODY};
use crate::malformed::{Malformed, Recovery, Refusal};
use crate::name::{DeviceName, TypeName};
use crate::stamp::Stamp;
use crate::wire::Reader;

/// Bytes of a header.
pub const HEADER_BYTES: usize = 58;

const TYPE_AT: u64 = 2;
const BODY_AT: u64 = 42;
/// The byte at which a header states the CRC of its body.
pub(crate) const CRC_AT: u64 = 50;

/// Which header a message has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub enum Version {
    /// Of protocols 1 and 2: the body is the content.
    #[default]
    One,
    /// Of protocol 3: the body is an extended header, the content, and metadata.
    Two,
}

impl Version {
    /// The number on the wire.
    pub const fn number(self) -> u16 {
        match self {
            Self::One => 1,
            Self::Two => 2,
        }
    }
}

/// A header that was found good; nothing of the body is known but its length and its CRC.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Header {
    /// Its version.
    pub version: Version,
    /// The type of the content.
    pub kind: TypeName,
    /// The device, or what is measured; it may be empty.
    pub device: DeviceName,
    /// When the content was generated, by the sender's clock.
    pub stamp: Stamp,
    /// Bytes of the body.
    pub body: u64,
    /// CRC-64 of the body.
    pub crc: u64,
}

impl Header {
    /// Reads one, and bounds the body that it announces.
    ///
    /// # Errors
    /// [`Fault::Protocol`], [`Fault::Version`], [`Fault::TypeName`] and [`Fault::BodyLimit`], after which the stream
    /// must be closed; [`Fault::NameByte`] of the device, after which it can go on.
    pub fn parse(bytes: &[u8; HEADER_BYTES], limits: &Limits) -> Result<Self, Malformed> {
        let version = version_of(bytes)?;
        let mut reader = Reader::new(bytes.get(2..).unwrap_or_default(), TYPE_AT);
        let kind = type_name(&mut reader).map_err(|refusal| closing(refusal, TypeName::EMPTY, DeviceName::EMPTY))?;
        let device = reader.name("the device's name");
        let named = *device.as_ref().unwrap_or(&DeviceName::EMPTY);
        let close = |refusal| closing(refusal, kind, named);
        // The fields behind a bad device are read all the same: a body that is too long is the graver fault.
        let (stamp, body, crc) = sizes(&bytes[..], limits).map_err(close)?;
        let device = device.map_err(|refusal| Malformed {
            recovery: Recovery::NextMessage,
            ..close(refusal)
        })?;
        Ok(Self {
            version,
            kind,
            device,
            stamp,
            body,
            crc,
        })
    }

    /// Its bytes.
    pub(crate) fn write(&self, out: &mut Vec<u8>) {
        out.extend(self.version.number().to_be_bytes());
        out.extend(self.kind.field());
        out.extend(self.device.field());
        out.extend(self.stamp.0.to_be_bytes());
        out.extend(self.body.to_be_bytes());
        out.extend(self.crc.to_be_bytes());
    }
}

fn closing(refusal: Refusal, kind: TypeName, device: DeviceName) -> Malformed {
    Malformed {
        fault: refusal.fault,
        at: refusal.at,
        kind,
        device,
        recovery: Recovery::Close,
    }
}

/// The version, of two bytes or more; what else is spoken on such ports is named.
pub(crate) fn version_of(bytes: &[u8]) -> Result<Version, Malformed> {
    let fault = match bytes {
        [0, 1, ..] => return Ok(Version::One),
        [0, 2, ..] => return Ok(Version::Two),
        [0x16, 3, ..] => Fault::Protocol("TLS"),
        [b'G', b'E', ..] | [b'P', b'O', ..] | [b'H', b'E', ..] | [b'H', b'T', ..] => Fault::Protocol("HTTP"),
        [b'S', b'S', ..] => Fault::Protocol("SSH"),
        [high, low, ..] => Fault::Version {
            found: u16::from_be_bytes([*high, *low]),
        },
        _ => Fault::Truncated {
            found: crate::wire::long(bytes.len()),
            needed: 2,
        },
    };
    Err(closing(Refusal { fault, at: 0 }, TypeName::EMPTY, DeviceName::EMPTY))
}

fn type_name(reader: &mut Reader<'_>) -> Result<TypeName, Refusal> {
    let bad = |at, byte| Refusal {
        fault: Fault::TypeName { byte },
        at,
    };
    match reader.name::<12>("the type") {
        Ok(name) if name.is_empty() => Err(bad(TYPE_AT, 0)),
        Err(Refusal {
            fault: Fault::NameByte { byte, .. },
            at,
        }) => Err(bad(at, byte)),
        other => other,
    }
}

/// Stamp, length of the body and CRC.
fn sizes(bytes: &[u8], limits: &Limits) -> Result<(Stamp, u64, u64), Refusal> {
    let mut reader = Reader::new(bytes, 0);
    reader.take(34)?;
    let stamp = Stamp(reader.u64()?);
    let body = reader.u64()?;
    let most = limits.body.min(MOST_BODY);
    if body > most {
        return Err(Refusal {
            fault: Fault::BodyLimit { found: body, most },
            at: BODY_AT,
        });
    }
    Ok((stamp, body, reader.u64()?))
}

/// The length of the body that a header announces, whatever else is wrong with it; `None` where it is beyond the
/// limits.
pub(crate) fn body_of(bytes: &[u8; HEADER_BYTES], limits: &Limits) -> Option<u64> {
    sizes(bytes, limits).ok().map(|(_, body, _)| body)
}
