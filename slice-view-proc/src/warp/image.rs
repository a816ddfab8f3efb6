//! Organs where they lie now, and an image of them.

use super::shape::Shape;

/// An organ where it lies now.
#[derive(Debug, Clone, Copy)]
pub struct Organ<'a> {
    /// The organ at rest.
    pub shape: &'a Shape,
    /// Its nodes now, mm in the CT's frame.
    pub places: &'a [[f32; 3]],
}

/// What lies at a pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Pixel {
    /// No organ, now or at rest: the CT as it is.
    #[default]
    Outside,
    /// The organ of this number, from 0.
    Inside(u8),
    /// An organ was here at rest and has gone, or its region reaches beyond its cubes here: nothing is known of what is here now.
    Vacated,
    /// More than one organ, or one twice; where more than 256 pixels of an organ are claimed so, what its pieces have beyond its surface counts too.
    Twice,
}

/// An image of places.
#[derive(Debug, Clone, Default)]
pub struct Warped {
    /// Row by row.
    pub pixels: Vec<Pixel>,
    /// The place at rest of what lies at a pixel, mm in the CT's frame: the pixel's own where nothing moved; of no meaning where two claim
    /// it, or it is vacated.
    pub rest: Vec<[f32; 3]>,
    /// An estimate of how far `rest` may be from the place that the organs' quadratic maps give, mm, without the rounding of `rest`. Of a cube
    /// drawn by pieces, the bend of its map and a part of a pixel, by the largest stretch of its pieces that were cut; a neighbour that is
    /// stretched far more and not cut is not in it. Of a cube drawn whole, what lies between the nodes of its grid, and beside its faces the
    /// difference of both sides' maps as far as its outline may be off them. Outside the organs 0.
    pub error_mm: f64,
    /// Pixels that more than one claims.
    pub twice: usize,
}
