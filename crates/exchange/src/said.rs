//! What a person says of a file that does not say it itself, and what is refused until she does.

use crate::{LengthUnit, NamedAxes, NamedUnit, PatientAxes};

/// No coordinate of a patient is larger, mm: ten metres from the origin of a scanner's coordinates there is no patient.
pub const MAX_MM: f64 = 1e4;
/// Where nothing in a file is larger than this it is taken for metres that are called millimetres: no person is larger,
/// and no operation is so small.
pub const METRES_BELOW: f64 = 2.0;

/// What whoever hands a file over says of it.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Said {
    /// Its axes.
    pub axes: Option<PatientAxes>,
    /// Its unit.
    pub unit: Option<LengthUnit>,
}

/// Why it is not settled where in the patient a file's numbers are.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Unsettled {
    /// Neither the file nor a person says the axes.
    #[error(
        "the file does not say whether its coordinates are LPS or RAS, and a wrong guess mirrors left and right; say it (--frame)"
    )]
    NoAxes,
    /// The file says other axes than a person.
    #[error("the file says {} and it was said to be {}; one of them is wrong, and nothing was taken", .file.name(), .said.name())]
    OtherAxes {
        /// Those of the file.
        file: PatientAxes,
        /// Those that were said.
        said: PatientAxes,
    },
    /// A comment of the file names other axes than it, or a person, says.
    #[error(
        "a comment of the file has the word {comment} and its axes would be {}; one of them is wrong, and nothing was taken. Say what the \
         comment says, or take the word out of it",
        .taken.name()
    )]
    Comment {
        /// The letters of those that the comment names.
        comment: String,
        /// Those that would be taken.
        taken: PatientAxes,
    },
    /// A comment of the file names another unit than is to be taken.
    #[error(
        "a comment of the file has the word {comment:?} and its numbers would be taken in {}; one of them is wrong, and nothing was taken. Write \
         the file in mm, or take the word out of it",
        .taken.name()
    )]
    CommentUnit {
        /// The word.
        comment: String,
        /// The unit that would be taken.
        taken: LengthUnit,
    },
    /// The file says another unit than a person.
    #[error("the file says {} and it was said to be in {}; one of them is wrong, and nothing was taken", .file.name(), .said.name())]
    OtherUnit {
        /// That of the file.
        file: LengthUnit,
        /// The one that was said.
        said: LengthUnit,
    },
    /// All of it would lie within a cherry.
    #[error(
        "{what} is {found} in the file's numbers: that looks like metres, and millimetres are expected (more than {METRES_BELOW}); {}",
        hint(*.says_mm)
    )]
    LooksLikeMetres {
        /// What was measured.
        what: &'static str,
        /// How large it is.
        found: f64,
        /// Whether the file says that it is in mm, and would not be believed to be in metres.
        says_mm: bool,
    },
    /// Something lies where no patient is.
    #[error("{what} is {mm} mm; at most {MAX_MM} mm are allowed, so the unit cannot be right")]
    TooFar {
        /// What.
        what: &'static str,
        /// How far.
        mm: f64,
    },
}

fn hint(says_mm: bool) -> &'static str {
    if says_mm {
        "the file says mm: if it does lie so near to the origin, say --unit mm, and if it is in metres, write it again in mm"
    } else {
        "say the unit (--unit m or --unit mm)"
    }
}

impl Said {
    /// The axes, of the file's word and the person's.
    ///
    /// # Errors
    /// [`Unsettled::NoAxes`], [`Unsettled::OtherAxes`].
    pub fn axes(self, stated: Option<PatientAxes>) -> Result<PatientAxes, Unsettled> {
        match (stated, self.axes) {
            (Some(file), Some(said)) if file != said => Err(Unsettled::OtherAxes { file, said }),
            (Some(axes), _) | (None, Some(axes)) => Ok(axes),
            (None, None) => Err(Unsettled::NoAxes),
        }
    }

    /// The same of a file in whose comments axes are named beside: these must be among them.
    ///
    /// # Errors
    /// Those of [`Said::axes`], and [`Unsettled::Comment`].
    pub fn axes_beside(self, stated: Option<PatientAxes>, named: &[NamedAxes]) -> Result<PatientAxes, Unsettled> {
        let taken = self.axes(stated)?;
        match named {
            [first, ..] if named.iter().all(|named| named.axes != Some(taken)) => Err(Unsettled::Comment {
                comment: first.letters.clone(),
                taken,
            }),
            _ => Ok(taken),
        }
    }

    /// Holds the units that are named in comments against the one that is taken, which must be among them.
    ///
    /// # Errors
    /// [`Unsettled::OtherUnit`], [`Unsettled::CommentUnit`].
    pub fn unit_beside(self, stated: Option<LengthUnit>, named: &[NamedUnit]) -> Result<(), Unsettled> {
        self.one_unit(stated)?;
        let taken = self.unit.or(stated).unwrap_or(LengthUnit::Millimetre);
        match named {
            [first, ..] if named.iter().all(|named| named.unit != Some(taken)) => Err(Unsettled::CommentUnit {
                comment: first.word.clone(),
                taken,
            }),
            _ => Ok(()),
        }
    }

    fn one_unit(self, stated: Option<LengthUnit>) -> Result<(), Unsettled> {
        match (stated, self.unit) {
            (Some(file), Some(said)) if file != said => Err(Unsettled::OtherUnit { file, said }),
            _ => Ok(()),
        }
    }

    /// Millimetres in the file's unit, which is mm where neither says another. `sizes` are what is measured of the
    /// file, in its own numbers: the first, the largest coordinate, must lie where a patient may be; the last must not
    /// look like metres, unless a person said the unit.
    ///
    /// # Errors
    /// [`Unsettled::OtherUnit`], [`Unsettled::LooksLikeMetres`], [`Unsettled::TooFar`].
    pub fn scale(self, stated: Option<LengthUnit>, sizes: [(&'static str, f64); 2]) -> Result<f64, Unsettled> {
        self.one_unit(stated)?;
        let [(what, largest), (measured, size)] = sizes;
        // A file that says mm may be one of metres from a pattern that says mm: a person alone is believed here.
        if self.unit.is_none() && stated != Some(LengthUnit::Metre) && size <= METRES_BELOW {
            return Err(Unsettled::LooksLikeMetres {
                what: measured,
                found: size,
                says_mm: stated.is_some(),
            });
        }
        let scale = self.unit.or(stated).unwrap_or(LengthUnit::Millimetre).mm();
        let mm = largest * scale;
        match mm <= MAX_MM {
            true => Ok(scale),
            false => Err(Unsettled::TooFar { what, mm }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::named::named_in;

    const LARGEST: &str = "the largest coordinate";

    fn scale(said: Option<LengthUnit>, stated: Option<LengthUnit>, size: f64) -> Result<f64, Unsettled> {
        let said = Said { axes: None, unit: said };
        said.scale(stated, [(LARGEST, size); 2])
    }

    #[test]
    fn what_nobody_says_is_refused_and_what_is_said_twice_must_agree() {
        use PatientAxes::{Lps, Ras};
        let axes = |said, stated| Said { axes: said, unit: None }.axes(stated);
        assert_eq!(axes(None, None), Err(Unsettled::NoAxes));
        assert_eq!(axes(Some(Ras), None), Ok(Ras));
        assert_eq!(axes(None, Some(Lps)), Ok(Lps));
        assert_eq!(axes(Some(Lps), Some(Lps)), Ok(Lps));
        assert_eq!(
            axes(Some(Ras), Some(Lps)),
            Err(Unsettled::OtherAxes { file: Lps, said: Ras })
        );
        let beside = |text: &str| Said::default().axes_beside(Some(Lps), &named_in(text));
        assert_eq!(beside(""), Ok(Lps));
        assert_eq!(beside("RAS, LPS"), Ok(Lps));
        for other in ["RAS", "LAS", "right-anterior-superior"] {
            assert!(matches!(beside(other), Err(Unsettled::Comment { .. })), "{other}");
        }
    }

    #[test]
    fn metres_are_refused_until_somebody_says_so() {
        use LengthUnit::{Metre, Millimetre};
        // What a file says to be in metres is small.
        assert_eq!(scale(None, Some(Metre), 0.12), Ok(1000.0));
        // The page's 2 is among what is refused.
        assert!(scale(None, None, 2.0).is_err());
        assert_eq!(scale(None, None, 2.0_f64.next_up()), Ok(1.0));
        // What is advised is what would be taken: metres are not, of a file that says mm.
        let said = scale(None, Some(Millimetre), 0.12).unwrap_err().to_string();
        assert!(said.contains("--unit mm") && !said.contains("--unit m or"), "{said}");
        let said = scale(None, None, 0.12).unwrap_err().to_string();
        assert!(said.contains("--unit m or --unit mm"), "{said}");
        assert_eq!(scale(None, None, 120.0), Ok(1.0));
        assert!(matches!(
            scale(None, Some(Millimetre), 0.12),
            Err(Unsettled::LooksLikeMetres { .. })
        ));
        assert_eq!(scale(Some(Metre), None, 0.12), Ok(1000.0));
        assert_eq!(scale(Some(Millimetre), Some(Millimetre), 0.12), Ok(1.0));
        assert!(matches!(
            scale(Some(Metre), Some(Millimetre), 0.12),
            Err(Unsettled::OtherUnit { .. })
        ));
        // Micrometres, and metres of something that is in mm.
        for (said, size) in [
            (None, 1.2e5),
            (Some(Metre), 120.0),
            (None, f64::INFINITY),
            (None, f64::NAN),
        ] {
            assert!(
                matches!(scale(said, None, size), Err(Unsettled::TooFar { .. })),
                "{size}"
            );
        }
    }
}
