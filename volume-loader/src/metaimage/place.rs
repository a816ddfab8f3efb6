//! From MetaImage's matrix, offset and spacing to `ct_from_voxel`: both LPS, and mm here.

use geometry::{Affine, Ct, Point, Vector, Voxel};

use super::error::MetaImageError;
use super::fields::{Field, Fields};
use crate::raster::{OpenOptions, Remarks, numbers};

/// How far a direction's length may be from 1: some programs write six digits.
const LENGTH: f64 = 1e-4;
/// How far from a right angle (cosine) axes may be before a person is told.
const SKEW: f64 = 1e-5;
const IDENTITY: [f64; 9] = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];

/// The map to the patient, and what is told a person.
///
/// # Errors
/// [`MetaImageError`].
pub(crate) fn ct_from_voxel(
    fields: &Fields,
    options: OpenOptions,
) -> Result<(Affine<Ct, Voxel>, Remarks), MetaImageError> {
    let mut remarks = Remarks::default();
    let mm = mm_per_unit(fields, &mut remarks)?;
    let spacing = spacing(fields, &mut remarks)?;
    check_centre(fields)?;
    let directions = directions(fields, options, &mut remarks)?;
    let origin = origin(fields, options, &mut remarks)?;
    let step = |axis: usize| {
        // Adding zero makes -0 a plain 0.
        let [x, y, z] = directions[axis].map(|component| 0.0 + component * spacing[axis] * mm);
        Vector::<Ct>::new(x, y, z)
    };
    let [x, y, z] = origin.map(|v| v * mm);
    let map = Affine::from_steps(Point::new(x, y, z), [0, 1, 2].map(step));
    Ok((map, remarks))
}

fn mm_per_unit(fields: &Fields, remarks: &mut Remarks) -> Result<f64, MetaImageError> {
    let Some(field) = fields.get("DistanceUnits") else {
        return Ok(1.0);
    };
    let mm = match field.text.as_str() {
        "mm" => return Ok(1.0),
        "um" => 1e-3,
        "cm" => 10.0,
        "m" => 1e3,
        "?" | "" => {
            remarks.doubt("unit of length unknown, taken as mm");
            return Ok(1.0);
        }
        _ => return Err(field.refuse("um, mm or cm")),
    };
    remarks.doubt(format!("lengths converted from {}", field.text));
    Ok(mm)
}

/// Distances of voxels; their sizes are the same where only these are told.
fn spacing(fields: &Fields, remarks: &mut Remarks) -> Result<[f64; 3], MetaImageError> {
    let field = match fields.get("ElementSpacing") {
        Some(field) => {
            let size = fields.get("ElementSize").map(|size| numbers::<f64, 3>(&size.text));
            if size.is_some_and(|size| size != numbers(&field.text)) {
                remarks.doubt("ElementSize is not ElementSpacing, which is taken");
            }
            field
        }
        None => fields.need("ElementSize", "ElementSpacing: the distances of voxels")?,
    };
    let positive = |steps: &[f64; 3]| steps.iter().all(|&step| step > 0.0);
    // A negative one would mirror the patient.
    numbers(&field.text)
        .filter(positive)
        .ok_or_else(|| field.refuse("three positive numbers"))
}

/// Programs disagree on what a centre elsewhere means for an image.
fn check_centre(fields: &Fields) -> Result<(), MetaImageError> {
    match fields.get("CenterOfRotation") {
        Some(field) if numbers(&field.text) != Some([0.0; 3]) => Err(field.refuse("0 0 0")),
        _ => Ok(()),
    }
}

/// The direction of each axis of the voxels.
fn directions(fields: &Fields, options: OpenOptions, remarks: &mut Remarks) -> Result<[[f64; 3]; 3], MetaImageError> {
    let Some(field) = fields.get("TransformMatrix") else {
        if !options.assume_lps {
            let field = "TransformMatrix";
            return Err(MetaImageError::NoOrientation { field });
        }
        if let Some(told) = fields.get("AnatomicalOrientation") {
            remarks.doubts.extend(told_otherwise(told, &rows(IDENTITY))?);
        }
        remarks.doubt("NO ORIENTATION IN THE FILE: its axes are taken as LPS, the format's default");
        return Ok(rows(IDENTITY));
    };
    let matrix = numbers(&field.text).ok_or_else(|| field.refuse("nine numbers"))?;
    let directions = rows(matrix);
    check_directions(field, &directions, remarks)?;
    if let Some(told) = fields.get("AnatomicalOrientation") {
        remarks.doubts.extend(told_otherwise(told, &directions)?);
    }
    Ok(directions)
}

fn rows(m: [f64; 9]) -> [[f64; 3]; 3] {
    std::array::from_fn(|r| std::array::from_fn(|c| m[3 * r + c]))
}

fn check_directions(field: &Field, directions: &[[f64; 3]; 3], remarks: &mut Remarks) -> Result<(), MetaImageError> {
    let dot = |a: usize, b: usize| -> f64 { directions[a].iter().zip(directions[b]).map(|(x, y)| x * y).sum() };
    for axis in 0..3 {
        let length = dot(axis, axis).sqrt();
        // A NaN is refused here too.
        if length.is_nan() || (length - 1.0).abs() > LENGTH {
            let line = field.line;
            return Err(MetaImageError::Length { line, axis, length });
        }
    }
    remarks.notes.push("oriented by its matrix".to_owned());
    if [dot(0, 1), dot(0, 2), dot(1, 2)]
        .iter()
        .any(|cosine| cosine.abs() > SKEW)
    {
        remarks.notes.push("its axes are not at right angles".to_owned());
    }
    Ok(())
}

fn origin(fields: &Fields, options: OpenOptions, remarks: &mut Remarks) -> Result<[f64; 3], MetaImageError> {
    match fields.get("Offset") {
        Some(field) => {
            let finite = |origin: &[f64; 3]| origin.iter().all(|v| v.is_finite());
            let origin = numbers(&field.text).filter(finite);
            origin.ok_or_else(|| field.refuse("three finite numbers"))
        }
        None if options.assume_lps => {
            remarks.doubt("no origin in the file, taken as 0");
            Ok([0.0; 3])
        }
        None => Err(MetaImageError::NoOrientation { field: "Offset" }),
    }
}

/// Refuses an `AnatomicalOrientation` that is not that of the directions. It names where each axis comes from, so that RAI is from right to
/// left, front to back, feet to head; some name where each goes to, which is told.
fn told_otherwise(field: &Field, directions: &[[f64; 3]; 3]) -> Result<Option<String>, MetaImageError> {
    let told = field.text.to_ascii_uppercase();
    let ours: String = directions.iter().map(letter).collect();
    let is_told = told.len() == 3 && told.chars().all(|c| "RLAPIS".contains(c));
    let to: String = ours.chars().map(across).collect();
    match told {
        told if !is_told || told == ours => Ok(None),
        told if told == to => Ok(Some(format!(
            "AnatomicalOrientation says {told}, where axes go to; where they come from is {ours}"
        ))),
        _ => Err(field.refuse("the letters of its axes' directions, RAI for those of LPS: by one of both the patient is turned or mirrored")),
    }
}

/// The other side.
fn across(side: char) -> char {
    let pairs = ["RL", "AP", "IS"];
    let pair = pairs.iter().find(|pair| pair.contains(side));
    pair.and_then(|pair| pair.chars().find(|other| *other != side))
        .unwrap_or(side)
}

fn letter(direction: &[f64; 3]) -> char {
    let size = direction.map(f64::abs);
    let largest = (0..3).fold(0, |best, i| if size[i] > size[best] { i } else { best });
    let [forth, back] = [['R', 'L'], ['A', 'P'], ['I', 'S']][largest];
    if direction[largest] < 0.0 { back } else { forth }
}
