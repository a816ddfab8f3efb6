//! Why an examination was not read.

use std::path::PathBuf;

use super::Place;
use super::known::KNOWN;
use crate::dicom::DicomError;
use crate::load::segmentation::SegmentationError;
use crate::metaimage::MetaImageError;
use crate::nifti::HeaderError;
use crate::nrrd::NrrdError;

/// Why an examination was not read. Byte positions count from 0, in the unpacked data where a file is compressed.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// There is no such file.
    #[error("{}: there is no such file; check the name and that its disk is mounted", path.display())]
    Missing {
        /// The file.
        path: PathBuf,
    },
    /// A link to a file that is not there.
    #[error("{}: this is a link to a file that is not there; check that the disk it leads to is mounted", path.display())]
    Dangling {
        /// The link.
        path: PathBuf,
    },
    /// The path names a folder, a pipe, a socket or a device.
    #[error("{}: this is {found}, expected a file", path.display())]
    NotAFile {
        /// The path.
        path: PathBuf,
        /// What it is.
        found: &'static str,
    },
    /// A header names itself as the file of its voxels, or one file twice.
    #[error(
        "{}: this is the same file as {}: a header's voxels are in files of their own, each named once; check the names in the header",
        path.display(), other.display()
    )]
    Twice {
        /// The file that was named.
        path: PathBuf,
        /// The header, or the name that led to it before.
        other: PathBuf,
    },
    /// The file begins as none that is read.
    #[error("{}: this is no volume that is read: its first bytes are {found:02x?}{hint}; {KNOWN}", path.display())]
    Unknown {
        /// The file.
        path: PathBuf,
        /// Its first bytes.
        found: Vec<u8>,
        /// What it seems to be.
        hint: &'static str,
    },
    /// The file has no bytes.
    #[error("{}: the file is empty (0 bytes); copy it again from its origin", path.display())]
    Empty {
        /// The file.
        path: PathBuf,
    },
    /// The operating system refused to open or read it.
    #[error("{}: cannot read {place} at byte {byte}: {source}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What was being read.
        place: Place,
        /// Where.
        byte: u64,
        /// The system's reason.
        source: std::io::Error,
    },
    /// The header is not one that can be used.
    #[error("{}: {source}", path.display())]
    Header {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        source: HeaderError,
    },
    /// The header of an NRRD file is not one that can be used.
    #[error("{}: {source}", path.display())]
    Nrrd {
        /// The header's file.
        path: PathBuf,
        /// What is wrong with it.
        source: NrrdError,
    },
    /// The header of a MetaImage file is not one that can be used.
    #[error("{}: {source}", path.display())]
    MetaImage {
        /// The header's file.
        path: PathBuf,
        /// What is wrong with it.
        source: MetaImageError,
    },
    /// A voxel written as text is no number, or there are more of them than voxels.
    #[error("{}: {place} has {found:?} before byte {byte}, expected {expected}", path.display())]
    Word {
        /// The file.
        path: PathBuf,
        /// What was being read.
        place: Place,
        /// The byte after it.
        byte: u64,
        /// What stands there, 80 characters at most.
        found: String,
        /// What would do.
        expected: &'static str,
    },
    /// A DICOM file, folder or series was refused.
    #[error(transparent)]
    Dicom(Box<DicomError>),
    /// A segmentation of DICOM is no label map.
    #[error("{}: {source}", path.display())]
    Segmentation {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        source: SegmentationError,
    },
    /// The file is shorter than its header says.
    #[error("{}: the file ends in {place}: expected at least {expected} bytes, found {found}; copy it again from its origin", path.display())]
    Truncated {
        /// The file.
        path: PathBuf,
        /// What was being read.
        place: Place,
        /// Bytes that the header asks for.
        expected: u64,
        /// Bytes that there are.
        found: u64,
    },
    /// The file is much longer than its header says: probably the header is wrong.
    #[error("{}: the voxels end at byte {expected}, found {found} bytes or more; the header's dimensions or datatype are wrong", path.display())]
    TooLong {
        /// The file.
        path: PathBuf,
        /// Bytes that the header asks for.
        expected: u64,
        /// Bytes that there are, at least.
        found: u64,
    },
    /// The compressed stream stops before its end.
    #[error("{}: the compressed stream breaks off in {place}: expected at least {expected} unpacked bytes and a checksum, found {found}; copy it again from its origin", path.display())]
    BrokenOff {
        /// The file.
        path: PathBuf,
        /// What was being read.
        place: Place,
        /// Unpacked bytes that the header asks for.
        expected: u64,
        /// Unpacked bytes that there are.
        found: u64,
    },
    /// The compressed stream is damaged.
    #[error("{}: the compressed stream is damaged in {place}, at unpacked byte {byte}: {detail}; copy it again from its origin", path.display())]
    Corrupt {
        /// The file.
        path: PathBuf,
        /// What was being read.
        place: Place,
        /// Unpacked bytes read before.
        byte: u64,
        /// What the decoder says.
        detail: String,
    },
    /// A slice was asked for out of order.
    #[error("slice {found} was asked for, expected slice {expected} of {count}: slices are read in order, each once")]
    Order {
        /// The slice whose turn it is.
        expected: u32,
        /// The slice asked for.
        found: u32,
        /// How many slices there are.
        count: u32,
    },
    /// The buffer for a slice has the wrong length.
    #[error("the buffer for slice {slice} holds {found} voxels, expected {expected}")]
    Buffer {
        /// The slice.
        slice: u32,
        /// Voxels per slice.
        expected: u64,
        /// Length of the buffer.
        found: usize,
    },
}

impl From<DicomError> for ReadError {
    fn from(error: DicomError) -> Self {
        Self::Dicom(Box::new(error))
    }
}
