//! 3D Slicer's markups, `.mrk.json`: fiducials, lines, angles and curves, of its schema 1.0.0 to 1.0.4.
//!
//! A file holds markups, and each says its own axes. What is read of a markup goes back with [`write()`]: its kind, name and points with
//! names, ids and flags. Keys of the schema that hold no coordinate are passed over; keys that are none of it are named in
//! [`Markups::left_out_keys`], points without a place in [`Markup::left_out`].
//!
//! Refused by name are planes and regions of interest, whose other keys are coordinates too, a unit other than mm, and a key that is one of
//! the schema's in other letters: what it says would be passed over.

mod error;
mod read;
mod rest;
mod write;

pub use error::MarkupsError;
pub use read::read;
pub use write::write;

use crate::{ControlPoint, LeftOut};

/// The longest file, bytes: one of thirty thousand points, as Slicer writes them.
pub const MAX_BYTES: usize = 16 << 20;
/// Most control points of a file.
pub const MAX_POINTS: usize = 100_000;
/// Most commas, brackets and braces: so many values are held while a file is read, and thirty thousand points have a million.
pub const MAX_VALUES: usize = 2_000_000;

/// What a markup is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MarkupKind {
    /// A list of points.
    Fiducial,
    /// Two points.
    Line,
    /// Three points, the angle at the second.
    Angle,
    /// A curve through its points.
    Curve,
    /// A curve that ends where it begins.
    ClosedCurve,
}

impl MarkupKind {
    /// All.
    pub const ALL: [Self; 5] = [Self::Fiducial, Self::Line, Self::Angle, Self::Curve, Self::ClosedCurve];

    /// The word in files.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Fiducial => "Fiducial",
            Self::Line => "Line",
            Self::Angle => "Angle",
            Self::Curve => "Curve",
            Self::ClosedCurve => "ClosedCurve",
        }
    }
}

/// A markup.
#[derive(Debug, Clone, PartialEq)]
pub struct Markup {
    /// What it is.
    pub kind: MarkupKind,
    /// Its name; empty where the file has none, as Slicer names markups by their files.
    pub name: String,
    /// Its points that have a place, in their order.
    pub points: Vec<ControlPoint>,
    /// Its points that have none.
    pub left_out: Vec<LeftOut>,
}

impl Markup {
    /// A new one.
    pub fn new(kind: MarkupKind, name: &str, points: Vec<ControlPoint>) -> Self {
        Self {
            kind,
            name: name.to_owned(),
            points,
            left_out: Vec::new(),
        }
    }
}

/// The content of a file.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Markups {
    /// In their order.
    pub markups: Vec<Markup>,
    /// Names of keys that are not kept, without repetition.
    pub left_out_keys: Vec<String>,
}
