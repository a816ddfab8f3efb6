//! stub
use std::path::Path;
use crate::plan::Plan;
use crate::record::Row;
/// Writes.
///
/// # Errors
/// io
pub fn write(_: &Path, _: &Plan, _: &[Row]) -> std::io::Result<()> { Ok(()) }
