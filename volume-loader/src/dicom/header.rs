//! What one file says of itself, as far as it is needed.

pub(super) mod frames;
pub(super) mod identity;
pub(super) mod part;
pub(crate) mod person;
pub(super) mod scanned;

use std::fs::File;
use std::io::{BufRead, BufReader, Read, Seek};
use std::path::{Path, PathBuf};

use self::frames::Frame;
use self::scanned::Scan;
use super::element::Elements;
use super::error::{DicomError, FileError};
use super::syntax::{Coding, Syntax};
use super::tag as el;
use super::tag::Tag;
use super::text::{Label, digest, name_digest};
use super::walk::{Element, WalkError, Walker};

/// One read of this many bytes holds most headers whole.
const BUFFER_BYTES: usize = 1 << 13;
/// SOP classes that are images of one slice: CT and MR Image Storage (PS3.4 table B.5-1).
const SLICE_CLASSES: [&str; 2] = ["1.2.840.10008.5.1.4.1.1.2", "1.2.840.10008.5.1.4.1.1.4"];

/// Where a slice lies, as the file says it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Placed {
    /// Centre of the first pixel, patient axes, mm.
    pub position: [f64; 3],
    /// Directions of a row and of a column, as cosines.
    pub orientation: [f64; 6],
    /// Distance between rows and distance between columns, mm.
    pub spacing: [f64; 2],
}

/// The header of one slice: of a file, or of one frame of a file.
#[derive(Debug, Clone)]
pub(crate) struct Header {
    pub path: PathBuf,
    pub syntax: Syntax,
    pub modality: String,
    /// StudyInstanceUID; never shown.
    pub study: String,
    /// SeriesInstanceUID; `None` where names were taken out and it with them. Never shown.
    pub series: Option<String>,
    /// SeriesNumber, as text.
    pub series_number: Option<String>,
    /// A digest of PatientID, which tells one from another and is held no longer than the scan: never shown.
    pub patient: Option<u64>,
    /// Digests of [`el::PERSON`], likewise; `None` where a file does not say.
    pub person: [Option<u64>; 5],
    /// Of which scan it is.
    pub scan: Scan,
    /// Never shown.
    pub frame_of_reference: String,
    /// PatientOrientation, and whether its words are a person's.
    pub sides: Option<String>,
    pub is_person: bool,
    pub localizer: bool,
    pub columns: u16,
    pub rows: u16,
    /// How many frames the file has; of a file whose frames are slices, from 1 to a bound.
    pub frames: i64,
    /// Which one this is, where the frames of the file are slices; `None` in a file of one slice.
    pub frame: Option<Frame>,
    pub samples: u16,
    pub photometric: String,
    pub bits_allocated: u16,
    pub bits_stored: u16,
    pub high_bit: u16,
    pub representation: u16,
    /// Where it lies, or the first element that is missing for it.
    pub placed: Result<Placed, Tag>,
    pub slope: Option<f64>,
    pub intercept: Option<f64>,
    pub rescale_type: Option<Label>,
    /// The fourth value of ImageType, or of a frame's FrameType.
    pub contrast: Option<String>,
    /// VolumetricProperties.
    pub volumetric: Option<String>,
    /// VolumeBasedCalculationTechnique.
    pub technique: Option<String>,
    /// PixelPaddingValue and PixelPaddingRangeLimit, as they are stored.
    pub padding: [Option<u16>; 2],
    pub tilt_deg: Option<f64>,
    pub thickness_mm: Option<f64>,
    pub spacing_between_mm: Option<f64>,
    pub kernel: Option<Label>,
    pub lossy: bool,
    pub modality_lut: bool,
    pub pixels: Element,
    /// The file's length, bytes.
    pub length: u64,
}

/// What a file turned out to be.
#[derive(Debug)]
pub(crate) enum Kind {
    /// A slice, or all frames of a file, at least one.
    Images(Vec<Header>),
    /// DICOM, but no image: a directory, a report, a structure set; and a segmentation.
    Object,
    /// Not DICOM.
    Other,
}

/// Opens a file and hands it to `parse`, whose errors get its name.
pub(crate) fn walk<T>(
    path: &Path,
    parse: impl FnOnce(&mut Walker<BufReader<File>>) -> Result<T, WalkError>,
) -> Result<T, DicomError> {
    let unreadable = |source| DicomError::Unreadable {
        path: path.to_owned(),
        source,
    };
    let (file, about) = scene::file::open(path).map_err(|error| unreadable(error.into()))?;
    let mut walker = Walker::new(BufReader::with_capacity(BUFFER_BYTES, file), about.len());
    parse(&mut walker).map_err(|error| match error {
        WalkError::Io(source) => unreadable(source),
        WalkError::File(source) => DicomError::File {
            path: path.to_owned(),
            source,
        },
    })
}

impl Header {
    /// Reads the header of the file at `path`.
    ///
    /// # Errors
    /// [`DicomError::File`], [`DicomError::Unreadable`].
    pub(crate) fn read(path: &Path) -> Result<Kind, DicomError> {
        walk(path, |walker| Self::parse(path, walker))
    }

    /// Whether the file begins like DICOM; one that cannot be read does not.
    pub(crate) fn has_preamble(path: &Path) -> bool {
        let mut first = [0; 132];
        let read = scene::file::open(path).map(|(mut file, _)| file.read_exact(&mut first));
        matches!(read, Ok(Ok(()))) && first.ends_with(b"DICM")
    }

    /// The header in `walker`'s bytes.
    ///
    /// # Errors
    /// [`WalkError`].
    pub(crate) fn parse<R: BufRead + Seek>(path: &Path, walker: &mut Walker<R>) -> Result<Kind, WalkError> {
        let Some(elements) = Elements::read(walker)? else {
            return Ok(Kind::Other);
        };
        // Their frames are no grey values.
        if elements.is_segmentation() {
            return Ok(Kind::Object);
        }
        let Some(pixels) = elements.pixels else {
            let slice = elements
                .class()
                .is_some_and(|class| SLICE_CLASSES.contains(&class.as_str()));
            return match slice || elements.is_framed() || elements.get(el::ROWS).is_some() {
                true => Err(FileError::Missing { tag: el::PIXELS }.into()),
                false => Ok(Kind::Object),
            };
        };
        let header = Self::of(path, &elements, pixels, walker.length())?;
        Ok(Kind::Images(match elements.is_framed() {
            true => frames::each(&header, &elements)?,
            false => vec![header],
        }))
    }

    fn of(path: &Path, e: &Elements, pixels: Element, length: u64) -> Result<Self, FileError> {
        let localizer = e.is_localizer(el::IMAGE_TYPE);
        Ok(Self {
            path: path.to_owned(),
            syntax: e.syntax,
            modality: e.code(el::MODALITY).ok_or(FileError::Missing { tag: el::MODALITY })?,
            study: e.text(el::STUDY).unwrap_or_default(),
            series: e.text(el::SERIES),
            series_number: e.text(el::SERIES_NUMBER),
            patient: e.get(el::PATIENT_ID).and_then(digest),
            person: el::PERSON.map(|tag| match (tag, e.get(tag)?) {
                (el::PATIENT_NAME, name) => name_digest(name),
                (_, bytes) => digest(bytes),
            }),
            scan: Scan::of(e),
            frame_of_reference: e.text(el::FRAME_OF_REFERENCE).unwrap_or_default(),
            sides: e.text(el::PATIENT_ORIENTATION),
            is_person: e.text(el::ANATOMY).is_none_or(|kind| kind != "QUADRUPED"),
            localizer,
            columns: e.u16(el::COLUMNS)?,
            rows: e.u16(el::ROWS)?,
            frames: e.number(el::FRAMES)?.map_or(1, |frames| frames as i64),
            frame: None,
            samples: e.u16(el::SAMPLES)?,
            photometric: e
                .code(el::PHOTOMETRIC)
                .ok_or(FileError::Missing { tag: el::PHOTOMETRIC })?,
            bits_allocated: e.u16(el::BITS_ALLOCATED)?,
            bits_stored: e.u16(el::BITS_STORED)?,
            high_bit: e.u16(el::HIGH_BIT)?,
            representation: e.u16(el::REPRESENTATION)?,
            placed: match e.is_framed() {
                // Each frame says it for itself.
                true => Err(el::POSITION),
                false => placed(
                    e.numbers(el::POSITION)?,
                    e.numbers(el::ORIENTATION)?,
                    e.numbers(el::PIXEL_SPACING)?,
                    localizer,
                )?,
            },
            slope: e.number(el::SLOPE)?,
            intercept: e.number(el::INTERCEPT)?,
            rescale_type: e.label(el::RESCALE_TYPE),
            contrast: e.contrast(el::IMAGE_TYPE),
            volumetric: e.code(el::VOLUMETRIC),
            technique: e.code(el::TECHNIQUE),
            padding: [padding(e, el::PADDING)?, padding(e, el::PADDING_LIMIT)?],
            tilt_deg: e.reported(el::GANTRY_TILT),
            thickness_mm: e.reported(el::SLICE_THICKNESS),
            spacing_between_mm: e.reported(el::SPACING_BETWEEN_SLICES),
            kernel: e.label(el::KERNEL),
            lossy: e.text(el::LOSSY).is_some_and(|lossy| lossy == "01"),
            modality_lut: e.modality_lut,
            pixels,
            length,
        })
    }

    /// The number of the frame, from 1, that an error is told of.
    pub(crate) fn frame_number(&self) -> Option<u32> {
        self.frame.as_ref().map(|frame| frame.number)
    }

    /// Whether numbers of several bytes have their most significant first.
    pub(crate) fn big_endian(&self) -> bool {
        self.syntax.elements == Coding::ExplicitBig
    }
}

/// Where a slice lies. The standard has both spacings above 0 (PS3.3, 10.7.1.1): one that is negative mirrors the patient, and two
/// turn them.
pub(crate) fn placed(
    position: Option<[f64; 3]>,
    orientation: Option<[f64; 6]>,
    spacing: Option<[f64; 2]>,
    localizer: bool,
) -> Result<Result<Placed, Tag>, FileError> {
    Ok(match (position, orientation, spacing) {
        (None, _, _) => Err(el::POSITION),
        (_, None, _) => Err(el::ORIENTATION),
        (_, _, None) => Err(el::PIXEL_SPACING),
        (Some(_), Some(_), Some([down, right])) if !localizer && (down <= 0.0 || right <= 0.0) => {
            return Err(FileError::Value {
                tag: el::PIXEL_SPACING,
                found: format!("\"{down}\\{right}\""),
                expected: "two numbers above 0: a negative one would mirror or turn the patient",
            });
        }
        (Some(position), Some(orientation), Some(spacing)) => Ok(Placed {
            position,
            orientation,
            spacing,
        }),
    })
}

fn padding(e: &Elements, tag: Tag) -> Result<Option<u16>, FileError> {
    match e.get(tag) {
        None | Some([]) => Ok(None),
        Some(_) => e.u16(tag).map(Some),
    }
}
