//! Which of a client's tools is which marker of the room.

use ndi::session::{Device, DeviceTool};
use ndi::{Handle, Rom};

/// A marker of the room.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Role {
    /// That on the surgeon's tool.
    Tool,
    /// That on the patient.
    Patient,
}

/// The definitions that stand for a marker; without them the first tool that a client loads is the surgeon's and the second the
/// patient's.
#[derive(Debug, Clone, Default)]
pub(crate) struct Definitions {
    pub(crate) tool: Option<Rom>,
    pub(crate) patient: Option<Rom>,
}

/// The roles of a client's handles. A handle keeps its role until it is freed: when one of two tools goes, the other must not turn
/// into it.
#[derive(Debug, Default)]
pub(super) struct Roles {
    definitions: Definitions,
    tool: Option<Handle>,
    patient: Option<Handle>,
}

impl Roles {
    pub(super) fn new(definitions: Definitions) -> Self {
        Self {
            definitions,
            ..Self::default()
        }
    }

    /// Looks at the device's tools, after each command that may have changed them.
    pub(super) fn look(&mut self, device: &Device) {
        let is_there = |handle: &Handle| device.tools().any(|tool| tool.handle == *handle && tool.rom.is_some());
        self.tool = self.tool.filter(is_there);
        self.patient = self.patient.filter(is_there);
        let by_order = self.definitions.tool.is_none() && self.definitions.patient.is_none();
        for tool in device.tools() {
            let Some(rom) = tool.rom.filter(|_| self.of(tool.handle).is_none()) else {
                continue;
            };
            let may_be = |definition: &Option<Rom>| by_order || definition.as_ref() == Some(rom);
            if self.tool.is_none() && may_be(&self.definitions.tool) {
                self.tool = Some(tool.handle);
            } else if self.patient.is_none() && may_be(&self.definitions.patient) {
                self.patient = Some(tool.handle);
            }
        }
    }

    /// What a handle stands for; `None`: for nothing in the room.
    pub(super) fn of(&self, handle: Handle) -> Option<Role> {
        match Some(handle) {
            it if it == self.tool => Some(Role::Tool),
            it if it == self.patient => Some(Role::Patient),
            _ => None,
        }
    }

    /// A tool in words.
    pub(super) fn words(&self, tool: &DeviceTool<'_>) -> Option<String> {
        let part = &tool.rom?.part;
        let role = match self.of(tool.handle) {
            Some(Role::Tool) => "the surgeon's tool",
            Some(Role::Patient) => "the patient's marker",
            None => "never seen",
        };
        Some(format!("{} ({part}): {role}", tool.handle))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulate::testing::{client, rom, send};

    #[test]
    fn the_first_tool_is_the_surgeon_s_and_stays_so_while_others_come_and_go() {
        let mut device = client(&[rom("a"), rom("b"), rom("c")]);
        let mut roles = Roles::new(Definitions::default());
        roles.look(&device);
        let all = |roles: &Roles| [1, 2, 3].map(|handle| roles.of(Handle(handle)));
        assert_eq!(all(&roles), [Some(Role::Tool), Some(Role::Patient), None]);
        send(&mut device, "TSTOP:");
        send(&mut device, "PHF:01");
        roles.look(&device);
        // What was never seen becomes the tool, as it is the first without a role; the patient's stays.
        assert_eq!(all(&roles), [None, Some(Role::Patient), Some(Role::Tool)]);
    }

    #[test]
    fn named_definitions_are_known_in_any_order_and_others_are_nobody() {
        let mut device = client(&[rom("c"), rom("b"), rom("a")]);
        let mut roles = Roles::new(Definitions {
            tool: Some(rom("a")),
            patient: Some(rom("b")),
        });
        roles.look(&device);
        assert_eq!(
            [1, 2, 3].map(|handle| roles.of(Handle(handle))),
            [None, Some(Role::Patient), Some(Role::Tool)]
        );
        send(&mut device, "INIT:");
        roles.look(&device);
        assert_eq!([1, 2, 3].map(|handle| roles.of(Handle(handle))), [None; 3]);
    }
}
