//! The region of a label in a label map, with a smooth surface.
//!
//! The label's indicator, 1 inside and 0 outside, is smoothed; the surface is where it falls below a level. A plane of any tilt alone
//! stays where it is; a ball of radius `R` would shrink by about `sigma^2 / R`, so the level is chosen such that the region
//! has the volume of the label's voxels. What a body loses at its edges comes back on its faces.

mod crop;
mod parts;
mod smooth;

use nalgebra::Vector3;

use super::field::{Bounds, Field};
use super::spline::Spline;
use crop::Crop;
use parts::{fill_holes, largest_part};

/// A label map in its own axes: `size[0] x size[1] x size[2]` voxels, x fastest, the centre of the first at `origin`, mm.
#[derive(Debug, Clone, Copy)]
pub struct LabelMap<'a> {
    /// Voxels along each axis.
    pub size: [usize; 3],
    /// Centre of the first voxel, mm.
    pub origin: Vector3<f64>,
    /// Distances of voxels, mm, above 0.
    pub spacing: Vector3<f64>,
    /// The labels.
    pub labels: &'a [u16],
}

/// Why a label has no region.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NoRegion {
    /// Sizes that do not agree.
    #[error("a label map of {size:?} voxels needs as many labels; {found} were given")]
    Size {
        /// Voxels along each axis.
        size: [usize; 3],
        /// Labels given.
        found: usize,
    },
    /// Places that are none.
    #[error(
        "the label map's first voxel is at {origin:?} mm and its spacing {spacing:?} mm; both must be finite, spacings above 0"
    )]
    Place {
        /// First voxel.
        origin: [f64; 3],
        /// Spacing.
        spacing: [f64; 3],
    },
    /// The smoothing.
    #[error("smoothing of {found} mm; it must be from 0 to {most} mm with these voxels")]
    Smoothing {
        /// What was found.
        found: f64,
        /// The most.
        most: f64,
    },
    /// No voxel has the label.
    #[error("no voxel has the label {label}")]
    Missing {
        /// The label.
        label: u16,
    },
    /// Several parts.
    #[error(
        "the label {label} has {count} parts that do not touch, the largest of {largest} and the next of {next} voxels: choose the largest, or mend the label map"
    )]
    Parts {
        /// The label.
        label: u16,
        /// How many.
        count: usize,
        /// Voxels of the largest.
        largest: usize,
        /// Voxels of the next.
        next: usize,
    },
    /// Too thin for the smoothing.
    #[error("smoothing by {sigma} mm loses {lost} of {voxels} voxels of the label {label}: it is too thin for that")]
    Lost {
        /// The label.
        label: u16,
        /// Standard deviation, mm.
        sigma: f64,
        /// Voxels of the label outside the region.
        lost: usize,
        /// Voxels of the label.
        voxels: usize,
    },
}

/// What to do with a label of several parts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Parts {
    /// Refuse it.
    #[default]
    Refuse,
    /// Take the largest; [`Facts::dropped`] counts the voxels of the others.
    Largest,
    /// Take all, uncounted ([`Facts::parts`] is 0): of what is no solid, as of bone that is in the way.
    All,
}

/// How a label becomes a region.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Smoothing {
    /// Standard deviation, mm; less than the splines' own, 0.58 voxels, counts as that.
    pub sigma: f64,
    /// Several parts.
    pub parts: Parts,
    /// Whether holes that the label encloses are filled.
    pub fill_holes: bool,
}

/// What was found about a label.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Facts {
    /// Voxels of the region's part of the label, filled holes among them.
    pub voxels: usize,
    /// Their volume, mm^3.
    pub volume: f64,
    /// Parts that do not touch.
    pub parts: usize,
    /// Voxels of the parts that were dropped.
    pub dropped: usize,
    /// Voxels of holes.
    pub holes: usize,
    /// Whether holes were filled.
    pub filled: bool,
    /// Whether it reaches the map's first or last plane along each axis: it goes on beyond, and is cut off there.
    pub cut: [[bool; 2]; 3],
    /// Voxels of the label whose centres are outside the smooth region, and others whose are inside.
    pub moved: [usize; 2],
}

/// The region of a label.
#[derive(Debug, Clone)]
pub struct LabelField {
    pub(super) spline: Spline,
    /// What was found about the label.
    pub facts: Facts,
    /// Corners of a box that holds the region, mm.
    pub corners: [Vector3<f64>; 2],
}

/// More of a label's voxels than this part outside its region, and it is another shape.
const MOST_LOST: f64 = 0.25;
/// Voxels kept around the label: the splines' reach, beyond what smoothing adds.
const MARGIN: usize = 3;

impl LabelField {
    /// The region of a label.
    ///
    /// # Errors
    /// Every variant of [`NoRegion`].
    pub fn new(map: &LabelMap<'_>, label: u16, smoothing: &Smoothing) -> Result<Self, NoRegion> {
        map.check()?;
        // The crop has room for what smoothing spreads: beyond it all is flat.
        let passes = smooth::passes(smoothing.sigma, &map.spacing)?;
        let crop = Crop::of(map, label, passes.map(|p| p + MARGIN)).ok_or(NoRegion::Missing { label })?;
        let (mut inside, mut facts) = (crop.indicator(map, label), crop.facts(map));
        let sizes = match smoothing.parts {
            Parts::All => Vec::new(),
            Parts::Refuse | Parts::Largest => largest_part(&mut inside, crop.size),
        };
        facts.parts = sizes.len();
        facts.dropped = sizes.iter().skip(1).sum();
        if sizes.len() > 1 && smoothing.parts == Parts::Refuse {
            return Err(NoRegion::Parts {
                label,
                count: sizes.len(),
                largest: sizes[0],
                next: sizes[1],
            });
        }
        facts.holes = fill_holes(&mut inside, crop.size, smoothing.fill_holes);
        facts.filled = smoothing.fill_holes;
        facts.voxels = inside.iter().filter(|i| **i).count();
        facts.volume = facts.voxels as f64 * map.spacing.product();
        let blurred = smooth::blurred(&inside, crop.size, passes);
        let spline = smooth::spline(blurred, crop.size, crop.origin(map), map.spacing, &inside);
        let spline = spline.ok_or_else(|| map.no_place())?;
        let moved = crop.moved(&spline, map, &inside);
        // The level keeps the volume of any shape: whether it is the label's own, its voxels say.
        if moved[0] as f64 > MOST_LOST * facts.voxels as f64 {
            return Err(NoRegion::Lost {
                label,
                sigma: smoothing.sigma,
                lost: moved[0],
                voxels: facts.voxels,
            });
        }
        facts.moved = moved;
        let corners = spline.corners();
        Ok(Self { spline, facts, corners })
    }
}

impl LabelMap<'_> {
    fn check(&self) -> Result<(), NoRegion> {
        let count = self.size[0]
            .checked_mul(self.size[1])
            .and_then(|c| c.checked_mul(self.size[2]));
        if count != Some(self.labels.len()) {
            return Err(NoRegion::Size {
                size: self.size,
                found: self.labels.len(),
            });
        }
        let good = self.origin.iter().all(|x| x.is_finite()) && self.spacing.iter().all(|s| s.is_finite() && *s > 0.0);
        if good { Ok(()) } else { Err(self.no_place()) }
    }

    fn no_place(&self) -> NoRegion {
        NoRegion::Place {
            origin: self.origin.into(),
            spacing: self.spacing.into(),
        }
    }

    fn at(&self, [i, j, k]: [usize; 3]) -> u16 {
        self.labels[(k * self.size[1] + j) * self.size[0] + i]
    }
}

impl Field for LabelField {
    fn value(&self, at: &Vector3<f64>) -> f64 {
        self.spline.value(at)
    }

    fn slope(&self, at: &Vector3<f64>) -> Vector3<f64> {
        self.spline.slope(at)
    }

    fn known(&self) -> Option<(f64, [Vector3<f64>; 2])> {
        Some((self.facts.volume, self.corners))
    }

    fn resolution(&self) -> f64 {
        self.spline.resolution()
    }

    fn bounds(&self, low: &Vector3<f64>, high: &Vector3<f64>) -> Bounds {
        self.spline.bounds(low, high)
    }

    fn slope_bounds(&self, low: &Vector3<f64>, high: &Vector3<f64>) -> [Bounds; 3] {
        self.spline.slope_bounds(low, high)
    }
}
