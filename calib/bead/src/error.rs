//! Why a volume was not searched, and why something in it is no bead.

use std::fmt;

use super::Search;

/// Why a volume was not searched.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Refused {
    /// The radii make no range.
    #[error(
        "the radii {0:?} mm are no range; expected 0 < least <= most <= {most} mm",
        most = Search::MAX_RADIUS_MM
    )]
    Radius([f64; 2]),
    /// The metal's HU is not a positive number.
    #[error("the metal's {0} HU over its surroundings is not a number of {low} to 1e6", low = Search::LEAST_METAL_HU)]
    Metal(f64),
    /// The steps of the slices' plane differ too much for one blur.
    #[error("voxels of {spacing_mm:?} mm have no two like steps: the blur cannot be taken as round in any plane")]
    Uneven {
        /// Lengths of the three steps.
        spacing_mm: [f64; 3],
    },
    /// The voxels are so large that a bead cannot be told from bone.
    #[error(
        "a bead of {radius_mm} mm radius and {metal_hu} HU would show as little as {least_hu:.0} HU in voxels of \
         {spacing_mm:?} mm, and bone is brighter; at least {needed_hu:.0} HU are needed: take thinner slices, larger \
         beads, or give the metal's HU if it is denser"
    )]
    TooCoarse {
        /// The least radius looked for.
        radius_mm: f64,
        /// The metal's HU.
        metal_hu: f64,
        /// The brightest voxel of a bead in the worst place, HU over its surroundings.
        least_hu: f64,
        /// The least that is accepted.
        needed_hu: f64,
        /// Lengths of the three steps.
        spacing_mm: [f64; 3],
    },
    /// The voxels are so small beside the bead that its neighbourhood has too many.
    #[error("the neighbourhood of a bead of {radius_mm} mm has {voxels} voxels; at most {limit} are searched")]
    TooFine {
        /// The greatest radius looked for.
        radius_mm: f64,
        /// Voxels of the neighbourhood.
        voxels: usize,
        /// The bound.
        limit: usize,
    },
    /// There are so many bright spots that this is no CT in HU, or the threshold is far too low.
    #[error("more than {limit} spots are brighter than {threshold_hu} HU; is this a CT in HU?")]
    TooMany {
        /// The bound.
        limit: usize,
        /// The threshold.
        threshold_hu: f64,
    },
}

/// Why a bright spot was not taken for a bead. Numbers are what was found and what was asked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Reason {
    /// It does not stand out from its surroundings enough: HU.
    Dim {
        /// Brightest voxel over the mean around.
        found_hu: f64,
        /// The least accepted.
        needed_hu: f64,
    },
    /// The detector's value is too small.
    Chi {
        /// The value.
        found: f64,
        /// The least accepted.
        needed: f64,
    },
    /// Something as bright touches it: a screw, a wire, an implant, another bead.
    NotAlone {
        /// The brightest voxel around, as a share of the spot's own contrast.
        share: f64,
        /// The most accepted.
        most: f64,
    },
    /// Too little of its neighbourhood lies within the volume.
    AtBorder {
        /// Voxels of the neighbourhood within.
        within: usize,
        /// Voxels of the whole neighbourhood.
        all: usize,
    },
    /// The model does not fit: not a ball.
    Shape {
        /// Root mean square residual as a share of the model's contrast.
        residual: f64,
        /// The most accepted.
        most: f64,
    },
    /// The blur that fits is not the scanner's: an elongated or a ragged thing.
    Blur {
        /// Fitted over expected, in the plane and along the normal.
        ratio: [f64; 2],
        /// Least and most accepted.
        range: [f64; 2],
    },
    /// It is less dense than the metal, or has less of it than the smallest bead: bone, calcification.
    NotMetal {
        /// HU over the surroundings: as fitted, or of the smallest bead with as much in it, whichever is less.
        found_hu: f64,
        /// The least accepted.
        needed_hu: f64,
    },
    /// The radius that fits is outside the range.
    Radius {
        /// mm.
        found_mm: f64,
        /// Least and most accepted, mm.
        range_mm: [f64; 2],
    },
    /// Its centre is not held as that of metal is: bone or calcium, hardly brighter than what is around it.
    Unsure {
        /// Deviation of the centre over the step between voxels, in the slices' plane and along their normal.
        share: [f64; 2],
        /// The most accepted.
        most: [f64; 2],
    },
    /// The fit did not settle, or strayed from where it began.
    NoFit,
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Dim { found_hu, needed_hu } => {
                write!(f, "{found_hu:.0} HU over its surroundings, {needed_hu:.0} are needed")
            }
            Self::Chi { found, needed } => write!(f, "chi {found:.2}, {needed:.2} is needed"),
            Self::NotAlone { share, most } => write!(
                f,
                "something of {:.0} % of its contrast touches it, at most {:.0} % is accepted",
                100.0 * share,
                100.0 * most
            ),
            Self::AtBorder { within, all } => {
                write!(f, "only {within} of the {all} voxels around are in the volume")
            }
            Self::Shape { residual, most } => write!(
                f,
                "no ball: the residual is {:.1} % of the contrast, at most {:.1} % is accepted",
                100.0 * residual,
                100.0 * most
            ),
            Self::Blur {
                ratio: [plane, axial],
                range: [least, most],
            } => write!(
                f,
                "no ball: {plane:.2} and {axial:.2} of the expected blur, {least} to {most} is accepted"
            ),
            Self::NotMetal { found_hu, needed_hu } => {
                write!(
                    f,
                    "{found_hu:.0} HU as a ball of this size, metal has at least {needed_hu:.0}"
                )
            }
            Self::Radius {
                found_mm,
                range_mm: [low, high],
            } => write!(f, "radius {found_mm:.2} mm, {low:.2} to {high:.2} is accepted"),
            Self::Unsure { share, most } => write!(
                f,
                "its centre is held to {:.1} and {:.1} % of a voxel, metal's to {:.1} and {:.1} %: bone or calcium",
                100.0 * share[0],
                100.0 * share[1],
                100.0 * most[0],
                100.0 * most[1]
            ),
            Self::NoFit => write!(f, "the model does not settle on it"),
        }
    }
}
