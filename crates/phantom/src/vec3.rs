//! The few operations on triples that the shapes need; millimetres in the patient's axes.

pub(crate) type Vec3 = [f64; 3];

pub(crate) fn add(a: Vec3, b: Vec3) -> Vec3 {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

pub(crate) fn sub(a: Vec3, b: Vec3) -> Vec3 {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(crate) fn scale(a: Vec3, s: f64) -> Vec3 {
    [a[0] * s, a[1] * s, a[2] * s]
}

pub(crate) fn dot(a: Vec3, b: Vec3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn norm(a: Vec3) -> f64 {
    dot(a, a).sqrt()
}

pub(crate) fn lerp(a: Vec3, b: Vec3, s: f64) -> Vec3 {
    add(a, scale(sub(b, a), s))
}

/// `a` mirrored in the median plane where `side` is -1, `a` itself where it is +1.
pub(crate) fn mirror(a: Vec3, side: f64) -> Vec3 {
    [a[0] * side, a[1], a[2]]
}

/// Orthonormal rows x', y', z' with z' along `long` and x' as near to the patient's x as can be.
///
/// `long` must not lie along x; the anatomy's long axes all run up and down.
pub(crate) fn upright(long: Vec3) -> [Vec3; 3] {
    let z = scale(long, 1.0 / norm(long));
    let x = sub([1.0, 0.0, 0.0], scale(z, z[0]));
    let x = scale(x, 1.0 / norm(x));
    let y = [
        z[1] * x[2] - z[2] * x[1],
        z[2] * x[0] - z[0] * x[2],
        z[0] * x[1] - z[1] * x[0],
    ];
    [x, y, z]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn upright_rows_are_a_rotation() {
        let rows = upright([0.3, -0.5, 2.0]);
        for (i, a) in rows.iter().enumerate() {
            for (j, b) in rows.iter().enumerate() {
                let want = if i == j { 1.0 } else { 0.0 };
                // Some ten roundings of numbers below one.
                assert!((dot(*a, *b) - want).abs() < 1e-14);
            }
        }
        assert!(rows[0][0] > 0.9 && rows[1][1] > 0.9);
    }
}
