//! Commands: as bytes with and without a CRC, and read back.

mod read;

use crate::crc::crc16;
use crate::handle::Handle;
use crate::malformed::Malformed;
use crate::options::{Bx2Options, ReplyOption};
use crate::rom::PIECE;

/// PHRQ for a passive or active wireless tool whose definition is written to the device.
pub const WIRELESS: &str = "*********1****";

/// A command to a device.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Command {
    /// Begin: frees all tools.
    Init,
    /// New speed of a serial line: five digits.
    Comm(String),
    /// Which firmware: 4 is the one that counts.
    Ver(u8),
    /// Which handles: 0 all, 1 to be freed, 2 not initialised, 3 initialised and not enabled, 4 enabled.
    Phsr(u8),
    /// A handle for a tool: 14 characters, [`WIRELESS`].
    Phrq(String),
    /// Free a handle.
    Phf(Handle),
    /// What is known of a tool, with these reply options.
    Phinf(Handle, u16),
    /// A piece of a tool's definition at this address.
    Pvwr(Handle, u16, Box<[u8; PIECE]>),
    /// Initialise a tool.
    Pinit(Handle),
    /// Track it: `S`tatic, `D`ynamic or `B`utton box.
    Pena(Handle, char),
    /// Track it no longer.
    Pdis(Handle),
    /// Begin to track.
    Tstart,
    /// Stop.
    Tstop,
    /// Poses as text.
    Tx(ReplyOption),
    /// Poses, binary.
    Bx(ReplyOption),
    /// Poses and markers, binary, with the device's time.
    Bx2(Bx2Options),
    /// So many beeps, 1 to 9.
    Beep(u8),
    /// Anything else, `RESET` too: name and arguments as they are.
    Other(String, String),
}

impl Command {
    /// Its name.
    pub fn name(&self) -> &str {
        match self {
            Self::Init => "INIT",
            Self::Comm(_) => "COMM",
            Self::Ver(_) => "VER",
            Self::Phsr(_) => "PHSR",
            Self::Phrq(_) => "PHRQ",
            Self::Phf(_) => "PHF",
            Self::Phinf(..) => "PHINF",
            Self::Pvwr(..) => "PVWR",
            Self::Pinit(_) => "PINIT",
            Self::Pena(..) => "PENA",
            Self::Pdis(_) => "PDIS",
            Self::Tstart => "TSTART",
            Self::Tstop => "TSTOP",
            Self::Tx(_) => "TX",
            Self::Bx(_) => "BX",
            Self::Bx2(_) => "BX2",
            Self::Beep(_) => "BEEP",
            Self::Other(name, _) => name,
        }
    }

    /// Its arguments as they stand on the wire.
    pub fn arguments(&self) -> String {
        match self {
            Self::Init | Self::Tstart | Self::Tstop => String::new(),
            Self::Comm(words) | Self::Phrq(words) | Self::Other(_, words) => words.clone(),
            Self::Ver(which) | Self::Beep(which) => which.to_string(),
            Self::Phsr(which) => format!("{which:02X}"),
            Self::Phf(handle) | Self::Pinit(handle) | Self::Pdis(handle) => handle.to_string(),
            Self::Phinf(handle, options) => format!("{handle}{options:04X}"),
            Self::Pvwr(handle, address, piece) => {
                let hex: String = piece.iter().map(|byte| format!("{byte:02X}")).collect();
                format!("{handle}{address:04X}{hex}")
            }
            Self::Pena(handle, priority) => format!("{handle}{priority}"),
            Self::Tx(options) | Self::Bx(options) => format!("{:04X}", options.0),
            Self::Bx2(options) => options.to_string(),
        }
    }

    /// As bytes: `NAME:arguments`, a CRC and a carriage return, or `NAME arguments` and a carriage return.
    pub fn to_bytes(&self, with_crc: bool) -> Vec<u8> {
        let (name, arguments) = (self.name(), self.arguments());
        if !with_crc {
            return format!("{name} {arguments}\r").into_bytes();
        }
        let line = format!("{name}:{arguments}");
        format!("{line}{:04X}\r", crc16(line.as_bytes())).into_bytes()
    }

    /// Of a line without its carriage return. A command that is not known is [`Command::Other`].
    ///
    /// # Errors
    /// A wrong CRC, or arguments that its command does not have.
    pub fn parse(line: &[u8]) -> Result<Self, Malformed> {
        read::command(line)
    }
}
