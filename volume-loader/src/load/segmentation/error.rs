//! Why a segmentation is no label map.

use crate::dicom::geometry::CORNER_MAX_MM;
use crate::load::origin::error::OriginError;

/// Why a segmentation of DICOM is no label map. Frames count from 1, as the standard counts them.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SegmentationError {
    /// No segment that could be named.
    #[error("this segmentation has no segment")]
    NoSegment,
    /// A label that a map of 16 bits does not hold, or that is the ground's.
    #[error("segment {found}: labels from 1 to 32767 are held")]
    Label {
        /// SegmentNumber.
        found: u16,
    },
    /// Two segments of one number.
    #[error("segment {segment} is described twice: which of the two it is, is not known")]
    DescribedTwice {
        /// SegmentNumber.
        segment: i16,
    },
    /// A frame of a segment that nothing describes.
    #[error("frame {frame} is of segment {found}, which SegmentSequence does not describe")]
    Undescribed {
        /// Which frame.
        frame: u32,
        /// ReferencedSegmentNumber.
        found: u16,
    },
    /// Two frames of one segment at one place.
    #[error(
        "frames {first} and {second} are both of segment {segment} at one place: which of the two holds, is not known"
    )]
    Twice {
        /// Which frame.
        first: u32,
        /// Which frame.
        second: u32,
        /// Of which segment.
        segment: i16,
    },
    /// A voxel of two structures.
    #[error(
        "segments {first} and {second} overlap, first at column {column}, row {row} of frame {frame}: a label map holds one structure a \
         voxel; write structures that overlap into files of their own"
    )]
    Overlap {
        /// The segment that has the voxel.
        first: i16,
        /// The segment that claims it too.
        second: i16,
        /// In which frame.
        frame: u32,
        /// Where, from 0.
        column: usize,
        /// Where, from 0.
        row: usize,
    },
    /// A voxel that is partly of a structure.
    #[error(
        "a voxel of frame {frame} is {found} of {most}, neither 0 nor all: this segmentation says how probable or how full a voxel is, and \
         where a structure ends would be a guess; write it as BINARY"
    )]
    Partly {
        /// Which frame.
        frame: u32,
        /// The value.
        found: u16,
        /// MaximumFractionalValue.
        most: u16,
    },
    /// A label of a map that nothing describes.
    #[error("a voxel of frame {frame} has the label {found}, which SegmentSequence does not describe")]
    Unknown {
        /// Which frame.
        frame: u32,
        /// The label.
        found: u16,
    },
    /// A segment of which there is nothing.
    #[error(
        "segment {segment} ({name:?}) has no voxel: who reads its name would take it for far away; write the segmentation without it"
    )]
    Empty {
        /// SegmentNumber.
        segment: i16,
        /// SegmentLabel.
        name: String,
    },
    /// Planes at places between which no step leads.
    #[error(
        "its planes lie at {places}; {stated}, which is no step that leads from each to the next: whether planes are missing, is not known"
    )]
    Step {
        /// The first places along the stack, mm.
        places: String,
        /// What the file says of the step.
        stated: String,
    },
    /// Frames of several points in time.
    #[error("its frames are of several points in time (TemporalPositionIndex): they are several segmentations")]
    Times,
    /// A frame beside the grid of the others.
    #[error(
        "a frame lies {found_mm:.3} mm beside the even grid of the others, expected at most {CORNER_MAX_MM} mm: it is no label map on one grid"
    )]
    Beside {
        /// How far one of its corners is off.
        found_mm: f64,
    },
    /// Planes that are nearly one.
    #[error(
        "frames lie closer than 0.001 mm to one another and not in one plane, or have other axes there: which of them are one plane, is not known"
    )]
    Nearly,
    /// Pixels that are compressed.
    #[error("its pixels are coded as {found}, and are read uncompressed; convert it, for instance with gdcmconv --raw")]
    Coded {
        /// The transfer syntax.
        found: &'static str,
    },
    /// It is of another patient, or was rejected.
    #[error(transparent)]
    Origin(#[from] OriginError),
    /// It belongs to another examination.
    #[error(
        "its places are in another frame of reference than the examination's (FrameOfReferenceUID): they are places in another scan, or of \
         another patient"
    )]
    OtherFrame,
}
