//! Transforms as ITK writes them into HDF5: a group `TransformGroup` with a group a transform, by its number.

use hdf5_pure::{File, Group};

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
    if count > MAX_PARTS {
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
    let kind = group.dataset("TransformType").and_then(|kind| kind.read_string());
    let kind = kind.map_err(|error| failed(&what("TransformType"), &error))?;
    let mut part = Part {
        kind: kind.first().cloned().unwrap_or_default(),
        ..Part::default()
    };
    part.known(number.max(1))?;
    if !part.is_composite() {
        part.parameters =
            numbers(&group, "TransformParameters").map_err(|why| failed(&what("TransformParameters"), &why))?;
        let fixed = numbers(&group, "TransformFixedParameters");
        part.fixed = fixed.map_err(|why| failed(&what("TransformFixedParameters"), &why))?;
    }
    Ok(part)
}

/// The numbers of a data set, whose length is looked at before they are read.
fn numbers(group: &Group, key: &str) -> Result<Vec<f64>, String> {
    let dataset = group.dataset(key).map_err(|error| error.to_string())?;
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
