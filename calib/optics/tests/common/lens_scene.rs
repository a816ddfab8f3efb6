//! Images of a grid of discs behind a lens, with the images of the discs' true centres.
//!
//! Nothing here is shared with what finds grids: rims are mapped point by point, from the paper through the camera and the
//! lens, and the pixels' shares of the polygons of 180 points that they make are exact areas (to `1 - cos(pi / 180)` = 1.5e-4
//! of a radius, the same all round). They are taken on a grid four times as fine, on which the blur is a comb of the Gaussian's values,
//! and added up to pixels. Lengths in the camera are in units of the focal length, [`FOCAL`] px for an image [`SIDE`] px wide:
//! `k1` is that of OpenCV's lens for a camera whose focal length is the image's width.

use nalgebra::{Rotation3, Vector2, Vector3};
use optics::image::Image;

use super::Random;

pub(crate) const SIDE: usize = 512;
pub(crate) const FOCAL: f64 = 512.0;
pub(crate) const PITCH: f64 = 20.0;
pub(crate) const RADIUS: f64 = 3.8;
/// Fine pixels in a pixel's side, and points on a rim.
const FINE: usize = 4;
const RIM: usize = 180;

/// What the light meets behind the pinhole.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Glass {
    /// Radial coefficients of r^2, r^4 and r^6, and the tangential p1 and p2.
    pub(crate) radial: [f64; 3],
    pub(crate) tangential: [f64; 2],
    /// How far its middle lies off the principal point, focal lengths.
    pub(crate) aside: [f64; 2],
    /// Equidistant: the radius is the angle off the axis, in the place of all coefficients.
    pub(crate) fisheye: bool,
}

/// What is drawn.
#[derive(Debug, Clone)]
pub(crate) struct LensScene {
    pub(crate) cols: usize,
    pub(crate) rows: usize,
    pub(crate) tilt_deg: f64,
    pub(crate) roll_deg: f64,
    pub(crate) glass: Glass,
    /// Heights over the plane, mm at the side's middle: along the columns, along the rows, and twisted.
    pub(crate) bow_mm: [f64; 3],
    /// The blur's deviation, pixels, and by what share it grows from the image's top to its middle.
    pub(crate) blur: f64,
    pub(crate) blur_slope: f64,
    pub(crate) noise: f64,
    /// The light lost in the corners beside the middle, and along x from side to side.
    pub(crate) vignette: f64,
    pub(crate) shade: f64,
    /// Grey of discs, paper and table.
    pub(crate) greys: [f64; 3],
    /// The paper beyond the outer discs' centres, steps of the grid.
    pub(crate) rim: f64,
    /// The part of the image that the grid fills: left, top, right, bottom, pixels.
    pub(crate) within: [f64; 4],
    /// The discs' radius, mm.
    pub(crate) radius: f64,
    pub(crate) hidden: Vec<[usize; 2]>,
    pub(crate) seed: u64,
}

impl Default for LensScene {
    fn default() -> Self {
        Self {
            cols: 10,
            rows: 10,
            tilt_deg: 0.0,
            roll_deg: 0.0,
            glass: Glass::default(),
            bow_mm: [0.0; 3],
            blur: 0.8,
            blur_slope: 0.0,
            noise: 2.0,
            vignette: 0.0,
            shade: 0.0,
            greys: [40.0, 200.0, 110.0],
            rim: 1.2,
            within: [40.0, 40.0, 472.0, 472.0],
            radius: RADIUS,
            hidden: Vec::new(),
            seed: 1,
        }
    }
}

/// An image and the images of the discs' centres, by rows.
pub(crate) struct Seen {
    pub(crate) image: Image,
    pub(crate) centres: Vec<Vector2<f64>>,
    /// How far the lens moves the discs from where the pinhole has them, the most, pixels.
    pub(crate) bent: f64,
}

impl Glass {
    /// Where a point of the plane at distance 1 is seen; none beyond where the radius grows.
    fn seen(&self, at: Vector2<f64>) -> Option<Vector2<f64>> {
        let aside = Vector2::from(self.aside);
        let x = at - aside;
        let (r2, [k1, k2, k3]) = (x.norm_squared(), self.radial);
        if self.fisheye {
            let r = r2.sqrt().max(1e-12);
            return Some(x * (r.atan() / r) + aside);
        }
        let slope = 1.0 + r2 * (3.0 * k1 + r2 * (5.0 * k2 + 7.0 * r2 * k3));
        let [p1, p2] = self.tangential;
        let q = Vector2::new(p2, p1);
        let out = x * (1.0 + r2 * (k1 + r2 * (k2 + r2 * k3)) + 2.0 * q.dot(&x)) + q * r2;
        (slope > 0.2).then_some(out + aside)
    }
}

/// Where the grid is before the camera.
struct Pose {
    turn: Rotation3<f64>,
    shift: Vector3<f64>,
    middle: Vector2<f64>,
}

impl LensScene {
    fn half(&self) -> [f64; 2] {
        [self.cols, self.rows].map(|n| 0.5 * (n as f64 - 1.0) * PITCH)
    }

    fn camera(&self, pose: &Pose, glass: &Glass, at: Vector2<f64>) -> Option<Vector2<f64>> {
        let [a, b] = self.half();
        let (u, v) = (at.x / a, at.y / b);
        let [along, across, twist] = self.bow_mm;
        let p = pose.turn * Vector3::new(at.x, at.y, along * u * u + across * v * v + twist * u * v) + pose.shift;
        let flat = p.xy() / p.z;
        let seen = glass.seen(flat).filter(|_| p.z > 0.1 * pose.shift.z)?;
        Some(seen * FOCAL + pose.middle)
    }

    fn place(&self, col: f64, row: f64) -> Vector2<f64> {
        let [a, b] = self.half();
        Vector2::new(col * PITCH - a, row * PITCH - b)
    }

    /// The pose in which the outer discs touch the part of the image that they are to fill.
    fn pose(&self, random: &mut Random) -> Pose {
        let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), self.roll_deg.to_radians())
            * Rotation3::from_axis_angle(&Vector3::x_axis(), self.tilt_deg.to_radians());
        let middle = Vector2::new(255.5 + 4.0 * random.signed(), 255.5 + 4.0 * random.signed());
        let mut pose = Pose {
            turn,
            shift: Vector3::new(0.0, 0.0, 60.0 * self.cols.max(self.rows) as f64),
            middle,
        };
        let [left, top, right, bottom] = self.within;
        for _ in 0..80 {
            let rim = (0..self.cols * self.rows).map(|i| self.place((i % self.cols) as f64, (i / self.cols) as f64));
            let seen: Option<Vec<_>> = rim.map(|p| self.camera(&pose, &self.glass, p)).collect();
            let Some(seen) = seen else {
                pose.shift.z *= 1.04;
                continue;
            };
            let low = seen.iter().fold(Vector2::repeat(1e9), |m, p| m.inf(p));
            let high = seen.iter().fold(Vector2::repeat(-1e9), |m, p| m.sup(p));
            let size = high - low;
            let grow = (size.x / (right - left)).max(size.y / (bottom - top));
            let off = (low + high) * 0.5 - Vector2::new(left + right, top + bottom) * 0.5;
            pose.shift.x -= 0.5 * off.x * pose.shift.z / FOCAL;
            pose.shift.y -= 0.5 * off.y * pose.shift.z / FOCAL;
            pose.shift.z *= grow.powf(0.5).clamp(0.9, 1.1);
        }
        pose
    }

    /// Draws it.
    pub(crate) fn draw(&self) -> Seen {
        let mut random = Random::new(self.seed * 7919 + 13);
        let pose = self.pose(&mut random);
        let map = |p: Vector2<f64>| self.camera(&pose, &self.glass, p);
        let [a, b] = self.half().map(|h| h + self.rim * PITCH);
        let mut fine = vec![self.greys[2] as f32; (SIDE * FINE).pow(2)];
        let corners = [[-a, -b], [a, -b], [a, b], [-a, b]].map(Vector2::from);
        let side = |k: usize, t: usize| corners[k] + (corners[(k + 1) % 4] - corners[k]) * (t as f64 / 200.0);
        let paper: Vec<_> = (0..800).filter_map(|i| map(side(i / 200, i % 200))).collect();
        fill(&mut fine, &paper, (self.greys[1] - self.greys[2]) as f32);
        let mut centres = Vec::new();
        let mut bent = 0.0_f64;
        for cell in (0..self.cols * self.rows).map(|i| [i % self.cols, i / self.cols]) {
            let at = self.place(cell[0] as f64, cell[1] as f64);
            let centre = map(at).expect("the grid is in front of the camera");
            let plain = self.camera(&pose, &Glass::default(), at).unwrap_or(centre);
            bent = bent.max((centre - plain).norm());
            centres.push(centre);
            let point = |k: usize| {
                let (s, c) = (k as f64 * std::f64::consts::TAU / RIM as f64).sin_cos();
                map(at + Vector2::new(c, s) * self.radius)
            };
            let rim: Option<Vec<_>> = (0..RIM).map(point).collect();
            if let Some(rim) = rim.filter(|_| !self.hidden.contains(&cell)) {
                fill(&mut fine, &rim, (self.greys[0] - self.greys[1]) as f32);
            }
        }
        Seen {
            image: self.photographed(&fine, &mut random),
            centres,
            bent,
        }
    }

    fn photographed(&self, fine: &[f32], random: &mut Random) -> Image {
        let blur = |y: f64| self.blur * (1.0 + self.blur_slope * (y - 255.5) / 256.0);
        let n = SIDE * FINE;
        let mut across = vec![0.0_f32; SIDE * n];
        for (y, row) in fine.chunks_exact(n).enumerate() {
            let weights = weights(blur(y as f64 / FINE as f64));
            for x in 0..SIDE {
                across[y * SIDE + x] = sum(&weights, FINE * x, n, |k| row[k]);
            }
        }
        let byte = |i: usize, value: f32| {
            let [x, y] = [i % SIDE, i / SIDE].map(|k| (k as f64 - 255.5) / 256.0);
            let light = (1.0 - 0.5 * self.vignette * (x * x + y * y)) * (1.0 + 0.5 * self.shade * x);
            (f64::from(value) * light + self.noise * random.normal())
                .clamp(0.0, 255.0)
                .round() as u8
        };
        let mut values = vec![0.0_f32; SIDE * SIDE];
        for y in 0..SIDE {
            let weights = weights(blur(y as f64));
            for x in 0..SIDE {
                values[y * SIDE + x] = sum(&weights, FINE * y, n, |k| across[k * SIDE + x]);
            }
        }
        let mut byte = byte;
        let bytes: Vec<u8> = values.iter().enumerate().map(|(i, v)| byte(i, *v)).collect();
        Image::from_bytes(SIDE, SIDE, &bytes).unwrap()
    }
}

/// Weights of fine pixels about a pixel's first one: the Gaussian, over the pixel.
fn weights(sigma: f64) -> Vec<f32> {
    let reach = (4.5 * sigma * FINE as f64).ceil() as i32;
    let value = |k: i32| (-0.5 * (f64::from(k) / (sigma * FINE as f64)).powi(2)).exp();
    let total: f64 = (-reach..=reach).map(value).sum();
    let over = |k: i32| {
        (0..FINE as i32)
            .map(|f| k - f)
            .filter(|d| d.abs() <= reach)
            .map(value)
            .sum::<f64>()
    };
    (-reach..=reach + FINE as i32 - 1)
        .map(|k| (over(k) / total / FINE as f64) as f32)
        .collect()
}

/// A weighted sum of fine samples about the first of a pixel; beyond the border the last ones again.
fn sum(weights: &[f32], first: usize, n: usize, value: impl Fn(usize) -> f32) -> f32 {
    let reach = ((weights.len() + 1 - FINE) / 2) as i64;
    let at = |k: usize| (first as i64 + k as i64 - reach).clamp(0, n as i64 - 1) as usize;
    weights.iter().enumerate().map(|(k, w)| w * value(at(k))).sum()
}

/// Adds to each fine pixel its share of a polygon, times `grey`. Pixels have their centres at whole coordinates.
fn fill(fine: &mut [f32], polygon: &[Vector2<f64>], grey: f32) {
    let n = (SIDE * FINE) as f64;
    let points: Vec<Vector2<f64>> = polygon.iter().map(|p| (p.add_scalar(0.5)) * FINE as f64).collect();
    let low = points
        .iter()
        .fold(Vector2::repeat(n), |m, p| m.inf(p))
        .map(|v| v.clamp(0.0, n).floor());
    let high = points
        .iter()
        .fold(Vector2::zeros(), |m, p| m.sup(p))
        .map(|v: f64| v.clamp(0.0, n).ceil());
    let (width, height) = ((high.x - low.x) as usize, (high.y - low.y) as usize);
    // Area to the right of each edge, cell by cell: what an edge adds in its own cell, and to all behind it.
    let mut sums = vec![0.0_f64; (width + 2) * height];
    for (k, p) in points.iter().enumerate() {
        edge(&mut sums, width, height, p - low, points[(k + 1) % points.len()] - low);
    }
    let sign = signed_area(&points).signum();
    for y in 0..height {
        let mut total = 0.0;
        for x in 0..width {
            total += sums[y * (width + 2) + x];
            let i = (low.y as usize + y) * SIDE * FINE + low.x as usize + x;
            fine[i] += grey * (sign * total) as f32;
        }
    }
}

fn signed_area(points: &[Vector2<f64>]) -> f64 {
    let cross = |k: usize| points[k].perp(&points[(k + 1) % points.len()]);
    -(0..points.len()).map(cross).sum::<f64>()
}

/// One edge, row by row and column by column.
fn edge(sums: &mut [f64], width: usize, height: usize, from: Vector2<f64>, to: Vector2<f64>) {
    if from.y == to.y {
        return;
    }
    let (sign, a, b) = if from.y < to.y {
        (1.0, from, to)
    } else {
        (-1.0, to, from)
    };
    let slope = (b.x - a.x) / (b.y - a.y);
    let rows = a.y.max(0.0).floor() as usize..(b.y.min(height as f64).ceil().max(0.0) as usize);
    for row in rows {
        let (top, bottom) = (a.y.max(row as f64), b.y.min(row as f64 + 1.0));
        if bottom <= top {
            continue;
        }
        let x = |y: f64| (a.x + (y - a.y) * slope).clamp(0.0, width as f64);
        let (mut x0, mut x1) = (x(top), x(bottom));
        if x0 > x1 {
            std::mem::swap(&mut x0, &mut x1);
        }
        let line = &mut sums[row * (width + 2)..(row + 1) * (width + 2)];
        let tall = sign * (bottom - top);
        // The part of each column that lies to the right of the edge.
        let (first, last) = (x0.floor() as usize, x1.ceil() as usize);
        let right_of = |c: f64| {
            // Integral over the edge's x of the share of all up to column c that lies to its right.
            let held = |e: f64| (c - e).max(0.0).powi(2) * 0.5;
            if x1 - x0 < 1e-9 {
                (c - x0).max(0.0)
            } else {
                (held(x0) - held(x1)) / (x1 - x0)
            }
        };
        let mut before = 0.0;
        let mut shares = 0.0;
        let cells = line.iter_mut().enumerate().take(last.min(width) + 1).skip(first);
        for (column, cell) in cells {
            let up_to = right_of(column as f64 + 1.0);
            let share = up_to - before;
            before = up_to;
            *cell += tall * (share - shares);
            shares = share;
        }
        if shares < 1.0 {
            line[last.min(width) + 1] += tall * (1.0 - shares);
        }
    }
}
