//! Why there is no pose: the codes on the wire and the words on the images.

/// Why there is no pose.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Lost {
    /// The localizer does not see the marker.
    NotSeen,
    /// The source has delivered nothing for longer than the scene's limit.
    Silent,
    /// A pose arrived that is not a pose: NaN, or a quaternion that is not a rotation.
    Refused,
    /// Fewer emitters of the marker are seen than a pose may rest on.
    TooFew,
    /// The emitters seen do not fit the marker.
    Residual,
    /// The emitters seen lie so that the tip does not follow.
    Geometry,
    /// The marker on the patient is not seen, or does not fit.
    Reference,
    /// The tool has no calibration that may be used.
    NotCalibrated,
    /// The patient has no registration that may be used.
    NotRegistered,
    /// The same numbers come again and again under fresh stamps: nothing is measured.
    Frozen,
}

impl Lost {
    /// The code on the wire; 0 is kept for valid poses.
    pub const fn code(self) -> u32 {
        match self {
            Self::NotSeen => 1,
            Self::Silent => 2,
            Self::Refused => 3,
            Self::TooFew => 4,
            Self::Residual => 5,
            Self::Geometry => 6,
            Self::Reference => 7,
            Self::NotCalibrated => 8,
            Self::NotRegistered => 9,
            Self::Frozen => 10,
        }
    }

    /// The reason with this code.
    pub const fn from_code(code: u32) -> Option<Self> {
        match code {
            1 => Some(Self::NotSeen),
            2 => Some(Self::Silent),
            3 => Some(Self::Refused),
            4 => Some(Self::TooFew),
            5 => Some(Self::Residual),
            6 => Some(Self::Geometry),
            7 => Some(Self::Reference),
            8 => Some(Self::NotCalibrated),
            9 => Some(Self::NotRegistered),
            10 => Some(Self::Frozen),
            _ => None,
        }
    }

    /// The reason in a few words, for the image and the report.
    pub const fn words(self) -> &'static str {
        match self {
            Self::NotSeen => "marker not seen",
            Self::Silent => "tracker silent",
            Self::Refused => "pose refused",
            Self::TooFew => "too few emitters",
            Self::Residual => "emitters do not fit",
            Self::Geometry => "emitters do not hold the tip",
            Self::Reference => "reference lost",
            Self::NotCalibrated => "tool not calibrated",
            Self::NotRegistered => "patient not registered",
            Self::Frozen => "FROZEN MEASUREMENT",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_reason_comes_back_by_its_code() {
        let known: Vec<Lost> = (0..100).filter_map(Lost::from_code).collect();
        assert_eq!(known.len(), 10);
        for reason in known {
            assert_eq!(Lost::from_code(reason.code()), Some(reason));
        }
    }
}
