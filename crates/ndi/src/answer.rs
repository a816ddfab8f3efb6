//! What a text says: done, refused, done with a doubt, that the device begins anew, or what was asked for.

use std::fmt;

use crate::fields::Fields;

/// A text by its first word.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Answer {
    /// `OKAY`: done.
    Okay,
    /// `ERRORnn`: not done.
    Error(ErrorCode),
    /// `WARNING` or `WARNINGnn`: done, but.
    Warning(Option<u8>),
    /// `RESET`: the device begins anew and knows no tool any more. It says so unasked too.
    Reset,
    /// Anything else: what was asked for.
    Words(String),
}

impl Answer {
    /// Of a text without its CRC.
    pub fn of(text: &str) -> Self {
        let code = |digits: &str| {
            (digits.len() == 2)
                .then(|| u8::from_str_radix(digits, 16).ok())
                .flatten()
        };
        match text {
            "OKAY" => Self::Okay,
            "RESET" => Self::Reset,
            "WARNING" => Self::Warning(None),
            _ => match (text.strip_prefix("ERROR"), text.strip_prefix("WARNING")) {
                (Some(digits), _) => code(digits).map(|code| Self::Error(ErrorCode(code))),
                (_, Some(digits)) => code(digits).map(|code| Self::Warning(Some(code))),
                _ => None,
            }
            .unwrap_or_else(|| Self::Words(text.to_owned())),
        }
    }

    /// As the text of a reply.
    pub fn text(&self) -> String {
        match self {
            Self::Okay => "OKAY".to_owned(),
            Self::Error(ErrorCode(code)) => format!("ERROR{code:02X}"),
            Self::Warning(None) => "WARNING".to_owned(),
            Self::Warning(Some(code)) => format!("WARNING{code:02X}"),
            Self::Reset => "RESET".to_owned(),
            Self::Words(words) => words.clone(),
        }
    }

    /// All of it, by name.
    pub fn fields(&self) -> Fields {
        let mut fields = Fields::default();
        match self {
            Self::Error(code) => {
                fields.add("reply", "ERROR");
                fields.add("code", code.0);
                fields.add("means", code.words());
            }
            Self::Warning(code) => {
                fields.add("reply", "WARNING");
                code.iter().for_each(|code| fields.add("code", *code));
            }
            Self::Words(words) => {
                fields.add("reply", "text");
                for (line, number) in words.lines().zip(0..) {
                    fields.add(format!("lines[{number}]"), line);
                }
            }
            Self::Okay | Self::Reset => fields.add("reply", self.text()),
        }
        fields
    }
}

/// The number behind `ERROR`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ErrorCode(pub u8);

impl ErrorCode {
    /// The device does not know this command.
    pub const INVALID_COMMAND: Self = Self(0x01);
    /// A command longer than the device takes.
    pub const TOO_LONG: Self = Self(0x02);
    /// A command that did not come as it was sent.
    pub const BAD_CRC: Self = Self(0x04);
    /// Arguments that are too few, too many, or none.
    pub const PARAMETERS: Self = Self(0x07);
    /// Not in this mode: polled without tracking, set up while tracking.
    pub const BAD_MODE: Self = Self(0x0C);
    /// A handle whose tool was not initialised.
    pub const NOT_INITIALIZED: Self = Self(0x0E);
    /// Before INIT.
    pub const SYSTEM_NOT_INITIALIZED: Self = Self(0x10);
    /// The tool's definition is none.
    pub const PINIT_FAILED: Self = Self(0x13);
    /// An argument beyond its range.
    pub const RANGE: Self = Self(0x23);
    /// A handle that was never given.
    pub const NO_HANDLE: Self = Self(0x2B);
    /// No handle is left.
    pub const HANDLES_FULL: Self = Self(0x2D);

    /// What the number means, as the device's programmer's guide says it.
    pub fn words(self) -> &'static str {
        let known = ERRORS.iter().find(|(code, _)| *code == self.0);
        known.map_or("an error without a known name", |(_, words)| words)
    }
}

impl fmt::Display for ErrorCode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "ERROR{:02X}: {}", self.0, self.words())
    }
}

const ERRORS: &[(u8, &str)] = &[
    (0x01, "a command that is not known"),
    (0x02, "the command is too long"),
    (0x03, "the command is too short"),
    (0x04, "the command has a wrong CRC"),
    (0x05, "the command took too long"),
    (0x06, "the line's new speed failed"),
    (0x07, "a wrong number of arguments"),
    (0x08, "no such port"),
    (0x09, "no such tracking mode"),
    (0x0A, "no such LED"),
    (0x0B, "no such state of an LED"),
    (0x0C, "not possible in this mode"),
    (0x0D, "no tool in this port"),
    (0x0E, "the tool is not initialised"),
    (0x0F, "the tool is not enabled"),
    (0x10, "the system is not initialised"),
    (0x11, "tracking cannot be stopped"),
    (0x12, "tracking cannot be started"),
    (0x13, "the tool cannot be initialised"),
    (0x14, "wrong parameters of the position sensor"),
    (0x15, "the system cannot be initialised"),
    (0x16, "diagnostics cannot be started"),
    (0x17, "diagnostics cannot be stopped"),
    (0x19, "the version of the firmware cannot be read"),
    (0x1A, "an internal error"),
    (0x1C, "the firing of markers cannot be set"),
    (0x1E, "the tool's memory cannot be read"),
    (0x1F, "the tool's memory cannot be written"),
    (0x21, "the tool's current cannot be tested"),
    (0x22, "an enabled tool does not fit the volume's parameters"),
    (0x23, "an argument is out of its range"),
    (0x24, "no camera parameters for this volume"),
    (0x25, "the features cannot be found out"),
    (0x28, "too many tools, or of a kind that is not supported"),
    (0x2A, "no memory is left"),
    (0x2B, "the handle was not given"),
    (0x2C, "the handle has no tool any more"),
    (0x2D, "all handles are given"),
    (0x2F, "a wrong description of a port"),
    (0x30, "the port has a handle already"),
    (0x32, "not possible with this device"),
    (0x33, "the feature is not to be had"),
    (0x34, "no such parameter"),
    (0x35, "a value of the wrong kind"),
    (0x36, "a value out of its range"),
    (0x37, "an index out of its range"),
    (0x38, "a value of the wrong size"),
    (0x39, "not allowed"),
    (0x3B, "no such file"),
    (0x3C, "the file cannot be written"),
    (0x3D, "the file cannot be read"),
    (0x42, "the device is not connected"),
    (0xF1, "too much infrared light"),
    (0xF4, "the memory cannot be erased"),
    (0xF5, "the memory cannot be written"),
    (0xF6, "the memory cannot be read"),
];
