//! What several tests make their scenes of.

use nalgebra::Vector3;
use simulation::control::{Failed, Minimum, Newton, Settings as Control};
use simulation::space::cells::{Bounds, Field, Mesh, Plane};
use simulation::space::solid::Solid;
use simulation::space::system::System;
use simulation::sparse::Dissection;

/// A region that has no end within `reach`.
pub(crate) fn everywhere(reach: f64) -> Plane {
    Plane {
        point: Vector3::new(0.0, 0.0, 10.0 * reach),
        normal: Vector3::z(),
    }
}

/// A bar without ends along z: `(x^2 + y^2 - a^2) / (2 a)`.
pub(crate) struct Cylinder {
    pub(crate) radius: f64,
}

impl Cylinder {
    fn of_square(&self, square: f64) -> f64 {
        0.5 * (square - self.radius * self.radius) / self.radius
    }
}

impl Field for Cylinder {
    fn value(&self, at: &Vector3<f64>) -> f64 {
        self.of_square(at.x * at.x + at.y * at.y)
    }

    fn slope(&self, at: &Vector3<f64>) -> Vector3<f64> {
        Vector3::new(at.x, at.y, 0.0) / self.radius
    }

    fn bounds(&self, low: &Vector3<f64>, high: &Vector3<f64>) -> Bounds {
        let mut sum = [0.0, 0.0];
        for k in 0..2 {
            let nearest = 0.0_f64.clamp(low[k], high[k]);
            sum[0] += nearest * nearest;
            sum[1] += low[k].abs().max(high[k].abs()).powi(2);
        }
        sum.map(|s| self.of_square(s))
    }

    fn slope_bounds(&self, low: &Vector3<f64>, high: &Vector3<f64>) -> [Bounds; 3] {
        [0, 1, 2].map(|k| {
            if k < 2 {
                [low[k] / self.radius, high[k] / self.radius]
            } else {
                [0.0; 2]
            }
        })
    }
}

/// Gives the unknown of a node along an axis a value that it keeps.
pub(crate) fn hold(system: &mut System, a: &mut [f64], unknown: usize, value: f64) {
    system.fixed[unknown] = true;
    a[unknown] = value;
}

/// Nodes on the three planes through the origin move in them only.
pub(crate) fn symmetric(system: &mut System, mesh: &Mesh, near: f64) {
    for k in 0..3 {
        for node in mesh.nodes_where(|x| x[k].abs() < near) {
            system.fixed[3 * node + k] = true;
        }
    }
}

/// A search to a tolerance, without a look at the stability.
pub(crate) fn newton(system: &System, tolerance: f64) -> Newton {
    let control = Control {
        provisional: true,
        tolerance,
        ..Control::default()
    };
    Newton::ordered_by(control, Dissection::by_places(&system.places(), &[]).unwrap())
}

/// The state in balance, from `a`.
pub(crate) fn balance(system: &System, a: &mut Vec<f64>, tolerance: f64) -> Result<Minimum, Failed> {
    newton(system, tolerance).minimise(system, a)
}

/// Forces that hold the nodes of a solid which is alone.
pub(crate) fn forces(solid: &dyn Solid, a: &[f64]) -> Vec<f64> {
    let mut forces = vec![0.0; a.len()];
    solid.gradient(a, &mut forces).unwrap();
    forces
}

/// The displacement of a place of the reference configuration.
pub(crate) fn displacement(mesh: &Mesh, a: &[f64], at: &Vector3<f64>) -> Vector3<f64> {
    let row = mesh.row(at).unwrap();
    row.iter()
        .map(|(n, w)| Vector3::from_column_slice(&a[3 * *n as usize..3 * *n as usize + 3]) * *w)
        .sum()
}
