//! From NRRD's space, in some unit, to `ct_from_voxel`, in LPS and mm.

use geometry::{Affine, Ct, Point, Vector, Voxel};

use super::error::NrrdError;
use super::fields::{Field, Fields};
use super::units::{agree, mm_per_unit};
use crate::raster::{OpenOptions, Remarks, numbers};

/// How far (relative) a spacing may be from its direction's length: both are written with a few digits.
const SPACING_DIFFERENCE: f64 = 1e-4;
const ORIENTED: &str = "left-posterior-superior (LPS), right-anterior-superior (RAS) or left-anterior-superior (LAS)";

/// Where the voxels lie, and which of the array's axes counts nothing.
pub(crate) struct Placed {
    pub ct_from_voxel: Affine<Ct, Voxel>,
    /// The array's axes that are x, y and z of a voxel's index.
    pub axes: [usize; 3],
    /// What is told a person.
    pub remarks: Remarks,
}

/// The map to the patient of an array of `dimension` axes, 3 or 4.
///
/// # Errors
/// [`NrrdError`].
pub(crate) fn place(fields: &Fields, dimension: usize, options: OpenOptions) -> Result<Placed, NrrdError> {
    let mut remarks = Remarks::default();
    let Some(directions) = fields.get("space directions") else {
        return by_spacings(fields, dimension, options);
    };
    agree(fields)?;
    let signs = signs(fields, options, &mut remarks)?;
    let scale = mm_per_unit(fields.get("space units"), &mut remarks)?;
    let vectors = vectors(directions, dimension)?;
    no_ends(fields, &vectors)?;
    let axes = three_axes(directions, &vectors)?;
    check_spacings(fields, &vectors)?;
    let lps_mm = |v: [f64; 3]| {
        // Adding zero makes -0 a plain 0.
        let [x, y, z] = std::array::from_fn(|i| 0.0 + signs[i] * scale[i] * v[i]);
        Vector::<Ct>::new(x, y, z)
    };
    let step = |axis: usize| lps_mm(vectors.get(axis).copied().flatten().unwrap_or_default());
    let origin = match fields.get("space origin") {
        Some(field) => lps_mm(vector(&field.text).ok_or_else(|| field.refuse("three numbers like (1,2,3)"))?),
        None if options.assume_lps => {
            remarks.doubt("no origin in the file, taken as 0");
            Vector::new(0.0, 0.0, 0.0)
        }
        None => return Err(NrrdError::NoOrigin),
    };
    Ok(Placed {
        ct_from_voxel: Affine::from_steps(Point::new(0.0, 0.0, 0.0) + origin, axes.map(step)),
        axes,
        remarks,
    })
}

/// Along the file's own axes, taken as LPS, where the caller vouches for them.
fn by_spacings(fields: &Fields, dimension: usize, options: OpenOptions) -> Result<Placed, NrrdError> {
    let found = match (fields.get("spacings"), fields.get("space")) {
        (None, _) => "neither space directions nor spacings",
        (Some(_), None) => "spacings only, no space and no space directions",
        (Some(_), Some(_)) => "a space and spacings, but no space directions",
    };
    let spacings = fields.get("spacings").filter(|_| options.assume_lps);
    let Some(spacings) = spacings else {
        let found = found.to_owned();
        return Err(NrrdError::NoOrientation { found });
    };
    // What the file does say is not overruled.
    if let Some(space) = fields.get("space")
        && signs(fields, options, &mut Remarks::default())? != [1.0; 3]
    {
        return Err(space.refuse("left-posterior-superior, as its axes are to be taken as LPS"));
    }
    if let Some(origin) = fields.get("space origin") {
        return Err(origin.refuse("space directions beside it, or neither of them: the origin would be taken as 0"));
    }
    // NaN is how the format's library writes that it does not know.
    let is_none =
        |field: &Field| numbers::<f64, 3>(&field.text).is_some_and(|mins| mins.iter().all(|x| *x == 0.0 || x.is_nan()));
    if let Some(least) = fields.get("axis mins").filter(|field| !is_none(field)) {
        return Err(least.refuse("0 0 0, or none: the origin would be taken as 0"));
    }
    let expected = "three positive numbers";
    let [x, y, z] = numbers::<f64, 3>(&spacings.text)
        .filter(|steps| dimension == 3 && steps.iter().all(|&step| step > 0.0))
        .ok_or_else(|| spacings.refuse(expected))?;
    let mut remarks = Remarks::default();
    remarks.doubt("NO ORIENTATION IN THE FILE: its axes are taken as LPS, its origin as 0");
    let [sx, sy, sz] = mm_per_unit(fields.get("units"), &mut remarks)?;
    let steps = [
        Vector::new(sx * x, 0.0, 0.0),
        Vector::new(0.0, sy * y, 0.0),
        Vector::new(0.0, 0.0, sz * z),
    ];
    Ok(Placed {
        ct_from_voxel: Affine::from_steps(Point::new(0.0, 0.0, 0.0), steps),
        axes: [0, 1, 2],
        remarks,
    })
}

/// What makes each coordinate of the file's space one of LPS.
fn signs(fields: &Fields, options: OpenOptions, remarks: &mut Remarks) -> Result<[f64; 3], NrrdError> {
    let word = fields.get("space").map(|field| (field, field.text.to_lowercase()));
    let nameless = match word.as_ref().map(|(field, word)| (*field, word.as_str())) {
        Some((_, "left-posterior-superior" | "lps")) => return named(remarks, "LPS", [1.0, 1.0, 1.0]),
        Some((_, "right-anterior-superior" | "ras")) => return named(remarks, "RAS", [-1.0, -1.0, 1.0]),
        Some((_, "left-anterior-superior" | "las")) => return named(remarks, "LAS", [1.0, -1.0, 1.0]),
        Some((_, name @ ("scanner-xyz" | "3d-right-handed"))) => name,
        Some((field, _)) => return Err(field.refuse(ORIENTED)),
        None => "no name",
    };
    if !options.assume_lps {
        let found = format!("its space is {nameless:?}, which says nothing of the patient");
        return Err(NrrdError::NoOrientation { found });
    }
    remarks.doubt(format!(
        "NO ORIENTATION IN THE FILE (space {nameless:?}): its axes are taken as LPS"
    ));
    Ok([1.0; 3])
}

fn named(remarks: &mut Remarks, space: &str, signs: [f64; 3]) -> Result<[f64; 3], NrrdError> {
    remarks.notes.push(format!("oriented in {space}"));
    Ok(signs)
}

/// Ends of an axis that has a direction are refused, as the format's library does: they may say another place than the origin.
fn no_ends(fields: &Fields, vectors: &[Option<[f64; 3]>]) -> Result<(), NrrdError> {
    for field in ["axis mins", "axis maxs"].iter().filter_map(|name| fields.get(name)) {
        let ends = field.text.split_whitespace().map(|word| word.parse::<f64>());
        let says = |(end, vector): (Result<f64, _>, &Option<_>)| vector.is_some() && !end.is_ok_and(f64::is_nan);
        if ends.zip(vectors).any(says) {
            return Err(field.refuse("NaN for each axis with a space direction, which says where it lies"));
        }
    }
    Ok(())
}

/// A vector or "none" for each axis of the array.
fn vectors(field: &Field, dimension: usize) -> Result<Vec<Option<[f64; 3]>>, NrrdError> {
    let refused = || field.refuse("a vector of three numbers like (0,0,1), or none, for each axis");
    let mut rest = field.text.trim();
    let mut found = Vec::new();
    while !rest.is_empty() && found.len() <= dimension {
        if let Some(after) = rest.strip_prefix("none") {
            found.push(None);
            rest = after.trim_start();
            continue;
        }
        let end = rest.find(')').ok_or_else(refused)?;
        let (text, after) = rest.split_at(end + 1);
        found.push(Some(vector(text).ok_or_else(refused)?));
        rest = after.trim_start();
    }
    if found.len() != dimension {
        return Err(refused());
    }
    Ok(found)
}

/// `(x,y,z)`.
fn vector(text: &str) -> Option<[f64; 3]> {
    let inner = text.trim().strip_prefix('(')?.strip_suffix(')')?;
    let mut parts = inner.split(',').map(|part| part.trim().parse::<f64>().ok());
    let vector = [parts.next()??, parts.next()??, parts.next()??];
    parts.next().is_none().then_some(vector)
}

/// The three axes that have a direction: of four, one has none.
fn three_axes(field: &Field, vectors: &[Option<[f64; 3]>]) -> Result<[usize; 3], NrrdError> {
    let axes: Vec<usize> = (0..vectors.len()).filter(|&i| vectors[i].is_some()).collect();
    let three = axes.try_into();
    three.map_err(|_| field.refuse("three axes with a direction, and none for a fourth"))
}

/// Spacings beside directions say nothing new, or something else.
fn check_spacings(fields: &Fields, vectors: &[Option<[f64; 3]>]) -> Result<(), NrrdError> {
    let Some(field) = fields.get("spacings") else {
        return Ok(());
    };
    let told = field.text.split_whitespace().map(|word| word.parse::<f64>().ok());
    for (axis, (told, vector)) in told.zip(vectors).enumerate() {
        let spacing = told.ok_or_else(|| field.refuse("a number for each axis"))?;
        let Some(vector) = vector.filter(|_| !spacing.is_nan()) else {
            continue;
        };
        let length = vector.iter().map(|v| v * v).sum::<f64>().sqrt();
        if (spacing - length).abs() > SPACING_DIFFERENCE * length {
            return Err(NrrdError::Disagreement {
                line: field.line,
                axis,
                spacing,
                length,
            });
        }
    }
    Ok(())
}
