//! Messages as bytes.

use crate::crc::Crc64;
use crate::fault::Fault;
use crate::header::{HEADER_BYTES, Header, Version};
use crate::limits::MOST_BODY;
use crate::message::{EXTENDED_BYTES, Message};
use crate::metadata::Metadata;
use crate::wire::{counted, long};

/// A message as bytes, in three pieces to be sent one after the other, in one call: some readers lose their place in a
/// stream when a header comes in two.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Encoded<'a> {
    head: Vec<u8>,
    borrowed: &'a [u8],
    tail: Vec<u8>,
}

impl<'a> Encoded<'a> {
    /// The header and what was made; what lies where the message borrows it (an image's voxels); what stands behind.
    pub fn pieces(&self) -> [&[u8]; 3] {
        [&self.head, self.borrowed, &self.tail]
    }

    /// Bytes of all three.
    pub fn len(&self) -> usize {
        self.pieces().iter().map(|piece| piece.len()).sum()
    }

    /// Never: there is a header.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// All in one piece.
    pub fn to_vec(&self) -> Vec<u8> {
        self.pieces().concat()
    }
}

impl Message<'_> {
    /// Its bytes, for a peer that reads its version.
    ///
    /// # Errors
    /// What a reader would refuse: numbers that are not finite, an image whose voxels are more or fewer than it says, a
    /// tool or a key twice, texts longer than their field, metadata in version 1, a body of more than [`MOST_BODY`]
    /// bytes.
    pub fn encode(&self) -> Result<Encoded<'_>, Fault> {
        let mut head = vec![0; HEADER_BYTES];
        let (index, values) = match self.version {
            Version::One if self.number != 0 || !self.metadata.is_empty() => return Err(Fault::NeedsVersionTwo),
            Version::One => Default::default(),
            Version::Two => extended(&self.metadata, self.number, &mut head)?,
        };
        self.body.write(&mut head)?;
        let (borrowed, tail) = (self.body.borrowed(), [index, values].concat());
        let made = head.get(HEADER_BYTES..).unwrap_or_default();
        let body = long(made.len()) + long(borrowed.len()) + long(tail.len());
        if body > MOST_BODY {
            return Err(Fault::BodyLimit {
                found: body,
                most: MOST_BODY,
            });
        }
        let header = Header {
            version: self.version,
            kind: self.body.kind(),
            device: self.device,
            stamp: self.stamp,
            body,
            crc: Crc64::new().with(made).with(borrowed).with(&tail).value(),
        };
        let mut bytes = Vec::with_capacity(HEADER_BYTES);
        header.write(&mut bytes);
        head.splice(..HEADER_BYTES, bytes);
        Ok(Encoded { head, borrowed, tail })
    }

    /// Its bytes in one piece.
    ///
    /// # Errors
    /// Those of [`Message::encode`].
    pub fn to_vec(&self) -> Result<Vec<u8>, Fault> {
        self.encode().map(|encoded| encoded.to_vec())
    }
}

/// Appends the extended header, and gives the index and the values that stand behind the content.
fn extended(metadata: &Metadata, number: u32, out: &mut Vec<u8>) -> Result<(Vec<u8>, Vec<u8>), Fault> {
    let (index, values) = metadata.write()?;
    let index_bytes: u16 = counted(index.len(), "bytes of a metadata index", u16::MAX.into())?;
    let value_bytes: u32 = counted(values.len(), "bytes of metadata", u32::MAX.into())?;
    out.extend(EXTENDED_BYTES.to_be_bytes());
    out.extend(index_bytes.to_be_bytes());
    out.extend(value_bytes.to_be_bytes());
    out.extend(number.to_be_bytes());
    Ok((index, values))
}
