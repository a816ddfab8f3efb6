//! Floor 1: files that other programs write, from bytes to types and back. Nothing is read or written here: whoever
//! holds a file hands its bytes in and puts the file's name before the error.
//!
//! | module | files |
//! |---|---|
//! | [`markups`] | 3D Slicer's `.mrk.json` |
//! | [`fcsv`] | 3D Slicer's `.fcsv` |
//! | [`itk`] | ITK's transforms, `.tfm`, `.txt` and `.h5` |
//! | [`mesh`] | surfaces of triangles, STL, PLY, OBJ and legacy VTK |
//! | [`plus`] | device sets of the PLUS toolkit, `.xml`: their calibrations |
//!
//! Every coordinate of a patient that leaves this crate is [`geometry::Ct`]: LPS, mm. Where a file's axes are turned
//! into these, and back, is [`PatientAxes`] alone. What a file does not say is refused until whoever hands it over says
//! it ([`Said`]); what it says is never overruled.

#![forbid(unsafe_code)]

mod axes;
pub mod fcsv;
pub mod itk;
pub mod markups;
pub mod mesh;
mod named;
pub mod plus;
mod points;
mod said;
mod units;

pub use axes::{PatientAxes, turned_to};
pub use named::NamedAxes;
pub use points::{ControlPoint, LeftOut};
pub use said::{MAX_MM, METRES_BELOW, Said, Unsettled};
pub use units::{LengthUnit, NamedUnit};

/// What is quoted of a file stays short, and neither moves a terminal's cursor nor turns the words about it round, whatever the file holds.
fn quoted(text: &str) -> String {
    let seen = |c: char| match c {
        '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}' => '?',
        c if c.is_control() => '?',
        c => c,
    };
    text.chars().take(64).map(seen).collect()
}

/// A text without the byte order mark that some programs put before it.
fn unmarked(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes)
}
