//! Replies about ports: PHRQ, PHSR and PHINF.

use crate::fields::Fields;
use crate::handle::Handle;
use crate::limits::MOST_TOOLS;
use crate::malformed::{Malformed, Refusal};
use crate::status::PortStatus;
use crate::text::Text;

/// The handle of a reply to PHRQ.
///
/// # Errors
/// Where it is not two hexadecimal digits.
pub fn parse_phrq(text: &str) -> Result<Handle, Malformed> {
    let mut fields = Text::new(text);
    let handle = fields
        .hex8("a handle")
        .and_then(|handle| fields.done("a handle").map(|()| handle));
    match handle {
        Ok(handle) => Ok(Handle(handle.into())),
        Err(refusal) => Err(refusal.of("PHRQ")),
    }
}

/// A handle of a list, with the lower twelve bits of its status.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Port {
    /// Which.
    pub handle: Handle,
    /// As in TX and BX.
    pub status: PortStatus,
}

/// The handles of a reply to PHSR.
///
/// # Errors
/// Where its count and its entries do not agree.
pub fn parse_phsr(text: &str) -> Result<Vec<Port>, Malformed> {
    listed(&mut Text::new(text)).map_err(|refusal| refusal.of("PHSR"))
}

fn listed(text: &mut Text<'_>) -> Result<Vec<Port>, Refusal> {
    let count = text.hex8("number of handles")?;
    let mut ports = Vec::with_capacity(usize::from(count).min(text.rest().len()));
    for _ in 0..count {
        ports.push(Port {
            handle: Handle(text.hex8("a handle")?.into()),
            status: PortStatus(text.hex(3, "a port's status")?),
        });
    }
    text.done("the last handle").map(|()| ports)
}

/// The text of a list.
pub fn phsr_text(ports: &[Port]) -> String {
    let ports = ports.get(..MOST_TOOLS - 1).unwrap_or(ports);
    let entry = |port: &Port| format!("{}{:03X}", port.handle, port.status.0 & 0xFFF);
    format!("{:02X}{}", ports.len(), ports.iter().map(entry).collect::<String>())
}

/// A list by name.
pub fn phsr_fields(ports: &[Port]) -> Fields {
    let mut fields = Fields::default();
    fields.add("reply", "PHSR");
    for (number, port) in ports.iter().enumerate() {
        fields.add(format!("ports[{number}].handle"), port.handle.to_string());
        fields.add(format!("ports[{number}].status"), port.status.0);
        fields.add(format!("ports[{number}].means"), port.status.why().to_string());
    }
    fields
}

/// What is known of a tool: PHINF with these options. Parts that were not asked for are `None`.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct PortInfo {
    /// Option 0001.
    pub tool: Option<ToolInfo>,
    /// Option 0002: the result of the test of a wired tool's currents.
    pub currents: Option<u32>,
    /// Option 0004: part number.
    pub part: Option<String>,
    /// Option 0008: switches and lights.
    pub accessories: Option<u8>,
    /// Option 0010: kind of marker.
    pub marker_kind: Option<u8>,
    /// Option 0020: where it is plugged in.
    pub location: Option<String>,
    /// Option 0040: its lines in and out.
    pub lines: Option<u8>,
}

/// The first part of [`PortInfo`].
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ToolInfo {
    /// Kind of tool, 8 hexadecimal digits.
    pub kind: String,
    /// Who made it.
    pub maker: String,
    /// Revision of the tool.
    pub revision: String,
    /// Serial number, 8 hexadecimal digits.
    pub serial: String,
    /// Lower eight bits of its status.
    pub status: PortStatus,
}

/// What a reply to PHINF with these options says; `None` where no tool is there.
///
/// # Errors
/// Where it is too short or too long for them.
pub fn parse_phinf(text: &str, options: u16) -> Result<Option<PortInfo>, Malformed> {
    if text == "UNOCCUPIED" {
        return Ok(None);
    }
    told(&mut Text::new(text), options)
        .map(Some)
        .map_err(|refusal| refusal.of("PHINF"))
}

fn told(text: &mut Text<'_>, options: u16) -> Result<PortInfo, Refusal> {
    let mut info = PortInfo::default();
    let has = |bit: u16| options & bit != 0;
    if has(0x0001) {
        info.tool = Some(ToolInfo {
            kind: words(text, 8)?,
            maker: words(text, 12)?,
            revision: words(text, 3)?,
            serial: words(text, 8)?,
            status: PortStatus(text.hex8("a port's status")?.into()),
        });
    }
    if has(0x0002) {
        info.currents = Some(text.hex(8, "a test of currents")?);
    }
    if has(0x0004) {
        info.part = Some(words(text, 20)?);
    }
    if has(0x0008) {
        info.accessories = Some(text.hex8("accessories")?);
    }
    if has(0x0010) {
        info.marker_kind = Some(text.hex8("kind of marker")?);
    }
    if has(0x0020) {
        info.location = Some(words(text, 14)?);
    }
    if has(0x0040) {
        info.lines = Some(text.hex8("lines")?);
    }
    text.done("what was asked for").map(|()| info)
}

/// A text of this length without the spaces at its end.
fn words(text: &mut Text<'_>, length: usize) -> Result<String, Refusal> {
    let bytes = text.take(length, "what is known of a tool")?;
    let words: String = bytes.iter().map(|byte| char::from(*byte)).collect();
    Ok(words.trim_end().to_owned())
}

impl PortInfo {
    /// The text of a reply to PHINF, of the parts that are there.
    pub fn text(&self) -> String {
        let tool = self.tool.as_ref().map(|tool| {
            let ToolInfo {
                kind,
                maker,
                revision,
                serial,
                status,
            } = tool;
            format!(
                "{kind:8.8}{maker:12.12}{revision:3.3}{serial:8.8}{:02X}",
                status.0 & 0xFF
            )
        });
        let byte = |byte: Option<u8>| byte.map(|byte| format!("{byte:02X}"));
        let parts = [
            tool,
            self.currents.map(|currents| format!("{currents:08X}")),
            self.part.as_ref().map(|part| format!("{part:20.20}")),
            byte(self.accessories),
            byte(self.marker_kind),
            self.location.as_ref().map(|location| format!("{location:14.14}")),
            byte(self.lines),
        ];
        parts.into_iter().flatten().collect()
    }

    /// All of it, by name.
    pub fn fields(&self) -> Fields {
        let mut fields = Fields::default();
        fields.add("reply", "PHINF");
        if let Some(tool) = &self.tool {
            fields.add("kind", tool.kind.as_str());
            fields.add("maker", tool.maker.as_str());
            fields.add("revision", tool.revision.as_str());
            fields.add("serial", tool.serial.as_str());
            fields.add("status", tool.status.0);
        }
        let words = [("part", &self.part), ("location", &self.location)];
        for (name, value) in words {
            value.iter().for_each(|value| fields.add(name, value.as_str()));
        }
        let bytes = [
            ("accessories", self.accessories),
            ("marker_kind", self.marker_kind),
            ("lines", self.lines),
        ];
        for (name, value) in bytes {
            value.iter().for_each(|value| fields.add(name, *value));
        }
        self.currents.iter().for_each(|value| fields.add("currents", *value));
        fields
    }
}
