//! From the numbers of a message to a pose, or why they are none.

use geometry::rotation::RotationMatrix;
use geometry::{Marker, Rigid, Tracker, Vector, checked};
use igtl::rotation::{RotationError, check, check_quaternion};
use igtl::{Matrix, Orientation, Placed, Position};

/// `tracker_from_marker`.
pub(super) type Tool = Rigid<Tracker, Marker>;

/// No localizer sees further, mm.
const FARTHEST_MM: f64 = 1e5;

/// Why numbers are no pose.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub(super) enum PoseError {
    /// The linear part is no rotation.
    #[error("{0}")]
    Rotation(#[from] RotationError),
    /// The place is none.
    #[error("a place {found_mm:e} mm off; allowed are {FARTHEST_MM:e} mm")]
    Far {
        /// Its distance, mm.
        found_mm: f64,
    },
    /// Where nothing can be: numbers in metres, or of nothing that was measured.
    #[error(
        "a place {found_mm:.0} mm from the localizer's origin; localizer.least_distance_mm allows {least_mm} mm and more: are its numbers metres?"
    )]
    Near {
        /// Its distance, mm.
        found_mm: f64,
        /// What is allowed, mm.
        least_mm: f64,
    },
    /// A POSITION that has a place alone.
    #[error("a place without an orientation")]
    NoOrientation,
    /// Not all six degrees of freedom are measured.
    #[error("a tool of kind {0}, of which not all six degrees of freedom are measured")]
    Kind(&'static str),
    /// What is stated of it cannot be known.
    #[error("{0}")]
    Unclear(String),
    /// Numbers that are not finite: igtl lets none through.
    #[error("numbers that are no rigid transform")]
    NotRigid,
}

/// Of a matrix; its columns may be off a rotation by `allowed`, the largest entry of `R^T R - I`, and are put right by the nearest one.
pub(super) fn of_matrix(matrix: &Matrix, allowed: f64) -> Result<Tool, PoseError> {
    check(&matrix.columns, allowed)?;
    let rows = matrix.rows().map(|row| [row[0], row[1], row[2]].map(f64::from));
    let nearest = RotationMatrix::nearest(rows).map_err(|_| PoseError::NotRigid)?;
    let [x, y, z] = placed(matrix.translation)?;
    Ok(Rigid::from_parts(nearest.matrix.rotation(), Vector::new(x, y, z)))
}

/// Of a place and a quaternion x y z w. Its length enters `R` squared, so that half of `allowed` is what it may be off 1.
pub(super) fn of_placed(tool: &Placed, allowed: f64) -> Result<Tool, PoseError> {
    check_quaternion(&tool.quaternion, allowed / 2.0)?;
    let [x, y, z, w] = tool.quaternion.map(f64::from);
    checked::rigid([w, x, y, z], placed(tool.place)?, allowed).map_err(|_| PoseError::NotRigid)
}

/// The same of a POSITION, which may leave the orientation out.
pub(super) fn of_position(position: &Position, allowed: f64) -> Result<Tool, PoseError> {
    let quaternion = match position.orientation {
        Orientation::None => return Err(PoseError::NoOrientation),
        Orientation::Full(whole) => whole,
        // The real part is left out where it is not negative.
        Orientation::Short([x, y, z]) => {
            let rest = 1.0 - x.mul_add(x, y.mul_add(y, z * z));
            [x, y, z, rest.max(0.0).sqrt()]
        }
    };
    let place = position.place;
    of_placed(&Placed { place, quaternion }, allowed)
}

/// `tool`, unless it is nearer to the localizer's origin than `least_mm`.
pub(super) fn not_near(tool: Tool, least_mm: f64) -> Result<Tool, PoseError> {
    let [x, y, z] = tool.translation_mm();
    let found_mm = x.hypot(y).hypot(z);
    match found_mm < least_mm {
        false => Ok(tool),
        true => Err(PoseError::Near { found_mm, least_mm }),
    }
}

/// Whether two poses are further apart than numbers of single precision make of one: by more than `most_rad`, or by eight roundings of the
/// place.
pub(super) fn are_apart(a: &Tool, b: &Tool, most_rad: f64) -> bool {
    let length = |[x, y, z]: [f64; 3]| x.hypot(y).hypot(z);
    let [there, here] = [a, b].map(Rigid::translation_mm);
    let shift = [0, 1, 2].map(|axis| there[axis] - here[axis]);
    let rounding_mm = 8.0 * f64::from(f32::EPSILON) * length(there).max(length(here));
    length(shift) > rounding_mm || (a.inverse() * *b).angle() > most_rad
}

fn placed(place: [f32; 3]) -> Result<[f64; 3], PoseError> {
    let [x, y, z] = place.map(f64::from);
    let found_mm = x.hypot(y).hypot(z);
    match found_mm <= FARTHEST_MM {
        true => Ok([x, y, z]),
        false => Err(PoseError::Far { found_mm }),
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// The largest entry of `R^T R - I` that scenes allow by default.
    const ALLOWED: f64 = 2e-3;

    fn matrix(pose: &Tool) -> Matrix {
        let turned = |axis: [f64; 3]| (*pose * Vector::<Marker>::new(axis[0], axis[1], axis[2])).mm();
        let columns = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(turned);
        let t = pose.translation_mm();
        let row = |r: usize| [columns[0][r], columns[1][r], columns[2][r], t[r]].map(|x| x as f32);
        Matrix::from_rows([row(0), row(1), row(2)])
    }

    fn any_pose() -> impl Strategy<Value = Tool> {
        let number = |most: f64| prop::array::uniform3(-most..most);
        (number(3.0), number(3000.0)).prop_map(|(turn, place)| {
            let vector = |[x, y, z]: [f64; 3]| Vector::new(x, y, z);
            Rigid::from_rotation_vector(vector(turn), vector(place)).unwrap()
        })
    }

    proptest! {
        /// Single precision: 3000 mm are known to 1.3e-4 mm, entries of a rotation to 6e-8.
        #[test]
        fn a_pose_comes_through_a_matrix_and_a_quaternion(pose in any_pose()) {
            let [w, x, y, z] = pose.quaternion().map(|q| q as f32);
            let place = pose.translation_mm().map(|mm| mm as f32);
            let placed = Placed { place, quaternion: [x, y, z, w] };
            for found in [of_matrix(&matrix(&pose), ALLOWED).unwrap(), of_placed(&placed, ALLOWED).unwrap()] {
                let off = pose.inverse() * found;
                prop_assert!(off.angle() < 1e-6, "{off:?}");
                let shifts = found.translation_mm().into_iter().zip(pose.translation_mm());
                prop_assert!(shifts.into_iter().all(|(a, b)| (a - b).abs() < 2e-4));
                prop_assert!(!are_apart(&found, &pose, 1e-5));
            }
        }
    }

    #[test]
    fn what_is_no_rotation_is_refused_by_name() {
        let good =
            matrix(&Rigid::from_rotation_vector(Vector::new(0.3, 0.2, -0.9), Vector::new(1.0, 2.0, -1500.0)).unwrap());
        let with = |change: fn(&mut Matrix)| {
            let mut bad = good;
            change(&mut bad);
            of_matrix(&bad, ALLOWED).unwrap_err().to_string()
        };
        assert!(with(|m| m.columns[0] = m.columns[0].map(|x| -x)).contains("mirrors"));
        assert!(with(|m| m.columns = [[0.0; 3]; 3]).contains("length 0"));
        assert!(with(|m| m.columns = m.columns.map(|c| c.map(|x| 1000.0 * x))).contains("scales by 1000"));
        assert!(with(|m| m.columns[1][2] += 0.01).contains("off a rotation by"));
        assert!(with(|m| m.translation[1] = 2e5).contains("a place 2.0000"));
        let placed = |quaternion| {
            of_placed(
                &Placed {
                    place: [0.0; 3],
                    quaternion,
                },
                ALLOWED,
            )
            .unwrap_err()
            .to_string()
        };
        assert!(placed([0.0; 4]).contains("length 0"));
        assert!(placed([0.0, 0.0, 0.0, 1.002]).contains("length 1.002"));
        let none = Position {
            place: [0.0; 3],
            orientation: Orientation::None,
        };
        assert_eq!(of_position(&none, ALLOWED), Err(PoseError::NoOrientation));
    }

    /// Trackers that were recorded are off a rotation by up to 5.3e-4.
    #[test]
    fn what_is_a_little_off_is_put_right() {
        let mut columns = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        columns[0][1] = 5e-4;
        let found = of_matrix(
            &Matrix {
                columns,
                translation: [0.0; 3],
            },
            ALLOWED,
        )
        .unwrap();
        // The nearest rotation halves a shear.
        assert!((found.angle() - 2.5e-4).abs() < 1e-7, "{found:?}");
    }
}
