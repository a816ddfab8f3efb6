//! The folder of results of a scene in space.

use std::path::Path;

use super::report::{Report, Whole};
use crate::output::{OutputError, json};

/// Writes everything; the names of the pictures.
///
/// # Errors
/// [`OutputError`].
pub(super) fn write(whole: &Whole<'_>, out: &Path) -> Result<Vec<String>, OutputError> {
    let pictures = Vec::new();
    json(&Report::new(whole, &pictures), &out.join("result.json"))?;
    Ok(pictures)
}
