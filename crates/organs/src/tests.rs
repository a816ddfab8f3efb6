//! A label map made in memory: a ball on a floor, which a tube presses from the front.

mod labels;
mod meeting;
mod model;
mod sha;

use std::path::Path;

use geometry::{Affine, Ct, VolumeGrid, Voxel};
use nalgebra::Vector3;

use crate::{Labels, NoLabels, Parsed, Plan, RawSpaceScene};

/// Voxels along each axis, and how far apart they are, mm.
const SIZE: [usize; 3] = [24, 26, 22];
const SPACING: f64 = 3.0;
/// Radius of the ball about the middle of the map, mm. A floor of label 3 is so far behind that.
const RADIUS: f64 = 18.0;

/// The ball is in the middle of the patient's axes.
const SCENE: &str = r#"
title = "a ball on a floor"
units = { length = "mm", stress = "N/mm2" }
space = { labels = "ball.nii" }

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
entry = [0.0, -50.0, 1.0]
target = [0.0, 0.0, 1.0]
stroke = 4.0
step = 2.0

[[targets]]
name = "middle"
at = [0.0, 0.0, 0.0]
"#;

/// A plan of a scene.
fn plan(text: &str) -> Result<Plan, String> {
    let parsed = Parsed::<RawSpaceScene>::parse(text.to_owned(), Path::new("ball.toml"));
    let parsed = parsed.map_err(|error| error.to_string())?;
    Plan::new(&parsed.scene).map_err(|invalid| parsed.error_at(invalid).to_string())
}

/// A grid whose axes are these columns, of steps of [`SPACING`], about the middle of the patient's axes.
fn grid(axes: [[f64; 3]; 3]) -> VolumeGrid {
    let steps = axes.map(|axis| Vector3::from(axis) * SPACING);
    let middle: Vector3<f64> = (0..3).map(|k| steps[k] * (0.5 * (SIZE[k] as f64 - 1.0))).sum();
    let rows = [0, 1, 2].map(|r| [steps[0][r], steps[1][r], steps[2][r], -middle[r]]);
    VolumeGrid::checked(SIZE.map(|n| n as i64), Affine::<Ct, Voxel>::from_rows(rows)).unwrap()
}

/// What the place of a voxel in the patient is labelled.
fn label(at: &Vector3<f64>) -> i16 {
    let floor = (RADIUS..RADIUS + 9.0).contains(&at.y);
    if at.norm() < RADIUS { 1 } else { 3 * i16::from(floor) }
}

/// The ball on a grid of these axes.
fn labels(axes: [[f64; 3]; 3]) -> Result<Labels, NoLabels> {
    labelled(axes, label)
}

/// Places of the patient, labelled, on a grid of these axes.
fn labelled(axes: [[f64; 3]; 3], label: impl Fn(&Vector3<f64>) -> i16) -> Result<Labels, NoLabels> {
    let grid = grid(axes);
    let rows = grid.ct_from_voxel().rows();
    Labels::new(&grid, "ball".to_owned(), |z, out| {
        for (n, voxel) in out.iter_mut().enumerate() {
            let at = [(n % SIZE[0]) as f64, (n / SIZE[0]) as f64, f64::from(z), 1.0];
            *voxel = label(&Vector3::from_fn(|r, _| (0..4).map(|c| rows[r][c] * at[c]).sum()));
        }
    })
}
