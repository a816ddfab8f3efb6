//! The side that answers: a device that is simulated. Commands come in, replies go out, and whoever drives it says what
//! is seen.

mod polls;
mod ports;

use crate::answer::{Answer, ErrorCode};
use crate::bx2::{Alert, Bx2Frame, FrameKind};
use crate::command::Command;
use crate::decode::{binary_reply, text_reply};
use crate::fault::Fault;
use crate::handle::Handle;
use crate::options::ReplyOption;
use crate::rom::Rom;
use crate::status::SystemStatus;
use ports::Ports;

/// The longest command that is taken, bytes.
const MOST_COMMAND: usize = 1024;
/// Frames that are kept: the newest of each kind.
const MOST_KINDS: usize = 16;

/// What a simulated device knows.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DeviceRules {
    /// What VER says.
    pub version: String,
    /// Whether it knows BX2.
    pub bx2: bool,
    /// Whether it knows BX.
    pub bx: bool,
}

impl Default for DeviceRules {
    /// It knows all, and says what it is.
    fn default() -> Self {
        Self {
            version: "Simulated localizer\nNDI S/N: simulated\nFreeze Tag: none".to_owned(),
            bx2: true,
            bx: true,
        }
    }
}

/// A tool of a simulated device.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DeviceTool<'a> {
    /// Its handle.
    pub handle: Handle,
    /// Its definition, once it was written and initialised; of a tool that is plugged in, its own.
    pub rom: Option<&'a Rom>,
    /// Whether it is tracked.
    pub enabled: bool,
}

/// A simulated device with one client.
#[derive(Debug, Clone)]
pub struct Device {
    rules: DeviceRules,
    line: Vec<u8>,
    /// The line is too long: all of it is dropped.
    dropped: bool,
    is_set_up: bool,
    tracking: bool,
    ports: Ports,
    /// The newest frame of each kind, and whether BX2 gave it already.
    frames: Vec<(Bx2Frame, bool)>,
    alerts: Vec<Alert>,
    system: SystemStatus,
}

impl Device {
    /// Just switched on.
    pub const fn new(rules: DeviceRules) -> Self {
        Self {
            rules,
            line: Vec::new(),
            dropped: false,
            is_set_up: false,
            tracking: false,
            ports: Ports::NONE,
            frames: Vec::new(),
            alerts: Vec::new(),
            system: SystemStatus(0),
        }
    }

    /// Whether it tracks.
    pub const fn is_tracking(&self) -> bool {
        self.tracking
    }

    /// Its tools.
    pub fn tools(&self) -> impl Iterator<Item = DeviceTool<'_>> {
        self.ports.tools()
    }

    /// A new frame is there, in the place of the last one of its kind. Tools and markers that nobody enabled are not
    /// told.
    pub fn show(&mut self, frame: Bx2Frame) {
        match self.frames.iter_mut().find(|(old, _)| old.kind == frame.kind) {
            Some(old) => *old = (frame, false),
            None => {
                self.frames.truncate(MOST_KINDS - 1);
                self.frames.push((frame, false));
            }
        }
    }

    /// What it says of itself from now on.
    pub fn say(&mut self, alerts: Vec<Alert>, system: SystemStatus) {
        self.alerts = alerts;
        self.system = system;
    }

    /// A tool is plugged in.
    pub fn plug(&mut self, rom: Rom) -> Option<Handle> {
        self.ports.plug(rom)
    }

    /// A tool is pulled out.
    pub fn unplug(&mut self, handle: Handle) {
        self.ports.unplug(handle);
    }

    /// It begins anew, unasked; what it sends.
    pub fn reset(&mut self) -> Vec<u8> {
        self.is_set_up = false;
        self.tracking = false;
        self.ports.free_all();
        self.frames.clear();
        self.line.clear();
        text_reply(&Answer::Reset.text())
    }

    /// Takes bytes of its client; what it answers.
    pub fn bytes(&mut self, bytes: &[u8]) -> Vec<u8> {
        let mut replies = Vec::new();
        for byte in bytes {
            match byte {
                b'\r' => replies.extend(self.line_ended()),
                _ if self.line.len() >= MOST_COMMAND => self.dropped = true,
                byte => self.line.push(*byte),
            }
        }
        replies
    }

    fn line_ended(&mut self) -> Vec<u8> {
        let line = std::mem::take(&mut self.line);
        if std::mem::take(&mut self.dropped) {
            return error(ErrorCode::TOO_LONG);
        }
        match Command::parse(&line) {
            Ok(command) => self.answer(&command).unwrap_or_else(error),
            Err(malformed) => error(match malformed.fault {
                Fault::TextCrc { .. } | Fault::TextShort { .. } => ErrorCode::BAD_CRC,
                Fault::Byte { .. } => ErrorCode::INVALID_COMMAND,
                Fault::Ends { .. } | Fault::Trailing { .. } => ErrorCode::PARAMETERS,
                _ => ErrorCode::RANGE,
            }),
        }
    }

    fn answer(&mut self, command: &Command) -> Result<Vec<u8>, ErrorCode> {
        match command {
            Command::Init => {
                self.is_set_up = true;
                self.tracking = false;
                self.ports.free_all();
                Ok(okay())
            }
            Command::Comm(_) | Command::Beep(1..=9) => Ok(okay()),
            Command::Beep(_) => Err(ErrorCode::RANGE),
            Command::Ver(_) => Ok(text_reply(&self.rules.version)),
            Command::Other(name, _) if name == "RESET" => Ok(self.reset()),
            Command::Other(name, _) if name == "APIREV" => Ok(text_reply("G.003.007")),
            Command::Other(..) => Err(ErrorCode::INVALID_COMMAND),
            Command::Bx2(_) if !self.rules.bx2 => Err(ErrorCode::INVALID_COMMAND),
            Command::Bx(_) if !self.rules.bx => Err(ErrorCode::INVALID_COMMAND),
            _ if !self.is_set_up => Err(ErrorCode::SYSTEM_NOT_INITIALIZED),
            Command::Tstart if self.tracking => Err(ErrorCode::BAD_MODE),
            Command::Tstart => {
                self.tracking = true;
                // Handles may mean other tools than when the last frame was shown.
                self.frames.clear();
                Ok(okay())
            }
            Command::Tx(_) | Command::Bx(_) | Command::Bx2(_) | Command::Tstop if !self.tracking => {
                Err(ErrorCode::BAD_MODE)
            }
            Command::Tstop => {
                self.tracking = false;
                Ok(okay())
            }
            Command::Tx(options) => Ok(text_reply(&self.tx(within(*options, ReplyOption::OF_TX)?))),
            Command::Bx(options) => Ok(binary_reply(&self.bx(within(*options, ReplyOption::OF_BX)?))),
            Command::Bx2(options) => Ok(binary_reply(&self.bx2(*options))),
            command => self.ports.answer(command, self.tracking).map(|text| text_reply(&text)),
        }
    }

    /// The newest frame that has been shown for tools of this kind.
    pub fn newest(&self, kind: FrameKind) -> Option<&Bx2Frame> {
        self.frames
            .iter()
            .find(|(frame, _)| frame.kind == kind)
            .map(|(frame, _)| frame)
    }
}

fn within(options: ReplyOption, known: u16) -> Result<ReplyOption, ErrorCode> {
    if options.0 & !known == 0 {
        Ok(options)
    } else {
        Err(ErrorCode::RANGE)
    }
}

fn okay() -> Vec<u8> {
    text_reply(&Answer::Okay.text())
}

fn error(code: ErrorCode) -> Vec<u8> {
    text_reply(&Answer::Error(code).text())
}
