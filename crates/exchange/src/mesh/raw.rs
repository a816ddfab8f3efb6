//! A surface as a file has it, before its frame and unit are settled.

use super::{MAX_COUNT, MeshError};
use crate::PatientAxes;

/// Points in the file's own numbers, triangles that nobody has checked, and the axes that its comment says.
#[derive(Debug, Default)]
pub(super) struct Raw {
    pub(super) points: Vec<[f64; 3]>,
    pub(super) triangles: Vec<[u32; 3]>,
    pub(super) axes: Option<PatientAxes>,
}

impl Raw {
    /// A polygon as a fan of triangles.
    pub(super) fn polygon(&mut self, place: usize, corners: &[u32]) -> Result<(), MeshError> {
        let [first, rest @ ..] = corners else {
            return Err(MeshError::Polygon { place, corners: 0 });
        };
        if rest.len() < 2 {
            return Err(MeshError::Polygon {
                place,
                corners: corners.len(),
            });
        }
        self.triangles
            .extend(rest.windows(2).map(|pair| [*first, pair[0], pair[1]]));
        counted("triangles", self.triangles.len() as u64).map(|_| ())
    }

    /// Takes the axes that a comment says, as 3D Slicer writes them; two words that differ are refused.
    pub(super) fn comment(&mut self, comment: &str) -> Result<(), MeshError> {
        for word in comment.split(|c: char| c.is_whitespace() || c == ';') {
            let Some(value) = word.strip_prefix("SPACE=") else {
                continue;
            };
            let refused = || MeshError::Space {
                found: crate::quoted(value),
            };
            let axes = match value {
                "RAS" => PatientAxes::Ras,
                "LPS" => PatientAxes::Lps,
                _ => return Err(refused()),
            };
            if self.axes.is_some_and(|before| before != axes) {
                return Err(refused());
            }
            self.axes = Some(axes);
        }
        Ok(())
    }
}

/// A count that a head promises, where it may be one.
pub(super) fn counted(what: &'static str, found: u64) -> Result<usize, MeshError> {
    let count = usize::try_from(found).ok().filter(|count| *count <= MAX_COUNT);
    count.ok_or(MeshError::TooMany { what, found })
}
