//! Volumes with beads whose centres are known, written by the project's own writer.

use std::path::Path;

use bus::volume::OwnedVolume;
use geometry::{Affine, Point, VolumeGrid};
use volume_loader::WriteOptions;
use volume_loader::source::{Conversion, ReadError, VoxelSource};

/// Deviation of the scanner's blur, mm, and where it clips.
const BLUR_MM: f64 = 0.45;
const CLIP_HU: f64 = 3071.0;

#[derive(Debug, Clone, Copy)]
pub(crate) struct Bead {
    /// In the patient, mm.
    pub(crate) centre: [f64; 3],
    pub(crate) radius: f64,
    /// Over what is around.
    pub(crate) metal_hu: f64,
}

/// A volume in memory as a source of slices.
pub(crate) struct Planted {
    grid: VolumeGrid,
    values: Vec<f64>,
}

impl Planted {
    /// Water with noise about the patient's origin.
    pub(crate) fn water(spacing: [f64; 3], dims: [u32; 3], beads: &[Bead]) -> Self {
        let rows = [0, 1, 2].map(|a| {
            let mut row = [0.0; 4];
            row[a] = spacing[a];
            row[3] = -0.5 * spacing[a] * f64::from(dims[a] - 1);
            row
        });
        let grid = VolumeGrid::checked(dims.map(i64::from), Affine::from_rows(rows)).unwrap();
        let mut state = 1_u64;
        let noise = |_: u64| {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            40.0 * ((state >> 40) as f64 / f64::from(1 << 24) - 0.5)
        };
        let values = (0..grid.voxels()).map(noise).collect();
        Self::with(grid, values, beads)
    }

    /// A real volume, beads added.
    pub(crate) fn in_volume(volume: &OwnedVolume, beads: &[Bead]) -> Self {
        let [nx, ny, nz] = volume.grid.dims();
        let view = volume.view();
        let all = (0..nz).flat_map(|z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z])));
        let values = all.map(|voxel| f64::from(view.at(voxel))).collect();
        Self::with(volume.grid, values, beads)
    }

    fn with(grid: VolumeGrid, values: Vec<f64>, beads: &[Bead]) -> Self {
        let mut planted = Self { grid, values };
        beads.iter().for_each(|bead| planted.add(bead));
        planted
    }

    /// A ball of small cubes, each seen through the blur; along the slices' normal the blur is 0.4 of a step at least.
    fn add(&mut self, bead: &Bead) {
        let spacing = self.grid.spacing_mm();
        let sigma = spacing.map(|s| f64::max(BLUR_MM, 0.4 * s));
        let dims = self.grid.dims();
        let [x, y, z] = bead.centre;
        let middle = (self.grid.voxel_from_ct() * Point::new(x, y, z)).mm();
        let range = |a: usize| {
            let reach = (bead.radius + 4.0 * sigma[a]) / spacing[a];
            let low = (middle[a] - reach).ceil().max(0.0) as u32;
            low..((middle[a] + reach).floor() as u32 + 1).min(dims[a])
        };
        let n = 12;
        let step = 2.0 * bead.radius / f64::from(n);
        let part = |i: i32| (f64::from(i) + 0.5) * step - bead.radius;
        let cubes = (0..n * n * n).map(|i| [i % n, i / n % n, i / n / n].map(part));
        let cubes: Vec<[f64; 3]> = cubes
            .filter(|c| c.iter().map(|u| u * u).sum::<f64>() <= bead.radius.powi(2))
            .collect();
        // The cubes have the ball's volume.
        let ball = 4.0 / 3.0 * std::f64::consts::PI * bead.radius.powi(3);
        let each = bead.metal_hu * ball / cubes.len() as f64;
        for k in range(2) {
            for j in range(1) {
                for i in range(0) {
                    let at = (self.grid.ct_from_voxel() * Point::new(f64::from(i), f64::from(j), f64::from(k))).mm();
                    let d = [0, 1, 2].map(|a| at[a] - bead.centre[a]);
                    let seen: f64 = cubes.iter().map(|c| density(d, *c, sigma)).sum();
                    let [nx, ny, _] = dims.map(|d| d as usize);
                    self.values[(k as usize * ny + j as usize) * nx + i as usize] += each * seen;
                }
            }
        }
    }

    pub(crate) fn write(mut self, path: &Path) {
        volume_loader::metaimage::write(path, &mut self, WriteOptions::default()).unwrap();
    }
}

fn density(d: [f64; 3], c: [f64; 3], sigma: [f64; 3]) -> f64 {
    let square: f64 = (0..3).map(|a| ((d[a] - c[a]) / sigma[a]).powi(2)).sum();
    let norm: f64 = sigma.iter().product::<f64>() * std::f64::consts::TAU.powf(1.5);
    (-0.5 * square).exp() / norm
}

impl VoxelSource for Planted {
    fn grid(&self) -> &VolumeGrid {
        &self.grid
    }

    fn padding_hu(&self) -> i16 {
        -1024
    }

    fn describe(&self) -> String {
        "planted beads".to_owned()
    }

    fn read_slice(&mut self, k: u32, out: &mut [i16]) -> Result<(), ReadError> {
        let start = k as usize * out.len();
        for (out, value) in out.iter_mut().zip(&self.values[start..]) {
            *out = value.min(CLIP_HU).round() as i16;
        }
        Ok(())
    }

    fn finish(&mut self) -> Result<Conversion, ReadError> {
        Ok(Conversion::default())
    }
}
