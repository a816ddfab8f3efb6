//! Control points, as both of Slicer's formats hold them.

use geometry::{Ct, Point, checked};

use crate::PatientAxes;

/// A point that was placed. Axes of its own, which 3D Slicer gives some, are not kept: a plan has no use for them.
#[derive(Debug, Clone, PartialEq)]
pub struct ControlPoint {
    /// Its name for programs.
    pub id: String,
    /// Its name for people.
    pub label: String,
    /// What people noted of it.
    pub description: String,
    /// The id of what it was placed on, in the program that placed it.
    pub associated_node: String,
    /// Where it is.
    pub position: Point<Ct>,
    /// Whether it is selected.
    pub selected: bool,
    /// Whether it is kept from being moved.
    pub locked: bool,
    /// Whether it is shown.
    pub visible: bool,
}

impl ControlPoint {
    /// A point of this name, shown and selected, as Slicer makes them.
    pub fn new(label: &str, position: Point<Ct>) -> Self {
        Self {
            id: String::new(),
            label: label.to_owned(),
            description: String::new(),
            associated_node: String::new(),
            position,
            selected: true,
            locked: false,
            visible: true,
        }
    }
}

/// A control point that has no place: its name, and what the file says of its place.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LeftOut {
    /// Its name for people.
    pub label: String,
    /// `undefined`, `preview` or `missing`.
    pub status: String,
}

/// The point in the patient, of components along these axes in a unit of so many mm. `None` where a number is not
/// finite.
pub(crate) fn position(axes: PatientAxes, scale: f64, components: [f64; 3]) -> Option<Point<Ct>> {
    checked::point(axes.turned(components.map(|c| c * scale))).ok()
}

/// The largest coordinate; 0 without points.
pub(crate) fn largest<'a>(places: impl Iterator<Item = &'a [f64; 3]>) -> f64 {
    // By hand, as `f64::max` forgets a NaN.
    places
        .flatten()
        .fold(0.0, |most, c| if c.abs() <= most { most } else { c.abs() })
}
