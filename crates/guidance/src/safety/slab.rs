//! A section of a tube, and how far a place is from it.

use super::placed::{About, Placed};

/// A voxel's centre, or a ball's, beside a tube.
#[derive(Clone, Copy)]
pub(super) struct Place {
    pub(super) depth: f64,
    /// How far outside the tube's side; less than zero within it.
    beside: f64,
    /// The signed distance from the whole tube.
    pub(super) signed: f64,
}

impl Place {
    #[inline]
    pub(super) fn of(tube: &Placed, about: About) -> Self {
        Self {
            depth: about[2],
            beside: tube.beside(about),
            signed: tube.signed(about),
        }
    }
}

/// What a tube has between two depths, mm.
#[derive(Clone, Copy)]
pub(super) struct Slab {
    pub(super) from: f64,
    pub(super) to: f64,
}

impl Slab {
    /// The square of the distance, 0 within.
    #[inline]
    pub(super) fn square(&self, place: &Place) -> f64 {
        let beside = place.beside.max(0.0);
        let beyond = (self.from - place.depth).max(place.depth - self.to).max(0.0);
        beside * beside + beyond * beyond
    }

    /// The key of the distance; within, of that from the whole tube.
    #[inline]
    pub(super) fn key(&self, place: &Place) -> f64 {
        let square = self.square(place);
        if square > 0.0 { square } else { place.signed.min(0.0) }
    }
}

/// The key of a signed distance.
pub(super) fn key_of(mm: f64) -> f64 {
    if mm > 0.0 { mm * mm } else { mm }
}

/// The signed distance of a key.
pub(super) fn mm_of(key: f64) -> f64 {
    if key > 0.0 { key.sqrt() } else { key }
}
