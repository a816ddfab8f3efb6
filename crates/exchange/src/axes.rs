//! The axes that a file's patient coordinates are along: the one place where they are turned.

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

    /// From the word, or the number that 3D Slicer wrote before it had words.
    pub fn of_word(word: &str) -> Option<Self> {
        match word {
            "LPS" | "1" => Some(Self::Lps),
            "RAS" | "0" => Some(Self::Ras),
            _ => None,
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

    /// The rows of a matrix whose product is along these axes, as rows of the one whose product is along LPS, and back.
    /// Exact. The hand stays: it is a turn.
    pub fn turned_rows(self, [x, y, z]: [[f64; 3]; 3]) -> [[f64; 3]; 3] {
        let turn = |row: [f64; 3]| match self {
            Self::Lps => row,
            Self::Ras => row.map(|c| 0.0 - c),
        };
        [turn(x), turn(y), z]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_turn_and_back_is_the_same_and_only_lps_stays() {
        let v = [1.5, -2.0, 0.0];
        for axes in PatientAxes::ALL {
            assert_eq!(axes.turned(axes.turned(v)), v);
            assert_eq!(axes.turned_rows(axes.turned_rows([v; 3])), [v; 3]);
            assert_eq!(PatientAxes::of_word(axes.name()), Some(axes));
        }
        assert_eq!(PatientAxes::Ras.turned([1.0, 2.0, 3.0]), [-1.0, -2.0, 3.0]);
        assert!(PatientAxes::Ras.turned([0.0; 3]).iter().all(|x| x.is_sign_positive()));
        for word in ["", "lps", "2", "IJK", "LAS", "LPS "] {
            assert_eq!(PatientAxes::of_word(word), None, "{word}");
        }
    }
}
