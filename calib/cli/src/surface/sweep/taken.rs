//! What a way or images gave, and what was left out.

use super::super::error::SurfaceCommandError;

/// The points of a way.
pub(in super::super) struct Taken {
    /// Their file.
    pub(in super::super) text: String,
    /// How many they are.
    pub(in super::super) count: usize,
    /// Images that were refused, where some were.
    pub(in super::super) refused: Option<Refused>,
}

/// Images that gave no points because the calibration does not hold for them.
#[derive(Debug)]
pub(in super::super) struct Refused {
    /// How many, and of how many.
    pub(in super::super) count: usize,
    pub(in super::super) of: usize,
    /// The number of the last of them.
    pub(in super::super) last: u64,
    /// Why the first was refused; it says which one that is.
    pub(in super::super) first: SurfaceCommandError,
}

impl Refused {
    /// Whether the sweep as a whole is none.
    pub(in super::super) fn is_most(&self) -> bool {
        2 * self.count > self.of
    }
}

impl std::fmt::Display for Refused {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { count, of, last, first } = self;
        write!(
            f,
            "{count} of {of} images are left out, the last of them image {last}: {first}"
        )
    }
}
