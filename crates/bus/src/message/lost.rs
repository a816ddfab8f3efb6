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
    /// The localizer says that the marker is outside the space in which it measures.
    OutOfVolume,
    /// The localizer says that something disturbs it: stray light, metal in a magnetic field.
    Interference,
    /// The localizer, or the marker's cable, is not connected.
    Disconnected,
}

impl Lost {
    /// Every reason, in the order of their codes, which begin with 1.
    pub const ALL: [Self; 13] = [
        Self::NotSeen,
        Self::Silent,
        Self::Refused,
        Self::TooFew,
        Self::Residual,
        Self::Geometry,
        Self::Reference,
        Self::NotCalibrated,
        Self::NotRegistered,
        Self::Frozen,
        Self::OutOfVolume,
        Self::Interference,
        Self::Disconnected,
    ];

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
            Self::OutOfVolume => 11,
            Self::Interference => 12,
            Self::Disconnected => 13,
        }
    }

    /// The reason with this code.
    pub const fn from_code(code: u32) -> Option<Self> {
        let place = code as usize;
        match place {
            0 => None,
            _ if place > Self::ALL.len() => None,
            _ => Some(Self::ALL[place - 1]),
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
            Self::OutOfVolume => "outside the localizer's view",
            Self::Interference => "localizer disturbed",
            Self::Disconnected => "localizer disconnected",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_reason_comes_back_by_its_code() {
        let known: Vec<Lost> = (0..100).filter_map(Lost::from_code).collect();
        assert_eq!(known, Lost::ALL);
        assert!((1..).zip(Lost::ALL).all(|(code, reason)| reason.code() == code));
    }
}
