//! Whether a card draws what the CPU draws: some pixels of each image, and whole small images before the first.
//!
//! The CPU's back end is the one that is compared with the f64 reference in tests, so agreement within both error bounds bounds the
//! distance from that reference too.

use std::fmt;

use bus::volume::VolumeView;
use chance::mix;
use geometry::{Affine, Direction, Point, SlicePlane, Vector, Voxel};
use scene::{Filter, Sampling};

use super::{Cpu, Resampler, ResliceError};

/// An image is cut into as many parts along each side, and one pixel of each part is computed again.
const PARTS: u32 = 4;
/// Two back ends may take a point within this distance of a border, or of the middle between two voxels, for one of either side,
/// voxels: their places are off by 2^-24 and 2^-25.
const TIE: f64 = 1.0 / (1 << 22) as f64;
/// Of [`Filter::Nearest`], one pixel in so many may differ: the mean of many points, of which two lie at ties on opposite sides.
const TIES: usize = 8;
/// The sides of the images that are compared whole, pixels.
const PROOF_SIDE: u32 = 24;
/// Where these look; the first is nearly along the axes, as most views are.
const PROOF_NORMALS: [[f64; 3]; 3] = [[0.02, 0.03, 1.0], [0.3, 0.5, 0.8], [1.0, -0.2, 0.1]];
/// The size of their pixels, mm: smaller than voxels, and as large as in a view of the whole patient.
const PROOF_PIXELS_MM: [f64; 2] = [0.3, 2.0];
/// How many images are compared for each way of sampling.
pub(super) const PROOFS: usize = PROOF_NORMALS.len() * PROOF_PIXELS_MM.len();

/// A pixel of which card and CPU say different things.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Deviation {
    pixel: [u32; 2],
    card_hu: f32,
    cpu_hu: f32,
    bound_hu: f64,
}

impl fmt::Display for Deviation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            pixel: [x, y],
            card_hu,
            cpu_hu,
            bound_hu,
        } = self;
        write!(
            f,
            "{card_hu:.2} HU at pixel {x}, {y}, the CPU has {cpu_hu:.2} (± {bound_hu:.4})"
        )
    }
}

/// What a card drew, to be compared.
#[derive(Debug, Clone, Copy)]
pub(super) struct Drawn<'a> {
    pub(super) volume: &'a VolumeView<'a>,
    pub(super) plane: &'a SlicePlane,
    pub(super) sampling: &'a Sampling,
    pub(super) hu: &'a [f32],
    /// The error bounds of both back ends together, HU.
    pub(super) bound_hu: f64,
}

impl Drawn<'_> {
    /// Compares one pixel of each part of the image; `seed` says which.
    ///
    /// # Errors
    /// The CPU's.
    pub(super) fn spot_check(&self, cpu: &mut Cpu, seed: u64) -> Result<Option<Deviation>, ResliceError> {
        let [width, height] = self.plane.size();
        let mut random = seed;
        let mut among = |part: u32, side: u32| {
            let (from, to) = (part * side / PARTS, (part + 1) * side / PARTS);
            random = mix(random);
            // Parts of an image of fewer than four pixels may be empty: then the pixel at their beginning.
            from + (random % u64::from((to - from).max(1))) as u32
        };
        let parts = (0..PARTS).flat_map(|y| (0..PARTS).map(move |x| [x, y]));
        let pixels: Vec<[u32; 2]> = parts.map(|[x, y]| [among(x, width), among(y, height)]).collect();
        self.compared(cpu, &pixels)
    }

    /// Compares every pixel.
    ///
    /// # Errors
    /// The CPU's.
    pub(super) fn check_all(&self, cpu: &mut Cpu) -> Result<Option<Deviation>, ResliceError> {
        let [width, height] = self.plane.size();
        let pixels: Vec<[u32; 2]> = (0..height).flat_map(|y| (0..width).map(move |x| [x, y])).collect();
        self.compared(cpu, &pixels)
    }

    fn compared(&self, cpu: &mut Cpu, pixels: &[[u32; 2]]) -> Result<Option<Deviation>, ResliceError> {
        let allowed = match self.sampling.filter {
            Filter::Nearest => pixels.len() / TIES,
            _ => 0,
        };
        let mut found = 0;
        for &pixel in pixels {
            if let Some(deviation) = self.deviation(cpu, pixel)? {
                found += 1;
                if found > allowed {
                    return Ok(Some(deviation));
                }
            }
        }
        Ok(None)
    }

    fn deviation(&self, cpu: &mut Cpu, pixel: [u32; 2]) -> Result<Option<Deviation>, ResliceError> {
        let card_hu = self.hu[(pixel[1] * self.plane.size()[0] + pixel[0]) as usize];
        let cpu_hu = self.by_cpu(cpu, pixel, [0.0; 3])?;
        // A value that is no number is near to none.
        let is_near = |cpu_hu: f32| (f64::from(card_hu) - f64::from(cpu_hu)).abs() <= self.bound_hu;
        if is_near(cpu_hu) {
            return Ok(None);
        }
        for corner in 0..8 {
            // A point may be at a tie on one axis or on several: all corners about it.
            let off = [0, 1, 2].map(|axis| if corner >> axis & 1 == 0 { -TIE } else { TIE });
            if is_near(self.by_cpu(cpu, pixel, off)?) {
                return Ok(None);
            }
        }
        Ok(Some(Deviation {
            pixel,
            card_hu,
            cpu_hu,
            bound_hu: self.bound_hu,
        }))
    }

    /// The pixel, moved by `off` voxels, as the CPU draws it.
    fn by_cpu(&self, cpu: &mut Cpu, [x, y]: [u32; 2], off: [f64; 3]) -> Result<f32, ResliceError> {
        let ct_from_voxel: Affine<_, Voxel> = self.volume.grid.ct_from_voxel();
        let off = ct_from_voxel * Vector::<Voxel>::new(off[0], off[1], off[2]);
        let centre = self.plane.point(f64::from(x), f64::from(y)) + off;
        let axes = [self.plane.right(), self.plane.down()];
        let alone = SlicePlane::centred(centre, axes, self.plane.pixel_mm(), [1, 1]);
        // A pixel of a plane that was drawn can be drawn.
        let alone = alone.map_err(|error| ResliceError::Gpu(error.to_string()))?;
        let mut hu = [f32::NAN];
        cpu.reslice(self.volume, &alone, self.sampling, &mut hu)?;
        Ok(hu[0])
    }
}

/// The plane of proof number `number` below [`PROOFS`], about the middle of `volume`.
pub(super) fn proof_plane(volume: &VolumeView<'_>, number: usize) -> Option<SlicePlane> {
    let [x, y, z] = PROOF_NORMALS[number % PROOF_NORMALS.len()];
    let pixel_mm = PROOF_PIXELS_MM[number / PROOF_NORMALS.len() % PROOF_PIXELS_MM.len()];
    let into = Vector::new(x, y, z).direction()?;
    let right = into.cross(Direction::Y).direction()?;
    let down = into.cross(right).direction()?;
    let middle = volume.grid.dims().map(|n| f64::from(n) / 2.0 - 0.37);
    let centre = volume.grid.ct_from_voxel() * Point::new(middle[0], middle[1], middle[2]);
    SlicePlane::centred(centre, [right, down], pixel_mm, [PROOF_SIDE; 2]).ok()
}
