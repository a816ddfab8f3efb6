//! Beads in a volume by quadrature that shares nothing with the model: thin columns of metal, each blurred in closed form.

use geometry::{Affine, VolumeGrid};

use crate::Dense;

/// Numbers in 0..1, the same in every run.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(super) fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Normal, by Box and Muller.
    pub(crate) fn normal(&mut self) -> f64 {
        let length = (-2.0 * (1.0 - self.next()).ln()).sqrt();
        length * (std::f64::consts::TAU * self.next()).cos()
    }
}

/// The integral of the normal density, to 1e-12, by the series of Marsaglia (2004).
pub(super) fn phi(x: f64) -> f64 {
    if x.abs() > 7.0 {
        return f64::from(u8::from(x > 0.0));
    }
    let (mut sum, mut term, mut i) = (x, x, 1.0);
    while f64::abs(term) > 1e-17 * sum.abs() {
        i += 2.0;
        term *= x * x / i;
        sum += term;
    }
    0.5 + sum * density(x)
}

fn density(x: f64) -> f64 {
    (-0.5 * x * x).exp() / std::f64::consts::TAU.sqrt()
}

/// The scanner: voxels along x, y and z, its Gaussian, and whether a voxel is the mean over its own extent besides.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scanner {
    pub(super) voxel_mm: [f64; 3],
    pub(super) sigma_mm: [f64; 2],
    pub(super) boxed: bool,
    pub(super) noise_hu: f64,
    pub(super) clip_hu: f64,
}

impl Scanner {
    /// The scanner of the table of simple methods: 0.45 mm, and 0.4 of a slice where that is more.
    pub(super) fn of(voxel_mm: [f64; 3]) -> Self {
        Self {
            voxel_mm,
            sigma_mm: [0.45, f64::max(0.45, 0.4 * voxel_mm[2])],
            boxed: false,
            noise_hu: 10.0,
            clip_hu: 32_767.0,
        }
    }

    /// Voxels of a volume, HU before noise and clipping.
    pub(super) fn empty(&self, dims: [u32; 3], ground_hu: f64) -> Image {
        Image {
            scanner: *self,
            dims: dims.map(|d| d as usize),
            values: vec![ground_hu; dims.iter().map(|d| *d as usize).product()],
        }
    }
}

pub(super) struct Image {
    scanner: Scanner,
    pub(super) dims: [usize; 3],
    pub(super) values: Vec<f64>,
}

impl Image {
    /// Adds `metal_hu` within the solid `height(x, y)` above and below the centre's plane, blurred; mm.
    pub(super) fn add(&mut self, centre: [f64; 3], reach: f64, metal_hu: f64, height: impl Fn(f64, f64) -> f64) {
        let columns = 60;
        let step = 2.0 * reach / f64::from(columns);
        for i in 0..columns {
            for j in 0..columns {
                let [x, y] = [i, j].map(|k| (f64::from(k) + 0.5) * step - reach);
                let h = height(x, y);
                if h > 0.0 {
                    self.column([centre[0] + x, centre[1] + y, centre[2]], h, metal_hu * step * step);
                }
            }
        }
    }

    /// A ball.
    pub(super) fn bead(&mut self, centre: [f64; 3], radius: f64, metal_hu: f64) {
        self.add(centre, radius, metal_hu, |x, y| {
            (radius * radius - x * x - y * y).max(0.0).sqrt()
        });
    }

    fn column(&mut self, [x, y, z]: [f64; 3], h: f64, weight: f64) {
        let [dx, dy, dz] = self.scanner.voxel_mm;
        let [plane, axial] = self.scanner.sigma_mm;
        let boxed = self.scanner.boxed;
        let across = |centre: f64, d: f64, n: usize| -> Vec<f64> {
            let at = |i: usize| {
                let u = i as f64 * d - centre;
                match boxed {
                    true => (phi((u + d / 2.0) / plane) - phi((u - d / 2.0) / plane)) / d,
                    false => density(u / plane) / plane,
                }
            };
            (0..n).map(at).collect()
        };
        let psi = |u: f64| u * phi(u / axial) + axial * density(u / axial);
        let along = |k: usize| {
            let u = k as f64 * dz - z;
            match boxed {
                true => {
                    (psi(u + h + dz / 2.0) - psi(u + h - dz / 2.0) - psi(u - h + dz / 2.0) + psi(u - h - dz / 2.0)) / dz
                }
                false => phi((u + h) / axial) - phi((u - h) / axial),
            }
        };
        let [nx, ny, nz] = self.dims;
        let (gx, gy) = (across(x, dx, nx), across(y, dy, ny));
        for k in 0..nz {
            let ez = along(k) * weight;
            if ez < 1e-9 {
                continue;
            }
            let slice = &mut self.values[k * ny * nx..][..ny * nx];
            for (row, along_y) in slice.chunks_exact_mut(nx).zip(&gy) {
                let ezy = ez * along_y;
                row.iter_mut().zip(&gx).for_each(|(v, g)| *v += ezy * g);
            }
        }
    }

    /// With noise, rounded and clipped; `rows` places it in the patient, the scanner's steps where there are none.
    pub(super) fn volume(&self, random: &mut Random, rows: Option<[[f64; 4]; 3]>) -> Dense {
        let [dx, dy, dz] = self.scanner.voxel_mm;
        let straight = [[dx, 0.0, 0.0, 0.0], [0.0, dy, 0.0, 0.0], [0.0, 0.0, dz, 0.0]];
        let grid =
            VolumeGrid::checked(self.dims.map(|d| d as i64), Affine::from_rows(rows.unwrap_or(straight))).unwrap();
        let value = |v: &f64| {
            (v + self.scanner.noise_hu * random.normal())
                .min(self.scanner.clip_hu)
                .round() as i16
        };
        Dense::new(grid, self.values.iter().map(value).collect()).unwrap()
    }
}
