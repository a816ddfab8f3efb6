//! Between RAS, which patients on the wire are in, and LPS: x and y change their signs.

use crate::body::image::{Image, Space};
use crate::body::pose::Matrix;

/// A place or a direction of one in the other; it is its own inverse.
pub fn turned([x, y, z]: [f32; 3]) -> [f32; 3] {
    [-x, -y, z]
}

/// `ras_from_a` of `lps_from_a`, and the reverse: the frame that is mapped from stays as it is.
pub fn turned_target(matrix: &Matrix) -> Matrix {
    Matrix {
        columns: matrix.columns.map(turned),
        translation: turned(matrix.translation),
    }
}

/// The same motion where both frames are turned: `S R S` and `S t` with `S = diag(-1, -1, 1)`.
pub fn turned_both(matrix: &Matrix) -> Matrix {
    let Matrix { columns: [x, y, z], .. } = turned_target(matrix);
    Matrix {
        columns: [x.map(|n| -n), y.map(|n| -n), z],
        ..turned_target(matrix)
    }
}

/// The steps and the middle of an image in this space, whichever its sender states.
pub fn placed_in(image: &Image<'_>, space: Space) -> Matrix {
    if image.space == space {
        image.placed
    } else {
        turned_target(&image.placed)
    }
}
