//! The points of an RT structure set: regions of interest that are one point each, such as planning systems mark them (DICOM PS3.3, A.19,
//! C.8.8.5 and C.8.8.6). Places are LPS, mm. Contours are no points and are counted.

#[cfg(test)]
mod tests;

use std::collections::BTreeMap;
use std::io::{BufRead, Seek};
use std::path::{Path, PathBuf};

use guidance::plan::MAX_MM;
use scene::VolumeSpec;

use super::frame::reference_of;
use crate::dicom::element::Elements;
use crate::dicom::element::tree::{Asked, Tree};
use crate::dicom::error::{DicomError, FileError};
use crate::dicom::header::walk;
use crate::dicom::tag::{self as el, Tag};
use crate::dicom::text::charset::Charset;
use crate::dicom::text::digest;
use crate::dicom::walk::{WalkError, Walker};
use crate::source::ReadError;

/// RT Structure Set Storage (PS3.4 table B.5-1).
const CLASS: &str = "1.2.840.10008.5.1.4.1.1.481.3";

const ASKED: Asked = Asked {
    values: &[
        el::CHARACTER_SET,
        el::SOP_CLASS,
        el::MEDIA_SOP_CLASS,
        el::TRANSFER_SYNTAX,
        el::PATIENT_ID,
        el::APPROVAL,
        el::ROI_NUMBER,
        el::ROI_FRAME,
        el::ROI_NAME,
        el::ROI_REFERENCED,
        el::CONTOUR_KIND,
        el::CONTOUR_DATA,
        el::CONTOUR_OFFSET,
        el::CONTOUR_POINTS,
    ],
    // Of contours that are no points.
    long: &[el::CONTOUR_DATA],
    sequences: &[el::ROIS, el::ROI_CONTOURS, el::CONTOURS],
};

/// A point.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedPoint {
    /// ROIName.
    pub name: String,
    /// LPS, mm.
    pub ct_mm: [f64; 3],
}

/// The points of a file.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct StructureSet {
    /// In the order of their numbers.
    pub points: Vec<NamedPoint>,
    /// The names of regions of interest that are contours or have none.
    pub others: Vec<String>,
    /// Whether the file says to be in the frame of reference of the examination, which is DICOM then.
    pub is_in_its_frame: bool,
}

/// Why a structure set gives no points.
#[derive(Debug, thiserror::Error)]
pub enum StructureSetError {
    /// It cannot be read, or an element is not what it must be.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// A region of interest of several points.
    #[error("{}: region of interest {number} ({name:?}) is {found} points: which of them is meant, is not known", path.display())]
    Several {
        /// The file.
        path: PathBuf,
        /// ROINumber.
        number: u64,
        /// ROIName.
        name: String,
        /// How many.
        found: usize,
    },
    /// It is of another patient.
    #[error(
        "{}: (0010,0020) PatientID: found another than the examination's: one of them is of another patient (values are not shown, as they name a patient)", path.display()
    )]
    OtherPatient {
        /// The file.
        path: PathBuf,
    },
    /// Somebody looked at it and did not approve of it.
    #[error("{}: (300E,0002) ApprovalStatus: found REJECTED, expected APPROVED or UNAPPROVED: it was looked at and is not to be used", path.display())]
    Rejected {
        /// The file.
        path: PathBuf,
    },
    /// It belongs to another examination.
    #[error(
        "{}: region of interest {number} ({name:?}) is in another frame of reference than the examination or the points before it \
         (ReferencedFrameOfReferenceUID): it is a place in another scan, or of another patient", path.display()
    )]
    OtherFrame {
        /// The file.
        path: PathBuf,
        /// ROINumber.
        number: u64,
        /// ROIName.
        name: String,
    },
}

/// A region of interest.
#[derive(Debug, Default)]
struct Region {
    name: String,
    frame: String,
    points: Vec<[f64; 3]>,
    is_described: bool,
    has_other_contours: bool,
}

type Regions = BTreeMap<u64, Region>;

/// What a file says.
struct Parsed {
    regions: Regions,
    /// A digest of PatientID.
    patient: Option<u64>,
    is_rejected: bool,
}

/// Reads the points of the structure set at `path`; `None` where it is none. A set that was rejected is refused, and where `examination` is
/// DICOM too, so is one of another PatientID and a point of another frame of reference.
///
/// # Errors
/// [`StructureSetError`].
pub fn structure_set(path: &Path, examination: &VolumeSpec) -> Result<Option<StructureSet>, StructureSetError> {
    if !crate::dicom::has_preamble(path) {
        return Ok(None);
    }
    let found = walk(path, parse).map_err(ReadError::from)?;
    let Some(parsed) = found else {
        return Ok(None);
    };
    if parsed.is_rejected {
        return Err(StructureSetError::Rejected { path: path.to_owned() });
    }
    let reference = reference_of(Some(examination))?;
    if parsed.patient.zip(reference.patient).is_some_and(|(set, of)| set != of) {
        return Err(StructureSetError::OtherPatient { path: path.to_owned() });
    }
    let mut frame = reference.frame;
    let mut set = StructureSet {
        is_in_its_frame: frame.is_some(),
        ..StructureSet::default()
    };
    for (number, region) in parsed.regions {
        let name = region.name.clone();
        match region.points[..] {
            [] => set.others.push(name),
            [ct_mm] if !region.has_other_contours => {
                // Of an examination that says none, all points must at least be in one.
                if *frame.get_or_insert_with(|| region.frame.clone()) != region.frame {
                    let path = path.to_owned();
                    return Err(StructureSetError::OtherFrame { path, number, name });
                }
                set.points.push(NamedPoint { name, ct_mm });
            }
            _ => {
                let (path, found) = (path.to_owned(), region.points.len());
                return Err(StructureSetError::Several {
                    path,
                    number,
                    name,
                    found,
                });
            }
        }
    }
    Ok(Some(set))
}

fn parse<R: BufRead + Seek>(walker: &mut Walker<R>) -> Result<Option<Parsed>, WalkError> {
    let (mut described, mut contours) = (Vec::new(), Regions::new());
    let elements = Tree::read(walker, &ASKED, |tag, item| match tag {
        el::ROIS => {
            described.push(item);
            Ok(())
        }
        _ => take_contours(&mut contours, &item),
    })?;
    let is_one = |elements: &Elements| elements.class().is_some_and(|class| class == CLASS);
    let Some(elements) = elements.filter(is_one) else {
        return Ok(None);
    };
    for item in &described {
        let number = whole(&item.values, el::ROI_NUMBER)?;
        let region = contours.entry(number).or_default();
        if std::mem::replace(&mut region.is_described, true) {
            return Err(refused(el::ROI_NUMBER, format!("{number} twice"), "each number once").into());
        }
        // An item may name sets of its own.
        let own = item.values.get(el::CHARACTER_SET);
        let charset = Charset::of(own.or(elements.get(el::CHARACTER_SET)));
        region.name = item
            .values
            .get(el::ROI_NAME)
            .map(|bytes| charset.text(bytes))
            .unwrap_or_default();
        region.frame = item
            .values
            .text(el::ROI_FRAME)
            .ok_or(FileError::Missing { tag: el::ROI_FRAME })?;
    }
    match contours.iter().find(|(_, region)| !region.is_described) {
        Some((number, _)) => Err(refused(
            el::ROI_REFERENCED,
            number.to_string(),
            "a number that StructureSetROISequence describes",
        )
        .into()),
        None => Ok(Some(Parsed {
            regions: contours,
            patient: elements.get(el::PATIENT_ID).and_then(digest),
            is_rejected: elements.code(el::APPROVAL).is_some_and(|status| status == "REJECTED"),
        })),
    }
}

/// Takes the contours of one region.
fn take_contours(regions: &mut Regions, item: &Tree) -> Result<(), FileError> {
    // A region without contours is in the sequence or is not, as the writer likes.
    let region = regions.entry(whole(&item.values, el::ROI_REFERENCED)?).or_default();
    for contour in item.items(el::CONTOURS) {
        if contour.values.text(el::CONTOUR_KIND).as_deref() != Some("POINT") {
            region.has_other_contours = true;
            continue;
        }
        let offset = contour.values.numbers::<3>(el::CONTOUR_OFFSET)?;
        if let Some(offset) = offset.filter(|offset| *offset != [0.0; 3]) {
            return Err(refused(el::CONTOUR_OFFSET, format!("{offset:?}"), "none, or zeros"));
        }
        let points = contour.values.numbers::<1>(el::CONTOUR_POINTS)?;
        if let Some([points]) = points.filter(|points| *points != [1.0]) {
            return Err(refused(el::CONTOUR_POINTS, points.to_string(), "1 for a POINT"));
        }
        let tag = el::CONTOUR_DATA;
        let place = contour.values.numbers::<3>(tag)?.ok_or(FileError::Missing { tag })?;
        if place.iter().any(|mm| mm.abs() > MAX_MM) {
            return Err(refused(
                tag,
                format!("{place:?}"),
                "three coordinates of no more than 10000 mm",
            ));
        }
        region.points.push(place);
    }
    Ok(())
}

fn whole(values: &Elements, tag: Tag) -> Result<u64, FileError> {
    let [number] = values.numbers::<1>(tag)?.ok_or(FileError::Missing { tag })?;
    match number.fract() == 0.0 && (0.0..=f64::from(i32::MAX)).contains(&number) {
        true => Ok(number as u64),
        false => Err(refused(tag, number.to_string(), "a whole number from 0 on")),
    }
}

fn refused(tag: Tag, found: String, expected: &'static str) -> FileError {
    FileError::Value { tag, found, expected }
}

impl From<DicomError> for StructureSetError {
    fn from(error: DicomError) -> Self {
        Self::Read(error.into())
    }
}
