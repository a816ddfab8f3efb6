//! Places of a real CT where beads may be put, by what lies there, and beads put there.

use bead::{Dense, Voxels};
use geometry::{Point, VolumeGrid};

/// Deviation of the scanner's blur, mm, the least share of a slice, and where it clips.
const BLUR_MM: f64 = 0.45;
const BLUR_PER_STEP: f64 = 0.4;
const CLIP_HU: f64 = 3071.0;
/// HU from which a voxel is bone, and metal.
const BONE_HU: i16 = 350;
const METAL_HU: i16 = 1700;
/// How far metal must be, mm, and how far bone is looked for.
const METAL_MM: f64 = 12.0;
const BONE_MM: f64 = 8.0;

/// What lies at a place: name, HU, and distance of its middle from the nearest voxel of bone, mm.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Kind {
    pub(crate) name: &'static str,
    hu: [i16; 2],
    bone_mm: [f64; 2],
}

const FAR: [f64; 2] = [BONE_MM, f64::INFINITY];
/// The kinds of the table.
pub(crate) const KINDS: [Kind; 7] = [
    Kind {
        name: "soft tissue",
        hu: [-20, 120],
        bone_mm: FAR,
    },
    Kind {
        name: "fat",
        hu: [-150, -50],
        bone_mm: FAR,
    },
    Kind {
        name: "lung",
        hu: [-980, -700],
        bone_mm: FAR,
    },
    Kind {
        name: "bone at 0.5 to 1.5 mm",
        hu: [-150, 150],
        bone_mm: [0.5, 1.5],
    },
    Kind {
        name: "bone at 1.5 to 2.5 mm",
        hu: [-150, 150],
        bone_mm: [1.5, 2.5],
    },
    Kind {
        name: "bone at 2.5 to 3.5 mm",
        hu: [-150, 150],
        bone_mm: [2.5, 3.5],
    },
    Kind {
        name: "bone at 3.5 to 5 mm",
        hu: [-150, 150],
        bone_mm: [3.5, 5.0],
    },
];

/// A place for a bead: anywhere within a voxel of its kind.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Site {
    pub(crate) kind: usize,
    /// mm.
    pub(crate) centre: [f64; 3],
}

/// Numbers below a bound, the same in every run.
struct Random(u64);

impl Random {
    fn below(&mut self, n: u32) -> u32 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as u32 % n
    }
}

/// Offsets of all voxels within a radius, and their lengths, mm.
fn within(grid: &VolumeGrid, radius_mm: f64) -> Vec<([i32; 3], f64)> {
    let spacing = grid.spacing_mm();
    let reach = spacing.map(|s| (1.2 * radius_mm / s).ceil() as i32);
    let rows = grid.ct_from_voxel().rows();
    let mut all = Vec::new();
    for k in -reach[2]..=reach[2] {
        for j in -reach[1]..=reach[1] {
            for i in -reach[0]..=reach[0] {
                let o = [i, j, k].map(f64::from);
                let mm = [0, 1, 2].map(|a| (0..3).map(|b| rows[a][b] * o[b]).sum::<f64>());
                let length = mm.iter().map(|c| c * c).sum::<f64>().sqrt();
                if length <= radius_mm {
                    all.push(([i, j, k], length));
                }
            }
        }
    }
    all.sort_by(|a, b| a.1.total_cmp(&b.1));
    all
}

fn moved(grid: &VolumeGrid, at: [u32; 3], offset: [i32; 3]) -> Option<[u32; 3]> {
    let mut place = [0; 3];
    for a in 0..3 {
        place[a] = at[a].checked_add_signed(offset[a]).filter(|i| *i < grid.dims()[a])?;
    }
    Some(place)
}

/// The distance of the nearest voxel of at least so many HU, mm.
fn nearest(volume: &Dense, at: [u32; 3], hu: i16, around: &[([i32; 3], f64)]) -> f64 {
    let bright = |o: &&([i32; 3], f64)| moved(volume.grid(), at, o.0).is_some_and(|v| volume.at(v) >= hu);
    around.iter().find(bright).map_or(f64::INFINITY, |o| o.1)
}

/// Up to `count` places of each kind, at least `apart_mm` from each other.
pub(crate) fn sites(volume: &Dense, count: usize, apart_mm: f64, seed: u64) -> Vec<Site> {
    let grid = *volume.grid();
    let (bone, metal) = (within(&grid, BONE_MM), within(&grid, METAL_MM));
    let mut random = Random(seed);
    let mut found: Vec<Site> = Vec::new();
    let mut counts = [0; KINDS.len()];
    // The edge of the volume is left out: there part of the surroundings is missing.
    let margin = grid.spacing_mm().map(|s| (6.0 / s).ceil() as u32);
    let free = [0, 1, 2].map(|a| grid.dims()[a].saturating_sub(2 * margin[a]).max(1));
    for _ in 0..4_000_000 {
        let voxel = [0, 1, 2].map(|a| margin[a].min(grid.dims()[a] - 1) + random.below(free[a]));
        let hu = volume.at(voxel);
        let wanted = |k: &usize| counts[*k] < count && (KINDS[*k].hu[0]..KINDS[*k].hu[1]).contains(&hu);
        if !(0..KINDS.len()).any(|k| wanted(&k)) {
            continue;
        }
        let far = nearest(volume, voxel, BONE_HU, &bone);
        let near = |k: &usize| (KINDS[*k].bone_mm[0]..KINDS[*k].bone_mm[1]).contains(&far.min(1e3));
        let Some(kind) = (0..KINDS.len()).find(|k| wanted(k) && near(k)) else {
            continue;
        };
        let index = voxel.map(|i| f64::from(i) + f64::from(random.below(1000)) / 1000.0 - 0.5);
        let centre = (grid.ct_from_voxel() * Point::new(index[0], index[1], index[2])).mm();
        let lone = found.iter().all(|s| distance(&s.centre, &centre) > apart_mm);
        if lone && nearest(volume, voxel, METAL_HU, &metal).is_infinite() {
            counts[kind] += 1;
            found.push(Site { kind, centre });
        }
    }
    found
}

/// mm.
pub(crate) fn distance(p: &[f64; 3], q: &[f64; 3]) -> f64 {
    (0..3).map(|a| (p[a] - q[a]).powi(2)).sum::<f64>().sqrt()
}

/// The volume with a body of metal at each place instead of what was there, seen through the blur, and clipped.
pub(crate) fn planted(volume: &Dense, sites: &[Site], body: &Body, metal_hu: f64) -> Dense {
    let grid = *volume.grid();
    let [nx, ny, nz] = grid.dims();
    let all = (0..nz).flat_map(|z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z])));
    // A scanner that clips does so everywhere.
    let mut values: Vec<i16> = all.map(|voxel| volume.at(voxel).min(CLIP_HU as i16)).collect();
    let scanner = Scanner::of(&grid);
    let around = within(&grid, body.reach_mm + 4.5 * scanner.plane_mm.max(scanner.axial_mm));
    for site in sites {
        let [x, y, z] = site.centre;
        let middle = (grid.voxel_from_ct() * Point::new(x, y, z))
            .mm()
            .map(|c| c.round() as u32);
        for voxel in around.iter().filter_map(|o| moved(&grid, middle, o.0)) {
            let [i, j, k] = voxel.map(f64::from);
            let at = (grid.ct_from_voxel() * Point::new(i, j, k)).mm();
            let d = [0, 1, 2].map(|a| at[a] - site.centre[a]);
            let share = body.each * body.parts.iter().map(|p| scanner.density(d, *p)).sum::<f64>();
            let value = &mut values[((voxel[2] * ny + voxel[1]) * nx + voxel[0]) as usize];
            let seen = (1.0 - share) * f64::from(*value) + share * metal_hu;
            *value = seen.min(CLIP_HU).round() as i16;
        }
    }
    Dense::new(grid, values).unwrap()
}

/// A body as small cubes.
pub(crate) struct Body {
    /// Their middles about the place, mm.
    parts: Vec<[f64; 3]>,
    /// The volume of each, mm^3.
    each: f64,
    /// How far it reaches, mm.
    reach_mm: f64,
}

impl Body {
    pub(crate) fn ball(radius: f64) -> Self {
        let squares = |c: &[f64; 3]| c.iter().map(|u| u * u).sum::<f64>();
        let mut ball = Self::cut([radius; 3], 2.0 * radius / 12.0, |c| squares(c) <= radius * radius);
        // The cubes have the ball's volume.
        ball.each = 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3) / ball.parts.len() as f64;
        ball
    }

    /// What of a box lies within, in cubes of `step`.
    pub(crate) fn cut(half_mm: [f64; 3], step: f64, within: impl Fn(&[f64; 3]) -> bool) -> Self {
        let counts = half_mm.map(|h| (2.0 * h / step).round().max(1.0) as i32);
        let part = |i: i32, a: usize| (f64::from(i) + 0.5) * step - 0.5 * step * f64::from(counts[a]);
        let [nx, ny, nz] = counts;
        let cubes = (0..nx * ny * nz).map(|i| [part(i % nx, 0), part(i / nx % ny, 1), part(i / nx / ny, 2)]);
        Self {
            parts: cubes.filter(within).collect(),
            each: step.powi(3),
            reach_mm: half_mm.iter().map(|h| h * h).sum::<f64>().sqrt(),
        }
    }
}

/// A Gaussian that is round in the slices' plane.
struct Scanner {
    normal: [f64; 3],
    plane_mm: f64,
    axial_mm: f64,
}

impl Scanner {
    fn of(grid: &VolumeGrid) -> Self {
        let rows = grid.ct_from_voxel().rows();
        let [x, y, z] = [0, 1, 2].map(|a| [rows[0][a], rows[1][a], rows[2][a]]);
        let cross = [
            x[1] * y[2] - x[2] * y[1],
            x[2] * y[0] - x[0] * y[2],
            x[0] * y[1] - x[1] * y[0],
        ];
        let length = dot(&cross, &cross).sqrt();
        let normal = cross.map(|c| c / length);
        let blur = |step: f64| BLUR_MM.max(BLUR_PER_STEP * step);
        Self {
            normal,
            plane_mm: blur(grid.spacing_mm()[0]),
            axial_mm: blur(dot(&normal, &z).abs()),
        }
    }

    fn density(&self, d: [f64; 3], c: [f64; 3]) -> f64 {
        let e = [0, 1, 2].map(|a| d[a] - c[a]);
        let along = dot(&e, &self.normal);
        let (p, a) = (self.plane_mm, self.axial_mm);
        let square = (dot(&e, &e) - along * along) / (p * p) + (along / a).powi(2);
        (-0.5 * square).exp() / (p * p * a * std::f64::consts::TAU.powf(1.5))
    }
}

fn dot(p: &[f64; 3], q: &[f64; 3]) -> f64 {
    (0..3).map(|a| p[a] * q[a]).sum()
}
