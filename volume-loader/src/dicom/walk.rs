//! From one data element to the next, in bounded memory: element headers by dicom-rs, lengths judged here.

use std::io::{BufRead, ErrorKind, Seek};

use dicom_core::VR;
use dicom_core::dictionary::stub::StubDataDictionary;
use dicom_encoding::decode::explicit_be::ExplicitVRBigEndianDecoder;
use dicom_encoding::decode::explicit_le::ExplicitVRLittleEndianDecoder;
use dicom_encoding::decode::implicit_le::ImplicitVRLittleEndianDecoder;
use dicom_encoding::decode::{Decode, Error as DecodeError};

use super::error::FileError;
use super::syntax::Coding;
use super::tag::{Tag, tag};

/// Sequences may be nested this deep; the standard's own objects stay below ten.
const MAX_DEPTH: usize = 32;
/// No element of a header that is read is longer, bytes.
pub(super) const MAX_VALUE: u64 = 1 << 16;
/// Elements and items in one file, up to its pixels, and in what one frame says of itself; a large header has a few thousand. The
/// number of frames is bounded, nothing is held of an element that is not read, and each has 8 bytes of the file at least.
const MAX_ELEMENTS: u32 = 1 << 20;
const ITEM: Tag = tag(0xFFFE, 0xE000);
const ITEM_END: Tag = tag(0xFFFE, 0xE00D);
const SEQUENCE_END: Tag = tag(0xFFFE, 0xE0DD);

/// An element's header.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Element {
    pub tag: Tag,
    /// Value representation; `UN` in implicit coding.
    pub vr: VR,
    /// Bytes of the value; `None` where only a delimiter ends it.
    pub length: Option<u32>,
    /// Where the header begins.
    pub byte: u64,
    /// Where the value begins.
    pub value_at: u64,
}

/// Why walking stopped.
#[derive(Debug)]
pub(crate) enum WalkError {
    File(FileError),
    Io(std::io::Error),
}

impl From<FileError> for WalkError {
    fn from(error: FileError) -> Self {
        Self::File(error)
    }
}

/// A sequence or an item that is being read: where it ends, and how its content is coded.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Open {
    tag: Tag,
    byte: u64,
    /// `None` where only the delimiter ends it.
    end: Option<u64>,
    delimiter: Tag,
    pub coding: Coding,
}

/// Bytes with a position and a known end.
pub(crate) struct Walker<R> {
    input: R,
    position: u64,
    length: u64,
    elements: u32,
}

impl<R: BufRead + Seek> Walker<R> {
    /// Starts at the first of `length` bytes.
    pub(crate) fn new(input: R, length: u64) -> Self {
        Self {
            input,
            position: 0,
            length,
            elements: 0,
        }
    }

    /// The next byte's position.
    pub(crate) fn position(&self) -> u64 {
        self.position
    }

    /// Bytes in all.
    pub(crate) fn length(&self) -> u64 {
        self.length
    }

    /// Goes to `position`, which lies within the file.
    pub(crate) fn seek(&mut self, position: u64) -> Result<(), WalkError> {
        // Stays in the buffer where it can.
        let delta = position as i64 - self.position as i64;
        self.input.seek_relative(delta).map_err(WalkError::Io)?;
        self.position = position;
        Ok(())
    }

    /// The next `N` bytes, which are read again afterwards; `None` where there are fewer.
    pub(crate) fn peek<const N: usize>(&mut self) -> Result<Option<[u8; N]>, WalkError> {
        if self.length.saturating_sub(self.position) < N as u64 {
            return Ok(None);
        }
        let (mut bytes, start) = ([0; N], self.position);
        self.input.read_exact(&mut bytes).map_err(|e| self.io(e, start))?;
        self.position += N as u64;
        self.seek(start)?;
        Ok(Some(bytes))
    }

    /// The next element's header.
    pub(crate) fn element(&mut self, coding: Coding) -> Result<Element, WalkError> {
        let byte = self.position;
        self.elements += 1;
        if self.elements > MAX_ELEMENTS {
            let limit = MAX_ELEMENTS;
            return Err(FileError::TooManyElements { byte, limit }.into());
        }
        let implicit = ImplicitVRLittleEndianDecoder::with_dict(StubDataDictionary);
        let decoded = match coding {
            Coding::ImplicitLittle => implicit.decode_header(&mut self.input),
            Coding::ExplicitLittle => ExplicitVRLittleEndianDecoder::default().decode_header(&mut self.input),
            Coding::ExplicitBig => ExplicitVRBigEndianDecoder::default().decode_header(&mut self.input),
        };
        let (header, bytes) = decoded.map_err(|error| self.io(io_error(error), byte))?;
        self.position += bytes as u64;
        Ok(Element {
            tag: tag(header.tag.group(), header.tag.element()),
            vr: header.vr,
            length: header.len.get(),
            byte,
            value_at: self.position,
        })
    }

    /// The value of `element`, whose header was just read.
    pub(crate) fn value(&mut self, element: &Element) -> Result<Vec<u8>, WalkError> {
        let (tag, byte) = (element.tag, element.byte);
        let found = element.length.map_or(u64::from(u32::MAX), u64::from);
        self.check_end(element, found)?;
        if found > MAX_VALUE {
            return Err(WalkError::File(FileError::TooLong {
                tag,
                byte,
                found,
                limit: MAX_VALUE,
            }));
        }
        let mut value = vec![0; found as usize];
        self.input.read_exact(&mut value).map_err(|e| self.io(e, byte))?;
        self.position += found;
        Ok(value)
    }

    /// Passes over the value of `element`, whose header was just read.
    pub(crate) fn skip(&mut self, element: &Element, coding: Coding) -> Result<(), WalkError> {
        match element.length {
            Some(length) => {
                self.check_end(element, u64::from(length))?;
                self.seek(element.value_at + u64::from(length))
            }
            None => self.skip_sequence(element, coding),
        }
    }

    /// Passes over a sequence of undefined length with a stack of its own, so that no nesting exhausts the thread's.
    fn skip_sequence(&mut self, sequence: &Element, coding: Coding) -> Result<(), WalkError> {
        let mut open = vec![(SEQUENCE_END, inner_coding(sequence, coding))];
        while let Some(&(end, coding)) = open.last() {
            if self.position >= self.length {
                let (byte, found) = (sequence.byte, self.length);
                return Err(FileError::BrokenOff { byte, found }.into());
            }
            let element = self.element(coding)?;
            let byte = element.byte;
            if element.tag == end {
                open.pop();
            } else if element.tag == ITEM_END || element.tag == SEQUENCE_END {
                let found = element.tag;
                return Err(FileError::Delimiter { byte, found }.into());
            } else if element.length.is_some() {
                self.skip(&element, coding)?;
            } else if open.len() == MAX_DEPTH {
                let limit = MAX_DEPTH;
                return Err(FileError::Nesting { byte, limit }.into());
            } else if element.tag == ITEM {
                open.push((ITEM_END, coding));
            } else {
                open.push((SEQUENCE_END, inner_coding(&element, coding)));
            }
        }
        Ok(())
    }

    /// Whether the sequence `element`, whose header was just read, has an item; goes back to its value.
    pub(crate) fn has_items(&mut self, element: &Element, coding: Coding) -> Result<bool, WalkError> {
        let sequence = self.open(element, coding)?;
        let any = self.next_item(&sequence)?.is_some();
        self.seek(element.value_at)?;
        Ok(any)
    }

    /// Reads what has a limit of elements of its own: one frame's item among thousands.
    ///
    /// # Errors
    /// Those of `read`.
    pub(crate) fn counted_apart<T>(
        &mut self,
        read: impl FnOnce(&mut Self) -> Result<T, WalkError>,
    ) -> Result<T, WalkError> {
        let outside = std::mem::take(&mut self.elements);
        let result = read(self);
        self.elements = outside;
        result
    }

    /// Goes into the sequence or the item `element`, whose header was just read.
    pub(crate) fn open(&self, element: &Element, coding: Coding) -> Result<Open, FileError> {
        let length = element.length.map(u64::from);
        if let Some(length) = length {
            self.check_end(element, length)?;
        }
        Ok(Open {
            tag: element.tag,
            byte: element.byte,
            end: length.map(|length| element.value_at + length),
            delimiter: if element.tag == ITEM { ITEM_END } else { SEQUENCE_END },
            coding: inner_coding(element, coding),
        })
    }

    /// The header of the next element of `open`; `None` at its end.
    pub(crate) fn next_in(&mut self, open: &Open) -> Result<Option<Element>, WalkError> {
        let (tag, byte, found) = (open.tag, open.byte, self.position);
        match open.end {
            Some(end) if found == end => return Ok(None),
            Some(end) if found > end => return Err(FileError::Overrun { tag, byte, end, found }.into()),
            _ if found >= self.length => {
                let found = self.length;
                return Err(FileError::BrokenOff { byte, found }.into());
            }
            _ => {}
        }
        let element = self.element(open.coding)?;
        if open.end.is_none() && element.tag == open.delimiter {
            return Ok(None);
        }
        if [ITEM_END, SEQUENCE_END].contains(&element.tag) {
            let (byte, found) = (element.byte, element.tag);
            return Err(FileError::Delimiter { byte, found }.into());
        }
        Ok(Some(element))
    }

    /// The next item of a sequence; `None` at its end.
    pub(crate) fn next_item(&mut self, sequence: &Open) -> Result<Option<Open>, WalkError> {
        match self.next_in(sequence)? {
            None => Ok(None),
            Some(item) if item.tag == ITEM => Ok(Some(self.open(&item, sequence.coding)?)),
            Some(Element { byte, tag: found, .. }) => Err(FileError::Delimiter { byte, found }.into()),
        }
    }

    fn check_end(&self, element: &Element, length: u64) -> Result<(), FileError> {
        let expected = element.value_at.saturating_add(length);
        if expected <= self.length {
            return Ok(());
        }
        Err(FileError::Truncated {
            tag: element.tag,
            byte: element.byte,
            expected,
            found: self.length,
        })
    }

    fn io(&self, error: std::io::Error, byte: u64) -> WalkError {
        if error.kind() == ErrorKind::UnexpectedEof {
            let found = self.length;
            return FileError::BrokenOff { byte, found }.into();
        }
        WalkError::Io(error)
    }
}

/// A sequence of unknown representation is what another program could not read: it is in implicit coding (PS3.5 section 6.2.2,
/// note on UN).
fn inner_coding(element: &Element, coding: Coding) -> Coding {
    if coding != Coding::ImplicitLittle && element.vr == VR::UN && element.tag.group != 0xFFFE {
        return Coding::ImplicitLittle;
    }
    coding
}

fn io_error(error: DecodeError) -> std::io::Error {
    match error {
        DecodeError::ReadHeaderTag { source, .. }
        | DecodeError::ReadItemHeader { source, .. }
        | DecodeError::ReadItemLength { source, .. }
        | DecodeError::ReadTag { source, .. }
        | DecodeError::ReadReserved { source, .. }
        | DecodeError::ReadLength { source, .. }
        | DecodeError::ReadVr { source, .. } => source,
        other => std::io::Error::new(ErrorKind::InvalidData, other.to_string()),
    }
}
