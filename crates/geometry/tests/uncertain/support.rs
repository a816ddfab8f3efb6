//! Random transforms and covariances, and small motions, for the tests of uncertain transforms.

use geometry::rotation::{Rotation, RotationVector};
use geometry::{Rigid, Vector};
use nalgebra::{Matrix6, Vector6};

/// Numbers that are the same in every run (splitmix64).
pub(crate) struct Chance(pub(crate) u64);

impl Chance {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / 2f64.powi(53)
    }

    pub(crate) fn signed(&mut self) -> f64 {
        2.0 * self.unit() - 1.0
    }

    pub(crate) fn normal(&mut self) -> f64 {
        let radius = (-2.0 * (1.0 - self.unit()).ln()).sqrt();
        radius * (std::f64::consts::TAU * self.unit()).cos()
    }

    pub(crate) fn vector<F>(&mut self, size: f64) -> Vector<F> {
        Vector::new(self.signed() * size, self.signed() * size, self.signed() * size)
    }

    pub(crate) fn rigid<A, B>(&mut self, size_mm: f64) -> Rigid<A, B> {
        Rigid::from_rotation_vector(self.vector(2.5), self.vector(size_mm)).unwrap()
    }

    /// A factor L of a covariance L L^T, of deviations about `turn` rad and `shift` mm.
    pub(crate) fn factor(&mut self, turn: f64, shift: f64) -> Matrix6<f64> {
        Matrix6::from_fn(|i, _| self.signed() * if i < 3 { turn } else { shift })
    }

    pub(crate) fn normals(&mut self) -> Vector6<f64> {
        Vector6::from_fn(|_, _| self.normal())
    }
}

/// The motion p -> exp(w) p + v.
pub(crate) fn motion<F>(m: Vector6<f64>) -> Rigid<F, F> {
    let turn = Rotation::from_vector(RotationVector::new([m[0], m[1], m[2]]).unwrap());
    Rigid::from_parts(turn, Vector::new(m[3], m[4], m[5]))
}

/// The (w, v) with `actual` = motion(w, v) `nominal`.
pub(crate) fn difference<A, B>(actual: Rigid<A, B>, nominal: Rigid<A, B>) -> Vector6<f64> {
    let motion = actual * nominal.inverse();
    let ([a, b, c], [x, y, z]) = (motion.rotation().vector().radians(), motion.translation_mm());
    Vector6::new(a, b, c, x, y, z)
}
