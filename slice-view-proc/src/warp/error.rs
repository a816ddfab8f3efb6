//! What cannot be drawn, by name.

/// Why there is no shape.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NoShape {
    /// Too few or too many of something.
    #[error("{what}: {found}; 1 to {allowed} are allowed")]
    Count {
        /// Of what.
        what: &'static str,
        /// How many there are.
        found: u64,
        /// How many there may be.
        allowed: u64,
    },
    /// A cube cannot be one of this mesh.
    #[error("cube {cube}: {why}")]
    Cube {
        /// Its number, from 0.
        cube: usize,
        /// What is wrong.
        why: String,
    },
    /// The region cannot be one.
    #[error("the region at rest: {0}")]
    Region(String),
    /// A size of pieces that is none.
    #[error("pieces of {0} mm; a positive size is needed, 1/64 of the largest cube or more")]
    Piece(f64),
}
