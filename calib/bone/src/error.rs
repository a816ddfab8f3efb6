//! Why no bone is taken from a CT.

use crate::component::Component;

/// Why no bone is taken from a CT.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Refused {
    /// An option is out of its range.
    #[error("{name} is {found}; allowed is {allowed}")]
    Option {
        /// Which.
        name: &'static str,
        /// What was given.
        found: String,
        /// What may be given.
        allowed: &'static str,
    },
    /// Voxels too coarse for any cortex.
    #[error("the CT's voxels are {found:.2} mm apart along axis {axis}; above {most} mm no cortex is seen")]
    Coarse {
        /// The axis, from 0.
        axis: usize,
        /// Its spacing, mm.
        found: f64,
        /// The most, mm.
        most: f64,
    },
    /// No two of the three spacings are alike, so that no axis is the slices' normal.
    #[error("the CT's voxels are {found:.3?} mm apart: which axis goes across the slices is not told")]
    Axes {
        /// Spacings, mm.
        found: [f64; 3],
    },
    /// The region has nothing in common with the CT.
    #[error("the region does not lie in the CT, which goes from {from:.1?} to {to:.1?} mm (left, posterior, superior)")]
    Outside {
        /// Least corner of the CT, mm.
        from: [f64; 3],
        /// Greatest corner of the CT, mm.
        to: [f64; 3],
    },
    /// The region holds no voxel.
    #[error(
        "the region holds no voxel of the CT but metal: it is cut away or kept out altogether, or lies between the voxels' centres"
    )]
    Empty,
    /// Nothing is bright enough.
    #[error(
        "no voxel of the region has {level} HU or more, metal of {metal} HU and more left aside; the brightest of the region has {brightest}. Are \
         these Hounsfield units, and is there bone here?"
    )]
    NoBone {
        /// The threshold, HU.
        level: f64,
        /// The least HU of metal.
        metal: i16,
        /// The brightest voxel of the region below metal, HU.
        brightest: i16,
    },
    /// The seed is in no bone.
    #[error(
        "at the seed {seed:.1?} mm there is no bone: within {within:.1} mm the brightest voxel has {brightest} HU, and {level} are needed"
    )]
    Seed {
        /// Where it is, mm.
        seed: [f64; 3],
        /// How far around it was looked, mm.
        within: f64,
        /// The brightest voxel there, HU.
        brightest: i16,
        /// The threshold, HU.
        level: f64,
    },
    /// There are several bodies above the threshold, and nobody said which.
    #[error(
        "which bone is meant? Above the threshold there are {count} bodies of 0.5 ml and more. The largest may be the heart of a CT with \
         contrast, or bones that touch in a joint: name the bone by a label map, a box, a place in it, or its number here"
    )]
    Which {
        /// How many.
        count: usize,
        /// The largest, at most 12.
        largest: Vec<Component>,
    },
    /// Nothing of the region is dark enough to lie beside bone.
    #[error(
        "{share:.0} % of what was measured about the body has {level} HU or more, and the darkest voxel has {darkest}: there is nothing beside \
         bone. Are these Hounsfield units, with 0 for water?"
    )]
    AllBone {
        /// Share of the body, %.
        share: f64,
        /// The threshold, HU.
        level: f64,
        /// The darkest voxel, HU.
        darkest: i16,
    },
    /// There is no body of that number.
    #[error("there is no body {asked} above the threshold: there are {count} of 0.5 ml and more")]
    NoComponent {
        /// The number, from 1.
        asked: usize,
        /// How many there are.
        count: usize,
    },
    /// What is above the threshold is no bone but noise or an image of another kind.
    #[error("more than {most} runs of voxels above the threshold: noise, or no Hounsfield units")]
    TooRough {
        /// The most.
        most: usize,
    },
    /// The surface is too large.
    #[error(transparent)]
    Surface(#[from] surface::SurfaceError),
    /// Too little of the surface could be fitted.
    #[error(
        "of {corners} places of the threshold's surface {kept} could be fitted, and at least {least:.0} % are needed: {reasons}"
    )]
    Few {
        /// Corners of the threshold's surface.
        corners: usize,
        /// Those with a position of their own.
        kept: usize,
        /// The least share, %.
        least: f64,
        /// Why the others have none.
        reasons: String,
    },
    /// What was taken has no cortex.
    #[error(
        "{share:.0} % of the surface has no cortex (contrast medium of at most {most:.0} HU explains its voxels): vessels or a heart with \
         contrast medium, or an organ, but no bone"
    )]
    NoCortex {
        /// Share of the surface, %.
        share: f64,
        /// Most HU of contrast medium.
        most: f64,
    },
}
