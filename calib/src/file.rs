//! Files of results and of recorded poses: from their text to typed values. Nothing is taken on trust, and nothing is read
//! or written here: whoever holds a file hands its text in and puts the file's name before the error.
//!
//! [`ToolFile`] is a tool's frame in its marker, [`RegistrationFile`] the patient's place in the localizer or in a marker on
//! it; both are JSON. [`sequence`] are recorded poses of the PLUS toolkit. Lengths are mm, angles radians, covariances in
//! the convention of [`geometry::uncertain`].

mod agrees;
mod error;
mod registration;
pub mod sequence;
mod tool;

#[cfg(test)]
mod tests;

pub use agrees::{COVARIANCE_CONVENTION, TRANSFORM_CONVENTION, agrees};
pub use error::FileError;
pub use registration::{Registered, RegistrationFile};
pub use tool::ToolFile;

use serde_json::Value;

/// The longest text of a JSON file, bytes: a registration of ten thousand pairs has 4 MiB.
pub const MAX_BYTES: usize = 16 << 20;
/// The largest coordinate, mm: a thousand kilometres, beyond which a file cannot be in millimetres.
pub const MAX_MM: f64 = 1e9;

/// The id of a file's content, of all but its key `id`: the first 16 hexadecimal digits of the BLAKE3 of it as JSON without
/// blanks, keys in the order of the alphabet.
pub fn content_id(mut content: Value) -> String {
    if let Some(map) = content.as_object_mut() {
        map.remove("id");
    }
    content.sort_all_objects();
    blake3::hash(content.to_string().as_bytes()).to_hex()[..16].to_owned()
}

/// The text as JSON.
fn parsed(text: &str) -> Result<Value, FileError> {
    if text.len() > MAX_BYTES {
        return Err(FileError::TooLong { bytes: text.len() });
    }
    Ok(serde_json::from_str(text)?)
}

/// What is quoted in errors stays short, whatever a file holds.
fn quoted(text: &str) -> String {
    text.chars().take(64).collect()
}

/// Refuses the name `found` where another was expected.
fn same(what: &'static str, found: &str, expected: &str) -> Result<(), FileError> {
    if found == expected {
        return Ok(());
    }
    Err(FileError::WrongPairing {
        what,
        found: quoted(found),
        expected: expected.to_owned(),
    })
}

/// Refuses a translation that cannot be in mm.
fn place(key: &'static str, mm: [f64; 3]) -> Result<(), FileError> {
    let good = mm.iter().all(|x| x.is_finite() && x.abs() <= MAX_MM);
    good.then_some(())
        .ok_or_else(|| FileError::number(key, &mm, "three numbers of at most 1e9 mm"))
}
