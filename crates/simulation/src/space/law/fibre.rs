//! One family of fibres behind a law, after Holzapfel, Gasser and Ogden (2000), without dispersion.

use nalgebra::Vector3;

use super::response::{Tangent, Tensor, add_square};

/// Why a fibre cannot be.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum BadFibre {
    /// The direction has no length, or is not finite.
    #[error("the direction ({x}, {y}, {z}) of a fibre must be finite and not zero")]
    Direction {
        /// Its first entry.
        x: f64,
        /// Its second entry.
        y: f64,
        /// Its third entry.
        z: f64,
    },
    /// A coefficient.
    #[error("{what} of a fibre is {found}; it must be a finite number above 0")]
    Coefficient {
        /// Which one.
        what: &'static str,
        /// The number found.
        found: f64,
    },
}

/// `w_f = k1 / (2 k2) (exp(k2 (I4 - 1)^2) - 1)` for `I4 > 1`, else 0, with `I4 = |F a|^2` of the unit direction `a`.
///
/// Fibres bear no pressure along them. The second derivative jumps at `I4 = 1` by `4 k1`, as in the paper. Where
/// the exponential or a derivative overflows, above `k2 (I4 - 1)^2 = 690` or so, the law has no energy.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fibre {
    direction: Vector3<f64>,
    stiffness: f64,
    exponent: f64,
}

impl Fibre {
    /// A fibre of a direction of any length in the reference solid, `k1` (units of stress) and `k2` (dimensionless).
    ///
    /// # Errors
    /// [`BadFibre`].
    pub fn new(direction: Vector3<f64>, k1: f64, k2: f64) -> Result<Self, BadFibre> {
        let [x, y, z] = direction.into();
        let largest = direction.amax();
        // Each entry is asked for itself, as a NaN may hide from the largest.
        if !(largest > 0.0 && direction.iter().all(|x| x.is_finite())) {
            return Err(BadFibre::Direction { x, y, z });
        }
        for (what, found) in [("k1", k1), ("k2", k2)] {
            if !(found.is_finite() && found > 0.0) {
                return Err(BadFibre::Coefficient { what, found });
            }
        }
        // Of entries up to 1, so that no square over- or underflows.
        let scaled = direction / largest;
        Ok(Self {
            direction: scaled / scaled.norm(),
            stiffness: k1,
            exponent: k2,
        })
    }

    /// The unit direction.
    pub fn direction(&self) -> Vector3<f64> {
        self.direction
    }

    /// `F a` and `I4 - 1 = 2 a . G a + |G a|^2`.
    fn stretched(&self, g: &Tensor) -> (Vector3<f64>, f64) {
        let a = &self.direction;
        let moved = Vector3::from_fn(|i, _| g[i] * a.x + g[i + 3] * a.y + g[i + 6] * a.z);
        // Not `|F a|^2 - 1`, which would leave the rounding of 1 in a small strain.
        (a + moved, 2.0 * a.dot(&moved) + moved.norm_squared())
    }

    /// Density, `2 dw/dI4` and `4 d2w/dI4^2` at `x = I4 - 1`.
    fn derivatives(&self, x: f64) -> [f64; 3] {
        let (k1, k2) = (self.stiffness, self.exponent);
        let y = k2 * x * x;
        // An overflow stays infinite here: the material refuses what is not finite.
        let growth = y.exp();
        // `(e^y - 1) / y`: an exponent next to nothing is a fibre of constant stiffness.
        let mean_growth = if y < f64::MIN_POSITIVE { 1.0 } else { y.exp_m1() / y };
        [
            0.5 * k1 * x * x * mean_growth,
            2.0 * k1 * x * growth,
            4.0 * k1 * (1.0 + 2.0 * y) * growth,
        ]
    }

    /// Density and stress, both zero where the fibre is not stretched. Not finite where the exponential overflows.
    pub(super) fn stress(&self, g: &Tensor) -> (f64, Tensor) {
        let (image, x) = self.stretched(g);
        // A NaN is not stretched either: the law behind refuses it.
        if x.is_nan() || x <= 0.0 {
            return (0.0, Tensor::zeros());
        }
        let [density, first, _] = self.derivatives(x);
        (density, self.dyad(&image) * first)
    }

    /// Adds `2 w' d_ik a_J a_L + 4 w'' (F a)_i a_J (F a)_k a_L`: positive semidefinite.
    pub(super) fn add_tangent(&self, g: &Tensor, tangent: &mut Tangent) {
        let (image, x) = self.stretched(g);
        if x.is_nan() || x <= 0.0 {
            return;
        }
        let [_, first, second] = self.derivatives(x);
        add_square(tangent, &self.dyad(&image), second);
        // What turns the fibre's pull with F: the unit vectors are its three components.
        for i in 0..3 {
            add_square(tangent, &self.dyad(&Vector3::ith(i, 1.0)), first);
        }
    }

    fn dyad(&self, left: &Vector3<f64>) -> Tensor {
        Tensor::from_fn(|entry, _| left[entry % 3] * self.direction[entry / 3])
    }
}
