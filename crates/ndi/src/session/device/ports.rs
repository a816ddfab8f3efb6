//! The ports of a simulated device: handles, definitions, what was initialised and enabled.

use super::DeviceTool;
use crate::answer::{Answer, ErrorCode};
use crate::command::Command;
use crate::handle::Handle;
use crate::limits::MOST_LOADED;
use crate::ports::{Port as Listed, PortInfo, ToolInfo, phsr_text};
use crate::rom::{BYTES, PIECE, Rom};
use crate::status::PortStatus;

/// Room for a definition: those of files are shorter.
const MEMORY: usize = 1024;
/// What a freshly written tool or one that was pulled out has.
const OCCUPIED: u32 = 0x01;
const INITIALIZED: u32 = 0x10;
const ENABLED: u32 = 0x20;

#[derive(Debug, Clone)]
struct Port {
    handle: Handle,
    wired: bool,
    memory: Box<[u8; MEMORY]>,
    rom: Option<Rom>,
    status: u32,
}

#[derive(Debug, Clone)]
pub(super) struct Ports(Vec<Port>);

impl Ports {
    pub(super) const NONE: Self = Self(Vec::new());

    pub(super) fn tools(&self) -> impl Iterator<Item = DeviceTool<'_>> {
        self.0.iter().map(|port| DeviceTool {
            handle: port.handle,
            rom: port.rom.as_ref(),
            enabled: port.status & ENABLED != 0,
        })
    }

    /// The status of a tool that is tracked.
    pub(super) fn enabled(&self) -> impl Iterator<Item = (Handle, PortStatus)> + '_ {
        let tracked = self.0.iter().filter(|port| port.status & ENABLED != 0);
        tracked.map(|port| (port.handle, PortStatus(port.status)))
    }

    fn add(&mut self, wired: bool, rom: Option<Rom>) -> Option<Handle> {
        let free = (1..=u16::try_from(MOST_LOADED).unwrap_or(1)).map(Handle);
        let handle = free
            .into_iter()
            .find(|handle| self.0.iter().all(|port| port.handle != *handle))?;
        self.0.push(Port {
            handle,
            wired,
            memory: Box::new([0; MEMORY]),
            status: if rom.is_some() { OCCUPIED } else { 0 },
            rom,
        });
        Some(handle)
    }

    pub(super) fn plug(&mut self, rom: Rom) -> Option<Handle> {
        self.add(true, Some(rom))
    }

    /// Its handle stays, without a tool, until somebody frees it.
    pub(super) fn unplug(&mut self, handle: Handle) {
        if let Ok(port) = self.port(handle) {
            port.status &= !OCCUPIED;
        }
    }

    /// Tools that are plugged in stay so.
    pub(super) fn free_all(&mut self) {
        self.0.retain(|port| port.wired && port.status & OCCUPIED != 0);
        self.0.iter_mut().for_each(|port| port.status = OCCUPIED);
    }

    fn port(&mut self, handle: Handle) -> Result<&mut Port, ErrorCode> {
        let port = self.0.iter_mut().find(|port| port.handle == handle);
        port.ok_or(ErrorCode::NO_HANDLE)
    }

    /// The text of a reply.
    pub(super) fn answer(&mut self, command: &Command, tracking: bool) -> Result<String, ErrorCode> {
        let okay = Ok(Answer::Okay.text());
        match command {
            Command::Phsr(which) => Ok(phsr_text(&self.listed(*which)?)),
            Command::Phinf(handle, options) => Ok(self.port(*handle)?.info(*options)),
            _ if tracking => Err(ErrorCode::BAD_MODE),
            Command::Phrq(_) => self
                .add(false, None)
                .map(|handle| handle.to_string())
                .ok_or(ErrorCode::HANDLES_FULL),
            Command::Phf(handle) => {
                self.port(*handle)?;
                self.0.retain(|port| port.handle != *handle);
                okay
            }
            Command::Pvwr(handle, address, piece) => self.port(*handle)?.write(*address, piece).and(okay),
            Command::Pinit(handle) => self.port(*handle)?.initialize().and(okay),
            Command::Pena(handle, _) => {
                let port = self.port(*handle)?;
                if port.status & INITIALIZED == 0 {
                    return Err(ErrorCode::NOT_INITIALIZED);
                }
                port.status |= ENABLED;
                okay
            }
            Command::Pdis(handle) => {
                self.port(*handle)?.status &= !ENABLED;
                okay
            }
            _ => Err(ErrorCode::INVALID_COMMAND),
        }
    }

    fn listed(&self, which: u8) -> Result<Vec<Listed>, ErrorCode> {
        let is_listed = |port: &&Port| {
            let has = |bit: u32| port.status & bit != 0;
            match which {
                1 => port.wired && !has(OCCUPIED),
                2 => has(OCCUPIED) && !has(INITIALIZED),
                3 => has(OCCUPIED) && has(INITIALIZED) && !has(ENABLED),
                4 => has(ENABLED),
                _ => true,
            }
        };
        if which > 4 {
            return Err(ErrorCode::RANGE);
        }
        let entry = |port: &Port| Listed {
            handle: port.handle,
            status: PortStatus(port.status),
        };
        Ok(self.0.iter().filter(is_listed).map(entry).collect())
    }
}

impl Port {
    fn write(&mut self, address: u16, piece: &[u8; PIECE]) -> Result<(), ErrorCode> {
        let at = usize::from(address);
        let into = self.memory.get_mut(at..at + PIECE).ok_or(ErrorCode::RANGE)?;
        into.copy_from_slice(piece);
        self.status |= OCCUPIED;
        Ok(())
    }

    fn initialize(&mut self) -> Result<(), ErrorCode> {
        if self.status & OCCUPIED == 0 {
            return Err(ErrorCode(0x0D));
        }
        if !self.wired {
            let bytes = self.memory.get(..BYTES).unwrap_or_default();
            self.rom = Some(Rom::parse(bytes).map_err(|_| ErrorCode::PINIT_FAILED)?);
        }
        self.status |= INITIALIZED;
        Ok(())
    }

    fn info(&self, options: u16) -> String {
        if self.status & OCCUPIED == 0 {
            return "UNOCCUPIED".to_owned();
        }
        let has = |bit: u16| options & bit != 0;
        let rom = self.rom.as_ref();
        let tool = || ToolInfo {
            kind: "02000000".to_owned(),
            maker: rom.map(|rom| rom.maker.clone()).unwrap_or_default(),
            revision: "000".to_owned(),
            serial: "00000000".to_owned(),
            status: PortStatus(self.status),
        };
        let info = PortInfo {
            tool: has(0x0001).then(tool),
            currents: has(0x0002).then_some(0),
            part: has(0x0004).then(|| rom.map(|rom| rom.part.clone()).unwrap_or_default()),
            accessories: has(0x0008).then_some(0),
            marker_kind: has(0x0010).then_some(0x29),
            location: has(0x0020).then(|| "0".repeat(14)),
            lines: has(0x0040).then_some(0),
        };
        info.text()
    }
}
