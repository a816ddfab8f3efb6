//! Whether what a registration's file says of itself is what is read of it.

use geometry::rotation::{Rotation, RotationVector};
use serde_json::{Value, json};

use super::{FileError, quoted};

/// What the transform of such a file does, in words.
pub const TRANSFORM_CONVENTION: &str = "maps coordinates in `from` to coordinates in `to`: p_to = scale * R * p_from + t, R from the unit quaternion w, x, y, z";
/// What its covariance means, in words.
pub const COVARIANCE_CONVENTION: &str = "rows and columns are (rotation vector w in rad, translation v in mm), both in `to`, turning about its origin: the \
     true transform is p -> exp(w) (scale R p + t) + v; a fitted scale is taken as known";

/// The largest difference of numbers that say the same, of their size: a quaternion may be 1e-9 off its length, which its matrix is by twice.
const TOLERANCE: f64 = 1e-8;

/// Refuses a registration's file that says the same in two ways which differ: units other than mm and rad, a name of the transform that is not
/// that of its frames, a matrix or a rotation vector that is not that of the quaternion, other conventions than are read. What it does not
/// say is not asked for, and keys that are not known are passed over.
///
/// # Errors
/// [`FileError::BadNumber`] with the key, what it holds and what it should hold.
pub fn agrees(file: &Value) -> Result<(), FileError> {
    let text = |of: &str| file.pointer(of).and_then(Value::as_str).unwrap_or_default();
    let name = format!("{}_from_{}", text("/to"), text("/from"));
    for (key, pointer, expected) in [
        ("units.length", "/units/length", "mm"),
        ("units.angle", "/units/angle", "rad"),
        ("transform.name", "/transform/name", &name),
        ("transform.convention", "/transform/convention", TRANSFORM_CONVENTION),
        ("covariance_convention", "/covariance_convention", COVARIANCE_CONVENTION),
    ] {
        match file.pointer(pointer) {
            Some(found) if found != expected => return Err(differs(key, found, format!("{expected:?}"))),
            _ => {}
        }
    }
    numbers(file)
}

/// The matrix and the rotation vector, against quaternion, scale and translation. A quaternion that is none is refused by whoever reads it.
fn numbers(file: &Value) -> Result<(), FileError> {
    let numbers = |of: &str| serde_json::from_value::<Vec<f64>>(file.pointer(of)?.clone()).ok();
    let quaternion = numbers("/transform/quaternion_wxyz").and_then(|q| <[f64; 4]>::try_from(q).ok());
    let rotation = quaternion.and_then(|q| Rotation::from_quaternion(q).ok());
    let shift = numbers("/transform/translation_mm").filter(|shift| shift.len() == 3);
    let (Some(rotation), Some(t)) = (rotation, shift) else {
        return Ok(());
    };
    let scale = file.pointer("/transform/scale").and_then(Value::as_f64).unwrap_or(1.0);
    let row = |([x, y, z], t): ([f64; 3], &f64)| [scale * x, scale * y, scale * z, *t];
    let mut rows: Vec<[f64; 4]> = rotation.matrix().rows().into_iter().zip(&t).map(row).collect();
    rows.push([0.0, 0.0, 0.0, 1.0]);
    if let Some(found) = file.pointer("/transform/matrix") {
        let matrix: Option<[[f64; 4]; 4]> = serde_json::from_value(found.clone()).ok();
        // A NaN is near nothing.
        let near = |a: f64, b: f64| (a - b).abs() <= TOLERANCE * scale.abs().max(1.0).max(b.abs());
        let same = matrix.is_some_and(|found| {
            found
                .iter()
                .flatten()
                .zip(rows.iter().flatten())
                .all(|(a, b)| near(*a, *b))
        });
        if !same {
            let expected = format!("that of quaternion and translation, {}", json!(rows));
            return Err(differs("transform.matrix", found, expected));
        }
    }
    if let Some(found) = file.pointer("/transform/rotation_vector_rad") {
        let own = numbers("/transform/rotation_vector_rad").and_then(|v| <[f64; 3]>::try_from(v).ok());
        let own = own.and_then(|v| RotationVector::new(v).ok());
        let angle = own.map(|v| Rotation::from_vector(v).distance(rotation));
        if !angle.is_some_and(|angle| angle <= TOLERANCE) {
            let expected = format!("that of the quaternion, {:?}", rotation.vector().radians());
            return Err(differs("transform.rotation_vector_rad", found, expected));
        }
    }
    Ok(())
}

fn differs(key: &'static str, found: &Value, expected: String) -> FileError {
    FileError::BadNumber {
        key,
        found: quoted(&found.to_string()),
        expected,
    }
}
