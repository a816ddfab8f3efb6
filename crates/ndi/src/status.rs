//! The statuses that a device states, each as a [`Why`]. Facts: NDI's programmer's guides (Polaris IL-1070101, Polaris
//! Vega IL-1070259).
//!
//! Whatever is not in a table is [`Why::Unknown`], never valid.

use crate::why::Why;

/// The status of a handle in BX.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct HandleStatus(pub u8);

impl HandleStatus {
    /// A pose is there.
    pub const VALID: Self = Self(1);
    /// None is there.
    pub const MISSING: Self = Self(2);
    /// The tool is not tracked.
    pub const DISABLED: Self = Self(4);

    /// Together with the status of its port: valid where both say so.
    pub fn why(self, port: PortStatus) -> Why {
        match self {
            Self::VALID => port.why(),
            Self::MISSING => match port.why() {
                Why::Valid => Why::Missing,
                why => why,
            },
            Self::DISABLED => Why::Disabled,
            Self(code) => unknown("handle status", code),
        }
    }
}

/// The status of a port in TX and BX: a bit for each thing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PortStatus(pub u32);

impl PortStatus {
    /// A tool is there, initialised and enabled, and nothing is said against it.
    pub const GOOD: Self = Self(0x31);
    /// The three switches of a tool, bits 1 to 3.
    pub const SWITCHES: u32 = 0x0E;

    /// Bits that must be set, and what it means that one is not.
    pub const NEEDED: &[(u32, Why)] = &[
        (1 << 0, Why::Unplugged),
        (1 << 4, Why::NotInitialized),
        (1 << 5, Why::Disabled),
    ];
    /// Bits that speak against a pose, the one that tells most first.
    pub const AGAINST: &[(u32, Why)] = &[
        (1 << 12, Why::ProcessingError),
        (1 << 9, Why::Interference),
        (1 << 8, Why::AlgorithmLimit),
        (1 << 15, Why::BufferLimit),
        (1 << 14, Why::FellBehind),
        (1 << 6, Why::OutOfVolume),
        (1 << 7, Why::PartlyOutOfVolume),
    ];

    /// What it says of a pose.
    pub fn why(self) -> Why {
        let missing = Self::NEEDED.iter().find(|(bit, _)| self.0 & bit == 0);
        let against = Self::AGAINST.iter().find(|(bit, _)| self.0 & bit != 0);
        let known: u32 = Self::NEEDED.iter().chain(Self::AGAINST).map(|(bit, _)| bit).sum();
        match missing.or(against) {
            Some((_, why)) => *why,
            None if self.0 & !(known | Self::SWITCHES) != 0 => Why::Unknown {
                field: "port status",
                code: self.0,
            },
            None => Why::Valid,
        }
    }
}

/// The status of a tool in BX2: a code in bits 0 to 7, missing in bit 8, averaged in bit 9, the face in bits 13 to 15.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ToolStatus(pub u16);

impl ToolStatus {
    /// The bit of a transform that is not sent.
    pub const MISSING: u16 = 1 << 8;
    /// The bit of a mean over several frames.
    pub const AVERAGED: u16 = 1 << 9;
    /// Bits that mean nothing yet.
    pub const RESERVED: u16 = 0b111 << 10;

    /// All codes that are known, but 0: nothing is said against the pose.
    pub const CODES: &[(u8, Why)] = &[
        (3, Why::PartlyOutOfVolume),
        (5, Why::PartlyAveraged),
        (9, Why::OutOfVolume),
        (13, Why::TooFewMarkers),
        (14, Why::Interference),
        (17, Why::BadFit),
        (18, Why::BufferLimit),
        (19, Why::AlgorithmLimit),
        (20, Why::FellBehind),
        (21, Why::OutOfSync),
        (22, Why::ProcessingError),
        (31, Why::Missing),
        (32, Why::Disabled),
        (33, Why::Unplugged),
    ];

    /// The code.
    pub const fn code(self) -> u8 {
        self.0.to_le_bytes()[0]
    }

    /// Whether no transform is sent.
    pub const fn is_missing(self) -> bool {
        self.0 & Self::MISSING != 0
    }

    /// Whether the pose is a mean over several frames.
    pub const fn is_averaged(self) -> bool {
        self.0 & Self::AVERAGED != 0
    }

    /// Which face of the tool is seen, from 0.
    pub const fn face(self) -> u8 {
        self.0.to_le_bytes()[1] >> 5
    }

    /// What it says of a pose.
    pub fn why(self) -> Why {
        let unknown = Why::Unknown {
            field: "tool status",
            code: self.0.into(),
        };
        match self.code() {
            0 if self.is_missing() => Why::Missing,
            0 if self.0 & Self::RESERVED == 0 => Why::Valid,
            code => Self::CODES
                .iter()
                .find(|(known, _)| *known == code)
                .map_or(unknown, |(_, why)| *why),
        }
    }
}

/// The status of a marker in the 3-D component of BX2.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MarkerStatus(pub u8);

impl MarkerStatus {
    /// All that are known.
    pub const CODES: &[(u8, Why)] = &[
        (0, Why::Valid),
        (1, Why::Missing),
        (2, Why::SteepAngle),
        (3, Why::MarkerError),
        (4, Why::OutOfVolume),
        (5, Why::OutOfVolume),
        (6, Why::Phantom),
        (7, Why::Saturated),
        (8, Why::SaturatedOutOfVolume),
    ];

    /// What it says of a place.
    pub fn why(self) -> Why {
        let known = Self::CODES.iter().find(|(code, _)| *code == self.0);
        known.map_or_else(|| unknown("marker status", self.0), |(_, why)| *why)
    }
}

/// What TX and BX say of a tool with option 0002: a bit for each thing, and the face in bits 4 to 6.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ToolInformation(pub u8);

impl ToolInformation {
    /// Bits that speak against a pose.
    pub const AGAINST: &[(u8, Why)] = &[
        (1 << 7, Why::ProcessingError),
        (1 << 2, Why::Interference),
        (1 << 0, Why::BadFit),
        (1 << 1, Why::TooFewMarkers),
        (1 << 3, Why::FellBehind),
    ];

    /// Which face of the tool is seen, from 0.
    pub const fn face(self) -> u8 {
        self.0 >> 4 & 0b111
    }

    /// What it says of a pose.
    pub fn why(self) -> Why {
        let against = Self::AGAINST.iter().find(|(bit, _)| self.0 & bit != 0);
        against.map_or(Why::Valid, |(_, why)| *why)
    }
}

/// What TX and BX say of each marker of a tool with option 0002, four bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MarkerUse(pub u8);

impl MarkerUse {
    /// All that are known.
    pub const CODES: &[(u8, Why)] = &[
        (0, Why::Missing),
        (1, Why::SteepAngle),
        (2, Why::MarkerError),
        (3, Why::Valid),
        (4, Why::OutOfVolume),
        (5, Why::OutOfVolume),
    ];

    /// Whether and why not it was used.
    pub fn why(self) -> Why {
        let known = Self::CODES.iter().find(|(code, _)| *code == self.0);
        known.map_or_else(|| unknown("marker information", self.0), |(_, why)| *why)
    }
}

/// The device's own status in TX and BX: a bit for each thing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct SystemStatus(pub u16);

impl SystemStatus {
    /// Some handle has become occupied.
    pub const OCCUPIED: u16 = 1 << 6;
    /// Some handle has become unoccupied: a tool was unplugged.
    pub const UNOCCUPIED: u16 = 1 << 7;
    /// All bits that are known; 1, 2, 4 and 5 are those of older devices.
    pub const BITS: &[(u16, &str)] = &[
        (1 << 0, "communication out of step"),
        (1 << 1, "too much infrared light"),
        (1 << 2, "a wrong CRC inside the device"),
        (1 << 3, "a processing error that it goes on after"),
        (1 << 4, "a failure of the hardware"),
        (1 << 5, "changed hardware"),
        (Self::OCCUPIED, "a tool was plugged in"),
        (Self::UNOCCUPIED, "a tool was unplugged"),
        (1 << 8, "a diagnosis waits"),
        (1 << 9, "temperature out of its range"),
        (1 << 10, "changed hardware"),
    ];

    /// What it says; empty where all is well.
    pub fn words(self) -> Vec<&'static str> {
        let known: u16 = Self::BITS.iter().map(|(bit, _)| bit).sum();
        let set = Self::BITS.iter().filter(|(bit, _)| self.0 & bit != 0);
        let other = (self.0 & !known != 0).then_some("a status that is not known");
        set.map(|(_, words)| *words).chain(other).collect()
    }
}

fn unknown(field: &'static str, code: u8) -> Why {
    Why::Unknown {
        field,
        code: code.into(),
    }
}
