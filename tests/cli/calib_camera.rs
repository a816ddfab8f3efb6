//! `calib grid` and `calib camera` end to end: images of a grid through a known lens, and the published stills of a
//! laparoscope.

#![allow(clippy::print_stdout, reason = "what was found, and why a test was skipped")]

use std::path::{Path, PathBuf};

use crate::support::*;
use calib_cli::CameraFile;
use geometry::rotation::{Rotation, RotationVector};

const WIDTH: usize = 480;
const HEIGHT: usize = 360;
/// fx, fy, cx, cy, and k1, k2, p1, p2.
const PINHOLE: [f64; 4] = [430.0, 434.0, 246.0, 174.0];
const LENS: [f64; 4] = [-0.25, 0.08, 0.002, -0.003];
const COLS: usize = 9;
const ROWS: usize = 7;
const PITCH_MM: f64 = 10.0;
const RADIUS_MM: f64 = 2.6;
/// Turns of the grid and where its middle is, mm.
const VIEWS: [([f64; 3], [f64; 3]); 6] = [
    ([0.45, 0.0, 0.05], [-12.0, 6.0, 112.0]),
    ([-0.42, 0.12, -0.1], [14.0, -6.0, 110.0]),
    ([0.08, 0.48, 0.12], [-14.0, -8.0, 114.0]),
    ([-0.05, -0.45, -0.08], [12.0, 10.0, 112.0]),
    ([0.3, 0.3, 0.2], [0.0, 0.0, 100.0]),
    ([-0.3, 0.32, -0.15], [4.0, 8.0, 108.0]),
];

/// The direction in which a pixel looks, at distance 1: the lens turned round by repeated substitution.
fn ray([u, v]: [f64; 2]) -> [f64; 2] {
    let [fx, fy, cx, cy] = PINHOLE;
    let [k1, k2, p1, p2] = LENS;
    let seen = [(u - cx) / fx, (v - cy) / fy];
    let [mut x, mut y] = seen;
    for _ in 0..40 {
        let r2 = x * x + y * y;
        let radial = 1.0 + k1 * r2 + k2 * r2 * r2;
        let a = (seen[0] - 2.0 * p1 * x * y - p2 * (r2 + 2.0 * x * x)) / radial;
        let b = (seen[1] - p1 * (r2 + 2.0 * y * y) - 2.0 * p2 * x * y) / radial;
        [x, y] = [a, b];
    }
    [x, y]
}

/// Places within a pixel of a pixel, and their weights: a tent, the optics' blur and the pixel's area.
fn tent() -> Vec<([f64; 2], f64)> {
    let steps = (-2..=2).map(|i| f64::from(i) * 0.4);
    let all = steps.clone().flat_map(|y| steps.clone().map(move |x| [x, y]));
    all.map(|[x, y]| ([x, y], (1.0 - x.abs()) * (1.0 - y.abs()))).collect()
}

/// Every ray of the image, by pixel and place in the tent.
fn rays() -> Vec<Vec<([f64; 2], f64)>> {
    let pixel = |i: usize| {
        let at = [(i % WIDTH) as f64, (i / WIDTH) as f64];
        let place = |([x, y], w): ([f64; 2], f64)| (ray([at[0] + x, at[1] + y]), w);
        tent().into_iter().map(place).collect()
    };
    (0..WIDTH * HEIGHT).map(pixel).collect()
}

/// Whether a ray meets a disc of the grid in this pose.
fn on_disc([x, y]: [f64; 2], axes: &[[f64; 3]; 3], middle: [f64; 3]) -> bool {
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let depth = dot(axes[2], middle) / dot(axes[2], [x, y, 1.0]);
    let off = [x * depth - middle[0], y * depth - middle[1], depth - middle[2]];
    let size = [COLS, ROWS];
    let near = [0, 1].map(|k| {
        let cell = dot(axes[k], off) / PITCH_MM + 0.5 * (size[k] - 1) as f64;
        let nearest = cell.round().clamp(0.0, (size[k] - 1) as f64);
        (cell - nearest) * PITCH_MM
    });
    near[0].hypot(near[1]) <= RADIUS_MM
}

/// An image of the grid, 40 to 210 of 255, with noise of two steps.
fn image(rays: &[Vec<([f64; 2], f64)>], view: usize) -> image::GrayImage {
    let (turn, middle) = VIEWS[view];
    let rotation = Rotation::from_vector(RotationVector::new(turn).unwrap());
    let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|axis| rotation.apply(axis));
    let mut state = view as u64 + 1;
    let mut unit = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f64 / f64::from(1 << 24)
    };
    let mut grey = |places: &Vec<([f64; 2], f64)>| {
        let all: f64 = places.iter().map(|p| p.1).sum();
        let dark: f64 = places.iter().filter(|p| on_disc(p.0, &axes, middle)).map(|p| p.1).sum();
        // Twelve uniform numbers have variance 1.
        let noise = (0..12).map(|_| unit()).sum::<f64>() - 6.0;
        (210.0 - 170.0 * dark / all + 2.0 * noise).round().clamp(0.0, 255.0) as u8
    };
    let pixels: Vec<u8> = rays.iter().map(&mut grey).collect();
    image::GrayImage::from_raw(WIDTH as u32, HEIGHT as u32, pixels).unwrap()
}

fn images(world: &World) -> Vec<PathBuf> {
    let rays = rays();
    let write = |view: usize| {
        let path = world.path(&format!("view{view}.png"));
        image(&rays, view).save(&path).unwrap();
        path
    };
    (0..VIEWS.len()).map(write).collect()
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// The planted camera comes back within its covariance: eight numbers, each within four of its deviations, which are
/// those of a calibration worth the name.
#[test]
fn a_known_camera_is_found_from_its_images() {
    let world = World::new();
    let paths = images(&world);
    let (grids, camera, png) = (
        world.path("grids.json"),
        world.path("camera.toml"),
        world.path("camera.png"),
    );
    let mut command = vec!["grid", "--cols", "9", "--rows", "7", "--pitch-mm", "10", "--one-by-one"];
    command.extend(["--out", text(&grids)]);
    command.extend(paths.iter().map(|p| text(p)));
    let output = world.output("calib", &command);
    assert!(output.status.success(), "{}", stderr(&output));
    let command = ["camera", text(&grids), "--out", text(&camera), "--png", text(&png)];
    let output = world.output("calib", &command);
    println!("{}{}", stdout(&output), stderr(&output));
    assert!(output.status.success(), "{}", stderr(&output));
    let file = CameraFile::read(&camera).unwrap();
    let [fx, fy, cx, cy] = PINHOLE;
    let [k1, k2, p1, p2] = LENS;
    let planted = [fx, fy, cx, cy, 0.0, k1, k2, p1, p2, 0.0, 0.0, 0.0, 0.0, 0.0];
    for (k, name) in file.names.iter().enumerate() {
        let (off, sigma) = ((file.numbers[k] - planted[k]).abs(), file.deviations[k]);
        assert!(off <= 4.0 * sigma, "{name}: {off} off, deviation {sigma}");
    }
    assert!(
        file.deviations[0] < 0.5 && file.deviations[5] < 0.005,
        "{:?}",
        file.deviations
    );
    // Twenty-five samples draw a pixel on a rim to some 6 steps, three times the noise, which is what discs are weighed by.
    assert!(
        file.rms_px < 0.05 && file.noise_ratio < 4.0,
        "{} {}",
        file.rms_px,
        file.noise_ratio
    );
    // One camera: what its views say of it differs by their noise.
    let view_ratio = file.view_ratio.unwrap();
    assert!((0.3..4.0).contains(&view_ratio), "{view_ratio}");
    let drawn = image::open(&png).unwrap();
    assert!(drawn.width() > 1000 && drawn.height() > 800);
    if let Ok(keep) = std::env::var("TROCAR_KEEP_PICTURES") {
        std::fs::copy(&png, Path::new(&keep).join("camera.png")).unwrap();
    }
}

/// The three stills of the metal plate. What is left is said in docs/camera.md; no parameter of the lens takes it away.
#[test]
fn the_stills_of_a_laparoscope_give_a_camera() {
    let Some(folder) = shared("data/circles-ucl/metal") else {
        return;
    };
    let world = World::new();
    let mut stills: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    stills.retain(|p| p.extension().is_some_and(|e| e == "png"));
    stills.sort();
    let (grids, camera) = (world.path("grids.json"), world.path("camera.toml"));
    let mut command = vec![
        "grid",
        "--cols",
        "16",
        "--rows",
        "14",
        "--pitch-mm",
        "5",
        "--one-by-one",
    ];
    command.extend(["--out", text(&grids)]);
    command.extend(stills.iter().map(|p| text(p)));
    let output = world.output("calib", &command);
    assert!(output.status.success(), "{}", stderr(&output));
    // The plate is bent and the lens is not quite Brown's: no camera for which the residuals are the discs' deviations.
    let refused = world.output("calib", &["camera", text(&grids)]);
    let said = stderr(&refused);
    assert!(
        !refused.status.success() && said.contains("times the discs' stated deviations, at most 3"),
        "{said}"
    );
    let asked = [
        "camera",
        text(&grids),
        "--out",
        text(&camera),
        "--max-noise-ratio",
        "100",
    ];
    let output = world.output("calib", &asked);
    println!("{}{}", stdout(&output), stderr(&output));
    assert!(output.status.success(), "{}", stderr(&output));
    let file = CameraFile::read(&camera).unwrap();
    // Within five deviations of the camera's makers' calibration, or five percent of the focal length: another focus.
    assert!((file.numbers[0] / 1766.0 - 1.0).abs() < 0.05, "{}", file.numbers[0]);
    assert!(
        file.rms_px < 0.7 && file.discs[0] > 600,
        "{} {:?}",
        file.rms_px,
        file.discs
    );
}
