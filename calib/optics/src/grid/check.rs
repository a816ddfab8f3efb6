//! Whether the pixels of single discs agree with a fit of the whole grid, and how far off the fit may be.

pub(super) mod agreement;
pub(super) mod misfit;
pub(super) mod own_centres;
pub(super) mod own_pixels;
