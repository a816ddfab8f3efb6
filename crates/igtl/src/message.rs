//! A message: who sent it, when, and what it says.

use crate::body::Body;
use crate::crc::crc64;
use crate::fault::Fault;
use crate::fields::Fields;
use crate::header::{CRC_AT, HEADER_BYTES, Header, Version};
use crate::limits::Limits;
use crate::malformed::{Malformed, Recovery, Refusal};
use crate::metadata::Metadata;
use crate::name::DeviceName;
use crate::stamp::Stamp;
use crate::wire::{Reader, long};

/// Bytes of the extended header of a message of version 2: `u16` its own length, `u16` of the index of the metadata,
/// `u32` of keys and values, `u32` number of the message.
pub(crate) const EXTENDED_BYTES: u16 = 12;

/// A message, whole and with the right CRC.
#[derive(Debug, Clone, PartialEq)]
pub struct Message<'a> {
    /// Of its header.
    pub version: Version,
    /// The device, or what is measured: `StylusToTracker`. It may be empty.
    pub device: DeviceName,
    /// When it was generated, by the sender's clock.
    pub stamp: Stamp,
    /// Its number by the sender; 0 in version 1.
    pub number: u32,
    /// Keys and values; none in version 1.
    pub metadata: Metadata,
    /// What it says.
    pub body: Body<'a>,
}

/// A body, taken apart.
struct Parts<'a> {
    number: u32,
    metadata: Metadata,
    content: Reader<'a>,
}

impl<'a> Message<'a> {
    /// A message of version 1 without a stamp.
    pub const fn new(device: DeviceName, body: Body<'a>) -> Self {
        Self {
            version: Version::One,
            device,
            stamp: Stamp::NONE,
            number: 0,
            metadata: Metadata::EMPTY,
            body,
        }
    }

    /// The same for a peer that reads this version: number and metadata are left out where it is 1.
    #[must_use]
    pub fn in_version(mut self, version: Version) -> Self {
        self.version = version;
        if version == Version::One {
            self.number = 0;
            self.metadata = Metadata::EMPTY;
        }
        self
    }

    /// With voxels and contents of its own.
    pub fn into_owned(self) -> Message<'static> {
        Message {
            version: self.version,
            device: self.device,
            stamp: self.stamp,
            number: self.number,
            metadata: self.metadata,
            body: self.body.into_owned(),
        }
    }

    /// Reads the body that a header announces: first its CRC, then everything in it.
    ///
    /// # Errors
    /// Whatever is wrong with it; the stream can go on behind the body.
    pub fn parse(header: &Header, body: &'a [u8], limits: &Limits) -> Result<Self, Malformed> {
        read(header, body, limits).map_err(|Refusal { fault, at }| Malformed {
            fault,
            at,
            kind: header.kind,
            device: header.device,
            recovery: Recovery::NextMessage,
        })
    }

    /// All that it says, by name.
    pub fn fields(&self) -> Fields {
        let mut fields = Fields::default();
        fields.add("type", &self.body.kind());
        fields.add("device", &self.device);
        fields.add("version", self.version.number());
        fields.add("stamp_ns", self.stamp.ns());
        if self.version == Version::Two {
            fields.add("message", self.number);
        }
        self.body.fields(&mut fields);
        for (number, entry) in self.metadata.entries().iter().enumerate() {
            fields.add(format!("metadata[{number}].key"), entry.key.as_str());
            fields.add(format!("metadata[{number}].encoding"), entry.value.encoding);
            fields.add(format!("metadata[{number}].value"), entry.value.to_string());
        }
        fields
    }
}

fn read<'a>(header: &Header, body: &'a [u8], limits: &Limits) -> Result<Message<'a>, Refusal> {
    let found = long(body.len());
    let start = long(HEADER_BYTES);
    if found != header.body {
        return Err(Refusal {
            fault: Fault::Truncated {
                found: found.saturating_add(start),
                needed: header.body.saturating_add(start),
            },
            at: start.saturating_add(found),
        });
    }
    let computed = crc64(body);
    if computed != header.crc {
        return Err(Refusal {
            fault: Fault::Crc {
                found: header.crc,
                computed,
            },
            at: CRC_AT,
        });
    }
    let mut parts = match header.version {
        Version::One => Parts {
            number: 0,
            metadata: Metadata::EMPTY,
            content: Reader::new(body, start),
        },
        Version::Two => take_apart(body, start, limits)?,
    };
    Ok(Message {
        version: header.version,
        device: header.device,
        stamp: header.stamp,
        number: parts.number,
        metadata: parts.metadata,
        body: Body::read(&header.kind, &mut parts.content, limits)?,
    })
}

/// Extended header, content and metadata of a body of version 2.
fn take_apart<'a>(body: &'a [u8], start: u64, limits: &Limits) -> Result<Parts<'a>, Refusal> {
    let mut reader = Reader::new(body, start);
    let (least, most) = (u64::from(EXTENDED_BYTES), reader.size());
    let bad = |found| Refusal {
        fault: Fault::ExtendedHeader { found, least, most },
        at: start,
    };
    if most < least {
        return Err(bad(most));
    }
    let mut head = reader.clone();
    let said = u64::from(head.u16()?);
    let (index, values) = (u64::from(head.u16()?), u64::from(head.u32()?));
    let number = head.u32()?;
    if said < least || said > most {
        return Err(bad(said));
    }
    // A later protocol may have a longer one; what it adds is not known here.
    reader.take(said)?;
    let (found, most) = (index + values, reader.left());
    let Some(content) = most.checked_sub(found) else {
        return Err(Refusal {
            fault: Fault::MetadataSize { found, most },
            at: start + 2,
        });
    };
    let at = reader.at();
    let content = Reader::new(reader.take(content)?, at);
    let at = reader.at();
    let metadata = Metadata::read(reader.take(index)?, reader.take(values)?, at, limits)?;
    Ok(Parts {
        number,
        metadata,
        content,
    })
}
