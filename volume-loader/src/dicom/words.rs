//! Directions in words.

use geometry::{Ct, Vector};

/// Beyond this angle from the nearest patient axis a plane is called oblique, degrees.
const OBLIQUE_DEG: f64 = 1.0;

/// The axis nearest to `v` (0, 1 or 2) and the angle to it, degrees.
fn nearest_axis(v: [f64; 3]) -> (usize, f64) {
    let axis = (0..3).fold(0, |best, i| if v[i].abs() > v[best].abs() { i } else { best });
    let [along, rest] = [
        v[axis].abs(),
        (0..3).filter(|&i| i != axis).map(|i| v[i] * v[i]).sum::<f64>().sqrt(),
    ];
    (axis, rest.atan2(along).to_degrees())
}

/// The patient's side that `v` points to.
fn towards(v: Vector<Ct>) -> &'static str {
    let v = v.mm();
    let (axis, _) = nearest_axis(v);
    let names = [["left", "right"], ["back", "front"], ["head", "feet"]];
    names[axis][usize::from(v[axis] < 0.0)]
}

/// The plane whose normal this is: axial, sagittal or frontal, and how oblique.
pub(crate) fn plane(normal: Vector<Ct>) -> String {
    let (axis, degrees) = nearest_axis(normal.mm());
    let name = ["sagittal", "frontal", "axial"][axis];
    match degrees > OBLIQUE_DEG {
        true => format!("{name}, oblique by {degrees:.1} degrees"),
        false => name.to_owned(),
    }
}

/// The plane, and where each axis of the grid points.
pub(crate) fn orientation(normal: Vector<Ct>, steps: [Vector<Ct>; 3]) -> String {
    let [x, y, z] = steps.map(towards);
    format!(
        "{}: columns to the {x}, rows to the {y}, slices to the {z}",
        plane(normal)
    )
}
