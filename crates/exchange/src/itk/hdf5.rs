//! Transforms as ITK writes them into HDF5: a group `TransformGroup` with a group a transform, by its number.

use hdf5_pure::{DType, Dataset, File, Group};

use super::parts::Part;
use super::{ItkError, MAX_PARTS};

/// What such a file begins with.
pub(super) const SIGNATURE: [u8; 8] = *b"\x89HDF\r\n\x1a\n";
/// The longest that is read, bytes: a rigid transform has 9 KB.
const MAX_BYTES: usize = 16 << 20;
/// Most numbers of a transform that are asked for.
const MOST_NUMBERS: u64 = 16;

/// The transforms, in the order of their numbers.
pub(super) fn parts(bytes: &[u8]) -> Result<Vec<Part>, ItkError> {
    if bytes.len() > MAX_BYTES {
        let why = format!(
            "{} bytes; at most {MAX_BYTES} are read of a rigid transform",
            bytes.len()
        );
        return Err(ItkError::Hdf5 {
            what: "the file".to_owned(),
            why,
        });
    }
    let file = File::from_bytes(bytes.to_vec()).map_err(|error| failed("the file", &error))?;
    let group = file
        .group("TransformGroup")
        .map_err(|error| failed("TransformGroup", &error))?;
    let count = group.groups().map_err(|error| failed("TransformGroup", &error))?.len();
    // The first may be a composite, which is none of its parts.
    if count > MAX_PARTS + 1 {
        return Err(ItkError::TooMany);
    }
    // By number: the names are in no order.
    (0..count).map(|number| part(&file, number)).collect()
}

fn failed(what: &str, error: &dyn std::fmt::Display) -> ItkError {
    ItkError::Hdf5 {
        what: what.to_owned(),
        why: error.to_string().chars().take(160).collect(),
    }
}

fn part(file: &File, number: usize) -> Result<Part, ItkError> {
    let name = format!("TransformGroup/{number}");
    let group = file.group(&name).map_err(|error| failed(&name, &error))?;
    let what = |key: &str| format!("{name}/{key}");
    let kind = kind(&group).map_err(|why| failed(&what("TransformType"), &why))?;
    let mut part = Part {
        kind,
        ..Part::default()
    };
    part.known(number.max(1))?;
    if !part.is_composite() {
        let numbers = |key: &str| numbers(&group, key).map_err(|why| failed(&what(key), &why));
        (part.parameters, part.fixed) = (numbers("TransformParameters")?, numbers("TransformFixedParameters")?);
    }
    Ok(part)
}

/// The one word of a data set, whose length is looked at before it is read: it may promise 2^40 words.
fn kind(group: &Group) -> Result<String, String> {
    let dataset = group.dataset("TransformType").map_err(|error| error.to_string())?;
    let shape = dataset.shape().map_err(|error| error.to_string())?;
    if !shape.iter().all(|side| *side == 1) {
        return Err(format!("of shape {shape:?}; one word is expected"));
    }
    let words = dataset.read_string().map_err(|error| error.to_string())?;
    Ok(words.into_iter().next().unwrap_or_default())
}

/// A data set by its name, or as ITK up to version 5.0 wrote it, without an `s`.
fn named(group: &Group, key: &str) -> Result<Dataset, String> {
    let old = key.replacen("Transform", "Tranform", 1);
    match (group.dataset(key), group.dataset(&old)) {
        (Ok(_), Ok(_)) => Err(format!("{old} is there too: which of them holds is not said")),
        (Ok(one), _) | (Err(_), Ok(one)) => Ok(one),
        (Err(error), Err(_)) => Err(error.to_string()),
    }
}

/// The numbers of a data set, whose length and type are looked at before they are read.
fn numbers(group: &Group, key: &str) -> Result<Vec<f64>, String> {
    let dataset = named(group, key)?;
    let of = dataset.dtype().map_err(|error| error.to_string())?;
    // ITK writes no others; half precision would be off by tenths of a millimetre.
    if !matches!(of, DType::F32 | DType::F64) {
        return Err(format!("of {of:?}; numbers of single or double precision are expected"));
    }
    let shape = dataset.shape().map_err(|error| error.to_string())?;
    let found = shape.iter().try_fold(1_u64, |product, side| product.checked_mul(*side));
    if found.is_none_or(|found| found > MOST_NUMBERS) {
        return Err(format!(
            "of shape {shape:?}; at most {MOST_NUMBERS} numbers are allowed"
        ));
    }
    // Single precision is read as such; the width is the data set's own.
    let numbers = dataset.read_f64();
    numbers.map_err(|error| error.to_string())
}
