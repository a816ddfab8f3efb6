//! Label maps that tests write, and scenes on them.

use std::path::{Path, PathBuf};

use nalgebra::{Matrix3, Vector3};

/// A NIfTI-1 header with voxels of one byte: `rows` are the sform's, RAS.
fn header(size: [usize; 3], rows: [[f32; 4]; 3]) -> Vec<u8> {
    let mut bytes = vec![0_u8; 352];
    let mut put = |at: usize, new: &[u8]| bytes[at..at + new.len()].copy_from_slice(new);
    put(0, &348_i32.to_le_bytes());
    for (k, n) in [3, size[0], size[1], size[2], 1, 1, 1, 1].into_iter().enumerate() {
        put(40 + 2 * k, &(n as i16).to_le_bytes());
    }
    put(70, &2_i16.to_le_bytes());
    put(72, &8_i16.to_le_bytes());
    for k in 0..4 {
        let length = if k == 0 {
            1.0
        } else {
            (0..3).map(|r| rows[r][k - 1].powi(2)).sum::<f32>().sqrt()
        };
        put(76 + 4 * k, &length.to_le_bytes());
    }
    put(108, &352_f32.to_le_bytes());
    put(123, &[2]);
    put(254, &1_i16.to_le_bytes());
    for (r, row) in rows.iter().enumerate() {
        for (c, x) in row.iter().enumerate() {
            put(280 + 16 * r + 4 * c, &x.to_le_bytes());
        }
    }
    put(344, b"n+1\0");
    bytes
}

/// Where a ball lies in the patient, LPS mm, and its radius.
pub(in super::super) const BALL: ([f64; 3], f64) = ([10.0, -20.0, 30.0], 20.0);
/// A layer of label 3 lies this far behind its middle (to the patient's back), mm, and is so thick.
pub(in super::super) const FLOOR: [f64; 2] = [20.0, 9.0];
/// Voxels of the map along each axis.
pub(in super::super) const SIZE: [usize; 3] = [30, 32, 28];

/// What a place is labelled, from the middle of the ball.
pub(in super::super) fn label(from: &Vector3<f64>) -> u8 {
    let floor = (FLOOR[0]..FLOOR[0] + FLOOR[1]).contains(&from.y);
    if from.norm() < BALL.1 { 1 } else { 3 * u8::from(floor) }
}

/// Voxels of 3 mm along axes that `turn` takes to LPS; `skew` of the second axis leans towards the first.
pub(in super::super) fn write(path: &Path, turn: &Matrix3<f64>, skew: f64) {
    let (size, spacing) = (SIZE, 3.0);
    let mut steps = turn * spacing;
    let first = steps.column(0).into_owned();
    let mut second = steps.column_mut(1);
    second += first * skew;
    let middle = Vector3::from(size.map(|n| 0.5 * (n as f64 - 1.0)));
    let origin = Vector3::from(BALL.0) - steps * middle;
    let lps = |r: usize, c: usize| if c < 3 { steps[(r, c)] } else { origin[r] };
    // LPS to RAS.
    let rows = [0, 1, 2].map(|r| [0, 1, 2, 3].map(|c| (if r < 2 { -lps(r, c) } else { lps(r, c) }) as f32));
    let mut bytes = header(size, rows);
    for n in 0..size.iter().product::<usize>() {
        let voxel = [n % size[0], n / size[0] % size[1], n / size[0] / size[1]];
        let from = origin + steps * Vector3::from(voxel.map(|x| x as f64)) - Vector3::from(BALL.0);
        bytes.push(label(&from));
    }
    std::fs::write(path, bytes).unwrap();
}

/// A scene of the ball, pushed to the back onto a floor.
pub(in super::super) const SCENE: &str = r#"
title = "a ball"
units = { length = "mm", stress = "N/mm2" }

[space]
labels = "ball.nii"
obtain = "the test writes it"

[[organs]]
name = "ball"
label = 1
law = "neo-hookean"
young = 0.01
poisson = 0.45
smoothing = 3.0
cubes = { side = 12.0, levels = 1, within = [12.0] }

[[rigid]]
name = "floor"
labels = [3]

[[attachments]]
organ = "ball"
to = ["floor"]
within = 4.0
kind = "fixed"

[surroundings]
young = 1e-3
margin = 20.0
corridor = 8.0

[tube]
diameter = 12.0
entry = [10.0, -60.0, 31.0]
target = [10.0, -20.0, 31.0]
stroke = 4.0
step = 2.0
"#;

/// A folder with the map, and the scene's path in it.
pub(in super::super) fn folder(turn: &Matrix3<f64>, skew: f64) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    write(&folder.path().join("ball.nii"), turn, skew);
    let path = folder.path().join("ball.toml");
    (folder, path)
}
