//! The signed singular value decomposition `F = sum_i s_i u_i v_i^T` with rotations of `u` and `v`, from `G`.
//!
//! One-sided Jacobi (Hestenes 1958) on `F V = V + W`, `W = G V`: `l_i^2 - 1` and the products of columns come from `W`,
//! never as the difference of two numbers near 1, so that the stretches of a tiny strain keep their digits.

use nalgebra::{Matrix3, Vector3};

use super::response::Tensor;

/// Sweeps at most: three or four are used; more only where numbers are not finite.
const SWEEPS: usize = 10;
/// A residual this much shorter than what it is left of has no direction of its own.
const SHORT: f64 = 1e-8;
/// Below it the stretch has more digits than its square less 1.
const SQUEEZED: f64 = -0.5;

/// Stretches and principal directions.
pub(super) struct Principal {
    /// `s_i`, in no order; the one of least magnitude carries the sign of `det F`.
    pub(super) stretches: [f64; 3],
    /// `s_i^2 - 1`.
    excesses: [f64; 3],
    /// `u_i`, in the deformed solid.
    pub(super) left: [Vector3<f64>; 3],
    /// `v_i`, in the reference solid.
    pub(super) right: [Vector3<f64>; 3],
}

impl Principal {
    pub(super) fn of(g: &Tensor) -> Self {
        let (right, moved) = directions(g);
        let excesses: [f64; 3] = std::array::from_fn(|p| product(&right, &moved, p, p));
        let images: [Vector3<f64>; 3] = std::array::from_fn(|p| right[p] + moved[p]);
        // The length of the shortest image would lose the sign of det F, and what rounding mixes in of the longer ones.
        let (left, least) = frame(&images);
        let mut stretches = images.map(|image| image.norm());
        stretches[least] = left[least].dot(&images[least]);
        Self {
            stretches,
            excesses,
            left,
            right,
        }
    }

    /// `ln s_i`. `None` where one is not above zero.
    pub(super) fn logs(&self) -> Option<[f64; 3]> {
        // The least stretch has the sign of `det F`: of an inverted state it has no logarithm.
        let positive = self.stretches.iter().all(|s| *s > 0.0);
        positive.then(|| {
            std::array::from_fn(|p| {
                if self.excesses[p] > SQUEEZED {
                    // Half the logarithm of the square, so that a tiny strain loses nothing to the 1.
                    0.5 * self.excesses[p].ln_1p()
                } else {
                    self.stretches[p].ln()
                }
            })
        })
    }

    /// `u_i v_j^T`.
    pub(super) fn dyad(&self, i: usize, j: usize) -> Tensor {
        let (u, v) = (&self.left[i], &self.right[j]);
        Tensor::from_fn(|entry, _| u[entry % 3] * v[entry / 3])
    }
}

/// `(F v_p) . (F v_q) - v_p . v_q`.
fn product(v: &[Vector3<f64>; 3], w: &[Vector3<f64>; 3], p: usize, q: usize) -> f64 {
    v[p].dot(&w[q]) + w[p].dot(&v[q]) + w[p].dot(&w[q])
}

/// `V`, a rotation, and `W = G V`, with `F V` orthogonal to rounding.
fn directions(g: &Tensor) -> ([Vector3<f64>; 3], [Vector3<f64>; 3]) {
    let g = Matrix3::from_column_slice(g.as_slice());
    let mut v: [Vector3<f64>; 3] = std::array::from_fn(|k| Vector3::ith(k, 1.0));
    let mut w: [Vector3<f64>; 3] = std::array::from_fn(|k| g.column(k).into_owned());
    for _ in 0..SWEEPS {
        let mut turned = false;
        for (p, q) in [(0, 1), (1, 2), (0, 2)] {
            let across = product(&v, &w, p, q);
            let (a, b) = (w[p].norm(), w[q].norm());
            // The rounding of the product itself.
            if across.abs() <= f64::EPSILON * (a + b + a * b) {
                continue;
            }
            turned = true;
            // The smaller of the two rotations that make the columns orthogonal: the iteration converges with it.
            let half = 0.5 * (product(&v, &w, q, q) - product(&v, &w, p, p)) / across;
            // Where the square overflows the angle is next to nothing, and 0 will do.
            let tangent = half.signum() / (half.abs() + (half * half + 1.0).sqrt());
            let cosine = 1.0 / (tangent * tangent + 1.0).sqrt();
            // G V turns as V does; it is never formed anew, which would cost the digits that differences keep.
            for x in [&mut v, &mut w] {
                let (xp, xq) = (x[p], x[q]);
                x[p] = (xp - xq * tangent) * cosine;
                x[q] = (xq + xp * tangent) * cosine;
            }
        }
        // Where no pair was turned, the next sweep would see the same columns and turn none either.
        if !turned {
            break;
        }
    }
    (v, w)
}

/// A rotation whose columns are the directions of three orthogonal vectors but for the shortest, which the other two
/// give; and which one that is.
fn frame(images: &[Vector3<f64>; 3]) -> ([Vector3<f64>; 3], usize) {
    let lengths = images.map(|image| image.norm());
    let least = (0..3).fold(0, |a, b| if lengths[b] < lengths[a] { b } else { a });
    // The longest gives the first direction, as it has the most digits.
    let (mut i, mut j) = ((least + 1) % 3, (least + 2) % 3);
    let cyclic = lengths[i] >= lengths[j];
    if !cyclic {
        (i, j) = (j, i);
    }
    let first = images[i].try_normalize(0.0).unwrap_or_else(Vector3::x);
    let off = |x: &Vector3<f64>| x - first * first.dot(x);
    // Twice, as the first round leaves rounding by the size of the image, which may be more than a short rest.
    let rest = off(&off(&images[j]));
    // Nothing tells a direction across a state of rank one: any will do.
    let second = if rest.norm() > SHORT * lengths[j] {
        rest.try_normalize(0.0)
    } else {
        None
    };
    let second = second.unwrap_or_else(|| {
        // The axis that `first` leans to least leaves the longest rest.
        let axis = first.iamin();
        let across = off(&Vector3::ith(axis, 1.0));
        across / across.norm()
    });
    // The sign makes the three a rotation, so that an inversion shows in the least stretch alone.
    let third = first.cross(&second) * if cyclic { 1.0 } else { -1.0 };
    let mut left = [third; 3];
    left[i] = first;
    left[j] = second;
    (left, least)
}
