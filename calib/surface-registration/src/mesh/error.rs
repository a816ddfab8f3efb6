//! Why triangles are no surface to register with.

use super::{DIAGONAL_MM, MOST_TRIANGLES};

/// Why triangles are no surface to register with. Indices count from 0.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SurfaceError {
    /// None, or more than can be handled.
    #[error("{found} triangles; 1 to {MOST_TRIANGLES} are taken")]
    Count {
        /// How many there are.
        found: usize,
    },
    /// A coordinate is NaN or infinite.
    #[error("corner {corner}: {found:?} holds a number that is not finite")]
    NotFinite {
        /// The first such corner.
        corner: usize,
        /// What was found.
        found: [f64; 3],
    },
    /// A triangle names a corner that is not there.
    #[error("triangle {triangle} names corner {found}; there are {corners}")]
    NoCorner {
        /// The first such triangle.
        triangle: usize,
        /// The corner that it names.
        found: u32,
        /// How many there are.
        corners: usize,
    },
    /// Too small for a bone in mm: in metres, most likely.
    #[error(
        "the surface is {diagonal:.4} mm across; a bone has {} to {} mm: is it in metres?",
        DIAGONAL_MM[0], DIAGONAL_MM[1]
    )]
    TooSmall {
        /// Diagonal of its bounding box, mm.
        diagonal: f64,
    },
    /// Too large for a bone in mm: in micrometres, or not one bone.
    #[error("the surface is {diagonal:.0} mm across; a bone has {} to {} mm", DIAGONAL_MM[0], DIAGONAL_MM[1])]
    TooLarge {
        /// Diagonal of its bounding box, mm.
        diagonal: f64,
    },
    /// Neighbours do not agree on which side is outside.
    #[error("{edges} edges have triangles of opposite orientation; the first goes from {from:?} to {to:?} mm")]
    Orientation {
        /// How many edges.
        edges: usize,
        /// One end of the first, mm.
        from: [f64; 3],
        /// Its other end, mm.
        to: [f64; 3],
    },
    /// Corners go clockwise seen from outside.
    #[error(
        "a part of {triangles} triangles is inside out: it encloses {volume_ml:.3} ml. It is the wall of a cavity \
         that is open somewhere, to be left out, or the order of its corners is to be turned round"
    )]
    InsideOut {
        /// Triangles of the part.
        triangles: usize,
        /// What it encloses, ml: below 0.
        volume_ml: f64,
    },
}
