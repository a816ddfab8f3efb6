//! The components of a frame, and what is said of them.

use super::{Alert, Bx2Frame, Bx2Marker, Bx2Markers, Bx2Tool, Component};
use crate::fault::Fault;
use crate::fields::Fields;
use crate::handle::Handle;
use crate::limits::MOST_TOOLS;
use crate::malformed::Refusal;
use crate::polled::bx::transform;
use crate::status::{MarkerStatus, ToolStatus};
use crate::wire::{Reader, long};

/// Handle and status.
const LEAST_TOOL: u64 = 4;
/// Handle and number of markers.
const LEAST_MARKERS: u64 = 4;
const MARKER: u64 = 16;
const ERROR: u64 = 4;
const ALERT: u64 = 4;

/// Kind, code, and what the device's guide says of it.
pub(super) const ALERT_WORDS: &[(u16, u16, &str)] = &[
    (0, 1, "parameters of the system"),
    (0, 2, "parameters of a sensor"),
    (0, 3, "main voltage"),
    (0, 4, "voltage of a sensor"),
    (0, 5, "voltage of an illuminator"),
    (0, 6, "current of an illuminator"),
    (0, 7, "temperature of the first sensor"),
    (0, 8, "temperature of the second sensor"),
    (0, 9, "temperature of the system"),
    (0, 10, "a sensor"),
    (1, 1, "battery"),
    (1, 2, "the device was bumped"),
    (1, 3, "firmware that does not fit"),
    (1, 4, "a parameter"),
    (1, 5, "the memory is full"),
    (1, 7, "it was stored too warm or too cold"),
    (1, 8, "too warm"),
    (1, 9, "too cold"),
    (1, 10, "the control unit is not connected"),
    (1, 13, "changed hardware"),
    (1, 14, "no common time"),
    (1, 15, "the video camera"),
    (1, 17, "firmware in its safe mode"),
    (2, 1, "a tool was plugged in"),
    (2, 2, "a tool was unplugged"),
    (2, 3, "an interface unit was connected"),
    (2, 4, "an interface unit was disconnected"),
    (2, 5, "changed hardware"),
    (2, 6, "another master of the time"),
];

/// u16 handle, u16 status; w x y z, x y z, error as f32 where the status does not say that it is missing.
pub(super) fn tools(component: &mut Component<'_>, tools: &mut Vec<Bx2Tool>) -> Result<(), Refusal> {
    let content = &mut component.content;
    let count = content.count(component.items, LEAST_TOOL, "tools")?;
    for _ in 0..room(content, tools.len(), count, "tools")? {
        let before = content.clone();
        let handle = Handle(content.u16("a tool")?);
        let status = ToolStatus(content.u16("a tool")?);
        if tools.iter().any(|tool| tool.handle == handle) {
            return Err(before.refuse(Fault::Twice { handle: handle.0 }));
        }
        let is_sent = !status.is_missing();
        tools.push(Bx2Tool {
            handle,
            status,
            transform: is_sent.then(|| transform(content)).transpose()?,
        });
    }
    content.done("the last tool")
}

/// u16 handle, u16 number; of each u8 status, u8 nothing, u16 index, x y z as f32.
pub(super) fn markers(component: &mut Component<'_>, all: &mut Vec<Bx2Markers>) -> Result<(), Refusal> {
    let content = &mut component.content;
    let lists = content.count(component.items, LEAST_MARKERS, "lists of markers")?;
    for _ in 0..room(content, all.len(), lists, "lists of markers")? {
        let handle = Handle(content.u16("a list of markers")?);
        let said = content.u16("a list of markers")?;
        let count = content.count(said.into(), MARKER, "markers")?;
        let mut markers = Vec::with_capacity(count);
        for _ in 0..count {
            let status = MarkerStatus(content.u8("a marker")?);
            let _reserved = content.u8("a marker")?;
            markers.push(Bx2Marker {
                status,
                index: content.u16("a marker")?,
                place_mm: content.reals("a marker")?,
            });
        }
        all.push(Bx2Markers { handle, markers });
    }
    content.done("the last marker")
}

/// So many more may be added: a device has at most so many tools, and strays beside them.
fn room(content: &Reader<'_>, have: usize, more: usize, what: &'static str) -> Result<usize, Refusal> {
    let (found, most) = (have.saturating_add(more), MOST_TOOLS + 1);
    if found > most {
        let (found, most) = (long(found), long(most));
        return Err(content.refuse(Fault::TooMany { what, found, most }));
    }
    Ok(more)
}

/// u16 handle, u16 number, so many f32. `None` where it is laid out otherwise: no pose rests on it.
pub(super) fn errors(component: &mut Component<'_>, have: usize) -> Option<Vec<(Handle, Vec<f64>)>> {
    let content = &mut component.content;
    let mut all = Vec::new();
    let lists = content.count(component.items, LEAST_MARKERS, "lists of errors").ok()?;
    for _ in 0..room(content, have, lists, "lists of errors").ok()? {
        let handle = Handle(content.u16("a list of errors").ok()?);
        let said = content.u16("a list of errors").ok()?;
        let count = content.count(said.into(), ERROR, "errors").ok()?;
        let one = || content.reals("an error").ok().map(|[error]| error);
        all.push((handle, std::iter::repeat_with(one).take(count).collect::<Option<_>>()?));
    }
    content.done("the last error").ok().map(|()| all)
}

/// u16 kind, u16 code.
pub(super) fn alerts(component: &mut Component<'_>) -> Result<Vec<Alert>, Refusal> {
    let content = &mut component.content;
    let mut alerts = Vec::new();
    for _ in 0..content.count(component.items, ALERT, "alerts")? {
        alerts.push(Alert {
            kind: content.u16("an alert")?,
            code: content.u16("an alert")?,
        });
    }
    content.done("the last alert").map(|()| alerts)
}

impl Bx2Frame {
    pub(super) fn put(&self, fields: &mut Fields, name: &str) {
        fields.add(format!("{name}.kind"), self.kind.words());
        fields.add(format!("{name}.index"), self.index);
        fields.add(format!("{name}.status"), self.status.0);
        fields.add(format!("{name}.number"), self.number);
        fields.add(format!("{name}.device_ns"), self.device_ns);
        for (number, tool) in self.tools.iter().enumerate() {
            let name = format!("{name}.tools[{number}]");
            fields.add(format!("{name}.handle"), tool.handle.to_string());
            fields.add(format!("{name}.status"), tool.status.0);
            fields.add(format!("{name}.why"), tool.status.why().to_string());
            fields.add(format!("{name}.face"), tool.status.face());
            tool.transform.iter().for_each(|transform| transform.put(fields, &name));
        }
        for (number, markers) in self.markers.iter().enumerate() {
            markers.put(fields, &format!("{name}.markers[{number}]"));
        }
        for (number, (handle, errors)) in self.errors.iter().enumerate() {
            fields.add(format!("{name}.errors[{number}].handle"), handle.to_string());
            fields.add(format!("{name}.errors[{number}].mm"), &errors[..]);
        }
    }
}

impl Bx2Markers {
    fn put(&self, fields: &mut Fields, name: &str) {
        let stray = self.handle == Handle::STRAY;
        let of = if stray {
            "none".to_owned()
        } else {
            self.handle.to_string()
        };
        fields.add(format!("{name}.handle"), of);
        for (number, marker) in self.markers.iter().enumerate() {
            let name = format!("{name}[{number}]");
            fields.add(format!("{name}.index"), marker.index);
            fields.add(format!("{name}.status"), marker.status.0);
            fields.add(format!("{name}.why"), marker.status.why().to_string());
            fields.add(format!("{name}.mm"), &marker.place_mm[..]);
        }
    }
}

impl super::FrameKind {
    /// In words.
    pub fn words(self) -> String {
        const WORDS: [&str; 8] = [
            "no tools",
            "active wireless",
            "passive",
            "active",
            "laser",
            "illuminated",
            "background",
            "magnetic",
        ];
        let known = WORDS.get(usize::from(self.0));
        known.map_or_else(|| format!("unknown {}", self.0), |words| (*words).to_owned())
    }
}
