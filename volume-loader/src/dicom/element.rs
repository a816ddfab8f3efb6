//! The data elements that are read, by tag and name (DICOM PS3.6 table 6-1). Everything else in a file is passed over, so
//! that nothing of a patient is even held; of PatientID a digest stays ([`Header::patient`](super::header::Header::patient)).

use std::io::{BufRead, Seek};

use super::error::{FileError, Tag};
use super::syntax::{Coding, PixelCoding, Syntax};
use super::walk::{Element, WalkError, Walker, tag};

macro_rules! elements {
    ($($name:ident = ($group:literal, $element:literal, $text:literal);)*) => {
        $(pub(crate) const $name: Tag = tag($group, $element);)*
        const NAMES: &[(Tag, &str)] = &[$(($name, $text)),*];
    };
}

elements! {
    MEDIA_SOP_CLASS = (0x0002, 0x0002, "MediaStorageSOPClassUID");
    TRANSFER_SYNTAX = (0x0002, 0x0010, "TransferSyntaxUID");
    IMAGE_TYPE = (0x0008, 0x0008, "ImageType");
    SOP_CLASS = (0x0008, 0x0016, "SOPClassUID");
    MODALITY = (0x0008, 0x0060, "Modality");
    PATIENT_ID = (0x0010, 0x0020, "PatientID");
    SLICE_THICKNESS = (0x0018, 0x0050, "SliceThickness");
    SPACING_BETWEEN_SLICES = (0x0018, 0x0088, "SpacingBetweenSlices");
    GANTRY_TILT = (0x0018, 0x1120, "GantryDetectorTilt");
    KERNEL = (0x0018, 0x1210, "ConvolutionKernel");
    STUDY = (0x0020, 0x000D, "StudyInstanceUID");
    SERIES = (0x0020, 0x000E, "SeriesInstanceUID");
    SERIES_NUMBER = (0x0020, 0x0011, "SeriesNumber");
    POSITION = (0x0020, 0x0032, "ImagePositionPatient");
    ORIENTATION = (0x0020, 0x0037, "ImageOrientationPatient");
    FRAME_OF_REFERENCE = (0x0020, 0x0052, "FrameOfReferenceUID");
    SAMPLES = (0x0028, 0x0002, "SamplesPerPixel");
    PHOTOMETRIC = (0x0028, 0x0004, "PhotometricInterpretation");
    FRAMES = (0x0028, 0x0008, "NumberOfFrames");
    ROWS = (0x0028, 0x0010, "Rows");
    COLUMNS = (0x0028, 0x0011, "Columns");
    PIXEL_SPACING = (0x0028, 0x0030, "PixelSpacing");
    BITS_ALLOCATED = (0x0028, 0x0100, "BitsAllocated");
    BITS_STORED = (0x0028, 0x0101, "BitsStored");
    HIGH_BIT = (0x0028, 0x0102, "HighBit");
    REPRESENTATION = (0x0028, 0x0103, "PixelRepresentation");
    PADDING = (0x0028, 0x0120, "PixelPaddingValue");
    PADDING_LIMIT = (0x0028, 0x0121, "PixelPaddingRangeLimit");
    INTERCEPT = (0x0028, 0x1052, "RescaleIntercept");
    SLOPE = (0x0028, 0x1053, "RescaleSlope");
    RESCALE_TYPE = (0x0028, 0x1054, "RescaleType");
    LOSSY = (0x0028, 0x2110, "LossyImageCompression");
    PIXELS = (0x7FE0, 0x0010, "PixelData");
}

/// Elements that name a patient, a visit or a place: read only where a person asks for them.
pub(crate) const IDENTITY: [(Tag, &str); 11] = [
    (tag(0x0010, 0x0010), "PatientName"),
    (PATIENT_ID, "PatientID"),
    (tag(0x0010, 0x0030), "PatientBirthDate"),
    (tag(0x0010, 0x0040), "PatientSex"),
    (tag(0x0008, 0x0020), "StudyDate"),
    (tag(0x0008, 0x0050), "AccessionNumber"),
    (tag(0x0008, 0x0080), "InstitutionName"),
    (tag(0x0008, 0x1030), "StudyDescription"),
    (tag(0x0008, 0x103E), "SeriesDescription"),
    (STUDY, "StudyInstanceUID"),
    (SERIES, "SeriesInstanceUID"),
];

/// The name of an element that is read.
pub(crate) fn name(tag: Tag) -> Option<&'static str> {
    NAMES.iter().find(|row| row.0 == tag).map(|row| row.1)
}

/// The values of one file's elements, as they stand there.
#[derive(Debug, Clone)]
pub(crate) struct Elements {
    pub syntax: Syntax,
    values: Vec<(Tag, Vec<u8>)>,
    /// The header of the pixel data, where there are any.
    pub pixels: Option<Element>,
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
            syntax: Syntax::DEFAULT,
            values: Vec::new(),
            pixels: None,
            besides,
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

    /// File Meta Information: always explicit little endian (PS3.10 section 7.1).
    fn read_meta<R: BufRead + Seek>(&mut self, walker: &mut Walker<R>) -> Result<(), WalkError> {
        let meta = Coding::ExplicitLittle;
        while walker.peek::<2>()? == Some([0x02, 0x00]) {
            let element = walker.element(meta)?;
            self.take(walker, &element, meta)?;
        }
        let uid = self
            .get(TRANSFER_SYNTAX)
            .ok_or(FileError::Missing { tag: TRANSFER_SYNTAX })?;
        self.syntax = Syntax::of(&super::values::text(uid))?;
        Ok(())
    }

    fn read_dataset<R: BufRead + Seek>(&mut self, walker: &mut Walker<R>) -> Result<(), WalkError> {
        let coding = self.syntax.elements;
        while walker.position() < walker.length() {
            let element = walker.element(coding)?;
            if element.tag == PIXELS {
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
        if name(tag).is_none() && !self.besides.iter().any(|(besides, _)| *besides == tag) {
            return walker.skip(element, coding);
        }
        if self.get(tag).is_some() {
            return Err(FileError::Twice { tag, byte }.into());
        }
        let value = walker.value(element)?;
        self.values.push((tag, value));
        Ok(())
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
