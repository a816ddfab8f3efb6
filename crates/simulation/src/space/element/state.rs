//! The state of an element at one of its points.

use nalgebra::{Matrix3, Vector3};

use super::Table;
use super::modes::MODES;
use crate::law::Law;
use crate::space::law::{Material, excess, vector};

/// What a point of a deformed element is like.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct State {
    /// The displacement gradient `G = F - I`.
    pub gradient: Matrix3<f64>,
    /// Cauchy's stress with the projected pressure: force by deformed area, units of stress.
    pub cauchy: Matrix3<f64>,
    /// `J = det F`.
    pub determinant: f64,
    /// Energy of a unit of reference volume, with the projected measure of volume: its weighted sum over the points is the energy.
    pub density: f64,
}

impl State {
    /// Von Mises' equivalent stress, `sqrt(3/2 s : s)` of the deviator `s` of Cauchy's: zero under pressure alone.
    pub fn von_mises(&self) -> f64 {
        // The mean is taken off before any square, as near incompressibility it may be most of the stress.
        let deviator = self.cauchy - Matrix3::from_diagonal_element(self.cauchy.trace() / 3.0);
        1.5_f64.sqrt() * deviator.norm()
    }

    /// Principal Cauchy stresses, the greatest first: positive where pulled.
    pub fn principal(&self) -> Vector3<f64> {
        let mut values = self.cauchy.symmetric_eigenvalues();
        // By a total order, which a NaN does not break.
        values.as_mut_slice().sort_by(|a, b| b.total_cmp(a));
        values
    }
}

impl Table {
    /// The state at a quadrature point, counted from 0. `None` where there is no such point, where the law has no energy,
    /// or `J <= 0` but with the linear law, which does not tell the deformed area from the reference one: its stress is `P`.
    pub fn state(&self, material: &Material, u: &[f64], point: usize) -> Option<State> {
        if point >= self.points() {
            return None;
        }
        let gradient = self.displacement_gradient(u, point);
        let g = vector(&gradient);
        let theta = if self.mode_count == 0 {
            material.theta(&g)?
        } else {
            self.projected(point, &self.means(material, u)?)
        };
        // What the element's energy has in this place, not what the law alone would give: a plain pressure checkers near nu = 1/2.
        let pressure = material.lame.lambda * theta;
        let (shear, stress) = material.shear_stress(&g)?;
        let piola = Matrix3::from_column_slice((stress + material.volume_slope(&g)?.1 * pressure).as_slice());
        let (density, determinant) = (shear + 0.5 * pressure * theta, 1.0 + excess(&g));
        let linear = material.law == Law::Linear;
        if !(density.is_finite() && (determinant > 0.0 || linear)) {
            return None;
        }
        let pushed = if linear {
            piola
        } else {
            piola * (Matrix3::identity() + gradient).transpose() / determinant
        };
        Some(State {
            gradient,
            // The mean of both shears: they differ by rounding.
            cauchy: (pushed + pushed.transpose()) * 0.5,
            determinant,
            density,
        })
    }

    /// Coefficients of the projected `theta`.
    pub(super) fn means(&self, material: &Material, u: &[f64]) -> Option<[f64; MODES]> {
        let mut means = [0.0; MODES];
        for point in 0..self.points() {
            let g = vector(&self.displacement_gradient(u, point));
            self.add_mean(point, material.theta(&g)?, &mut means);
        }
        Some(means)
    }
}
