//! Centres of beads on ground that is not even: random fields, edges of bone, another bead in the window.

#![allow(clippy::print_stdout, reason = "the errors reached are worth reading")]

use nalgebra::{Matrix3, Vector3};

use super::specimen::{Image, Random, Scanner, phi};
use crate::{Bead, Ground, Search, find};

const METAL_HU: f64 = 14_000.0;
const RADIUS_MM: f64 = 1.0;

fn scanner(clip_hu: f64) -> Scanner {
    Scanner {
        clip_hu,
        noise_hu: 15.0,
        ..Scanner::of([0.7, 0.7, 1.0])
    }
}

/// A volume of some 15 mm, and a place in its middle voxel, mm.
fn place(scanner: &Scanner, random: &mut Random) -> ([u32; 3], [f64; 3]) {
    let dims = scanner.voxel_mm.map(|d| (15.0 / d) as u32 | 1);
    let centre = [0, 1, 2].map(|a| (f64::from(dims[a] / 2) + random.next() - 0.5) * scanner.voxel_mm[a]);
    (dims, centre)
}

/// The values of a ground with balls in it instead of what was there.
fn replaced(scanner: &Scanner, dims: [u32; 3], balls: &[[f64; 3]], ground: impl Fn([f64; 3]) -> f64) -> Image {
    let mut shares = scanner.empty(dims, 0.0);
    balls.iter().for_each(|c| shares.bead(*c, RADIUS_MM, 1.0));
    let [nx, ny, _] = shares.dims;
    for (i, value) in shares.values.iter_mut().enumerate() {
        let voxel = [i % nx, i / nx % ny, i / nx / ny];
        let at = [0, 1, 2].map(|a| voxel[a] as f64 * scanner.voxel_mm[a]);
        *value = *value * METAL_HU + (1.0 - *value) * ground(at);
    }
    shares
}

fn found(image: &Image, random: &mut Random, ground: Ground) -> Vec<Bead> {
    let search = Search {
        ground,
        ..Search::of_radius(RADIUS_MM)
    };
    find(&image.volume(random, None), &search).unwrap().beads
}

fn error(bead: &Bead, truth: [f64; 3]) -> Vector3<f64> {
    Vector3::from_fn(|a, _| bead.centre.mm()[a] - truth[a])
}

/// A field with Matern's covariance of order 5/2 and 2 mm: waves whose vectors follow Student's distribution.
fn field(deviation: f64, random: &mut Random) -> impl Fn([f64; 3]) -> f64 + use<> {
    let waves: Vec<([f64; 3], f64)> = (0..300)
        .map(|_| {
            let chi: f64 = (0..5).map(|_| random.normal().powi(2)).sum();
            let scale = (5.0 / chi).sqrt() / 2.0;
            (
                [0; 3].map(|_| scale * random.normal()),
                std::f64::consts::TAU * random.next(),
            )
        })
        .collect();
    move |at| {
        let wave = |(k, phase): &([f64; 3], f64)| (k[0] * at[0] + k[1] * at[1] + k[2] * at[2] + phase).cos();
        40.0 + deviation * (2.0 / waves.len() as f64).sqrt() * waves.iter().map(wave).sum::<f64>()
    }
}

#[test]
fn the_covariance_is_that_of_the_errors_on_a_random_field_clipped_or_not() {
    for clip_hu in [3071.0, 32_767.0] {
        let scanner = scanner(clip_hu);
        let mut random = Random(21);
        let (mut squares, mut sums, n) = (0.0, [0.0; 2], 40);
        for _ in 0..n {
            let (dims, truth) = place(&scanner, &mut random);
            let image = replaced(&scanner, dims, &[truth], field(150.0, &mut random));
            let beads = [Ground::Correlated, Ground::Sloping].map(|g| found(&image, &mut Random(5), g)[0]);
            let e = error(&beads[0], truth);
            // These specimens have no more blur than the model: without what is kept for that.
            let spare = Matrix3::from_diagonal(&Vector3::new(0.0035, 0.0035, 0.005).map(|e| e * e));
            squares += e.dot(&((beads[0].covariance - spare).try_inverse().unwrap() * e));
            (0..2).for_each(|i| sums[i] += error(&beads[i], truth).norm_squared());
        }
        let ratio = squares / f64::from(3 * n);
        let [field, slope] = sums.map(|s| (s / f64::from(n)).sqrt());
        println!("clip {clip_hu}: {ratio:.2} of what is predicted; rms {field:.4} mm, on a slope {slope:.4} mm");
        // Chi-squared with 120 degrees of freedom: 1 within four deviations, 4 sqrt(2 / 120) = 0.52.
        assert!((0.48..1.52).contains(&ratio), "{ratio}");
        // Each is good to 1 / sqrt(240) = 6 %: less by more than three of both.
        assert!(field < 0.75 * slope, "{field} {slope}");
    }
}

/// Bone within a voxel of a bead drew its centre by up to 0.1 mm.
#[test]
fn a_bone_at_any_distance_does_not_draw_the_centre() {
    let mut sums = [0.0; 2];
    let mut random = Random(3);
    let distances = [0.5, 0.8, 1.1, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0, 5.0];
    for (i, distance) in distances.into_iter().enumerate() {
        let scanner = scanner(if i.is_multiple_of(2) { 3071.0 } else { 32_767.0 });
        let (dims, truth) = place(&scanner, &mut random);
        let normal = Vector3::from_fn(|_, _| random.normal()).try_normalize(0.0).unwrap();
        // The edge as the scanner blurs it.
        let bone = |at: [f64; 3]| {
            let d = Vector3::from_fn(|a, _| at[a] - truth[a]).dot(&normal) - distance;
            40.0 + 1200.0 * phi(d / 0.45)
        };
        let image = replaced(&scanner, dims, &[truth], bone);
        for (sum, ground) in sums.iter_mut().zip([Ground::Correlated, Ground::Sloping]) {
            let beads = found(&image, &mut Random(9), ground);
            let e = error(&beads[0], truth).norm();
            println!(
                "{ground:?}, {distance} mm from bone: {e:.4} mm, {:.4} expected",
                beads[0].error_rms_mm()
            );
            *sum += e * e;
        }
    }
    let [field, slope] = sums.map(|s: f64| (s / distances.len() as f64).sqrt());
    println!("rms {field:.4} mm, on a slope {slope:.4} mm");
    assert!(field <= 0.02 && field < slope, "{field} {slope}");
}

#[test]
fn another_bead_in_the_window_does_not_draw_the_centre() {
    let scanner = scanner(3071.0);
    let mut random = Random(8);
    for away in [5.0, 5.5, 6.5] {
        let (dims, truth) = place(&scanner, &mut random);
        let other = [truth[0] - 0.6 * away, truth[1] + 0.8 * away, truth[2]];
        let image = replaced(&scanner, dims, &[truth, other], |_| 40.0);
        let beads = found(&image, &mut Random(9), Ground::Correlated);
        let least = beads
            .iter()
            .map(|b| error(b, truth).norm())
            .fold(f64::INFINITY, f64::min);
        println!("a bead {away} mm away: {least:.4} mm");
        assert!(beads.len() == 2 && least < 0.02, "{away} mm: {least}");
    }
}
