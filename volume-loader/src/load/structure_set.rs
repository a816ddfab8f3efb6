//! The points of an RT structure set: regions of interest that are one point each, such as planning systems mark them (DICOM PS3.3, A.19,
//! C.8.8.5 and C.8.8.6). Places are LPS, mm. Contours are no points and are counted.

mod error;

#[cfg(test)]
mod tests;

use std::collections::BTreeMap;
use std::io::{BufRead, Seek};
use std::path::Path;

use guidance::plan::MAX_MM;
use scene::VolumeSpec;

pub use error::StructureSetError;

use super::origin::{Origin, reference_of};
use crate::dicom::element::Elements;
use crate::dicom::element::tree::{Asked, Tree};
use crate::dicom::error::FileError;
use crate::dicom::header::walk;
use crate::dicom::tag::{self as el, Tag};
use crate::dicom::text::charset::Charset;
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
        el::PATIENT_NAME,
        el::ID_ISSUER,
        el::BIRTH_DATE,
        el::SEX,
        el::STUDY,
        el::SERIES,
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
    sequences: &[
        el::REFERENCED_FRAMES,
        el::RT_STUDIES,
        el::RT_SERIES,
        el::ROIS,
        el::ROI_CONTOURS,
        el::CONTOURS,
    ],
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
    /// What is doubtful about whose it is and whether anybody approved of it, a sentence each.
    pub warnings: Vec<String>,
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
    origin: Origin,
}

/// Reads the points of the structure set at `path`; `None` where it is none. A set that was rejected is refused, and where `examination` is
/// DICOM too, so is one of which both say another patient and a point of another frame of reference.
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
    let reference = reference_of(Some(examination))?;
    let refused = |source| StructureSetError::Origin {
        path: path.to_owned(),
        source,
    };
    let mut frames = reference.frames.clone();
    let mut set = StructureSet {
        is_in_its_frame: !frames.is_empty(),
        warnings: parsed.origin.check(&reference).map_err(refused)?,
        ..StructureSet::default()
    };
    for (number, region) in parsed.regions {
        let name = region.name.clone();
        match region.points[..] {
            [] => set.others.push(name),
            [ct_mm] if !region.has_other_contours => {
                // Of an examination that says none, all points must at least be in one.
                if frames.is_empty() {
                    frames.insert(region.frame.clone());
                }
                if !frames.contains(&region.frame) {
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
    let (mut described, mut contours, mut series) = (Vec::new(), Regions::new(), Vec::new());
    let elements = Tree::read(walker, &ASKED, |tag, item| match tag {
        el::REFERENCED_FRAMES => {
            series.extend(series_of(&item));
            Ok(())
        }
        // Within the frames alone: elsewhere they say nothing.
        el::RT_STUDIES | el::RT_SERIES | el::CONTOURS => Ok(()),
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
            origin: Origin::of(&elements, series),
        })),
    }
}

/// The series that a frame of reference of the set names.
fn series_of(frame: &Tree) -> Vec<String> {
    let studies = frame.items(el::RT_STUDIES).iter();
    let series = studies.flat_map(|study| study.items(el::RT_SERIES));
    series.filter_map(|series| series.values.text(el::SERIES)).collect()
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
