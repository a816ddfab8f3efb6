//! Numbers, vectors and transforms by chance, the same in every run.

use geometry::{Ct, Point, Rigid, Tracker, Vector};

/// Uniform and normal numbers from a seed (xorshift64*; Box and Muller).
pub(crate) struct Random(u64);

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1)
    }

    /// In 0..1.
    pub(crate) fn unit(&mut self) -> f64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// In -1..1.
    pub(crate) fn signed(&mut self) -> f64 {
        2.0 * self.unit() - 1.0
    }

    /// Of mean 0 and deviation 1.
    pub(crate) fn normal(&mut self) -> f64 {
        let radius = (-2.0 * (1.0 - self.unit()).ln()).sqrt();
        radius * (std::f64::consts::TAU * self.unit()).cos()
    }

    pub(crate) fn vector<F>(&mut self, size: f64) -> Vector<F> {
        Vector::new(self.signed() * size, self.signed() * size, self.signed() * size)
    }

    /// Normal noise of deviation `sigma[k]` along axis `k`.
    pub(crate) fn noise<F>(&mut self, sigma: [f64; 3]) -> Vector<F> {
        let [x, y, z] = sigma.map(|s| s * self.normal());
        Vector::new(x, y, z)
    }

    pub(crate) fn transform(&mut self) -> Rigid<Ct, Tracker> {
        Rigid::from_rotation_vector(self.vector(1.8), self.vector(300.0)).unwrap()
    }

    pub(crate) fn cloud(&mut self, n: usize, size: f64) -> Vec<Point<Tracker>> {
        let origin = Point::new(0.0, 0.0, 0.0);
        (0..n).map(|_| origin + self.vector(size)).collect()
    }
}

/// `2 vec(p * conj(q))`, the rotation vector from `q` to `p` where it is small.
pub(crate) fn turn(p: [f64; 4], q: [f64; 4]) -> [f64; 3] {
    let [a, b, c, d] = p;
    let [w, x, y, z] = q;
    let s = (a * w + b * x + c * y + d * z).signum() * 2.0;
    [
        s * (-a * x + b * w - c * z + d * y),
        s * (-a * y + b * z + c * w - d * x),
        s * (-a * z - b * y + c * x + d * w),
    ]
}
