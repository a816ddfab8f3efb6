//! The data elements that are read, by tag and name (DICOM PS3.6 table 6-1).

use std::fmt;

/// A data element: group and element number, and its name in PS3.6.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Tag {
    /// Group number.
    pub group: u16,
    /// Element number.
    pub element: u16,
}

impl fmt::Display for Tag {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "({:04X},{:04X})", self.group, self.element)?;
        match name(*self) {
            Some(name) => write!(f, " {name}"),
            None => Ok(()),
        }
    }
}

/// A tag by its numbers.
pub(crate) const fn tag(group: u16, element: u16) -> Tag {
    Tag { group, element }
}

macro_rules! elements {
    ($list:ident: $($name:ident = ($group:literal, $element:literal, $text:literal);)*) => {
        $(pub(crate) const $name: Tag = tag($group, $element);)*
        const $list: &[(Tag, &str)] = &[$(($name, $text)),*];
    };
}

elements! { NAMES:
    MEDIA_SOP_CLASS = (0x0002, 0x0002, "MediaStorageSOPClassUID");
    TRANSFER_SYNTAX = (0x0002, 0x0010, "TransferSyntaxUID");
    IMAGE_TYPE = (0x0008, 0x0008, "ImageType");
    SOP_CLASS = (0x0008, 0x0016, "SOPClassUID");
    SOP_INSTANCE = (0x0008, 0x0018, "SOPInstanceUID");
    ACQUISITION_UID = (0x0008, 0x0017, "AcquisitionUID");
    STUDY_DATE = (0x0008, 0x0020, "StudyDate");
    SERIES_DATE = (0x0008, 0x0021, "SeriesDate");
    ACQUISITION_DATE = (0x0008, 0x0022, "AcquisitionDate");
    CONTENT_DATE = (0x0008, 0x0023, "ContentDate");
    ACQUISITION_DATETIME = (0x0008, 0x002A, "AcquisitionDateTime");
    ACQUISITION_TIME = (0x0008, 0x0032, "AcquisitionTime");
    ACCESSION = (0x0008, 0x0050, "AccessionNumber");
    MODALITY = (0x0008, 0x0060, "Modality");
    SERIES_DESCRIPTION = (0x0008, 0x103E, "SeriesDescription");
    SCANNER_MODEL = (0x0008, 0x1090, "ManufacturerModelName");
    VOLUMETRIC = (0x0008, 0x9206, "VolumetricProperties");
    TECHNIQUE = (0x0008, 0x9207, "VolumeBasedCalculationTechnique");
    PATIENT_NAME = (0x0010, 0x0010, "PatientName");
    PATIENT_ID = (0x0010, 0x0020, "PatientID");
    ID_ISSUER = (0x0010, 0x0021, "IssuerOfPatientID");
    BIRTH_DATE = (0x0010, 0x0030, "PatientBirthDate");
    SEX = (0x0010, 0x0040, "PatientSex");
    ANATOMY = (0x0010, 0x2210, "AnatomicalOrientationType");
    CONTRAST_AGENT = (0x0018, 0x0010, "ContrastBolusAgent");
    SLICE_THICKNESS = (0x0018, 0x0050, "SliceThickness");
    KVP = (0x0018, 0x0060, "KVP");
    SPACING_BETWEEN_SLICES = (0x0018, 0x0088, "SpacingBetweenSlices");
    SCANNER_SERIAL = (0x0018, 0x1000, "DeviceSerialNumber");
    GANTRY_TILT = (0x0018, 0x1120, "GantryDetectorTilt");
    KERNEL = (0x0018, 0x1210, "ConvolutionKernel");
    PATIENT_POSITION = (0x0018, 0x5100, "PatientPosition");
    STUDY = (0x0020, 0x000D, "StudyInstanceUID");
    SERIES = (0x0020, 0x000E, "SeriesInstanceUID");
    SERIES_NUMBER = (0x0020, 0x0011, "SeriesNumber");
    ACQUISITION_NUMBER = (0x0020, 0x0012, "AcquisitionNumber");
    PATIENT_ORIENTATION = (0x0020, 0x0020, "PatientOrientation");
    POSITION = (0x0020, 0x0032, "ImagePositionPatient");
    ORIENTATION = (0x0020, 0x0037, "ImageOrientationPatient");
    FRAME_OF_REFERENCE = (0x0020, 0x0052, "FrameOfReferenceUID");
    SLICE_LOCATION = (0x0020, 0x1041, "SliceLocation");
    CONCATENATION = (0x0020, 0x9161, "ConcatenationUID");
    IN_CONCATENATION = (0x0020, 0x9162, "InConcatenationNumber");
    IN_CONCATENATION_TOTAL = (0x0020, 0x9163, "InConcatenationTotalNumber");
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

// Sequences and tables, which are no values, and what stands in functional groups alone (PS3.3, C.7.6.16 and C.8.15).
elements! { NESTED:
    FRAME_TYPE = (0x0008, 0x9007, "FrameType");
    ACQUISITION_DETAILS = (0x0018, 0x9304, "CTAcquisitionDetailsSequence");
    CARDIAC = (0x0018, 0x9118, "CardiacSynchronizationSequence");
    RECONSTRUCTION = (0x0018, 0x9314, "CTReconstructionSequence");
    ALGORITHM = (0x0018, 0x9315, "ReconstructionAlgorithm");
    CT_FRAME_TYPE = (0x0018, 0x9329, "CTImageFrameTypeSequence");
    STACK = (0x0020, 0x9056, "StackID");
    IN_STACK = (0x0020, 0x9057, "InStackPositionNumber");
    FRAME_CONTENT = (0x0020, 0x9111, "FrameContentSequence");
    PLANE_POSITION = (0x0020, 0x9113, "PlanePositionSequence");
    PLANE_ORIENTATION = (0x0020, 0x9116, "PlaneOrientationSequence");
    TEMPORAL = (0x0020, 0x9128, "TemporalPositionIndex");
    FRAME_ACQUISITION = (0x0020, 0x9156, "FrameAcquisitionNumber");
    SHARED_UNASSIGNED = (0x0020, 0x9170, "UnassignedSharedConvertedAttributesSequence");
    FRAME_UNASSIGNED = (0x0020, 0x9171, "UnassignedPerFrameConvertedAttributesSequence");
    CARDIAC_DELAY = (0x0020, 0x9153, "NominalCardiacTriggerDelayTime");
    CARDIAC_PHASE = (0x0020, 0x9241, "NominalPercentageOfCardiacPhase");
    RESPIRATORY_PHASE = (0x0020, 0x9245, "NominalPercentageOfRespiratoryPhase");
    RESPIRATORY = (0x0020, 0x9253, "RespiratorySynchronizationSequence");
    MODALITY_LUT = (0x0028, 0x3000, "ModalityLUTSequence");
    PIXEL_MEASURES = (0x0028, 0x9110, "PixelMeasuresSequence");
    TRANSFORMATION = (0x0028, 0x9145, "PixelValueTransformationSequence");
    SHARED_GROUPS = (0x5200, 0x9229, "SharedFunctionalGroupsSequence");
    FRAME_GROUPS = (0x5200, 0x9230, "PerFrameFunctionalGroupsSequence");
    OFFSETS = (0x7FE0, 0x0001, "ExtendedOffsetTable");
    OFFSET_LENGTHS = (0x7FE0, 0x0002, "ExtendedOffsetTableLengths");
}

// Of segmentations (PS3.3, C.8.20).
elements! { SEGMENTED:
    SEGMENTATION_TYPE = (0x0062, 0x0001, "SegmentationType");
    SEGMENTS = (0x0062, 0x0002, "SegmentSequence");
    SEGMENT = (0x0062, 0x0004, "SegmentNumber");
    SEGMENT_LABEL = (0x0062, 0x0005, "SegmentLabel");
    SEGMENT_OF_FRAME = (0x0062, 0x000A, "SegmentIdentificationSequence");
    SEGMENT_REFERENCED = (0x0062, 0x000B, "ReferencedSegmentNumber");
    FRACTION_MOST = (0x0062, 0x000E, "MaximumFractionalValue");
}

// Of structure sets (PS3.3, C.8.8.5 and C.8.8.6), and of which series segmentations and they are made.
elements! { STRUCTURES:
    REFERENCED_SERIES = (0x0008, 0x1115, "ReferencedSeriesSequence");
    REFERENCED_FRAMES = (0x3006, 0x0010, "ReferencedFrameOfReferenceSequence");
    RT_STUDIES = (0x3006, 0x0012, "RTReferencedStudySequence");
    RT_SERIES = (0x3006, 0x0014, "RTReferencedSeriesSequence");
    ROIS = (0x3006, 0x0020, "StructureSetROISequence");
    ROI_NUMBER = (0x3006, 0x0022, "ROINumber");
    ROI_FRAME = (0x3006, 0x0024, "ReferencedFrameOfReferenceUID");
    ROI_NAME = (0x3006, 0x0026, "ROIName");
    ROI_CONTOURS = (0x3006, 0x0039, "ROIContourSequence");
    CONTOURS = (0x3006, 0x0040, "ContourSequence");
    CONTOUR_KIND = (0x3006, 0x0042, "ContourGeometricType");
    CONTOUR_OFFSET = (0x3006, 0x0045, "ContourOffsetVector");
    CONTOUR_POINTS = (0x3006, 0x0046, "NumberOfContourPoints");
    CONTOUR_DATA = (0x3006, 0x0050, "ContourData");
    ROI_REFERENCED = (0x3006, 0x0084, "ReferencedROINumber");
    APPROVAL = (0x300E, 0x0002, "ApprovalStatus");
}

/// The elements that are read in functional groups.
pub(crate) const GROUPED: [Tag; 21] = [
    FRAME_TYPE,
    VOLUMETRIC,
    TECHNIQUE,
    SLICE_THICKNESS,
    SPACING_BETWEEN_SLICES,
    GANTRY_TILT,
    KERNEL,
    ALGORITHM,
    POSITION,
    ORIENTATION,
    STACK,
    IN_STACK,
    TEMPORAL,
    FRAME_ACQUISITION,
    CARDIAC_DELAY,
    CARDIAC_PHASE,
    RESPIRATORY_PHASE,
    PIXEL_SPACING,
    INTERCEPT,
    SLOPE,
    RESCALE_TYPE,
];

pub(crate) const CHARACTER_SET: Tag = tag(0x0008, 0x0005);
pub(crate) const STUDY_DESCRIPTION: Tag = tag(0x0008, 0x1030);

/// What a series says of one person and of how she lies, besides PatientID.
pub(crate) const PERSON: [Tag; 5] = [PATIENT_NAME, ID_ISSUER, BIRTH_DATE, SEX, PATIENT_POSITION];

/// What a slice says of the scan it is from, beside [`Header`](super::header::Header)'s own: told where slices of one series differ.
pub(crate) const SCAN: [Tag; 14] = [
    ACQUISITION_NUMBER,
    ACQUISITION_UID,
    STUDY_DATE,
    SERIES_DATE,
    ACQUISITION_DATE,
    CONTENT_DATE,
    ACCESSION,
    SERIES_DESCRIPTION,
    SCANNER_MODEL,
    SCANNER_SERIAL,
    CONTRAST_AGENT,
    KVP,
    IMAGE_TYPE,
    SERIES_NUMBER,
];

/// Whether an element is only told of a series, or compared where it is said: one that is longer than any is passed over, and refuses no slice.
pub(crate) fn is_only_told(tag: Tag) -> bool {
    let more = [ACQUISITION_DATETIME, ACQUISITION_TIME, SLICE_LOCATION];
    PERSON.contains(&tag) || more.contains(&tag) || SCAN.contains(&tag) && tag != IMAGE_TYPE
}

/// Elements that name a patient, a visit or a place: held only where a person asks for them, and for the bus.
pub(crate) const IDENTITY: [(Tag, &str); 12] = [
    // In which the others are written.
    (CHARACTER_SET, "SpecificCharacterSet"),
    (PATIENT_NAME, "PatientName"),
    (PATIENT_ID, "PatientID"),
    (BIRTH_DATE, "PatientBirthDate"),
    (SEX, "PatientSex"),
    (STUDY_DATE, "StudyDate"),
    (ACCESSION, "AccessionNumber"),
    (tag(0x0008, 0x0080), "InstitutionName"),
    (STUDY_DESCRIPTION, "StudyDescription"),
    (SERIES_DESCRIPTION, "SeriesDescription"),
    (STUDY, "StudyInstanceUID"),
    (SERIES, "SeriesInstanceUID"),
];

/// Whether the value of an element of the data set itself is read.
pub(crate) fn is_read(tag: Tag) -> bool {
    NAMES.iter().any(|row| row.0 == tag)
}

/// The name of an element that is looked at.
fn name(tag: Tag) -> Option<&'static str> {
    NAMES
        .iter()
        .chain(NESTED)
        .chain(SEGMENTED)
        .chain(STRUCTURES)
        .find(|row| row.0 == tag)
        .map(|row| row.1)
}
