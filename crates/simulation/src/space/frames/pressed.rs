//! Points held by springs, by the compliance of what they press: `(S + B^T K B) y = B^T f` by `W = B S^-1 B^T` alone.
//!
//! With `K = sum of k d d^T` over a few directions `d` of points, `q = (K^-1 + D^T W D)^-1 D^T W f` are the forces of the springs, and `B y = W (f - D q)`
//! (Woodbury): as many equations as there are directions. By Haynsworth's law of inertia `S + B^T K B` is positive definite where that
//! matrix has as many negative eigenvalues as there are negative springs; these come last, so that the signs of pivots tell.

use nalgebra::{DMatrix, Matrix2, Vector3};

use super::near::Active;
use crate::space::tube::Distance;
use crate::sparse::Dense;

/// Bends below this part of a spring along the normal change nothing that could be seen.
const SMALL_PART: f64 = 1e-9;

/// Springs along directions of points.
#[derive(Debug, Clone, Default)]
pub(super) struct Pressed {
    /// Number of a point among those active, direction, stiffness: those above zero first.
    springs: Vec<(usize, Vector3<f64>, f64)>,
    positive: usize,
    first: Dense,
    last: Dense,
    matrix: DMatrix<f64>,
}

impl Pressed {
    /// Springs of points: `(number among those active, distance, stiffness along the normal, force)`; where `bent`, with those of the normal's turn
    /// under that force. False where the whole is not positive definite.
    pub(super) fn take(
        &mut self,
        points: impl Iterator<Item = (usize, Distance, f64, f64)>,
        bent: bool,
        active: &Active,
    ) -> bool {
        // Positive springs first: the two kinds are eliminated apart, as together they are not definite.
        self.springs.clear();
        let mut negative = Vec::new();
        for (point, distance, stiffness, force) in points {
            self.springs.push((point, distance.gradient, stiffness));
            if bent {
                for (direction, curvature) in bends(&distance) {
                    let spring = (point, direction, -force * curvature);
                    // What is next to nothing would have an inverse that is next to infinite.
                    if spring.2 > SMALL_PART * stiffness {
                        self.springs.push(spring);
                    } else if spring.2 < -SMALL_PART * stiffness {
                        negative.push(spring);
                    }
                }
            }
        }
        self.positive = self.springs.len();
        self.springs.extend(negative);
        self.factor(active)
    }

    fn factor(&mut self, active: &Active) -> bool {
        let count = self.springs.len();
        self.matrix = DMatrix::zeros(count, count);
        for (j, (point, d, stiffness)) in self.springs.iter().enumerate() {
            for (i, (other, e, _)) in self.springs.iter().enumerate().skip(j) {
                let moved = e.dot(&(active.block(*other, *point) * d));
                self.matrix[(i, j)] = moved + if i == j { 1.0 / stiffness } else { 0.0 };
            }
        }
        self.matrix.fill_upper_triangle_with_lower_triangle();
        if !self.first.eliminate(&self.matrix, self.positive) {
            return false;
        }
        // What is left on the negative ones is negative definite.
        self.first.rest(&mut self.matrix);
        self.matrix.neg_mut();
        self.last.factor(&self.matrix)
    }

    /// The forces of the springs against what moves points, by their numbers: `(number, D q)`.
    pub(super) fn holding(&self, moved: &[Vector3<f64>]) -> impl Iterator<Item = (usize, Vector3<f64>)> {
        // Woodbury's formula: only the springs' own equations are solved.
        let mut q: Vec<f64> = self.springs.iter().map(|(point, d, _)| d.dot(&moved[*point])).collect();
        self.first.forward(&mut q);
        let last = &mut q[self.positive..];
        last.iter_mut().for_each(|q| *q = -*q);
        self.last.solve(last);
        self.first.back(&mut q);
        self.springs.iter().zip(q).map(|((point, d, _), q)| (*point, d * q))
    }
}

/// The principal directions of a surface, and its curvatures.
pub(super) fn bends(distance: &Distance) -> [(Vector3<f64>, f64); 2] {
    let normal = distance.gradient;
    // The axis that the normal is least along: never parallel to it. Without a normal there is no direction, and no spring.
    let across = normal.cross(&Vector3::ith(normal.iamin(), 1.0));
    let one = across.try_normalize(0.0).unwrap_or_default();
    let two = normal.cross(&one);
    let entry = |a: &Vector3<f64>, b: &Vector3<f64>| a.dot(&(distance.hessian * b));
    let eigen = Matrix2::new(
        entry(&one, &one),
        entry(&one, &two),
        entry(&one, &two),
        entry(&two, &two),
    )
    .symmetric_eigen();
    [0, 1].map(|k| {
        let v = eigen.eigenvectors.column(k);
        (one * v[0] + two * v[1], eigen.eigenvalues[k])
    })
}
