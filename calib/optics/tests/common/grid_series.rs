//! Images of a grid of discs at growing tilt, with the true centres: drawn by counting 6 x 6 points a pixel, blurred,
//! shaded, with noise, rounded to 8 bits; with large and hidden discs, false ones, and a lens that bends on demand.

use nalgebra::{Matrix3, Vector2, Vector3};
use optics::image::{Image, Plane, smoothed};

use super::Random;

pub(crate) const SIDE: usize = 512;
pub(crate) const DISCS: usize = 10;
pub(crate) const PITCH: f64 = 20.0;
pub(crate) const RADIUS: f64 = 3.8;
/// A large disc's.
pub(crate) const LARGE: f64 = 8.0;
const FOCAL: f64 = 900.0;
const FINE: usize = 6;

/// What is on the sheet.
#[derive(Debug, Clone)]
pub(crate) struct Sheet {
    pub(crate) cols: usize,
    pub(crate) rows: usize,
    /// Places of large discs, and of discs that are not there.
    pub(crate) marks: Vec<[usize; 2]>,
    pub(crate) hidden: Vec<[usize; 2]>,
    /// Spots that are no discs of the grid: column, row, radius, all in steps of the grid.
    pub(crate) spots: Vec<[f64; 3]>,
}

impl Default for Sheet {
    fn default() -> Self {
        Self {
            cols: DISCS,
            rows: DISCS,
            marks: Vec::new(),
            hidden: Vec::new(),
            spots: Vec::new(),
        }
    }
}

/// What is drawn.
#[derive(Debug, Clone, Default)]
pub(crate) struct Scene {
    pub(crate) tilt_deg: f64,
    pub(crate) roll_deg: f64,
    pub(crate) noise: f64,
    pub(crate) seed: u64,
    pub(crate) sheet: Sheet,
    /// How much farther from the middle, beside the distance, a point lies at the middle of a side: the lens.
    pub(crate) bend: f64,
    /// Pixels that the sheet's middle is moved by.
    pub(crate) aside: [f64; 2],
    /// A circle of light: its middle and its radius, pixels.
    pub(crate) glare: Option<[f64; 3]>,
}

/// An image and its truth.
pub(crate) struct Drawn {
    pub(crate) image: Image,
    /// Images of the discs' centres, by rows.
    pub(crate) centres: Vec<Vector2<f64>>,
    pub(crate) cols: usize,
    /// The distance between neighbours that is smallest, pixels.
    pub(crate) least_pitch: f64,
    /// From mm about the sheet's middle to pixels, without the lens.
    pub(crate) px_from_mm: Matrix3<f64>,
}

impl Drawn {
    /// Where a disc's centre is.
    pub(crate) fn centre(&self, col: usize, row: usize) -> Vector2<f64> {
        self.centres[row * self.cols + col]
    }
}

fn project(h: &Matrix3<f64>, p: Vector2<f64>) -> Vector2<f64> {
    let q = h * Vector3::new(p.x, p.y, 1.0);
    Vector2::new(q.x / q.z, q.y / q.z)
}

/// Draws a scene.
pub(crate) fn draw(scene: &Scene) -> Drawn {
    let mut random = Random::new(scene.seed * 1000 + (scene.tilt_deg * 10.0) as u64 + 7);
    let h = camera(scene, &mut random);
    let lens = Lens(scene.bend);
    let sharp = sharp(scene, &h, lens);
    let image = photographed(sharp, scene, &mut random);
    let sheet = &scene.sheet;
    let (cols, rows) = (sheet.cols, sheet.rows);
    let at = |i: usize| sheet.mm((i % cols) as f64, (i / cols) as f64);
    let centres: Vec<Vector2<f64>> = (0..cols * rows).map(|i| lens.bent(project(&h, at(i)))).collect();
    let down = (0..cols * (rows - 1)).map(|i| (centres[i + cols] - centres[i]).norm());
    let least_pitch = down.fold(f64::MAX, f64::min);
    Drawn {
        image,
        centres,
        cols,
        least_pitch,
        px_from_mm: h,
    }
}

impl Sheet {
    fn middle(&self) -> [f64; 2] {
        [self.cols, self.rows].map(|n| (n as f64 - 1.0) / 2.0)
    }

    /// A place of the grid on the sheet, mm from its middle.
    fn mm(&self, col: f64, row: f64) -> Vector2<f64> {
        let [c, r] = self.middle();
        Vector2::new(col - c, row - r) * PITCH
    }

    /// Grey of the sheet at a place, mm.
    fn grey(&self, x: f64, y: f64) -> f32 {
        let reach = [self.cols, self.rows].map(|n| PITCH * (n as f64 / 2.0 + 0.7));
        if x.abs() > reach[0] || y.abs() > reach[1] {
            return 110.0;
        }
        let [c, r] = self.middle();
        let (gx, gy) = (x / PITCH + c, y / PITCH + r);
        let (i, j) = (gx.round(), gy.round());
        let on = (0.0..self.cols as f64).contains(&i) && (0.0..self.rows as f64).contains(&j);
        let cell = [i.max(0.0) as usize, j.max(0.0) as usize];
        let radius = if self.marks.contains(&cell) { LARGE } else { RADIUS };
        let inside = (gx - i).powi(2) + (gy - j).powi(2) < (radius / PITCH).powi(2);
        let spot = |s: &[f64; 3]| (gx - s[0]).powi(2) + (gy - s[1]).powi(2) < s[2] * s[2];
        let disc = inside && on && !self.hidden.contains(&cell);
        if disc || self.spots.iter().any(spot) {
            40.0
        } else {
            200.0
        }
    }
}

/// From mm on the sheet to pixels: the first two columns of Rz(roll) Rx(tilt), and the distance.
fn camera(scene: &Scene, random: &mut Random) -> Matrix3<f64> {
    let (t, r) = (
        scene.tilt_deg.to_radians(),
        (scene.roll_deg + 3.0 * random.signed()).to_radians(),
    );
    let distance = 570.0 * (1.0 + 0.02 * random.signed());
    let middle = [4.0 * random.signed() + 256.0, 4.0 * random.signed() + 256.0];
    let plane = Matrix3::new(
        r.cos(),
        -r.sin() * t.cos(),
        0.0,
        r.sin(),
        r.cos() * t.cos(),
        0.0,
        0.0,
        t.sin(),
        distance,
    );
    let [x, y] = [0, 1].map(|k| middle[k] + scene.aside[k]);
    Matrix3::new(FOCAL, 0.0, x, 0.0, FOCAL, y, 0.0, 0.0, 1.0) * plane
}

/// A lens about the middle of the image: a pixel at distance `d` shows what without it is at `d (1 + k (d / 256)^2)`.
#[derive(Clone, Copy)]
struct Lens(f64);

impl Lens {
    fn straight(self, p: Vector2<f64>) -> Vector2<f64> {
        let d = p - Vector2::repeat(256.0);
        Vector2::repeat(256.0) + d * (1.0 + self.0 * d.norm_squared() / 65536.0)
    }

    /// The inverse, by fixed point: each step gains a factor of `3 k`, at most 0.3 here.
    fn bent(self, p: Vector2<f64>) -> Vector2<f64> {
        (0..60).fold(p, |q, _| q + (p - self.straight(q)))
    }
}

/// Grey from 0 to 255 without blur.
fn sharp(scene: &Scene, h: &Matrix3<f64>, lens: Lens) -> Vec<f32> {
    let back = h.try_inverse().unwrap();
    let grey = |x: f64, y: f64| {
        let p = project(&back, lens.straight(Vector2::new(x, y)));
        scene.sheet.grey(p.x, p.y)
    };
    // Corners, sides and middles first: pixels in which they agree hold no edge but for slivers below 2e-3 of a pixel.
    let n = 2 * SIDE + 1;
    let half = |k: usize| k as f64 * 0.5 - 0.5;
    let coarse: Vec<f32> = (0..n * n).map(|i| grey(half(i % n), half(i / n))).collect();
    let pixel = |i: usize| {
        let (x, y) = (i % SIDE, i / SIDE);
        let first = coarse[2 * y * n + 2 * x];
        let same = (0..3).all(|r| (0..3).all(|c| coarse[(2 * y + r) * n + 2 * x + c] == first));
        if same {
            return first;
        }
        let part = |k: usize| (k as f64 + 0.5) / FINE as f64 - 0.5;
        let fine = (0..FINE * FINE).map(|k| grey(x as f64 + part(k % FINE), y as f64 + part(k / FINE)));
        fine.sum::<f32>() / (FINE * FINE) as f32
    };
    (0..SIDE * SIDE).map(pixel).collect()
}

fn photographed(sharp: Vec<f32>, scene: &Scene, random: &mut Random) -> Image {
    // Shaded and blurred in 16 bits: rounding of 1/256 grey.
    let shade = |i: usize| 1.0 - 0.25 * ((i % SIDE) as f32 / 512.0 * 0.6 + (i / SIDE) as f32 / 512.0 * 0.4);
    let fine: Vec<u16> = sharp
        .iter()
        .enumerate()
        .map(|(i, v)| (v * shade(i) * 256.0) as u16)
        .collect();
    let Plane { samples, .. } = smoothed(&Image::new(SIDE, SIDE, fine).unwrap(), 0.7);
    let lit = |i: usize| {
        scene.glare.is_some_and(|[x, y, r]| {
            let (dx, dy) = ((i % SIDE) as f64 - x, (i / SIDE) as f64 - y);
            dx * dx + dy * dy < r * r
        })
    };
    let bytes = samples.iter().enumerate().map(|(i, v)| {
        let value = if lit(i) { 255.0 } else { f64::from(*v) / 256.0 };
        (value + scene.noise * random.normal()).clamp(0.0, 255.0).round() as u8
    });
    Image::from_bytes(SIDE, SIDE, &bytes.collect::<Vec<u8>>()).unwrap()
}
