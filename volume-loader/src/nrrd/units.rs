//! NRRD's units of length, as mm.

use super::error::NrrdError;
use super::fields::{Field, Fields};
use crate::raster::{Remarks, quote};

const UNITS: &str = "a quoted unit for each axis of space: \"mm\", \"cm\", \"m\", \"um\" or \"nm\"";

/// Units of the array's axes are those of spacings, which are not what is read where there are directions; what they say must be what
/// the directions are taken in.
pub(crate) fn agree(fields: &Fields) -> Result<(), NrrdError> {
    let Some(field) = fields.get("units") else {
        return Ok(());
    };
    let taken = mm_per_unit(fields.get("space units"), &mut Remarks::default())?;
    let quoted: Vec<&str> = field.text.split('"').skip(1).step_by(2).map(str::trim).collect();
    let is_known = |unit: &&str| !["", "???", "none"].contains(unit);
    let is_taken = |unit: &str| mm_in(unit).is_some_and(|mm| taken == [mm; 3]);
    match quoted.iter().copied().filter(is_known).all(is_taken) && (!quoted.is_empty() || field.text.is_empty()) {
        true => Ok(()),
        false => {
            Err(field
                .refuse("mm, as the space directions are taken, or the unit that `space units` says for all of them"))
        }
    }
}

/// How many mm a unit has, where it is one that is read.
fn mm_in(unit: &str) -> Option<f64> {
    Some(match unit {
        "mm" | "millimeter" | "millimeters" | "millimetre" | "millimetres" => 1.0,
        "cm" => 10.0,
        "m" => 1e3,
        "um" | "µm" | "μm" | "micron" | "microns" => 1e-3,
        "nm" => 1e-6,
        _ => return None,
    })
}

/// A unit for each coordinate of space, as mm.
pub(crate) fn mm_per_unit(units: Option<&Field>, remarks: &mut Remarks) -> Result<[f64; 3], NrrdError> {
    let unknown = "unit of length unknown, taken as mm";
    let Some(field) = units else {
        remarks.doubt(unknown);
        return Ok([1.0; 3]);
    };
    let mut parts = field.text.split('"');
    let mut scale = [1.0; 3];
    for place in &mut scale {
        let between = parts.next().map(str::trim);
        let unit = parts.next().map(str::trim);
        let (Some(""), Some(unit)) = (between, unit) else {
            return Err(field.refuse(UNITS));
        };
        *place = match (unit, mm_in(unit)) {
            (_, Some(mm)) => mm,
            ("" | "???", None) => {
                remarks.doubt(unknown);
                1.0
            }
            _ => return Err(field.refuse(UNITS)),
        };
    }
    match (parts.next().map(str::trim), parts.next()) {
        (Some("") | None, None) => {}
        _ => return Err(field.refuse(UNITS)),
    }
    if scale != [1.0; 3] {
        remarks.doubt(format!("lengths converted from {}", quote(&field.text)));
    }
    Ok(scale)
}
