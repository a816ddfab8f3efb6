//! From points to the text of a file.

use std::fmt::Write;

use super::row::column;
use super::{COLUMNS, FcsvError, Fiducials};
use crate::{ControlPoint, PatientAxes};

/// The version that is written: the last that old and new Slicers read alike.
const VERSION: &str = "4.11";

/// The text of a file whose coordinates are along these axes, in mm, each number with the digits that bring back every
/// bit. Points that have no place are left out: this version has no word for them.
///
/// # Errors
/// [`FcsvError::Unwritable`].
pub fn write(file: &Fiducials, axes: PatientAxes) -> Result<String, FcsvError> {
    // By number: Slicer up to 4.11 takes every word for 0.
    let number = match axes {
        PatientAxes::Ras => 0,
        PatientAxes::Lps => 1,
    };
    let mut text =
        format!("# Markups fiducial file version = {VERSION}\n# CoordinateSystem = {number}\n# columns = {COLUMNS}\n");
    for point in &file.points {
        row(&mut text, point, axes)?;
    }
    Ok(text)
}

fn row(text: &mut String, point: &ControlPoint, axes: PatientAxes) -> Result<(), FcsvError> {
    let [x, y, z] = axes.turned(point.position.mm());
    let [vis, sel, lock] = [point.visible, point.selected, point.locked].map(u8::from);
    let [id, label, desc, node] = [&point.id, &point.label, &point.description, &point.associated_node];
    for name in [id, label, desc, node] {
        // A blank at an end is lost by readers that trim, and a sign of a comment at the beginning of a line makes it
        // one.
        if name.contains(char::is_control) || name.trim() != name || (name == id && name.starts_with('#')) {
            return Err(FcsvError::Unwritable {
                name: crate::quoted(name),
            });
        }
    }
    let [id, label, desc, node] = [id, label, desc, node].map(|name| column(name));
    // 0,0,0,1 stands for no axes of its own. Writing to a string does not fail.
    let _ = writeln!(
        text,
        "{id},{x},{y},{z},0,0,0,1,{vis},{sel},{lock},{label},{desc},{node}"
    );
    Ok(())
}
