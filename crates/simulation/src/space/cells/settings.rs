//! How a region is cut into elements, and why it may not be.

use super::rule::Depth;
use crate::space::element::{Dilatation, Order};

/// How a region is cut into elements.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Side of the largest cubes, mm.
    pub side: f64,
    /// Times that they may be halved, at most [`Self::MOST_LEVELS`].
    pub levels: u32,
    /// Nodes of an element.
    pub order: Order,
    /// Space of the dilatations.
    pub dilatation: Dilatation,
    /// A cube filled by less than this part has its lonely nodes extended from a neighbour; 0 to 0.9.
    pub least_fill: f64,
    /// How finely the part of a cube inside is found.
    pub depth: Depth,
    /// More cubes than these are refused.
    pub most_cubes: usize,
}

impl Settings {
    /// Halvings of a cube at most.
    pub const MOST_LEVELS: u32 = 6;

    /// 27 nodes, linear dilatations, no refinement.
    pub fn of_side(side: f64) -> Self {
        Self {
            side,
            levels: 0,
            order: Order::Quadratic,
            dilatation: Dilatation::Linear,
            least_fill: 0.02,
            depth: Depth::default(),
            most_cubes: 200_000,
        }
    }

    /// 8 nodes and a constant dilatation on the same cubes.
    #[must_use]
    pub fn fast(self) -> Self {
        Self {
            order: Order::Linear,
            dilatation: Dilatation::Constant,
            ..self
        }
    }
}

/// Why a region has no mesh.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NoMesh {
    /// A setting is outside its range.
    #[error("{what} is {found}; it must be {wanted}")]
    Setting {
        /// Which.
        what: &'static str,
        /// What was found.
        found: f64,
        /// The range.
        wanted: &'static str,
    },
    /// The box has corners that are not finite, or no volume.
    #[error("the box from {low:?} to {high:?} mm has no volume")]
    Box {
        /// Lowest corner.
        low: [f64; 3],
        /// Highest corner.
        high: [f64; 3],
    },
    /// Too many cubes.
    #[error("cubes of {side} mm, halved up to {levels} times, are more than {most}: use larger ones")]
    TooMany {
        /// Side of the largest.
        side: f64,
        /// Halvings.
        levels: u32,
        /// The most.
        most: usize,
    },
    /// The field is nowhere negative in the box.
    #[error("the region has no volume in the box")]
    Empty,
    /// The mesh is not the region.
    #[error(
        "the mesh has {found:.1} mm^3 and the region {expected:.1} mm^3: cubes are too large for its thin parts, or it is of a few voxels only"
    )]
    Lost {
        /// Volume of the mesh.
        found: f64,
        /// That of the region.
        expected: f64,
    },
    /// Parts of the mesh do not hold together.
    #[error(
        "the mesh has {count} parts that share no node, one of them near {at:?} mm: the region is apart there, or its bridge was smoothed away"
    )]
    Apart {
        /// How many.
        count: usize,
        /// A node of another part than the first.
        at: [f64; 3],
    },
    /// A part that no cube is well filled by.
    #[error(
        "no cube near {at:?} mm is well filled: the region is thin there beside cubes of {side} mm; use smaller ones"
    )]
    Thin {
        /// The middle of a cube there.
        at: [f64; 3],
        /// Its side, mm.
        side: f64,
    },
    /// An element whose points are no rule.
    #[error("the element near {at:?} mm: {why}")]
    Element {
        /// The middle of its cube.
        at: [f64; 3],
        /// What is wrong.
        why: String,
    },
}

impl Settings {
    pub(super) fn check(&self) -> Result<(), NoMesh> {
        let refused = |what, found, wanted| Err(NoMesh::Setting { what, found, wanted });
        if !(self.side.is_finite() && self.side > 0.0) {
            return refused("the side of the cubes", self.side, "finite and above 0");
        }
        if self.levels > Self::MOST_LEVELS {
            return refused("the number of halvings", f64::from(self.levels), "0 to 6");
        }
        if !(0.0..=0.9).contains(&self.least_fill) {
            return refused("the least fill", self.least_fill, "0 to 0.9");
        }
        if self.depth.cuts > 6 || !(1..=5).contains(&self.depth.points) {
            return refused(
                "the depth of the rules",
                f64::from(self.depth.cuts),
                "0 to 6 cuts of 1 to 5 points",
            );
        }
        Ok(())
    }
}
