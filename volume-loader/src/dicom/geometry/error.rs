//! Why slices make no volume.

use super::{CORNER_MAX_MM, LATERAL_MAX_MM, MIN_SLICES, ORIENTATION_MAX};

/// So many gaps are listed in full.
const LISTED: usize = 12;

/// A step between two slices that is not the others'.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gap {
    /// The slice before it, counted from 0 along the stack.
    pub after: usize,
    /// Where that slice lies: mm from the first along the line of positions.
    pub position_mm: f64,
    /// The median step, mm.
    pub expected_mm: f64,
    /// The step found, mm.
    pub found_mm: f64,
    /// How many slices would fill it.
    pub missing: u64,
}

/// Why slices make no volume.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum GeometryError {
    /// Overview images.
    #[error("these are localizers (scouts), not slices of a volume; choose the series of the slices")]
    Localizer,
    /// Too few slices.
    #[error("too few slices: {found}, expected at least {MIN_SLICES}")]
    TooFew {
        /// How many there are.
        found: usize,
    },
    /// Slices at one place.
    #[error(
        "not a volume: {}{} slices in all; export one series of one point in time",
        places(groups),
        total
    )]
    Duplicates {
        /// For each place with several slices, how many.
        groups: Vec<usize>,
        /// How many slices there are.
        total: usize,
    },
    /// The axes of a slice are not at right angles or not of unit length.
    #[error(
        "ImageOrientationPatient {found:?}: lengths and angle are off by {error:.2e}, expected at most {ORIENTATION_MAX:e}"
    )]
    Orientation {
        /// The six cosines.
        found: [f64; 6],
        /// The largest deviation.
        error: f64,
    },
    /// The positions do not lie on a line.
    #[error(
        "slice {slice} lies {found_mm:.3} mm beside the line from the first to the last, expected at most {LATERAL_MAX_MM} mm: not one volume"
    )]
    NotOnALine {
        /// The slice, counted from 0 along the stack.
        slice: usize,
        /// Distance from the line, mm.
        found_mm: f64,
    },
    /// Rows, columns and the slices' order are not right-handed: the patient would be seen in a mirror.
    #[error(
        "rows, columns and slices make a mirrored patient: the determinant of their steps is {determinant} mm3, expected above 0"
    )]
    Mirrored {
        /// Of one pixel to the right, one down, and the direction from slice to slice.
        determinant: f64,
    },
    /// Slices that are not alike.
    #[error(
        "slice {slice}, put at its own place, has a corner {found_mm:.3} mm from where its header puts it, expected at most {CORNER_MAX_MM} mm: the slices' axes differ"
    )]
    Askew {
        /// The slice, counted from 0 along the stack.
        slice: usize,
        /// How far, mm.
        found_mm: f64,
    },
    /// Steps differ.
    #[error("the slices are uneven, {} of {steps} steps differ from {step_mm:.4} mm:\n{}--regrid puts them on an even grid and marks every image", gaps.len(), listed(gaps))]
    Uneven {
        /// The median step, mm.
        step_mm: f64,
        /// How many steps there are.
        steps: usize,
        /// Those that differ.
        gaps: Vec<Gap>,
    },
    /// Small deviations add up.
    #[error(
        "an even grid puts a corner of slice {slice} {found_mm:.3} mm from its place, expected at most {CORNER_MAX_MM} mm; --regrid follows the positions and marks every image"
    )]
    Corner {
        /// The slice, counted from 0 along the stack.
        slice: usize,
        /// How far, mm.
        found_mm: f64,
    },
}

fn places(groups: &[usize]) -> String {
    match groups {
        [one] => format!("{one} slices at one place, "),
        _ => format!(
            "{} places hold several slices each, up to {}, ",
            groups.len(),
            groups.iter().max().unwrap_or(&0)
        ),
    }
}

fn listed(gaps: &[Gap]) -> String {
    let line = |gap: &Gap| {
        format!(
            "  after slice {} at {:.3} mm: expected {:.4} mm, found {:.4} mm, {} missing\n",
            gap.after, gap.position_mm, gap.expected_mm, gap.found_mm, gap.missing
        )
    };
    let mut text: String = gaps.iter().take(LISTED).map(line).collect();
    if gaps.len() > LISTED {
        text.push_str(&format!("  and {} more\n", gaps.len() - LISTED));
    }
    text
}
