//! Horn's polar form, `O = Psi (Psi^T Psi)^(-1/2)` (4.15 to 4.17), with the completion that the printed form lacks.

use nalgebra::{Matrix3, Vector3};

use super::jacobi::symmetric3;

/// The best proper rotation, or `None` where `Psi` has rank below 2 once squared.
///
/// With the eigenvectors `w_k` of `Psi^T Psi`, largest values first, the images `Psi w_k / sqrt(d_k)` of the first two
/// are completed by their vector product: at rank 2 the pseudo-inverse of 4.15 gives no rotation at all (errata), and
/// where `det Psi < 0` the vector product is the flip `I - 2 u u^T` of the least eigenvector.
pub(super) fn rotation(psi: &Matrix3<f64>) -> Option<Matrix3<f64>> {
    let (values, vectors) = symmetric3(psi.transpose() * psi);
    // Sorted and not by the extremes: of three equal values, as of an octahedron, the least and the largest are one.
    let mut order = [0, 1, 2];
    order.sort_by(|a, b| values[*b].total_cmp(&values[*a]));
    let [most, middle, _] = order;
    let image = |k: usize| -> Option<[Vector3<f64>; 2]> {
        let w = vectors.column(k).into_owned();
        // Psi^T Psi has no negative eigenvalue but for rounding.
        let root = values[k].max(0.0).sqrt();
        (root > 0.0).then(|| [psi * w / root, w])
    };
    let [u1, w1] = image(most)?;
    let [u2, w2] = image(middle)?;
    let u3 = u1.cross(&u2);
    let w3 = w1.cross(&w2);
    Some(u1 * w1.transpose() + u2 * w2.transpose() + u3 * w3.transpose())
}
