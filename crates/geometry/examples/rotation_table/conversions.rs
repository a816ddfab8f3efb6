//! What is measured: the six conversions of section 2.5 and the exponential and logarithm of 4-space.

use geometry::rotation::{Log4, Rotation, Rotation4, RotationMatrix, RotationVector};
use nalgebra::{Matrix3, Quaternion, Rotation3, UnitQuaternion, Vector3};
use serde_json::Value;

use crate::rotation_support::inputs;

/// A conversion by one library, from a case of the references to numbers.
pub(crate) struct Conversion {
    pub(crate) name: &'static str,
    pub(crate) by: &'static str,
    pub(crate) dimension: &'static str,
    /// The key of the right answer, and how many numbers it has.
    pub(crate) answer: &'static str,
    pub(crate) count: usize,
    /// Whether only the vector part of a quaternion is compared, relative to its own norm.
    pub(crate) vector_part: bool,
    pub(crate) run: fn(&Value) -> Vec<f64>,
}

pub(crate) fn vector(case: &Value) -> RotationVector {
    RotationVector::new(inputs(case, "w")).unwrap()
}

pub(crate) fn quaternion(case: &Value) -> Rotation {
    Rotation::from_quaternion(inputs(case, "q_in")).unwrap()
}

pub(crate) fn matrix(case: &Value) -> RotationMatrix {
    let m: [f64; 9] = inputs(case, "M_in");
    RotationMatrix::new([[m[0], m[1], m[2]], [m[3], m[4], m[5]], [m[6], m[7], m[8]]], 1e-15).unwrap()
}

pub(crate) fn matrix4(case: &Value) -> [[f64; 4]; 4] {
    let m: [f64; 16] = inputs(case, "M_in");
    std::array::from_fn(|i| std::array::from_fn(|j| m[4 * i + j]))
}

pub(crate) fn log4(case: &Value) -> Log4 {
    Log4::new(inputs(case, "h")).unwrap()
}

pub(crate) fn na_vector(case: &Value) -> Vector3<f64> {
    Vector3::from(inputs::<3>(case, "w"))
}

pub(crate) fn na_quaternion(case: &Value) -> UnitQuaternion<f64> {
    let [s, x, y, z] = inputs(case, "q_in");
    UnitQuaternion::new_normalize(Quaternion::new(s, x, y, z))
}

pub(crate) fn na_matrix(case: &Value) -> Rotation3<f64> {
    Rotation3::from_matrix_unchecked(Matrix3::from_row_slice(&inputs::<9>(case, "M_in")))
}

fn wijk(q: &UnitQuaternion<f64>) -> Vec<f64> {
    vec![q.w, q.i, q.j, q.k]
}

fn by_rows(m: &Rotation3<f64>) -> Vec<f64> {
    m.matrix().transpose().as_slice().to_vec()
}

/// One conversion of space: its name, the key and size of the answer, and the two libraries' ways.
type Pair = (
    &'static str,
    &'static str,
    usize,
    [(&'static str, fn(&Value) -> Vec<f64>); 2],
);

fn in_space() -> [Pair; 7] {
    [
        (
            "w -> q",
            "q",
            4,
            [
                ("ours", |c| Rotation::from_vector(vector(c)).quaternion().to_vec()),
                ("nalgebra `from_scaled_axis`", |c| {
                    wijk(&UnitQuaternion::from_scaled_axis(na_vector(c)))
                }),
            ],
        ),
        (
            "w -> M",
            "M",
            9,
            [
                ("ours", |c| vector(c).matrix().rows().as_flattened().to_vec()),
                ("nalgebra `Rotation3::from_scaled_axis`", |c| {
                    by_rows(&Rotation3::from_scaled_axis(na_vector(c)))
                }),
            ],
        ),
        (
            "q -> w",
            "w_from_q",
            3,
            [
                ("ours", |c| quaternion(c).vector().radians().to_vec()),
                ("nalgebra `scaled_axis`", |c| {
                    na_quaternion(c).scaled_axis().as_slice().to_vec()
                }),
            ],
        ),
        (
            "q -> M",
            "M_from_q",
            9,
            [
                ("ours", |c| quaternion(c).matrix().rows().as_flattened().to_vec()),
                ("nalgebra `to_rotation_matrix`", |c| {
                    by_rows(&na_quaternion(c).to_rotation_matrix())
                }),
            ],
        ),
        (
            "M -> q",
            "q_from_M",
            4,
            [
                ("ours", |c| matrix(c).rotation().quaternion().to_vec()),
                ("nalgebra `from_rotation_matrix`", |c| {
                    wijk(&UnitQuaternion::from_rotation_matrix(&na_matrix(c)))
                }),
            ],
        ),
        (
            "M -> w",
            "w_from_M",
            3,
            [
                ("ours", |c| matrix(c).vector().radians().to_vec()),
                ("nalgebra `Rotation3::scaled_axis`", |c| {
                    na_matrix(c).scaled_axis().as_slice().to_vec()
                }),
            ],
        ),
        (
            "M -> q -> w",
            "w_from_M",
            3,
            [
                ("ours", |c| matrix(c).rotation().vector().radians().to_vec()),
                ("nalgebra `from_rotation_matrix`, `scaled_axis`", |c| {
                    UnitQuaternion::from_rotation_matrix(&na_matrix(c))
                        .scaled_axis()
                        .as_slice()
                        .to_vec()
                }),
            ],
        ),
    ]
}

pub(crate) fn conversions() -> Vec<Conversion> {
    let space = in_space().into_iter().flat_map(|(name, answer, count, ways)| {
        ways.map(|(by, run)| Conversion {
            name,
            by,
            dimension: "so3",
            answer,
            count,
            vector_part: false,
            run,
        })
    });
    let whole: Vec<_> = space.chain(in_4_space()).collect();
    let parts: Vec<_> = whole
        .iter()
        .filter(|c| c.count == 4)
        .map(|c| Conversion {
            vector_part: true,
            ..*c
        })
        .collect();
    whole.into_iter().chain(parts).collect()
}

fn in_4_space() -> [Conversion; 2] {
    let (by, dimension) = ("ours", "so4");
    [
        Conversion {
            name: "H -> M, 4-D",
            by,
            dimension,
            answer: "M",
            count: 16,
            vector_part: false,
            run: |c| log4(c).exp().matrix().as_flattened().to_vec(),
        },
        Conversion {
            name: "M -> H, 4-D",
            by,
            dimension,
            answer: "h_from_M",
            count: 6,
            vector_part: false,
            run: |c| {
                Rotation4::from_matrix(matrix4(c), 1e-14)
                    .unwrap()
                    .0
                    .log()
                    .radians()
                    .to_vec()
            },
        },
    ]
}
