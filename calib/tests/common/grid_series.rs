//! Images of a grid of 10 x 10 discs at growing tilt, with the true centres: drawn by counting 6 x 6 points a pixel,
//! blurred, shaded, with noise, rounded to 8 bits.

use calib::image::{Image, Plane, smoothed};
use nalgebra::{Matrix3, Vector2, Vector3};

use super::Random;

pub(crate) const SIDE: usize = 512;
pub(crate) const DISCS: usize = 10;
pub(crate) const PITCH: f64 = 20.0;
pub(crate) const RADIUS: f64 = 3.8;
const FOCAL: f64 = 900.0;
const FINE: usize = 6;

/// What is drawn.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Scene {
    pub(crate) tilt_deg: f64,
    pub(crate) roll_deg: f64,
    pub(crate) noise: f64,
    pub(crate) seed: u64,
}

/// An image and its truth.
pub(crate) struct Drawn {
    pub(crate) image: Image,
    /// Images of the discs' centres, by rows.
    pub(crate) centres: Vec<Vector2<f64>>,
    /// The distance between neighbours that is smallest, pixels.
    pub(crate) least_pitch: f64,
}

/// Draws a scene.
pub(crate) fn draw(scene: &Scene) -> Drawn {
    let mut random = Random::new(scene.seed * 1000 + (scene.tilt_deg * 10.0) as u64 + 7);
    let (t, r) = (
        scene.tilt_deg.to_radians(),
        (scene.roll_deg + 3.0 * random.signed()).to_radians(),
    );
    let distance = 570.0 * (1.0 + 0.02 * random.signed());
    let middle = [4.0 * random.signed() + 256.0, 4.0 * random.signed() + 256.0];
    // The first two columns of Rz(roll) Rx(tilt), and the distance.
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
    let camera = Matrix3::new(FOCAL, 0.0, middle[0], 0.0, FOCAL, middle[1], 0.0, 0.0, 1.0);
    let h = camera * plane;
    let sharp = sharp(&h);
    let image = photographed(&sharp, scene.noise, &mut random);
    let half = (DISCS as f64 - 1.0) / 2.0;
    let at = |i: usize| Vector2::new((i % DISCS) as f64 - half, (i / DISCS) as f64 - half) * PITCH;
    let project = |p: Vector2<f64>| {
        let q = h * Vector3::new(p.x, p.y, 1.0);
        Vector2::new(q.x / q.z, q.y / q.z)
    };
    let centres: Vec<Vector2<f64>> = (0..DISCS * DISCS).map(|i| project(at(i))).collect();
    let down = (0..DISCS * (DISCS - 1)).map(|i| (centres[i + DISCS] - centres[i]).norm());
    let least_pitch = down.fold(f64::MAX, f64::min);
    Drawn {
        image,
        centres,
        least_pitch,
    }
}

/// Grey from 0 to 255 without blur.
fn sharp(h: &Matrix3<f64>) -> Vec<f32> {
    let back = h.try_inverse().unwrap();
    let mut out = vec![0.0; SIDE * SIDE];
    for (i, value) in out.iter_mut().enumerate() {
        let mut sum = 0.0;
        for k in 0..FINE * FINE {
            let part = |n: usize| (n as f64 + 0.5) / FINE as f64 - 0.5;
            let (x, y) = ((i % SIDE) as f64 + part(k % FINE), (i / SIDE) as f64 + part(k / FINE));
            let p = back * Vector3::new(x, y, 1.0);
            sum += grey(p.x / p.z, p.y / p.z);
        }
        *value = (sum / (FINE * FINE) as f64) as f32;
    }
    out
}

/// Grey of the sheet at a place, mm.
fn grey(x: f64, y: f64) -> f64 {
    let reach = PITCH * (DISCS as f64 / 2.0 + 0.7);
    if x.abs() > reach || y.abs() > reach {
        return 110.0;
    }
    let half = (DISCS as f64 - 1.0) / 2.0;
    let (gx, gy) = (x / PITCH + half, y / PITCH + half);
    let (i, j) = (gx.round(), gy.round());
    let last = DISCS as f64 - 1.0;
    let inside = (gx - i).powi(2) + (gy - j).powi(2) < (RADIUS / PITCH).powi(2);
    let on = (0.0..=last).contains(&i) && (0.0..=last).contains(&j);
    if inside && on { 40.0 } else { 200.0 }
}

fn photographed(sharp: &[f32], noise: f64, random: &mut Random) -> Image {
    // Shaded and blurred in 16 bits: rounding of 1/256 grey.
    let shade = |i: usize| 1.0 - 0.25 * ((i % SIDE) as f32 / 512.0 * 0.6 + (i / SIDE) as f32 / 512.0 * 0.4);
    let fine: Vec<u16> = sharp
        .iter()
        .enumerate()
        .map(|(i, v)| (v * shade(i) * 256.0) as u16)
        .collect();
    let Plane { samples, .. } = smoothed(&Image::new(SIDE, SIDE, fine).unwrap(), 0.7);
    let seen = |v: &f32| {
        (f64::from(*v) / 256.0 + noise * random.normal())
            .clamp(0.0, 255.0)
            .round() as u8
    };
    let bytes: Vec<u8> = samples.iter().map(seen).collect();
    Image::from_bytes(SIDE, SIDE, &bytes).unwrap()
}
