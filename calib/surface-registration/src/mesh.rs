//! The bone's surface: triangles that were checked, and what is inside and outside of them.

mod check;
mod error;
mod topology;

use std::marker::PhantomData;

use geometry::{Frame, Point};
use nalgebra::Vector3;

pub use error::SurfaceError;

use crate::tree::Tree;

/// The most triangles that are taken.
pub const MOST_TRIANGLES: usize = 4_000_000;
/// The least and the greatest diagonal of a bone's bounding box, mm: beyond them the unit is not mm.
pub const DIAGONAL_MM: [f64; 2] = [10.0, 3000.0];

/// A bone's surface in `F`, mm: triangles whose corners go anticlockwise seen from outside.
#[derive(Debug, Clone)]
pub struct Surface<F> {
    pub(crate) tree: Tree,
    /// Cones over the open ends: with them the surface is closed.
    pub(crate) caps: Vec<[Vector3<f64>; 3]>,
    facts: Facts,
    frame: PhantomData<fn() -> F>,
}

/// What was found of a surface when it was checked.
#[derive(Debug, Clone, PartialEq)]
pub struct Facts {
    /// Triangles in use.
    pub triangles: usize,
    /// Triangles without area in their topology (two corners at one place), left out.
    pub collapsed: usize,
    /// Connected parts in use.
    pub parts: usize,
    /// Connected parts that lie inside another one (marrow cavities, inner walls), left out: no probe reaches them.
    pub inner_parts: usize,
    /// Triangles of those.
    pub inner_triangles: usize,
    /// Edges with a triangle on one side only.
    pub open_edges: usize,
    /// Where the surface is open; empty where it is closed.
    pub open_ends: Vec<OpenEnd>,
    /// Area, mm^2.
    pub area_mm2: f64,
    /// Opposite corners of the bounding box, mm.
    pub bounds_mm: [[f64; 3]; 2],
    /// Whether it encloses so little that inside and outside are told by the nearest triangle alone.
    pub is_sheet: bool,
}

/// One connected piece of the border of an open surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OpenEnd {
    /// Edges of it.
    pub edges: usize,
    /// Its length, mm.
    pub length_mm: f64,
    /// The mean of its corners, mm.
    pub centre_mm: [f64; 3],
}

/// Where a place is with respect to the surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Distance {
    /// Distance to the surface, mm: above 0 outside, below 0 inside.
    pub mm: f64,
    /// Its gradient: of length 1, away from the bone's inside.
    pub normal: [f64; 3],
    /// Whether the nearest place of the surface is on an open border, so that nothing is known of the bone beyond.
    pub is_open: bool,
}

impl<F: Frame> Surface<F> {
    /// Checks a surface: `corners_mm` in `F`, and three of them for each triangle, anticlockwise seen from outside. Corners at one
    /// place, to the bit, become one.
    ///
    /// # Errors
    /// Each variant of [`SurfaceError`].
    pub fn new(corners_mm: &[[f64; 3]], triangles: &[[u32; 3]]) -> Result<Self, SurfaceError> {
        let checked = check::checked(corners_mm, triangles)?;
        Ok(Self {
            tree: Tree::new(&checked.corners, &checked.triangles),
            caps: checked.caps,
            facts: checked.facts,
            frame: PhantomData,
        })
    }

    /// What was found when it was checked.
    pub fn facts(&self) -> &Facts {
        &self.facts
    }

    /// The signed distance of a place, exact to rounding. The sign is that of the pseudo-normal at the nearest place (Baerentzen and
    /// Aanaes 2005), which on a surface without self-intersections is inside and outside.
    pub fn distance(&self, place: Point<F>) -> Distance {
        let p = Vector3::from(place.mm());
        self.tree.foot(&p, f64::INFINITY, None).map_or(
            Distance {
                mm: f64::NAN,
                normal: [f64::NAN; 3],
                is_open: true,
            },
            |foot| {
                let (mm, normal) = foot.signed(&p);
                Distance {
                    mm,
                    normal: normal.into(),
                    is_open: foot.is_open,
                }
            },
        )
    }

    /// How often the surface, its open ends closed by cones, winds about a place: 1 inside, 0 outside; the sum of solid angles over
    /// 4 pi (van Oosterom and Strackee 1983). Looks at every triangle.
    pub fn winding(&self, place: Point<F>) -> f64 {
        let p = Vector3::from(place.mm());
        let triangles = self.tree.triangles().map(|t| [t.a, t.b, t.c]);
        check::winding(triangles.chain(self.caps.iter().copied()), &p)
    }
}
