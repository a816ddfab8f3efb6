//! The values of the data elements that are read. Everything else in a file is passed over, so that nothing of a patient is even held; of
//! PatientID, of the name, its issuer, the date of birth and the sex, and of dates, contrast agents and scanners, digests stay
//! ([`Header::patient`](super::header::Header::patient), [`Scan`](super::header::scanned::Scan)). Names are read where a person asks, once for the bus, on which they are for
//! the operator's screen ([`identity`](super::header::identity)), and to be compared ([`person`](super::header::person)); no error, line or report has them.

pub(super) mod groups;
pub(crate) mod tree;

use std::io::{BufRead, Seek};

use self::groups::{FRAMES_ALLOWED, Group, MAX_FRAMES};
use super::error::FileError;
use super::syntax::{Coding, PixelCoding, Syntax};
use super::tag::{self as el, Tag};
use super::walk::{Element, MAX_VALUE, WalkError, Walker};

/// SOP classes whose frames are slices of a CT (PS3.4 table B.5-1): Enhanced CT and Legacy Converted Enhanced CT.
const FRAMED_CLASSES: [&str; 2] = ["1.2.840.10008.5.1.4.1.1.2.1", "1.2.840.10008.5.1.4.1.1.2.2"];

/// Segmentation Storage and Label Map Segmentation Storage (PS3.4 table B.5-1).
const SEGMENTATION_CLASSES: [&str; 2] = ["1.2.840.10008.5.1.4.1.1.66.4", "1.2.840.10008.5.1.4.1.1.66.7"];

/// The values of one file's elements, as they stand there; or of one item.
#[derive(Debug, Clone, Default)]
pub(crate) struct Elements {
    pub syntax: Syntax,
    values: Vec<(Tag, Vec<u8>)>,
    /// The header of the pixel data, where there are any.
    pub pixels: Option<Element>,
    /// Whether there is a Modality LUT, by which stored numbers would have to be looked up.
    pub modality_lut: bool,
    /// The headers of the extended table of offsets and of that of lengths.
    pub tables: [Option<Element>; 2],
    /// What all frames share; no more than one item.
    pub shared: Option<Vec<Group>>,
    /// What each frame says of itself.
    pub frames: Option<Vec<Group>>,
    /// Elements that are kept beside those that are always read.
    besides: &'static [(Tag, &'static str)],
}

impl Elements {
    /// Reads a file from its first byte to its pixel data; `None` where it is no DICOM file.
    ///
    /// # Errors
    /// [`WalkError`].
    pub(crate) fn read<R: BufRead + Seek>(walker: &mut Walker<R>) -> Result<Option<Self>, WalkError> {
        Self::read_with(walker, &[])
    }

    /// The same, and keeps the elements `besides` too.
    ///
    /// # Errors
    /// [`WalkError`].
    pub(crate) fn read_with<R: BufRead + Seek>(
        walker: &mut Walker<R>,
        besides: &'static [(Tag, &'static str)],
    ) -> Result<Option<Self>, WalkError> {
        let mut elements = Self {
            besides,
            ..Self::default()
        };
        if starts_with_preamble(walker)? {
            elements.read_meta(walker)?;
        } else if !starts_without_meta(walker)? {
            return Ok(None);
        }
        elements.read_dataset(walker)?;
        Ok(Some(elements))
    }

    /// The value of an element.
    pub(crate) fn get(&self, tag: Tag) -> Option<&[u8]> {
        self.values.iter().find(|row| row.0 == tag).map(|row| row.1.as_slice())
    }

    /// The class of the object; of a file's meta information where the data set does not say it.
    pub(crate) fn class(&self) -> Option<String> {
        self.text(el::SOP_CLASS).or_else(|| self.text(el::MEDIA_SOP_CLASS))
    }

    /// Whether the file's frames are slices of a CT, however many there are.
    pub(crate) fn is_framed(&self) -> bool {
        self.class()
            .is_some_and(|class| FRAMED_CLASSES.contains(&class.as_str()))
    }

    /// File Meta Information: always explicit little endian (PS3.10 section 7.1).
    fn read_meta<R: BufRead + Seek>(&mut self, walker: &mut Walker<R>) -> Result<(), WalkError> {
        let meta = Coding::ExplicitLittle;
        while walker.peek::<2>()? == Some([0x02, 0x00]) {
            let element = walker.element(meta)?;
            self.take(walker, &element, meta)?;
        }
        let uid = self.get(el::TRANSFER_SYNTAX).ok_or(FileError::Missing {
            tag: el::TRANSFER_SYNTAX,
        })?;
        self.syntax = Syntax::of(&super::text::text(uid))?;
        Ok(())
    }

    fn read_dataset<R: BufRead + Seek>(&mut self, walker: &mut Walker<R>) -> Result<(), WalkError> {
        let coding = self.syntax.elements;
        while walker.position() < walker.length() {
            let element = walker.element(coding)?;
            if element.tag == el::PIXELS {
                self.pixels = Some(element);
                return self.check_pixels(walker, &element);
            }
            self.take(walker, &element, coding)?;
        }
        Ok(())
    }

    /// Keeps the value if it is read, and passes over it otherwise.
    fn take<R: BufRead + Seek>(
        &mut self,
        walker: &mut Walker<R>,
        element: &Element,
        coding: Coding,
    ) -> Result<(), WalkError> {
        let Element { tag, byte, .. } = *element;
        match tag {
            el::MODALITY_LUT => self.modality_lut |= walker.has_items(element, coding)?,
            el::OFFSETS => self.tables[0] = Some(*element),
            el::OFFSET_LENGTHS => self.tables[1] = Some(*element),
            // Who asks for other elements asks for no frames.
            el::SHARED_GROUPS | el::FRAME_GROUPS if self.besides.is_empty() && self.is_framed() => {
                return self.take_groups(walker, element, coding);
            }
            _ => {}
        }
        let is_asked_for = self.besides.iter().any(|(besides, _)| *besides == tag);
        // A name that is longer than any tells no slices apart; who asks for it is told.
        let is_endless = el::is_only_told(tag) && element.length.is_none_or(|length| u64::from(length) > MAX_VALUE);
        if !is_asked_for && (is_endless || !el::is_read(tag)) {
            return walker.skip(element, coding);
        }
        if self.get(tag).is_some() {
            return Err(FileError::Twice { tag, byte }.into());
        }
        let value = walker.value(element)?;
        self.values.push((tag, value));
        Ok(())
    }

    fn take_groups<R: BufRead + Seek>(
        &mut self,
        walker: &mut Walker<R>,
        element: &Element,
        coding: Coding,
    ) -> Result<(), WalkError> {
        let Element { tag, byte, .. } = *element;
        let shared = tag == el::SHARED_GROUPS;
        let most = match (shared, self.frame_count()) {
            (true, _) => 1,
            (false, Ok(frames)) => frames,
            (false, Err(_)) => MAX_FRAMES,
        };
        let groups = groups::read(walker, element, coding, most)?;
        let before = match shared {
            true => self.shared.replace(groups),
            false => self.frames.replace(groups),
        };
        match before {
            None => Ok(()),
            Some(_) => Err(FileError::Twice { tag, byte }.into()),
        }
    }

    /// Whether the file's frames say where structures are.
    pub(crate) fn is_segmentation(&self) -> bool {
        self.class()
            .is_some_and(|class| SEGMENTATION_CLASSES.contains(&class.as_str()))
    }

    /// NumberOfFrames, which is above 0 and bounded.
    ///
    /// # Errors
    /// [`FileError::Missing`], [`FileError::Value`].
    pub(crate) fn frame_count(&self) -> Result<u32, FileError> {
        let tag = el::FRAMES;
        let frames = self.number(tag)?.ok_or(FileError::Missing { tag })?;
        if frames.fract() == 0.0 && (1.0..=f64::from(MAX_FRAMES)).contains(&frames) {
            return Ok(frames as u32);
        }
        let (found, expected) = (frames.to_string(), FRAMES_ALLOWED);
        Err(FileError::Value { tag, found, expected })
    }

    /// The pixel data must lie within the file; how long they must be is judged with the whole header.
    fn check_pixels<R: BufRead + Seek>(&self, walker: &Walker<R>, element: &Element) -> Result<(), WalkError> {
        let (expected, found) = match (self.syntax.pixels, element.length) {
            (PixelCoding::Native, None) => ("in one piece", "in fragments"),
            (PixelCoding::Native, Some(length)) => {
                let (end, found) = (element.value_at + u64::from(length), walker.length());
                let (tag, byte) = (element.tag, element.byte);
                return match end <= found {
                    true => Ok(()),
                    false => Err(FileError::Truncated {
                        tag,
                        byte,
                        expected: end,
                        found,
                    }
                    .into()),
                };
            }
            (_, Some(_)) => ("in fragments", "in one piece"),
            (_, None) => return Ok(()),
        };
        Err(FileError::Encapsulation { found, expected }.into())
    }
}

/// 128 bytes of anything, then "DICM" (PS3.10 section 7.1).
fn starts_with_preamble<R: BufRead + Seek>(walker: &mut Walker<R>) -> Result<bool, WalkError> {
    let Some(first) = walker.peek::<132>()? else {
        return Ok(false);
    };
    if !first.ends_with(b"DICM") {
        return Ok(false);
    }
    walker.seek(132)?;
    Ok(true)
}

/// Old files begin at once with group 0008 in implicit little endian; its first elements are short.
fn starts_without_meta<R: BufRead + Seek>(walker: &mut Walker<R>) -> Result<bool, WalkError> {
    let Some([0x08, 0x00, low, high, length @ ..]) = walker.peek::<8>()? else {
        return Ok(false);
    };
    let length = u64::from(u32::from_le_bytes(length));
    Ok(u16::from_le_bytes([low, high]) <= 0x0070 && length <= 256 && 8 + length <= walker.length())
}
