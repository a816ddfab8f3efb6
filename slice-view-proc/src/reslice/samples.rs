//! Where the points of an image lie in the volume.

use bus::volume::VolumeView;
use geometry::{Affine, Ct, SlicePlane, Vector, Voxel};
use scene::{Minify, Sampling, Slab};

/// A step this little longer than one voxel counts as one: rounding must not double the work.
const ONE_VOXEL: f64 = 1.0 + 1e-6;

/// The points at which an image samples the volume, in continuous voxel indices.
///
/// Pixel (column c, row r) owns the points `origin + (c kx + i) right + (r ky + j) down + d into` with 0 <= i < kx, 0 <=
/// j < ky and 0 <= d < depths, where (kx, ky) is [`Samples::fold`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Samples {
    /// The first point.
    pub origin: [f64; 3],
    /// From one point to the next along a row.
    pub right: [f64; 3],
    /// From one row of points to the next.
    pub down: [f64; 3],
    /// From one depth to the next, away from the viewer.
    pub into: [f64; 3],
    /// Points of one pixel along rows and columns.
    pub fold: [u32; 2],
    /// Layers of points through the slab.
    pub depths: u32,
}

impl Samples {
    /// The points of `plane` under `sampling`.
    ///
    /// A pixel (a slab) whose side is m voxels on its longest axis has ceil(m) points along it, at the middles of as many
    /// equal parts.
    pub fn new(volume: &VolumeView<'_>, plane: &SlicePlane, sampling: &Sampling) -> Self {
        let voxel_from_ct = volume.grid.voxel_from_ct();
        let (right, down) = (plane.step_right(), plane.step_down());
        let fold = match sampling.minify {
            Minify::Point => [1, 1],
            Minify::Area => [right, down].map(|side| parts(&voxel_from_ct, side)),
        };
        let (depths, into) = layers(&voxel_from_ct, plane, sampling.slab);
        let index = |v: Vector<Ct>| (voxel_from_ct * v).mm();
        let (right, down) = (right * (1.0 / f64::from(fold[0])), down * (1.0 / f64::from(fold[1])));
        // From a pixel's centre to its first point: half of all the steps between its points, backwards.
        let back = |count: u32| -0.5 * (f64::from(count) - 1.0);
        let first = plane.origin() + right * back(fold[0]) + down * back(fold[1]) + into * back(depths);
        Self {
            origin: (voxel_from_ct * first).mm(),
            right: index(right),
            down: index(down),
            into: index(into),
            fold,
            depths,
        }
    }

    /// The index of the point in column `x`, row `y` and layer `d` of points.
    pub fn at(&self, x: f64, y: f64, d: f64) -> [f64; 3] {
        std::array::from_fn(|a| self.origin[a] + self.right[a] * x + self.down[a] * y + self.into[a] * d)
    }

    /// Whether each pixel is a single point.
    pub fn are_pixels(&self) -> bool {
        self.fold == [1, 1] && self.depths == 1
    }
}

/// Into how many parts a side is cut so that none is longer than a voxel on any axis.
fn parts(voxel_from_ct: &Affine<Voxel, Ct>, side: Vector<Ct>) -> u32 {
    let longest = (*voxel_from_ct * side)
        .mm()
        .into_iter()
        .map(f64::abs)
        .fold(0.0, f64::max);
    // At least one point; the upper end keeps a pixel far larger than the volume from endless work.
    (longest / ONE_VOXEL).ceil().clamp(1.0, f64::from(u16::MAX)) as u32
}

fn layers(voxel_from_ct: &Affine<Voxel, Ct>, plane: &SlicePlane, slab: Option<Slab>) -> (u32, Vector<Ct>) {
    let Some(slab) = slab else {
        return (1, Vector::new(0.0, 0.0, 0.0));
    };
    let through = plane.into_screen() * slab.thickness_mm;
    let depths = parts(voxel_from_ct, through);
    (depths, through * (1.0 / f64::from(depths)))
}
