//! One fit of all discs of a grid to the pixels: plane, or bent by a lens.

pub(super) mod contrast;
pub(super) mod disc_in_lens;
pub(super) mod disc_jacobian;
pub(super) mod disc_score;
pub(super) mod grid_fit;
pub(super) mod growth;
pub(super) mod lens_fit;
pub(super) mod lens_model;
pub(super) mod lens_polynomial;
pub(super) mod normal_equations;
pub(super) mod paper_edge;
pub(super) mod sample_pixels;
