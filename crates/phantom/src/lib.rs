//! The generated patient: an analytic trunk whose true HU is known at every point.
//!
//! It is the oracle of every accuracy test: whatever reads, stores, reslices or shows a volume can be held against
//! [`Phantom::hu`], which knows no voxels. Lengths are mm, axes LPS (+x to the patient's left, +y to the back, +z up), and
//! z = 0 is the middle of the fifth lumbar vertebra. The patient is about 335 mm wide, 230 mm deep and 340 mm tall, cut
//! off flat at z = -130 and z = 210 as a scan cuts, with air around.
//!
//! Solids are painted one over another: `value + (solid - value) * coverage`, where coverage climbs from 0 to 1 along a
//! quintic ramp across the solid's surface, 1.6 mm wide for tissues and 1 mm for nodes and beads: the scanner's blur. The
//! field is therefore twice continuously differentiable almost everywhere and once at the joints of a vessel.
//!
//! ```
//! let patient = phantom::Phantom::new(phantom::DEFAULT_SEED);
//! let node = &patient.targets()[0];
//! assert_eq!(patient.hu(node.centre), 60.0);
//! let grid = patient.grid(phantom::DEFAULT_SPACING_MM)?;
//! let [nx, ny, nz] = grid.dims();
//! let mut slice = vec![0_i16; (nx * ny) as usize];
//! patient.fill_slice(&grid, nz / 2, &mut slice);
//! # Ok::<(), geometry::GridError>(())
//! ```

mod anatomy;
mod canvas;
mod landmark;
mod plan;
mod raster;
pub mod structure;
mod surface;
mod trunk;
mod vec3;

use geometry::{Affine, Ct, GridError, Point, Vector, VolumeGrid};

use canvas::Canvas;
pub use landmark::{Approach, Landmark};
use plan::Plan;

/// The seed of the patient that demonstrations show.
pub const DEFAULT_SEED: u64 = 1;
/// The default distance between voxels along each axis, mm: 240 x 168 x 232 voxels, 19 MB.
pub const DEFAULT_SPACING_MM: [f64; 3] = [1.5; 3];
/// HU of the air around the patient, exactly, wherever nothing is painted.
pub const AIR_HU: f64 = canvas::AIR_HU;
/// The box that [`Phantom::grid`] covers, mm: every seed's patient and at least 4 mm of air on each side.
const FIELD_MM: [[f64; 2]; 3] = [[-180.0, 180.0], [-126.0, 126.0], [-134.0, 214.0]];

/// One generated patient.
#[derive(Debug, Clone)]
pub struct Phantom {
    canvas: Canvas,
    targets: Vec<Landmark>,
    beads: Vec<Landmark>,
    approach: Approach,
}

impl Phantom {
    /// The patient of this seed: the same anatomy in slightly different measures, contrast and loops of bowel.
    pub fn new(seed: u64) -> Self {
        let plan = Plan::new(seed);
        let mut canvas = anatomy::paint(&plan);
        let targets = landmark::nodes(&plan);
        let beads = landmark::beads(&plan);
        landmark::paint(&mut canvas, landmark::NODE_HU, &targets, &structure::NODES);
        landmark::paint(&mut canvas, landmark::BEAD_HU, &beads, &[]);
        let approach = landmark::approach(&plan, &targets);
        Self {
            canvas,
            targets,
            beads,
            approach,
        }
    }

    /// The true HU at `p`; [`AIR_HU`] outside the patient and where `p` is not finite.
    pub fn hu(&self, p: Point<Ct>) -> f64 {
        self.canvas.hu(p.mm())
    }

    /// The structure that `p` lies in, as [`structure`] numbers them; 0 for none of them, and where `p` is not finite.
    pub fn structure(&self, p: Point<Ct>) -> u16 {
        self.canvas.structure(p.mm())
    }

    /// Five lymph nodes of 5 mm in fat, beside the great vessels.
    pub fn targets(&self) -> &[Landmark] {
        &self.targets
    }

    /// Eight metal beads of 2 mm on the skin.
    pub fn beads(&self) -> &[Landmark] {
        &self.beads
    }

    /// A straight way to one of the targets that meets neither bone, vessel, kidney nor gas.
    pub fn approach(&self) -> Approach {
        self.approach.clone()
    }

    /// A grid along the patient's axes, centred on the patient, with air on every side; dimensions are multiples of 4.
    ///
    /// # Errors
    /// [`GridError`] where a spacing is not finite, not positive or far from a scanner's.
    pub fn grid(&self, spacing_mm: [f64; 3]) -> Result<VolumeGrid, GridError> {
        let mut dims = [0_i64; 3];
        let mut origin = [0.0; 3];
        for i in 0..3 {
            let [low, high] = FIELD_MM[i];
            // A spacing of zero or NaN makes a count that saturates or is zero; the grid's own checks name it.
            dims[i] = (((high - low) / spacing_mm[i] / 4.0).ceil() as i64).saturating_mul(4);
            origin[i] = (low + high) / 2.0 - spacing_mm[i] * (dims[i] as f64 - 1.0) / 2.0;
        }
        let [x, y, z] = origin;
        let [sx, sy, sz] = spacing_mm;
        let steps = [
            Vector::new(sx, 0.0, 0.0),
            Vector::new(0.0, sy, 0.0),
            Vector::new(0.0, 0.0, sz),
        ];
        VolumeGrid::checked(dims, Affine::from_steps(Point::new(x, y, z), steps))
    }

    /// Slice `k` of `grid`: [`Phantom::hu`] at each voxel's centre, rounded to the nearest, halves away from zero.
    ///
    /// `out` is row-major, x fastest, `dims[0] * dims[1]` values; rows beyond a shorter `out` are left out and values
    /// beyond the slice are left alone. Any grid will do, tilted and sheared ones too.
    pub fn fill_slice(&self, grid: &VolumeGrid, k: u32, out: &mut [i16]) {
        raster::fill_slice(&self.canvas, grid, k, out);
    }

    /// The same of [`Phantom::structure`]: a label map's slice.
    pub fn fill_structures(&self, grid: &VolumeGrid, k: u32, out: &mut [i16]) {
        raster::fill_structures(&self.canvas, grid, k, out);
    }
}
