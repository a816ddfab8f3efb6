//! The singular value decomposition of `Psi` and the rotation it gives (Arun 1987, Umeyama 1991).

use nalgebra::{Matrix3, Vector3};

use super::SingularValues;
use super::jacobi::one_sided;

/// `Psi = U diag(s) V^T` with `U` and `V` proper rotations: the third value carries the sign of the determinant.
pub(super) struct Decomposition {
    pub(super) u: Matrix3<f64>,
    pub(super) v: Matrix3<f64>,
    pub(super) values: SingularValues,
}

impl Decomposition {
    /// Of a finite matrix whose size is within 1e-100 to 1e100.
    ///
    /// One-sided Jacobi: the error is a few units of the largest value, also where the others are smaller by 1e14.
    /// nalgebra's `Matrix3::svd` decomposes `Psi^T Psi` and loses half the digits.
    pub(super) fn of(psi: &Matrix3<f64>) -> Self {
        let (columns, right) = one_sided(*psi);
        let norms: Vector3<f64> = Vector3::from_fn(|i, _| columns.column(i).norm());
        let order = descending(&norms);
        let [u1, u2] = [0, 1].map(|i| columns.column(order[i]).into_owned());
        let [v1, v2] = [0, 1].map(|i| right.column(order[i]).into_owned());
        // A zero matrix has no direction; any will do, as its values of zero are refused as undetermined.
        let u1 = u1.try_normalize(0.0).unwrap_or_else(Vector3::x);
        let u2 = orthogonal_unit(&u1, &u2);
        // Once sorted, either basis may be left-handed: third vectors by the vector product make both proper rotations.
        let (u3, v3) = (u1.cross(&u2), v1.cross(&v2));
        // s3 = u3^T Psi v3 with its sign, which the norm of the third column lacks.
        let third = u3.dot(&(psi * v3));
        Self {
            u: Matrix3::from_columns(&[u1, u2, u3]),
            v: Matrix3::from_columns(&[v1, v2, v3]),
            values: SingularValues([norms[order[0]], norms[order[1]], third]),
        }
    }

    /// The best proper rotation, `U V^T`. Where `det Psi < 0` this already is `V diag(1, 1, det) U^T` of the thesis:
    /// both factors are proper, so that the reflection sits in the sign of the third value.
    pub(super) fn rotation(&self) -> Matrix3<f64> {
        self.u * self.v.transpose()
    }
}

fn descending(v: &Vector3<f64>) -> [usize; 3] {
    let mut order = [0, 1, 2];
    order.sort_by(|&i, &j| v[j].total_cmp(&v[i]));
    order
}

/// The unit vector of `v` once its part along the unit vector `axis` is gone; any orthogonal one where nothing is left.
fn orthogonal_unit(axis: &Vector3<f64>, v: &Vector3<f64>) -> Vector3<f64> {
    // Jacobi leaves columns orthogonal relative to their lengths, so of a true second column nearly all is left; where
    // less than half is, squares have underflowed and its direction says nothing.
    let rest = v.try_normalize(0.0).map(|v| v - axis * axis.dot(&v));
    // The coordinate axis least along `axis` is 54 degrees from it at least, so that the product is well above zero.
    let any = || axis.cross(&Matrix3::identity().column(axis.iamin()).into_owned());
    rest.and_then(|v| v.try_normalize(0.5))
        .or_else(|| any().try_normalize(0.0))
        .unwrap_or_else(Vector3::y)
}
