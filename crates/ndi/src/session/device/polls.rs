//! What is seen, as a reply to each way of polling.

use super::Device;
use crate::bx2::{Bx2, Bx2Frame, Bx2Markers, Bx2Tool, bx2_body};
use crate::handle::Handle;
use crate::options::{Bx2Options, ReplyOption};
use crate::polled::bx::bx_body;
use crate::polled::tx::tx_text;
use crate::polled::{Information, Polled, PolledTool, Single, Spot, Spots};
use crate::status::{HandleStatus, MarkerStatus, MarkerUse, PortStatus, ToolInformation, ToolStatus};
use crate::why::Why;

const UNPLUGGED: ToolStatus = ToolStatus(ToolStatus::MISSING | 33);

impl Device {
    /// What is new since the last BX2.
    pub(super) fn bx2(&mut self, options: Bx2Options) -> Vec<u8> {
        let enabled: Vec<(Handle, PortStatus)> = self.ports.enabled().collect();
        let mut reply = Bx2 {
            alerts: self.alerts.clone(),
            ..Bx2::default()
        };
        for (frame, given) in self.frames.iter_mut().filter(|(_, given)| !given) {
            *given = true;
            reply.frames.push(asked_for(frame, options, &enabled));
        }
        bx2_body(&reply)
    }

    pub(super) fn bx(&self, options: ReplyOption) -> Vec<u8> {
        bx_body(&self.polled(options), options)
    }

    pub(super) fn tx(&self, options: ReplyOption) -> String {
        tx_text(&self.polled(options), options)
    }

    fn polled(&self, options: ReplyOption) -> Polled {
        let tools = self
            .ports
            .enabled()
            .map(|(handle, port)| self.tool(handle, port, options));
        Polled {
            tools: tools.collect(),
            strays: Some(self.strays()),
            system: self.system,
        }
    }

    fn tool(&self, handle: Handle, port: PortStatus, options: ReplyOption) -> PolledTool {
        let of = |frame: &Bx2Frame| frame.tools.iter().find(|tool| tool.handle == handle).copied();
        let seen = self
            .frames
            .iter()
            .find_map(|(frame, _)| Some((frame.number, of(frame)?)));
        let newest = || self.frames.last().map_or(0, |(frame, _)| frame.number);
        let (frame, tool) = seen.unwrap_or_else(|| (newest(), missing(handle, ToolStatus::MISSING | 31)));
        let mut polled = PolledTool::new(handle, HandleStatus::MISSING);
        let (bits, information) = stated(tool.status);
        let is_there = port.0 & 1 == 1;
        let is_told = tool.status.why() != Why::OutOfVolume || options.has(ReplyOption::OUT_OF_VOLUME);
        polled.port = Some(PortStatus(port.0 | bits));
        polled.frame = Some(frame);
        polled.information = Some(Information {
            tool: ToolInformation(information | tool.status.face() << 4),
            markers: [MarkerUse(0); 20],
        });
        polled.single = Some(Single::NOTHING);
        polled.markers = Some(self.spots(handle));
        if tool.status.code() == 32 {
            polled.status = HandleStatus::DISABLED;
        } else if is_there && is_told && !tool.status.is_missing() && tool.transform.is_some() {
            polled.status = HandleStatus::VALID;
            polled.transform = tool.transform;
        }
        polled
    }

    fn strays(&self) -> Spots {
        self.spots(Handle::STRAY)
    }

    /// BX says of a marker only whether it is out of volume; what else speaks against one keeps it back.
    fn spots(&self, handle: Handle) -> Spots {
        let lists = self.frames.iter().flat_map(|(frame, _)| &frame.markers);
        let markers = lists
            .filter(|list| list.handle == handle)
            .flat_map(|list| &list.markers);
        let told = markers.filter(|marker| matches!(marker.status, MarkerStatus(0 | 4 | 5)));
        let spot = |marker: &crate::bx2::Bx2Marker| Spot {
            out_of_volume: marker.status != MarkerStatus(0),
            place_mm: Some(marker.place_mm),
        };
        Spots(told.map(spot).collect())
    }
}

/// Of a frame, the tools that are tracked and the markers that are wanted.
fn asked_for(frame: &Bx2Frame, options: Bx2Options, enabled: &[(Handle, PortStatus)]) -> Bx2Frame {
    let is_enabled = |handle: Handle| enabled.iter().any(|(one, _)| *one == handle);
    let is_there = |handle: Handle| enabled.iter().any(|(one, port)| *one == handle && port.0 & 1 == 1);
    let tool = |tool: &Bx2Tool| {
        if is_there(tool.handle) {
            *tool
        } else {
            missing(tool.handle, UNPLUGGED.0)
        }
    };
    let tools = frame
        .tools
        .iter()
        .filter(|tool| options.tools && is_enabled(tool.handle))
        .map(tool);
    let is_wanted = |list: &&Bx2Markers| match list.handle {
        Handle::STRAY => options.markers.strays(),
        handle => options.markers.tools() && is_there(handle),
    };
    Bx2Frame {
        tools: tools.collect(),
        markers: frame.markers.iter().filter(is_wanted).cloned().collect(),
        errors: Vec::new(),
        ..*frame
    }
}

const fn missing(handle: Handle, status: u16) -> Bx2Tool {
    Bx2Tool {
        handle,
        status: ToolStatus(status),
        transform: None,
    }
}

/// The bits of a port and of the tool's information that say the same.
fn stated(status: ToolStatus) -> (u32, u8) {
    let why = status.why();
    let of_port = PortStatus::AGAINST
        .iter()
        .find(|(_, of)| *of == why)
        .map(|(bit, _)| *bit);
    let of_tool = ToolInformation::AGAINST
        .iter()
        .find(|(_, of)| *of == why)
        .map(|(bit, _)| *bit);
    (of_port.unwrap_or(0), of_tool.unwrap_or(0))
}
