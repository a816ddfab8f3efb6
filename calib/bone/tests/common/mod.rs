//! Generated CTs of bodies in closed form. Nothing here knows the model that is fitted: bodies are rasterised several times finer than the
//! voxels, blurred in three dimensions by the voxel's own box and a Gaussian, and get noise that goes on from voxel to voxel.

use bone::Voxels;
use chance::SplitMix64;
use geometry::{Affine, Ct, Point, Vector, VolumeGrid, Voxel};

/// A bone's outer surface.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Body {
    Ball {
        radius: f64,
    },
    /// A rod with round ends along y.
    Capsule {
        radius: f64,
        half: f64,
    },
    Torus {
        ring: f64,
        tube: f64,
    },
    Ellipsoid {
        half: [f64; 3],
    },
    /// Four rods that run into one another, of 8 to 11 mm radius and 180 mm in all, as wide as a pelvis; nothing of it is symmetric. Its distance is exact
    /// where one rod is near, and its zero is the surface everywhere.
    Rods,
}

/// Ends and radii of the rods, mm.
const RODS: [([f64; 3], [f64; 3], f64); 4] = [
    ([-70.0, 0.0, 0.0], [70.0, 8.0, 0.0], 11.0),
    ([60.0, 8.0, 0.0], [75.0, 70.0, 40.0], 9.0),
    ([-62.0, 0.0, 0.0], [-80.0, 55.0, 60.0], 8.0),
    ([5.0, 0.0, 0.0], [-5.0, 25.0, -65.0], 10.0),
];

fn rod(p: [f64; 3], (a, b, radius): ([f64; 3], [f64; 3], f64)) -> f64 {
    let along = [0, 1, 2].map(|k| b[k] - a[k]);
    let length: f64 = along.iter().map(|x| x * x).sum();
    let share = ((0..3).map(|k| (p[k] - a[k]) * along[k]).sum::<f64>() / length).clamp(0.0, 1.0);
    (0..3)
        .map(|k| (p[k] - a[k] - share * along[k]).powi(2))
        .sum::<f64>()
        .sqrt()
        - radius
}

impl Body {
    /// Signed distance, above 0 outside; of an ellipsoid exact at the surface, and to first order beside it.
    pub(crate) fn distance(self, [x, y, z]: [f64; 3]) -> f64 {
        match self {
            Self::Ball { radius } => (x * x + y * y + z * z).sqrt() - radius,
            Self::Capsule { radius, half } => {
                let along = y - y.clamp(-half, half);
                (x * x + along * along + z * z).sqrt() - radius
            }
            Self::Torus { ring, tube } => (x.hypot(y) - ring).hypot(z) - tube,
            Self::Ellipsoid { half: [a, b, c] } => {
                let k0 = ((x / a).powi(2) + (y / b).powi(2) + (z / c).powi(2)).sqrt();
                let k1 = ((x / (a * a)).powi(2) + (y / (b * b)).powi(2) + (z / (c * c)).powi(2)).sqrt();
                if k1 < 1e-12 {
                    -a.min(b).min(c)
                } else {
                    k0 * (k0 - 1.0) / k1
                }
            }
            Self::Rods => {
                // A smooth minimum: where rods meet, the corner is rounded over 6 mm.
                let sum: f64 = RODS.iter().map(|r| (-rod([x, y, z], *r) / 3.0).exp()).sum();
                -3.0 * sum.ln()
            }
        }
    }

    fn half(self) -> [f64; 3] {
        match self {
            Self::Ball { radius } => [radius; 3],
            Self::Capsule { radius, half } => [radius, radius + half, radius],
            Self::Torus { ring, tube } => [ring + tube, ring + tube, tube],
            Self::Ellipsoid { half } => half,
            Self::Rods => [90.0, 80.0, 78.0],
        }
    }
}

impl Body {
    /// The gradient of the distance, by differences.
    pub(crate) fn gradient(self, p: [f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|k| {
            let at = |d: f64| {
                let mut q = p;
                q[k] += d;
                self.distance(q)
            };
            (at(1e-4) - at(-1e-4)) / 2e-4
        })
    }

    /// The place of the surface that a place is led to along the gradient.
    pub(crate) fn led(self, mut p: [f64; 3]) -> [f64; 3] {
        for _ in 0..12 {
            let (d, g) = (self.distance(p), self.gradient(p));
            let square: f64 = g.iter().map(|x| x * x).sum();
            p = [0, 1, 2].map(|k| p[k] - d * g[k] / square);
        }
        p
    }
}

/// How thick its cortex is.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Cortex {
    Even(f64),
    /// Between the two, in waves of about 15 mm along the surface.
    Waves(f64, f64),
}

impl Cortex {
    pub(crate) fn at(self, [x, y, z]: [f64; 3]) -> f64 {
        match self {
            Self::Even(mm) => mm,
            Self::Waves(least, most) => {
                let wave = (x / 5.0).sin() * (y / 6.0).cos() + (z / 5.5).sin();
                least + (most - least) * (0.5 + 0.25 * wave)
            }
        }
    }
}

/// What a CT shows.
#[derive(Debug, Clone)]
pub(crate) struct Scene {
    pub(crate) body: Body,
    pub(crate) cortex: Cortex,
    pub(crate) hu: [f64; 3],
    pub(crate) step_mm: [f64; 3],
    /// Deviation of the whole blur, the voxel's own box included.
    pub(crate) blur_mm: [f64; 2],
    pub(crate) noise_hu: f64,
    /// Turns the voxels' axes in the patient, rad.
    pub(crate) turn: [f64; 3],
    pub(crate) seed: u64,
    /// Around the body, mm.
    pub(crate) margin_mm: f64,
    /// Another bone: a ball, its middle and radius.
    pub(crate) other: Option<([f64; 3], f64)>,
    /// A vessel with contrast.
    pub(crate) vessel: Option<Vessel>,
}

/// A straight vessel with round ends, without a wall; where it meets bone, bone is.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Vessel {
    /// Middles of its ends, mm.
    pub(crate) ends: [[f64; 3]; 2],
    pub(crate) radius: f64,
    pub(crate) hu: f64,
}

impl Vessel {
    /// Signed distance, above 0 outside.
    pub(crate) fn distance(self, p: [f64; 3]) -> f64 {
        rod(p, (self.ends[0], self.ends[1], self.radius))
    }
}

impl Scene {
    pub(crate) fn new(body: Body, cortex: Cortex, step_mm: f64, blur_mm: f64) -> Self {
        Self {
            body,
            cortex,
            hu: [40.0, 1300.0, 200.0],
            step_mm: [step_mm; 3],
            blur_mm: [blur_mm; 2],
            noise_hu: 20.0,
            turn: [0.2, -0.3, 0.4],
            seed: 1,
            margin_mm: 9.0,
            other: None,
            vessel: None,
        }
    }

    /// The HU before any blur; `fine` is the width over which the raster mixes both sides of an interface, mm.
    fn hu_at(&self, p: [f64; 3], fine: f64) -> f64 {
        let mut d = self.body.distance(p);
        if let Some((middle, radius)) = self.other {
            d = d.min((0..3).map(|k| (p[k] - middle[k]).powi(2)).sum::<f64>().sqrt() - radius);
        }
        let t = self.cortex.at(p);
        let share = |d: f64| (0.5 - d / fine).clamp(0.0, 1.0);
        let (outer, inner) = (share(d), share(d + t));
        let [mut tissue, cortex, inside] = self.hu;
        if let Some(vessel) = self.vessel {
            tissue += (vessel.hu - tissue) * share(vessel.distance(p));
        }
        tissue + (cortex - tissue) * outer + (inside - cortex) * inner
    }
}

/// A CT in memory.
pub(crate) struct Dense {
    pub(crate) grid: VolumeGrid,
    pub(crate) hu: Vec<i16>,
}

impl Voxels for Dense {
    fn grid(&self) -> &VolumeGrid {
        &self.grid
    }

    fn row(&self, y: u32, z: u32, out: &mut [i16]) {
        let [nx, ny, _] = self.grid.dims().map(|d| d as usize);
        let first = (z as usize * ny + y as usize) * nx;
        out.copy_from_slice(&self.hu[first..first + nx]);
    }
}

/// Three axes at right angles, from a rotation vector.
fn axes(turn: [f64; 3]) -> [[f64; 3]; 3] {
    let turn = geometry::Rigid::<Ct, Ct>::from_rotation_vector(
        Vector::new(turn[0], turn[1], turn[2]),
        Vector::new(0.0, 0.0, 0.0),
    )
    .unwrap();
    [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|[x, y, z]| (turn * Point::new(x, y, z)).mm())
}

/// The grid that holds the body, its middle off the voxels.
pub(crate) fn grid(scene: &Scene) -> VolumeGrid {
    let axes = axes(scene.turn);
    let half = scene.body.half();
    let dims = [0, 1, 2].map(|k| {
        let reach: f64 = (0..3)
            .map(|i| half[i] * axes[k][i].abs())
            .sum::<f64>()
            .min(half.iter().fold(0.0, |m: f64, h| m.max(*h)));
        (2.0 * (reach + scene.margin_mm) / scene.step_mm[k]).ceil() as i64
    });
    let mut origin = [0.0; 3];
    for k in 0..3 {
        for i in 0..3 {
            origin[i] -= axes[k][i] * scene.step_mm[k] * (dims[k] as f64 / 2.0 - 0.37);
        }
    }
    let step = |k: usize| {
        let s = scene.step_mm[k];
        Vector::new(axes[k][0] * s, axes[k][1] * s, axes[k][2] * s)
    };
    let affine: Affine<Ct, Voxel> =
        Affine::from_steps(Point::new(origin[0], origin[1], origin[2]), [step(0), step(1), step(2)]);
    VolumeGrid::checked(dims, affine).unwrap()
}

/// The CT of a scene, on a grid.
pub(crate) fn scan(scene: &Scene, grid: VolumeGrid) -> Dense {
    let dims = grid.dims().map(|d| d as usize);
    // Under half of the blur: interfaces are mixed linearly over a fine step, which adds a twelfth of its square to the blur's, 1.7 % of it.
    let step = 0.45 * scene.blur_mm[0].min(scene.blur_mm[1]);
    let parts = scene.step_mm.map(|s| ((s / step).ceil() as usize).max(2));
    let fine = scene
        .step_mm
        .iter()
        .zip(parts)
        .map(|(s, n)| s / n as f64)
        .fold(0.0, f64::max);
    let pad = [0, 1, 2].map(|k| {
        let blur = scene.blur_mm[usize::from(k == 2)];
        (4.0 * blur / scene.step_mm[k]).ceil() as usize + 1
    });
    let affine = grid.ct_from_voxel();
    let count = [0, 1, 2].map(|k| (dims[k] + 2 * pad[k]) * parts[k]);
    let mut values = vec![0.0_f32; count.iter().product()];
    let index = |i: usize, k: usize| (i as f64 + 0.5) / parts[k] as f64 - 0.5 - pad[k] as f64;
    let mut at = 0;
    for z in 0..count[2] {
        for y in 0..count[1] {
            for x in 0..count[0] {
                let p = affine * Point::<Voxel>::new(index(x, 0), index(y, 1), index(z, 2));
                values[at] = scene.hu_at(p.mm(), fine) as f32;
                at += 1;
            }
        }
    }
    let mut size = count;
    for k in 0..3 {
        let own = scene.step_mm[k] / 12.0_f64.sqrt();
        let blur = scene.blur_mm[usize::from(k == 2)];
        let rest = (blur * blur - own * own).max(0.0).sqrt();
        let kernel = kernel(scene.step_mm[k] / parts[k] as f64, parts[k], rest);
        values = along(&values, &mut size, k, &kernel, parts[k], pad[k], dims[k]);
    }
    let noise = noise(scene, dims);
    let hu = values
        .iter()
        .zip(noise)
        .map(|(v, n)| (f64::from(*v) + n).round() as i16)
        .collect();
    Dense { grid, hu }
}

/// A box of `parts` fine steps with a Gaussian, by fine steps from its middle.
fn kernel(fine: f64, parts: usize, sigma: f64) -> Vec<f64> {
    let reach = (4.5 * sigma / fine).ceil() as i64 + parts as i64;
    let weight = |d: f64| {
        if sigma < 1e-9 {
            f64::from(u8::from(d.abs() < 0.5 * fine))
        } else {
            (-0.5 * (d / sigma).powi(2)).exp()
        }
    };
    // Fine samples of a voxel lie at -(n-1)/2..(n-1)/2 fine steps from its middle.
    let kernel: Vec<f64> = (-2 * reach..=2 * reach)
        .map(|twice| {
            let d = 0.5 * twice as f64 * fine;
            (0..parts)
                .map(|i| weight(d - (i as f64 - (parts as f64 - 1.0) / 2.0) * fine))
                .sum()
        })
        .collect();
    kernel
}

/// Blurs along one axis and keeps a sample a voxel.
fn along(
    values: &[f32],
    size: &mut [usize; 3],
    axis: usize,
    kernel: &[f64],
    parts: usize,
    pad: usize,
    voxels: usize,
) -> Vec<f32> {
    let stride: usize = size[..axis].iter().product();
    let (n, outer) = (size[axis], size[axis + 1..].iter().product::<usize>());
    let middle = (kernel.len() / 2) as i64;
    let mut out = vec![0.0_f32; stride * voxels * outer];
    for o in 0..outer {
        for v in 0..voxels {
            // Twice the fine index of the voxel's middle.
            let centre = 2 * ((v + pad) * parts) as i64 + parts as i64 - 1;
            let taps: Vec<(usize, f64)> = (0..n as i64)
                .filter_map(|i| {
                    let k = usize::try_from(2 * i - centre + middle).ok()?;
                    Some((i as usize, *kernel.get(k)?)).filter(|t| t.1 > 1e-7)
                })
                .collect();
            let sum: f64 = taps.iter().map(|t| t.1).sum();
            for (i, weight) in taps {
                let weight = (weight / sum) as f32;
                let (from, to) = ((o * n + i) * stride, (o * voxels + v) * stride);
                for s in 0..stride {
                    out[to + s] += weight * values[from + s];
                }
            }
        }
    }
    size[axis] = voxels;
    out
}

/// Noise whose neighbours go together by about 0.4 in the slice's plane.
fn noise(scene: &Scene, dims: [usize; 3]) -> Vec<f64> {
    let mut random = SplitMix64::new(scene.seed);
    let mut normal = || (0..12).map(|_| random.around(0.0, 0.5)).sum::<f64>();
    let white: Vec<f64> = (0..dims.iter().product()).map(|_| normal()).collect();
    let [nx, ny, _] = dims;
    let weights = [0.25_f64, 1.0, 0.25];
    let norm = weights.iter().map(|w| w * w).sum::<f64>().powi(2).sqrt();
    (0..white.len())
        .map(|at| {
            let (x, y, z) = (at % nx, at / nx % ny, at / (nx * ny));
            let mut sum = 0.0;
            for (j, wy) in weights.iter().enumerate() {
                for (i, wx) in weights.iter().enumerate() {
                    let (u, v) = ((x + i + nx - 1) % nx, (y + j + ny - 1) % ny);
                    sum += wx * wy * white[(z * ny + v) * nx + u];
                }
            }
            scene.noise_hu * sum / norm
        })
        .collect()
}
