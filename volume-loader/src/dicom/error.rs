//! Why a DICOM file, folder or series is refused. No message holds anything that names a patient: elements are told by
//! tag and name, values only where they are numbers or codes of the standard.

use std::path::PathBuf;

use geometry::GridError;

use super::geometry::GeometryError;
use super::tag::{self as el, Tag};

/// Why a folder or a series was refused.
#[derive(Debug, thiserror::Error)]
pub enum DicomError {
    /// One file is not what it must be.
    #[error("{}: {source}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        source: FileError,
    },
    /// The operating system refused to list or read.
    #[error("{}: cannot be read: {source}; make it readable or take it out of the folder, as it may be a slice", path.display())]
    Unreadable {
        /// The file or folder.
        path: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// A link to a file that is not there.
    #[error("{}: this is a link to a file that is not there, and it may be a slice; check that the disk it leads to is mounted, or take the link out of the folder", path.display())]
    Dangling {
        /// The link.
        path: PathBuf,
    },
    /// The folder holds too much to be one examination.
    #[error("{}: more than {limit} {what} below this folder; name the folder of the examination itself", path.display())]
    TooMuch {
        /// The folder.
        path: PathBuf,
        /// The most allowed.
        limit: usize,
        /// Of what.
        what: &'static str,
    },
    /// No DICOM image at all.
    #[error("{}: no DICOM image in this folder ({ignored} other files{left_out}); name the folder that holds the slices", path.display())]
    None {
        /// The folder.
        path: PathBuf,
        /// Files that are not DICOM images.
        ignored: usize,
        /// What is no file, in words behind a semicolon; empty where there is nothing.
        left_out: String,
    },
    /// One part of a volume in several files, and nothing says whether it is all of it.
    #[error("{}: this is part {number} of a volume in several files (a concatenation), the only one here, and it does not say how many there are; copy the examination again from its origin", path.display())]
    PartAlone {
        /// The file.
        path: PathBuf,
        /// Its InConcatenationNumber.
        number: u32,
    },
    /// Two files say that they are the same part of a volume in several.
    #[error("{}: this is part {number} of a volume in several files (a concatenation), and so is {}; take one of them out of the folder", path.display(), other.display())]
    PartTwice {
        /// One file.
        path: PathBuf,
        /// The other.
        other: PathBuf,
        /// The InConcatenationNumber of both.
        number: u32,
    },
    /// A file of another kind.
    #[error(
        "{}: this is DICOM, and no slices of an examination (a segmentation, a structure set, a report): segmentations are read as label \
         maps (volume-loader labels, pilot plan --labels), points of structure sets into a plan (pilot plan --import)", path.display()
    )]
    NoSlices {
        /// The file.
        path: PathBuf,
    },
    /// One file of a volume in several.
    #[error("{}: this is part {number} of a volume in several files (a concatenation); name the folder that holds all of them: {}", path.display(), folder.display())]
    OnePart {
        /// The file.
        path: PathBuf,
        /// Its InConcatenationNumber.
        number: u32,
        /// Its folder.
        folder: PathBuf,
    },
    /// A part of a volume in several files is not there.
    #[error("{}: part {missing} of {total} of a volume in several files (a concatenation) is not there; copy the examination again from its origin", path.display())]
    Parts {
        /// A file of it.
        path: PathBuf,
        /// The first InConcatenationNumber that no file has.
        missing: u32,
        /// How many parts there must be.
        total: u32,
    },
    /// One file of a series is no volume.
    #[error("{}: this is one slice, not a volume; name the folder that holds all of them: {}", path.display(), folder.display())]
    OneFile {
        /// The file.
        path: PathBuf,
        /// Its folder.
        folder: PathBuf,
    },
    /// There are several series and nobody chose.
    #[error("{}: {count} series here, choose one with --series N:\n{list}{hint}", path.display())]
    Several {
        /// The folder.
        path: PathBuf,
        /// How many.
        count: usize,
        /// One line each.
        list: String,
        /// The only one that can be meant, if there is one.
        hint: String,
    },
    /// A series was chosen that is not there.
    #[error("{}: --series {asked}: there are series 1 to {count}:\n{list}", path.display())]
    NoSuchSeries {
        /// The folder.
        path: PathBuf,
        /// The number asked for.
        asked: usize,
        /// How many there are.
        count: usize,
        /// One line each.
        list: String,
    },
    /// A slice of another patient, study or frame of reference in a series. Values are not told.
    #[error("{}: {tag}: found {found} in {slices} slices, expected {expected} in {usual} slices such as {}: slices of several patients, positions, studies or frames of reference are no volume; take them apart (values are not shown, as they name a patient)", path.display(), other.display())]
    Mixed {
        /// The first odd slice.
        path: PathBuf,
        /// What differs.
        tag: Tag,
        /// Another value, or none.
        found: &'static str,
        /// How many slices have that.
        slices: usize,
        /// What most have.
        expected: &'static str,
        /// How many those are.
        usual: usize,
        /// The first of them.
        other: PathBuf,
    },
    /// The slices make no volume.
    #[error("{}: series {number}: {source}{}", path.display(), both(two.as_deref()))]
    Geometry {
        /// The folder.
        path: PathBuf,
        /// The series' number.
        number: usize,
        /// What is wrong.
        source: GeometryError,
        /// The files of two slices at one place.
        two: Option<Box<[PathBuf; 2]>>,
    },
    /// Dimensions or spacing that no scanner makes.
    #[error("{}: series {number}: {source}", path.display())]
    Grid {
        /// The folder.
        path: PathBuf,
        /// The series' number.
        number: usize,
        /// What is wrong.
        source: GridError,
    },
}

/// Two slices at one place by their files.
fn both(two: Option<&[PathBuf; 2]>) -> String {
    match two {
        None => String::new(),
        Some([one, other]) if one == other => format!(" (two of them are frames of {})", one.display()),
        Some([one, other]) => format!(" (two of them: {} and {})", one.display(), other.display()),
    }
}

/// Why one file was refused. Byte positions count from the file's first.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum FileError {
    /// It has the name of a DICOM file and is none.
    #[error(
        "not a DICOM file: no \"DICM\" at byte 128, and no element of group 0008 at byte 0; copy it again from its origin, or take it out of the folder"
    )]
    NotDicom,
    /// An element reaches beyond the end of the file.
    #[error(
        "the file ends in element {tag} at byte {byte}: expected {expected} bytes in the file, found {found}; copy it again from its origin"
    )]
    Truncated {
        /// The element.
        tag: Tag,
        /// Where it begins.
        byte: u64,
        /// Where it would end.
        expected: u64,
        /// The file's length.
        found: u64,
    },
    /// The file ends where an element's header or an end of a sequence must be.
    #[error(
        "the file ends at byte {found} within an element header or an open sequence that begins at byte {byte}; copy it again from its origin"
    )]
    BrokenOff {
        /// Where the header or the sequence begins.
        byte: u64,
        /// The file's length.
        found: u64,
    },
    /// A header element is absurdly long.
    #[error("element {tag} at byte {byte} is {found} bytes long, expected at most {limit}; the file is damaged")]
    TooLong {
        /// The element.
        tag: Tag,
        /// Where it begins.
        byte: u64,
        /// Its length.
        found: u64,
        /// The longest accepted.
        limit: u64,
    },
    /// Sequences within sequences without end.
    #[error("sequences are nested deeper than {limit} at byte {byte}; the file is damaged")]
    Nesting {
        /// Where.
        byte: u64,
        /// The deepest accepted.
        limit: usize,
    },
    /// More elements than any header has.
    #[error("more than {limit} elements before byte {byte}; the file is damaged")]
    TooManyElements {
        /// Where the next one begins.
        byte: u64,
        /// The most accepted.
        limit: u32,
    },
    /// An end of a sequence or item where none is open, or another one is.
    #[error("at byte {byte} stands {found}, which closes nothing that is open there; the file is damaged")]
    Delimiter {
        /// Where.
        byte: u64,
        /// The delimiter.
        found: Tag,
    },
    /// An element stands there twice.
    #[error("element {tag} stands there twice, the second time at byte {byte}; the file is damaged")]
    Twice {
        /// The element.
        tag: Tag,
        /// The second place.
        byte: u64,
    },
    /// An element that must be there is not.
    #[error("element {tag} is missing; without it the slice cannot be placed or read")]
    Missing {
        /// The element.
        tag: Tag,
    },
    /// An element's value cannot be used.
    #[error("element {tag} is {found}, expected {expected}")]
    Value {
        /// The element.
        tag: Tag,
        /// The value, if it is a number or a code.
        found: String,
        /// What it must be.
        expected: &'static str,
    },
    /// Two ways to say where rows and columns point, and each says another.
    #[error(
        "{} is \"{found}\", expected {expected}: by one of them the patient is mirrored or turned, and \
         which of them is right is not known",
        el::PATIENT_ORIENTATION
    )]
    Sides {
        /// PatientOrientation.
        found: String,
        /// The same by the cosines, and these.
        expected: String,
    },
    /// A slope and an intercept that lead most pixels out of the HU that are held.
    #[error(
        "{held} of {pixels} pixels are beyond -32768 to 32767 HU with RescaleSlope {slope} and RescaleIntercept {intercept}, expected at most half of them: these are no HU"
    )]
    Beyond {
        /// Pixels beyond.
        held: u64,
        /// Pixels of the slice.
        pixels: u64,
        /// RescaleSlope.
        slope: f64,
        /// RescaleIntercept.
        intercept: f64,
    },
    /// A transfer syntax that is not read.
    #[error(
        "transfer syntax {uid} ({name}) is not read; convert the series to Explicit VR Little Endian, for instance with dcmconv, dcmdjpeg or gdcmconv --raw"
    )]
    Syntax {
        /// The unique identifier.
        uid: String,
        /// Its name.
        name: &'static str,
    },
    /// Several images in one file.
    #[error(
        "{frames} frames in one file are read of Enhanced CT and Legacy Converted Enhanced CT only, whose frames say where each lies; convert it to one file per slice"
    )]
    MultiFrame {
        /// How many.
        frames: i64,
    },
    /// Something is wrong with one frame of several.
    #[error("frame {frame}: {source}")]
    Frame {
        /// Its number, from 1.
        frame: u32,
        /// What is wrong.
        source: Box<FileError>,
    },
    /// Frames and functional groups are not as many.
    #[error("{tag} has {found}, expected {expected}")]
    Items {
        /// The sequence.
        tag: Tag,
        /// How many there are, in words.
        found: String,
        /// How many there must be, and for what.
        expected: String,
    },
    /// An element reaches beyond the sequence or the item that holds it.
    #[error("{tag} at byte {byte} ends at byte {end}, and what it holds at byte {found}; the file is damaged")]
    Overrun {
        /// The sequence or the item.
        tag: Tag,
        /// Where it begins.
        byte: u64,
        /// Where it ends.
        end: u64,
        /// Where its last element ends.
        found: u64,
    },
    /// It is not said which fragments make which frame.
    #[error(
        "the table of offsets of the frames: found {found}, expected {expected}; without it no frame is told from the next"
    )]
    Offsets {
        /// What there is.
        found: String,
        /// What there must be.
        expected: String,
    },
    /// The pixel data have another length than the header says.
    #[error("the pixel data are {found} bytes long, expected {expected} for {} of {columns} x {rows} pixels of {bits} bits", frames_of(*frames))]
    PixelLength {
        /// Bytes that there are.
        found: u64,
        /// Bytes that the header asks for.
        expected: u64,
        /// Frames in the file.
        frames: u64,
        /// Pixels in a row.
        columns: u16,
        /// Rows.
        rows: u16,
        /// Bits of a pixel.
        bits: u16,
    },
    /// Fragments where there must be none, or none where there must be some.
    #[error("the pixel data are {found}, expected {expected} in this transfer syntax")]
    Encapsulation {
        /// How they are.
        found: &'static str,
        /// How they must be.
        expected: &'static str,
    },
    /// The compressed image is another than the header says.
    #[error("the {codec} stream holds {found}, the header says {expected}")]
    Mismatch {
        /// The codec.
        codec: &'static str,
        /// What the stream says.
        found: String,
        /// What the header says.
        expected: String,
    },
    /// The compressed image cannot be decoded.
    #[error("the {codec} stream cannot be decoded: {detail}; copy the file again from its origin")]
    Codec {
        /// The codec.
        codec: &'static str,
        /// What is wrong.
        detail: String,
    },
}

fn frames_of(count: u64) -> String {
    match count {
        1 => "one image".to_owned(),
        _ => format!("{count} frames"),
    }
}

impl FileError {
    /// The same, told of a frame where the file has several.
    pub(crate) fn in_frame(self, frame: Option<u32>) -> Self {
        match frame {
            Some(frame) => Self::Frame {
                frame,
                source: Box::new(self),
            },
            None => self,
        }
    }
}
