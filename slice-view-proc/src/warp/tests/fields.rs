//! Fields that move tissue, with their inverses where they have one.

use super::stage::Field;

/// A turn about (1, 2, 3) and a shift.
pub(super) fn rigid(x: [f64; 3]) -> [f64; 3] {
    let turn = nalgebra::Rotation3::from_scaled_axis(nalgebra::Vector3::new(1.0, 2.0, 3.0) * 0.3);
    (turn * nalgebra::Vector3::from(x) + nalgebra::Vector3::new(3.0, -2.0, 1.5)).into()
}

/// A dent of 6 mm from above, 12 mm wide.
pub(super) fn dent([x, y, z]: [f64; 3]) -> [f64; 3] {
    let near = (-(x * x + y * y + (z - 14.0) * (z - 14.0)) / 144.0).exp();
    [x * (1.0 + 0.1 * near), y * (1.0 + 0.1 * near), z - 6.0 * near]
}

/// A shear that grows with the square of the height: its inverse is known, and cubes of 27 nodes give it exactly.
pub(super) fn bent([x, y, z]: [f64; 3]) -> [f64; 3] {
    [x + 0.02 * z * z, y - 0.3 * z, z]
}

pub(super) fn unbent([x, y, z]: [f64; 3]) -> [f64; 3] {
    [x - 0.02 * z * z, y + 0.3 * z, z]
}

pub(super) const ALL: [(&str, Field); 3] = [("rigid", rigid), ("dent", dent), ("bent", bent)];
