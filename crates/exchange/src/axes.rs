//! The axes that a file's patient coordinates are along: the one place where they are turned.

use std::str::FromStr;

use geometry::rotation::Rotation;
use geometry::{Rigid, Vector};

/// Which way the three axes of a patient's coordinates point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PatientAxes {
    /// To the patient's left, back and head: DICOM, ITK and Trocar.
    Lps,
    /// To the patient's right, front and head: 3D Slicer inside, NIfTI.
    Ras,
}

impl PatientAxes {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Lps, Self::Ras];

    /// The word in files.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Lps => "LPS",
            Self::Ras => "RAS",
        }
    }

    /// Components along these axes as components along LPS, and LPS as these: the same turn about the third axis by
    /// half a circle. Exact.
    pub fn turned(self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        match self {
            Self::Lps => [x, y, z],
            // Without negative zeros, which some readers print and others refuse.
            Self::Ras => [0.0 - x, 0.0 - y, z],
        }
    }
}

impl FromStr for PatientAxes {
    type Err = String;

    /// From the word of a command line.
    fn from_str(word: &str) -> Result<Self, String> {
        let found = Self::ALL
            .into_iter()
            .find(|axes| axes.name().eq_ignore_ascii_case(word));
        found.ok_or_else(|| "expected lps or ras".to_owned())
    }
}

/// The same transform with the axes of both its frames turned by half a circle about their third: of LPS numbers the RAS ones, and back.
/// Exact.
pub(crate) fn turned_both<To, From>(transform: &Rigid<To, From>) -> Rigid<To, From> {
    let [w, x, y, z] = transform.quaternion();
    rigid([w, -x, -y, z], PatientAxes::Ras.turned(transform.translation_mm()))
}

/// The same with the axes of `To` turned alone: of a transform into LPS the one into RAS, and back. Exact.
pub fn turned_to<To, From>(transform: &Rigid<To, From>) -> Rigid<To, From> {
    let [w, x, y, z] = transform.quaternion();
    // The product with the quaternion (0, 0, 0, 1) of that turn.
    rigid([-z, -y, x, w], PatientAxes::Ras.turned(transform.translation_mm()))
}

/// From the same four numbers in another order and with other signs, which is a unit quaternion again.
fn rigid<To, From>(quaternion: [f64; 4], [x, y, z]: [f64; 3]) -> Rigid<To, From> {
    let rotation = Rotation::from_quaternion(quaternion).unwrap_or(Rotation::IDENTITY);
    Rigid::from_parts(rotation, Vector::new(x, y, z))
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::{Ct, Point, Tracker};

    #[test]
    fn a_transform_is_turned_as_its_points_are() {
        let rotation = Rotation::from_quaternion([0.5, 0.1, -0.7, 0.5]).unwrap();
        let given = Rigid::<Ct, Tracker>::from_parts(rotation, Vector::new(10.0, -20.0, 30.0));
        let ras = |[x, y, z]: [f64; 3]| [-x, -y, z];
        let p = [3.0, 5.0, -7.0];
        let at = |transform: Rigid<Ct, Tracker>, [x, y, z]: [f64; 3]| (transform * Point::new(x, y, z)).mm();
        let near = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-13 * 64.0);
        assert!(near(at(turned_to(&given), p), ras(at(given, p))));
        assert!(near(at(turned_both(&given), ras(p)), ras(at(given, p))));
        assert_eq!(turned_both(&turned_both(&given)), given);
    }

    #[test]
    fn a_turn_and_back_is_the_same_and_only_lps_stays() {
        let v = [1.5, -2.0, 0.0];
        for axes in PatientAxes::ALL {
            assert_eq!(axes.turned(axes.turned(v)), v);
        }
        assert_eq!(PatientAxes::Ras.turned([1.0, 2.0, 3.0]), [-1.0, -2.0, 3.0]);
        assert!(PatientAxes::Ras.turned([0.0; 3]).iter().all(|x| x.is_sign_positive()));
    }
}
