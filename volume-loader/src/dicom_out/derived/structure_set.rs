//! Points as an RT Structure Set (DICOM PS3.3, A.19, C.8.8.5 and C.8.8.6): a region of interest for each, of one POINT. Places are LPS, mm, as
//! they are in DICOM, to 5.1e-11 mm (see `dicom_out::ds`).

use dicom_core::VR;
use dicom_dictionary_std::{tags, uids};
use scene::VolumeSpec;

use super::context::Context;
use super::error::DerivedError;
use super::items::{self, Object, encoded, item, now, put, put_items};
use crate::dicom_out::ds::{decimal_string, decimal_strings};
use crate::dicom_out::uid::of_hash;
use crate::load::structure_set::NamedPoint;

/// Largest rounding of a place, mm.
const MAX_ERROR_MM: f64 = 1e-6;
/// Points of one set: planning systems hold some hundreds.
const MOST_POINTS: usize = 10_000;

/// These points as a structure set of the examination, a whole file.
///
/// # Errors
/// [`DerivedError`].
pub fn structure_set_bytes(examination: &VolumeSpec, points: &[NamedPoint]) -> Result<Vec<u8>, DerivedError> {
    check(points)?;
    let context = Context::of(examination)?;
    let [day, time] = now();
    let uid = |which: &str| {
        let mut hasher = blake3::Hasher::new_derive_key("trocar dicom structure set 1");
        for part in [which, &day, &time, &context.series] {
            hasher.update(part.as_bytes()).update(&[0]);
        }
        for point in points {
            hasher.update(point.name.as_bytes()).update(&[0]);
            point.ct_mm.iter().for_each(|mm| {
                hasher.update(&mm.to_le_bytes());
            });
        }
        of_hash(&hasher)
    };
    let mut object = Object::new_empty();
    context.put(&mut object);
    put(&mut object, tags::SOP_CLASS_UID, VR::UI, uids::RT_STRUCTURE_SET_STORAGE);
    put(&mut object, tags::SOP_INSTANCE_UID, VR::UI, &uid("instance"));
    put(&mut object, tags::MODALITY, VR::CS, "RTSTRUCT");
    put(&mut object, tags::SERIES_INSTANCE_UID, VR::UI, &uid("series"));
    put(&mut object, tags::SERIES_NUMBER, VR::IS, "1");
    put(&mut object, tags::OPERATORS_NAME, VR::PN, "");
    put(&mut object, tags::MANUFACTURER, VR::LO, "Trocar");
    put(&mut object, tags::SOFTWARE_VERSIONS, VR::LO, env!("CARGO_PKG_VERSION"));
    put(&mut object, tags::INSTANCE_NUMBER, VR::IS, "1");
    put(&mut object, tags::STRUCTURE_SET_LABEL, VR::SH, "Targets");
    put(&mut object, tags::STRUCTURE_SET_DATE, VR::DA, &day);
    put(&mut object, tags::STRUCTURE_SET_TIME, VR::TM, &time);
    // Nobody looked at it with the eyes of a planning system.
    put(&mut object, tags::APPROVAL_STATUS, VR::CS, "UNAPPROVED");
    regions(&mut object, &context, points);
    encoded(object)
}

fn check(points: &[NamedPoint]) -> Result<(), DerivedError> {
    match points.len() {
        0 => return Err(DerivedError::Nothing { what: "point" }),
        found if found > MOST_POINTS => {
            return Err(DerivedError::TooMany {
                found: found as u64,
                what: "points",
                most: MOST_POINTS as u64,
            });
        }
        _ => {}
    }
    for point in points {
        items::name(&point.name)?;
        let is_held = |mm: &f64| {
            let written = decimal_string(*mm).parse::<f64>();
            // Not a number is refused too.
            written.is_ok_and(|written| (written - mm).abs() <= MAX_ERROR_MM)
        };
        if !point.ct_mm.iter().all(is_held) {
            return Err(DerivedError::Place {
                name: point.name.clone(),
                found_mm: point.ct_mm,
            });
        }
    }
    Ok(())
}

/// The regions with their frame of reference, their points, and what they are.
fn regions(object: &mut Object, context: &Context, points: &[NamedPoint]) {
    let frame = item(|object| {
        put(
            object,
            tags::FRAME_OF_REFERENCE_UID,
            VR::UI,
            &context.frame_of_reference,
        );
        let study = context.referenced_study();
        put_items(object, tags::RT_REFERENCED_STUDY_SEQUENCE, vec![study]);
    });
    put_items(object, tags::REFERENCED_FRAME_OF_REFERENCE_SEQUENCE, vec![frame]);
    let numbered = || (1_u32..).map(|number| number.to_string()).zip(points);
    let rois = numbered().map(|(number, point)| {
        item(|object| {
            put(object, tags::ROI_NUMBER, VR::IS, &number);
            let frame = &context.frame_of_reference;
            put(object, tags::REFERENCED_FRAME_OF_REFERENCE_UID, VR::UI, frame);
            put(object, tags::ROI_NAME, VR::LO, &point.name);
            put(object, tags::ROI_GENERATION_ALGORITHM, VR::CS, "");
        })
    });
    put_items(object, tags::STRUCTURE_SET_ROI_SEQUENCE, rois.collect());
    let contours = numbered().map(|(number, point)| {
        item(|object| {
            put(object, tags::REFERENCED_ROI_NUMBER, VR::IS, &number);
            let contour = item(|object| {
                put(object, tags::CONTOUR_GEOMETRIC_TYPE, VR::CS, "POINT");
                put(object, tags::NUMBER_OF_CONTOUR_POINTS, VR::IS, "1");
                put(object, tags::CONTOUR_DATA, VR::DS, &decimal_strings(point.ct_mm));
            });
            put_items(object, tags::CONTOUR_SEQUENCE, vec![contour]);
        })
    });
    put_items(object, tags::ROI_CONTOUR_SEQUENCE, contours.collect());
    let observations = numbered().map(|(number, _)| {
        item(|object| {
            put(object, tags::OBSERVATION_NUMBER, VR::IS, &number);
            put(object, tags::REFERENCED_ROI_NUMBER, VR::IS, &number);
            put(object, tags::RTROI_INTERPRETED_TYPE, VR::CS, "");
            put(object, tags::ROI_INTERPRETER, VR::PN, "");
        })
    });
    put_items(object, tags::RTROI_OBSERVATIONS_SEQUENCE, observations.collect());
}
