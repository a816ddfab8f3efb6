//! What a segmentation says of itself (DICOM PS3.3, A.51 and C.8.20).

use std::io::{BufRead, Seek};
use std::path::Path;

use super::error::SegmentationError;
use super::groups::{Group, Sequences};
use crate::dicom::element::Elements;
use crate::dicom::element::tree::{Asked, Tree};
use crate::dicom::error::{DicomError, FileError};
use crate::dicom::header::{Placed, placed, walk};
use crate::dicom::syntax::{Coding, PixelCoding};
use crate::dicom::tag as el;
use crate::dicom::text::charset::Charset;
use crate::dicom::walk::{Element, WalkError, Walker};
use crate::load::origin::Origin;
use crate::source::ReadError;

/// Pixels of a frame, as of a slice.
const MAX_PIXELS: u64 = 1 << 24;

const ASKED: Asked = Asked {
    values: &[
        el::CHARACTER_SET,
        el::SOP_CLASS,
        el::MEDIA_SOP_CLASS,
        el::TRANSFER_SYNTAX,
        el::PATIENT_ID,
        el::PATIENT_NAME,
        el::ID_ISSUER,
        el::BIRTH_DATE,
        el::SEX,
        el::STUDY,
        el::SERIES,
        el::APPROVAL,
        el::FRAME_OF_REFERENCE,
        el::SAMPLES,
        el::FRAMES,
        el::ROWS,
        el::COLUMNS,
        el::BITS_ALLOCATED,
        el::PADDING,
        el::SEGMENTATION_TYPE,
        el::FRACTION_MOST,
        el::SEGMENT,
        el::SEGMENT_LABEL,
        el::SEGMENT_REFERENCED,
        el::POSITION,
        el::ORIENTATION,
        el::PIXEL_SPACING,
        el::SPACING_BETWEEN_SLICES,
        el::TEMPORAL,
        el::BITS_STORED,
    ],
    long: &[],
    sequences: &[
        el::REFERENCED_SERIES,
        el::FRAME_CONTENT,
        el::SEGMENTS,
        el::SHARED_GROUPS,
        el::FRAME_GROUPS,
        el::PLANE_POSITION,
        el::PLANE_ORIENTATION,
        el::PIXEL_MEASURES,
        el::SEGMENT_OF_FRAME,
    ],
};

/// What a number of the pixel data means.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Cells {
    /// One bit: whether the voxel is of the frame's segment.
    Bits,
    /// How much of the voxel is of the frame's segment, of this many.
    Parts(u16),
    /// A label, in so many bytes.
    Labels(usize),
}

/// One frame.
#[derive(Debug, Clone, Copy)]
pub(super) struct Frame {
    /// Its segment; `None` in a map of labels.
    pub segment: Option<i16>,
    pub placed: Placed,
}

/// A segmentation, but for its pixels.
#[derive(Debug)]
pub(super) struct Object {
    pub cells: Cells,
    pub columns: u16,
    pub rows: u16,
    /// The segments with their names, in the order of the file.
    pub segments: Vec<(i16, String)>,
    pub frames: Vec<Frame>,
    /// SpacingBetweenSlices, mm, where all frames say it.
    pub step_mm: Option<f64>,
    /// Never shown.
    pub frame_of_reference: String,
    pub origin: Origin,
    pub pixels: Element,
}

fn items(found: String, expected: String) -> FileError {
    let tag = el::FRAME_GROUPS;
    FileError::Items { tag, found, expected }
}

/// Why an object is not read: one of its elements, or what they say together.
#[derive(Debug)]
pub(super) enum Refused {
    Element(FileError),
    Meaning(SegmentationError),
}

impl From<FileError> for Refused {
    fn from(error: FileError) -> Self {
        Self::Element(error)
    }
}

impl From<SegmentationError> for Refused {
    fn from(error: SegmentationError) -> Self {
        Self::Meaning(error)
    }
}

impl Refused {
    pub(super) fn of(self, path: &Path) -> ReadError {
        let path = path.to_owned();
        match self {
            Self::Element(source) => DicomError::File { path, source }.into(),
            Self::Meaning(source) => ReadError::Segmentation { path, source },
        }
    }
}

impl Object {
    /// Reads the file; `None` where it is no segmentation.
    ///
    /// # Errors
    /// [`ReadError::Dicom`], [`ReadError::Segmentation`].
    pub(super) fn read(path: &Path) -> Result<Option<Self>, ReadError> {
        let found = walk(path, parse)?;
        let Some((elements, sequences)) = found else {
            return Ok(None);
        };
        Self::of(&elements, &sequences)
            .map(Some)
            .map_err(|error| error.of(path))
    }

    fn of(e: &Elements, sequences: &Sequences) -> Result<Self, Refused> {
        let pixels = e.pixels.ok_or(FileError::Missing { tag: el::PIXELS })?;
        if e.syntax.pixels != PixelCoding::Native || e.syntax.elements == Coding::ExplicitBig {
            let found = e.syntax.name;
            return Err(SegmentationError::Coded { found }.into());
        }
        let cells = cells(e)?;
        let object = Self {
            cells,
            columns: e.u16(el::COLUMNS)?,
            rows: e.u16(el::ROWS)?,
            segments: segments(e, &sequences.segments, cells)?,
            step_mm: sequences.step_mm()?,
            frames: frames(e, sequences, cells)?,
            frame_of_reference: e.text(el::FRAME_OF_REFERENCE).ok_or(FileError::Missing {
                tag: el::FRAME_OF_REFERENCE,
            })?,
            origin: Origin::of(e, sequences.series.clone()),
            pixels,
        };
        if !sequences.is_of_one_time()? {
            return Err(SegmentationError::Times.into());
        }
        object.check_segments()?;
        object.check_length()?;
        Ok(object)
    }

    /// Pixels of one frame.
    pub(super) fn frame_pixels(&self) -> u64 {
        u64::from(self.columns) * u64::from(self.rows)
    }

    fn check_segments(&self) -> Result<(), SegmentationError> {
        let is_described = |segment: i16| self.segments.iter().any(|row| row.0 == segment);
        for (frame, number) in self.frames.iter().zip(1..) {
            if let Some(segment) = frame.segment.filter(|segment| !is_described(*segment)) {
                let found = segment.unsigned_abs();
                return Err(SegmentationError::Undescribed { frame: number, found });
            }
        }
        Ok(())
    }

    /// The pixel data have the length that the header asks for, up to one byte that makes it even; bits go on from frame to frame
    /// without a gap (PS3.5 section 8.1.1).
    fn check_length(&self) -> Result<(), FileError> {
        let (pixels, frames) = (self.frame_pixels(), self.frames.len() as u64);
        if pixels == 0 || pixels > MAX_PIXELS {
            let (tag, found) = (el::ROWS, format!("{} and Columns {}", self.rows, self.columns));
            let expected = "at least 1 each, and at most 16777216 pixels";
            return Err(FileError::Value { tag, found, expected });
        }
        let bits = match self.cells {
            Cells::Bits => 1,
            Cells::Parts(_) => 8,
            Cells::Labels(bytes) => 8 * bytes as u16,
        };
        let expected = (pixels * frames * u64::from(bits)).div_ceil(8);
        let found = u64::from(self.pixels.length.unwrap_or(0));
        if found == expected || found == expected.next_multiple_of(2) {
            return Ok(());
        }
        Err(FileError::PixelLength {
            found,
            expected,
            frames,
            columns: self.columns,
            rows: self.rows,
            bits,
        })
    }
}

fn parse<R: BufRead + Seek>(walker: &mut Walker<R>) -> Result<Option<(Elements, Sequences)>, WalkError> {
    let mut sequences = Sequences::default();
    let elements = Tree::read(walker, &ASKED, |tag, item| sequences.take(tag, item))?;
    Ok(elements
        .filter(Elements::is_segmentation)
        .map(|elements| (elements, sequences)))
}

/// What the pixels mean, by SegmentationType and BitsAllocated.
fn cells(e: &Elements) -> Result<Cells, FileError> {
    let (tag, kind) = (el::SEGMENTATION_TYPE, e.text(el::SEGMENTATION_TYPE));
    let kind = kind.ok_or(FileError::Missing { tag })?;
    let samples = e.u16(el::SAMPLES)?;
    if samples != 1 {
        return Err(FileError::Value {
            tag: el::SAMPLES,
            found: samples.to_string(),
            expected: "1: one value a voxel",
        });
    }
    match (kind.as_str(), e.u16(el::BITS_ALLOCATED)?) {
        ("BINARY", 1) => Ok(Cells::Bits),
        ("FRACTIONAL", 8) => Ok(Cells::Parts(e.u16(el::FRACTION_MOST)?)),
        // Other bits beside the labels would be read as theirs.
        ("LABELMAP", bits @ (8 | 16)) if e.u16(el::BITS_STORED)? != bits => Err(FileError::Value {
            tag: el::BITS_STORED,
            found: e.u16(el::BITS_STORED)?.to_string(),
            expected: "as many as BitsAllocated",
        }),
        ("LABELMAP", 8) => Ok(Cells::Labels(1)),
        ("LABELMAP", 16) => Ok(Cells::Labels(2)),
        ("BINARY" | "FRACTIONAL" | "LABELMAP", bits) => Err(FileError::Value {
            tag: el::BITS_ALLOCATED,
            found: bits.to_string(),
            expected: "1 for BINARY, 8 for FRACTIONAL, 8 or 16 for LABELMAP",
        }),
        _ => Err(FileError::Value {
            tag,
            found: "another".to_owned(),
            expected: "BINARY, FRACTIONAL or LABELMAP",
        }),
    }
}

/// The segments and their names; in a map of labels the ground may be described too, and is none.
fn segments(e: &Elements, items: &[Tree], cells: Cells) -> Result<Vec<(i16, String)>, Refused> {
    if let (Cells::Labels(_), Some(padding)) = (cells, e.get(el::PADDING).filter(|value| !value.is_empty()))
        && padding.iter().any(|&byte| byte != 0)
    {
        return Err(Refused::Element(FileError::Value {
            tag: el::PADDING,
            found: "not 0".to_owned(),
            expected: "0: the label of the ground",
        }));
    }
    let mut segments: Vec<(i16, String)> = Vec::new();
    for item in items {
        let found = item.values.u16(el::SEGMENT)?;
        if found == 0 && matches!(cells, Cells::Labels(_)) {
            continue;
        }
        let segment = label(found)?;
        if segments.iter().any(|row| row.0 == segment) {
            return Err(SegmentationError::DescribedTwice { segment }.into());
        }
        // An item may name sets of its own.
        let charset = Charset::of(item.values.get(el::CHARACTER_SET).or(e.get(el::CHARACTER_SET)));
        let name = item.values.get(el::SEGMENT_LABEL).map(|bytes| charset.text(bytes));
        segments.push((segment, name.unwrap_or_default()));
    }
    match segments.is_empty() {
        true => Err(SegmentationError::NoSegment.into()),
        false => Ok(segments),
    }
}

fn label(found: u16) -> Result<i16, SegmentationError> {
    let label = i16::try_from(found).ok().filter(|label| *label > 0);
    label.ok_or(SegmentationError::Label { found })
}

fn frames(e: &Elements, sequences: &Sequences, cells: Cells) -> Result<Vec<Frame>, Refused> {
    let [frames] = e
        .numbers::<1>(el::FRAMES)?
        .ok_or(FileError::Missing { tag: el::FRAMES })?;
    if frames != sequences.frames.len() as f64 || sequences.frames.is_empty() {
        let (found, expected) = (
            sequences.frames.len().to_string(),
            format!("{frames}: one for each frame"),
        );
        return Err(items(found, expected).into());
    }
    let shared = sequences.shared()?;
    let frame = |(group, number): (&Group, u32)| -> Result<Frame, Refused> {
        let group = group.or(shared);
        let missing = |tag| FileError::Missing { tag }.in_frame(Some(number));
        let segment = match cells {
            Cells::Labels(_) => None,
            Cells::Bits | Cells::Parts(_) => {
                let found = group.segment.ok_or_else(|| missing(el::SEGMENT_REFERENCED))?;
                Some(label(found)?)
            }
        };
        let placed = placed(group.position, group.orientation, group.spacing, false);
        let placed = placed.map_err(|error| error.in_frame(Some(number)))?.map_err(missing)?;
        Ok(Frame { segment, placed })
    };
    sequences.frames.iter().zip(1..).map(frame).collect()
}
