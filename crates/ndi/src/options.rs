//! What a poll asks for.

use std::fmt;

/// Reply option of TX and BX: a bit for each thing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ReplyOption(pub u16);

impl ReplyOption {
    /// Transforms, statuses and frame numbers.
    pub const TRANSFORMS: u16 = 0x0001;
    /// What is said of tools and of their markers.
    pub const INFORMATION: u16 = 0x0002;
    /// The single stray marker of an active tool.
    pub const SINGLE_STRAY: u16 = 0x0004;
    /// Places of the markers of tools; BX alone.
    pub const MARKERS: u16 = 0x0008;
    /// What is out of volume too.
    pub const OUT_OF_VOLUME: u16 = 0x0800;
    /// Places of passive markers of no tool.
    pub const STRAYS: u16 = 0x1000;
    /// All that TX knows.
    pub const OF_TX: u16 = 0x1807;
    /// All that BX knows.
    pub const OF_BX: u16 = 0x180F;

    /// Whether this bit is set.
    pub const fn has(self, bit: u16) -> bool {
        self.0 & bit != 0
    }
}

/// Which markers BX2 gives (`--3d`).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Markers {
    /// None.
    #[default]
    None,
    /// Those of tools.
    Tools,
    /// Those of no tool.
    Strays,
    /// All.
    All,
}

impl Markers {
    /// All of them with their words.
    pub const WORDS: [(Self, &'static str); 4] = [
        (Self::None, "none"),
        (Self::Tools, "tools"),
        (Self::Strays, "strays"),
        (Self::All, "all"),
    ];

    /// Whether markers of tools are meant.
    pub const fn tools(self) -> bool {
        matches!(self, Self::Tools | Self::All)
    }

    /// Whether markers of no tool are meant.
    pub const fn strays(self) -> bool {
        matches!(self, Self::Strays | Self::All)
    }
}

/// The options of BX2 that are used here. Those that are left out have the device's defaults.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Bx2Options {
    /// Poses of tools (`--6d`).
    pub tools: bool,
    /// Single markers (`--3d`).
    pub markers: Markers,
    /// Buttons (`--1d`).
    pub buttons: bool,
}

impl Default for Bx2Options {
    /// Those of the device.
    fn default() -> Self {
        Self {
            tools: true,
            markers: Markers::None,
            buttons: true,
        }
    }
}

impl fmt::Display for Bx2Options {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let tools = if self.tools { "tools" } else { "none" };
        let buttons = if self.buttons { "buttons" } else { "none" };
        let of_markers = |(markers, _): &&(Markers, &str)| *markers == self.markers;
        let markers = Markers::WORDS.iter().find(of_markers).map_or("none", |(_, word)| word);
        write!(f, "--6d={tools} --3d={markers} --1d={buttons}")
    }
}

impl Bx2Options {
    /// Of the words behind `BX2`; the first that is not known is the error.
    ///
    /// # Errors
    /// The word.
    pub fn parse(words: &str) -> Result<Self, String> {
        words
            .split_ascii_whitespace()
            .try_fold(Self::default(), |mut options, word| {
                match word.split_once('=') {
                    Some(("--6d", "tools")) => options.tools = true,
                    Some(("--6d", "none")) => options.tools = false,
                    Some(("--1d", "buttons")) => options.buttons = true,
                    Some(("--1d", "none")) => options.buttons = false,
                    Some(("--3d", which)) => {
                        let known = Markers::WORDS.iter().find(|(_, word)| *word == which);
                        options.markers = known.ok_or(word)?.0;
                    }
                    Some(("--2d" | "--sensor", "none")) => {}
                    _ => return Err(word.to_owned()),
                }
                Ok(options)
            })
    }
}
