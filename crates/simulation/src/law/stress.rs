//! The stress that a material bears where it is now: Cauchy's, in plane strain.

use nalgebra::{Matrix2, Vector4};

use super::response::{excess, vector};
use super::{Law, Material};

/// Cauchy's stress: force by deformed area, the third direction held.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stress {
    /// In the plane: `(xx, yy, xy)`.
    pub plane: [f64; 3],
    /// Across the plane: what it takes to keep the third stretch 1.
    pub across: f64,
}

impl Stress {
    /// The principal stresses in the plane, the greater first: positive where pulled.
    pub fn principal(&self) -> [f64; 2] {
        let [xx, yy, xy] = self.plane;
        let (mean, half) = (0.5 * (xx + yy), (0.5 * (xx - yy)).hypot(xy));
        [mean + half, mean - half]
    }

    /// The angle of the direction of the greater one from x, radians, in `(-pi/2, pi/2]`; 0 where both are equal.
    pub fn direction(&self) -> f64 {
        let [xx, yy, xy] = self.plane;
        0.5 * (2.0 * xy).atan2(xx - yy)
    }

    /// Von Mises' equivalent stress, `sqrt(3/2 s : s)` of the deviator `s` in three dimensions: zero under pressure alone.
    pub fn von_mises(&self) -> f64 {
        let ([a, b], c) = (self.principal(), self.across);
        (0.5 * ((a - b).powi(2) + (b - c).powi(2) + (c - a).powi(2))).sqrt()
    }
}

impl Material {
    /// Cauchy's stress at a displacement gradient: `P F^T / J`. `None` where the energy is none, or `det F <= 0`.
    ///
    /// The linear law does not tell the deformed area from the reference one: its stress is `P`.
    pub fn cauchy(&self, g: &Matrix2<f64>) -> Option<Stress> {
        self.state(g, None).map(|(_, stress)| stress)
    }

    /// Energy density and stress; with `theta` in place of the law's measure of volume, as the mixed form has it.
    pub(crate) fn state(&self, g: &Matrix2<f64>, theta: Option<f64>) -> Option<(f64, Stress)> {
        let (lambda, volume, shear) = (self.lame.lambda, self.volume(g)?, self.shear(g)?);
        let theta = theta.unwrap_or(volume.theta);
        let (density, pressure) = (shear.density + 0.5 * lambda * theta * theta, lambda * theta);
        let piola = shear.stress + volume.gradient * pressure;
        let entries = vector(g);
        let x = excess(&entries);
        let j = 1.0 + x;
        // The linear law stretches no area, so that its stress needs no `J`.
        if !(density.is_finite() && (j > 0.0 || self.law == Law::Linear)) {
            return None;
        }
        // Derivatives by the third stretch at 1, of the law in three dimensions.
        let across = match self.law {
            Law::StableNeoHookean => self.lame.mu * x * x + pressure * j,
            _ => pressure,
        };
        let stress = match self.law {
            Law::Linear => Stress {
                plane: [piola[0], piola[3], piola[1]],
                across,
            },
            _ => pushed(&piola, &entries, j, across),
        };
        Some((density, stress))
    }
}

/// `P F^T / J`, symmetric because energy does not change with a rotation.
fn pushed(p: &Vector4<f64>, g: &Vector4<f64>, j: f64, across: f64) -> Stress {
    let f = [1.0 + g[0], g[1], g[2], 1.0 + g[3]];
    let entry = |row: usize, column: usize| (p[row] * f[column] + p[row + 2] * f[column + 2]) / j;
    Stress {
        // The mean of both shears: they differ by rounding.
        plane: [entry(0, 0), entry(1, 1), 0.5 * (entry(0, 1) + entry(1, 0))],
        across: across / j,
    }
}

#[cfg(test)]
mod tests {
    use super::super::Ogden;
    use super::*;

    const LAWS: [Law; 3] = [Law::StVenantKirchhoff, Law::NeoHookean, Law::StableNeoHookean];

    fn gradient(k: u32) -> Matrix2<f64> {
        let x = f64::from(k);
        Matrix2::new(
            0.2 * x.sin(),
            0.15 * (2.1 * x).cos(),
            0.2 * (1.3 * x).sin(),
            0.25 * (0.7 * x).cos(),
        )
    }

    /// The laws in three dimensions, written from their definitions: `F` in the plane, and a third stretch.
    fn solid_density(law: Law, lambda: f64, mu: f64, g: &Matrix2<f64>, third: f64) -> f64 {
        let f = Matrix2::identity() + g;
        let (trace, j) = (f.norm_squared() + third * third, f.determinant() * third);
        match law {
            Law::StVenantKirchhoff => {
                let e = (f.transpose() * f - Matrix2::identity()) * 0.5;
                let e33 = 0.5 * (third * third - 1.0);
                0.5 * lambda * (e.trace() + e33).powi(2) + mu * (e.norm_squared() + e33 * e33)
            }
            Law::NeoHookean => 0.5 * mu * (trace - 3.0) - mu * j.ln() + 0.5 * lambda * j.ln().powi(2),
            _ => 0.5 * mu * (trace - 3.0) - mu * (j - 1.0) + 0.5 * (lambda + mu) * (j - 1.0).powi(2),
        }
    }

    #[test]
    fn the_stress_across_is_the_derivative_by_the_third_stretch() {
        let h = 1e-5;
        for law in LAWS {
            let material = Material::new(law, 1.7, 0.3).unwrap();
            let (lambda, mu) = (material.lame.lambda, material.lame.mu);
            for g in (0..20).map(gradient) {
                let at = |third: f64| solid_density(law, lambda, mu, &g, third);
                let j = (Matrix2::identity() + g).determinant();
                let difference = (at(1.0 + h) - at(1.0 - h)) / (2.0 * h) / j;
                let across = material.cauchy(&g).unwrap().across;
                // h^2 times a third derivative of about 10 times the modulus, and rounding 1e-16 / h.
                assert!((across - difference).abs() < 1e-8, "{law:?} {across} {difference}");
                let density = material.density(&g).unwrap();
                assert!((at(1.0) - density).abs() < 1e-13, "{law:?}");
            }
        }
    }

    #[test]
    fn stress_turns_with_the_solid() {
        let turn = |angle: f64| Matrix2::new(angle.cos(), -angle.sin(), angle.sin(), angle.cos());
        let laws = LAWS.into_iter().chain([Law::Ogden(Ogden::new(&[(1.0, 3.0)]).unwrap())]);
        for law in laws {
            let material = Material::new(law, 1.0, 0.25).unwrap();
            for g in (0..20).map(gradient) {
                let (still, r) = (material.cauchy(&g).unwrap(), turn(0.8));
                let turned = r * (Matrix2::identity() + g) - Matrix2::identity();
                let after = material.cauchy(&turned).unwrap();
                let tensor = |s: &Stress| Matrix2::new(s.plane[0], s.plane[2], s.plane[2], s.plane[1]);
                let expected = r * tensor(&still) * r.transpose();
                assert!((tensor(&after) - expected).amax() < 1e-13, "{law:?}");
                assert!((after.von_mises() - still.von_mises()).abs() < 1e-13);
                let along = after.direction() - still.direction() - 0.8;
                let half_turns = along / std::f64::consts::PI;
                assert!((half_turns - half_turns.round()).abs() < 1e-9, "{law:?} {along}");
            }
        }
    }

    #[test]
    fn planted_stresses() {
        // A bar held across both ways, linear: sigma = (lambda + 2 mu) e along, lambda e across.
        let material = Material::new(Law::Linear, 2.0, 0.25).unwrap();
        let (lambda, mu) = (material.lame.lambda, material.lame.mu);
        let stress = material.cauchy(&Matrix2::new(1e-3, 0.0, 0.0, 0.0)).unwrap();
        let expected = [(lambda + 2.0 * mu) * 1e-3, lambda * 1e-3];
        assert!((stress.principal()[0] - expected[0]).abs() < 1e-17);
        assert!((stress.principal()[1] - expected[1]).abs() < 1e-17);
        // Two equal stresses: von Mises' is their difference to the third.
        assert!((stress.von_mises() - 2.0 * mu * 1e-3).abs() < 1e-17);
        assert_eq!(stress.direction(), 0.0);
        let even = Stress {
            plane: [-3.0, -3.0, 0.0],
            across: -3.0,
        };
        assert_eq!((even.von_mises(), even.principal()), (0.0, [-3.0, -3.0]));
        // Turned inside out: no stress.
        let svk = Material::new(Law::StVenantKirchhoff, 1.0, 0.3).unwrap();
        assert!(svk.cauchy(&Matrix2::new(-2.0, 0.0, 0.0, 0.0)).is_none());
    }
}
