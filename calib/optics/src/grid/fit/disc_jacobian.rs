//! The image of a disc by the grid's homography: where its centre goes, and how its outline moves with the entries.

use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};

/// A cell as a point of the grid's plane.
pub(crate) fn point(cell: [i32; 2]) -> Vector2<f64> {
    Vector2::new(f64::from(cell[0]), f64::from(cell[1]))
}

/// Derivatives of an ellipse's centre and shape (xx, xy, yy) by the entries of the homography and the radius.
pub(crate) fn ellipse_slopes(h: &Matrix3<f64>, at: Vector2<f64>, radius: f64) -> [[f64; 9]; 5] {
    let a = Vector3::new(at.x, at.y, 1.0);
    // A line l touches the circle where (l . a)^2 = r^2 (l_x^2 + l_y^2): its dual conic is a a^T - r^2 diag(1, 1, 0).
    let mut dual = a * a.transpose();
    dual[(0, 0)] -= radius * radius;
    dual[(1, 1)] -= radius * radius;
    // The dual conic goes through a homography as H C H^T, and its derivative needs no inverse.
    let image = h * dual * h.transpose();
    let w = image[(2, 2)];
    let centre = Vector2::new(image[(0, 2)], image[(1, 2)]) / w;
    // That of an ellipse of centre c and shape S is w (c c^T - S, c; c^T, 1), so that S = c c^T - upper.
    let upper: Matrix2<f64> = image.fixed_view::<2, 2>(0, 0) / w;
    let mut out = [[0.0; 9]; 5];
    for k in 0..9 {
        let change = if k < 8 {
            let mut part = Matrix3::zeros();
            // By the entry (i, j) the derivative of H D H^T is e_i (row j of D H^T), and its transpose.
            part.set_row(k / 3, &(dual * h.transpose()).row(k % 3));
            part + part.transpose()
        } else {
            let columns = h.fixed_view::<3, 2>(0, 0);
            -2.0 * radius * columns * columns.transpose()
        };
        // By the quotient rule, as centre and shape are the conic's entries over w.
        let turn = change[(2, 2)] / w;
        let dc = Vector2::new(change[(0, 2)], change[(1, 2)]) / w - centre * turn;
        let ds =
            dc * centre.transpose() + centre * dc.transpose() - (change.fixed_view::<2, 2>(0, 0) / w - upper * turn);
        let all = [dc.x, dc.y, ds[(0, 0)], ds[(0, 1)], ds[(1, 1)]];
        all.iter().zip(&mut out).for_each(|(value, row)| row[k] = *value);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::disc::Ellipse;

    #[test]
    fn slopes_of_an_ellipse_agree_with_differences() {
        let h = Matrix3::new(30.0, -4.0, 250.0, 3.0, 9.0, 200.0, 1e-3, 3e-2, 1.0);
        let (at, radius) = (Vector2::new(3.0, 7.0), 0.19);
        let slopes = ellipse_slopes(&h, at, radius);
        for k in 0..9 {
            let e = [1e-4, 1e-4, 1e-3, 1e-4, 1e-4, 1e-3, 1e-7, 1e-7, 1e-5][k];
            let moved = |sign: f64| {
                let (mut g, mut r) = (h, radius);
                if k < 8 {
                    g[(k / 3, k % 3)] += sign * e
                } else {
                    r += sign * e
                }
                let ellipse = Ellipse::of_circle(&g, at, r).unwrap();
                let s = ellipse.shape;
                [ellipse.centre.x, ellipse.centre.y, s[(0, 0)], s[(0, 1)], s[(1, 1)]]
            };
            let (up, down) = (moved(1.0), moved(-1.0));
            for (i, row) in slopes.iter().enumerate() {
                let difference = (up[i] - down[i]) / (2.0 * e);
                let error = (row[k] - difference).abs();
                let allowed = 1e-4 * (1.0 + difference.abs());
                assert!(error < allowed, "{k} {i}: {} {difference}", row[k]);
            }
        }
    }
}
