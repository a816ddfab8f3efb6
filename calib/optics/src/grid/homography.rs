//! The plane of a grid in an image: homographies from points.

use nalgebra::{Matrix2, Matrix3, SMatrix, SVector, Vector2, Vector3};

/// The homography's image of a point; NaN on the horizon.
pub fn project(h: &Matrix3<f64>, at: Vector2<f64>) -> Vector2<f64> {
    let p = h * Vector3::new(at.x, at.y, 1.0);
    Vector2::new(p.x / p.z, p.y / p.z)
}

/// The derivative of [`project`] by the point.
pub fn jacobian(h: &Matrix3<f64>, at: Vector2<f64>) -> Matrix2<f64> {
    let p = h * Vector3::new(at.x, at.y, 1.0);
    let image = Vector2::new(p.x / p.z, p.y / p.z);
    Matrix2::from_fn(|i, j| (h[(i, j)] - image[i] * h[(2, j)]) / p.z)
}

/// Moves the mean to the origin and the mean distance to the root of 2 (Hartley 1997).
fn normalising(points: impl Iterator<Item = Vector2<f64>> + Clone) -> Option<Matrix3<f64>> {
    let n = points.clone().count() as f64;
    let mean = points.clone().sum::<Vector2<f64>>() / n;
    let spread = points.map(|p| (p - mean).norm()).sum::<f64>() / n;
    // No points or one point many times make it infinite or NaN, which is refused below.
    let s = std::f64::consts::SQRT_2 / spread;
    let m = Matrix3::new(s, 0.0, -s * mean.x, 0.0, s, -s * mean.y, 0.0, 0.0, 1.0);
    s.is_finite().then_some(m)
}

/// The homography that maps the first of each pair to the second with the least algebraic error, `h[(2, 2)] = 1` or
/// unit norm where that vanishes; none for fewer than 4 pairs or pairs on a line.
pub fn homography(pairs: &[(Vector2<f64>, Vector2<f64>)]) -> Option<Matrix3<f64>> {
    if pairs.len() < 4 {
        return None;
    }
    let from = normalising(pairs.iter().map(|p| p.0))?;
    let to = normalising(pairs.iter().map(|p| p.1))?;
    // Normal equations square the condition, which the normalising keeps small enough: 81 sums, whatever the number of
    // pairs.
    let mut normal = SMatrix::<f64, 9, 9>::zeros();
    for (a, b) in pairs {
        let (a, b) = (project(&from, *a), project(&to, *b));
        let rows = [
            [a.x, a.y, 1.0, 0.0, 0.0, 0.0, -b.x * a.x, -b.x * a.y, -b.x],
            [0.0, 0.0, 0.0, a.x, a.y, 1.0, -b.y * a.x, -b.y * a.y, -b.y],
        ];
        for row in rows.map(SVector::<f64, 9>::from) {
            normal += row * row.transpose();
        }
    }
    let eigen = normal.symmetric_eigen();
    let mut order: Vec<usize> = (0..9).collect();
    // The decomposition gives eigenvalues in no order.
    order.sort_by(|i, j| eigen.eigenvalues[*i].total_cmp(&eigen.eigenvalues[*j]));
    // A second null direction: the points lie on a line.
    if eigen.eigenvalues[order[1]] <= 1e-12 * eigen.eigenvalues[order[8]] {
        return None;
    }
    let v = eigen.eigenvectors.column(order[0]);
    let m = Matrix3::from_row_slice(v.as_slice());
    let h = to.try_inverse()? * m * from;
    // The entry is the depth of the plane's origin, 0 where that lies on the horizon.
    let scale = if h[(2, 2)].abs() > 1e-9 * h.norm() {
        h[(2, 2)]
    } else {
        h.norm()
    };
    Some(h / scale)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_planted_homography_is_found() {
        let h = Matrix3::new(30.0, -4.0, 250.0, 3.0, 9.0, 200.0, 1e-3, 3e-2, 1.0);
        let at = |i: i32| Vector2::new(f64::from(i % 4), f64::from(i / 4));
        let pairs: Vec<_> = (0..12).map(|i| (at(i), project(&h, at(i)))).collect();
        let found = homography(&pairs).unwrap();
        // The squared condition of the normal equations, about 1e5, times the rounding.
        assert!((found - h).norm() < 1e-8 * h.norm(), "{found}");
        let line: Vec<_> = (0..9).map(|i| (at(i * 4), project(&h, at(i * 4)))).collect();
        assert!(homography(&line).is_none());
        assert!(homography(&pairs[..3]).is_none());
    }

    #[test]
    fn the_jacobian_agrees_with_differences() {
        let h = Matrix3::new(30.0, -4.0, 250.0, 3.0, 9.0, 200.0, 1e-3, 3e-2, 1.0);
        let (at, e) = (Vector2::new(2.0, -3.0), 1e-5);
        let j = jacobian(&h, at);
        for k in 0..2 {
            let step = Vector2::ith(k, e);
            let difference = (project(&h, at + step) - project(&h, at - step)) / (2.0 * e);
            assert!((j.column(k) - difference).norm() < 1e-6);
        }
    }
}
