//! BX2: a container of components (general binary format). A frame is a component, and holds those of its tools and
//! markers. What is not known here is skipped by its size and counted.
//!
//! Container: u16 version (1), u16 number of components. Component: u16 kind, u32 size with these 12 bytes, u16 option,
//! u32 number of items. Item of a frame (kind 1): u8 kind, u8 index, u16 status, u32 number, u32 s, u32 ns, container.

mod items;
mod write;

pub use write::bx2_body;

use crate::fault::Fault;
use crate::fields::Fields;
use crate::handle::Handle;
use crate::malformed::{Malformed, Refusal};
use crate::pose::{Transform, device_ns};
use crate::status::{MarkerStatus, ToolStatus};
use crate::wire::{Reader, long};

pub(crate) const FRAME: u16 = 1;
pub(crate) const TOOLS: u16 = 2;
pub(crate) const MARKERS: u16 = 3;
pub(crate) const ERRORS: u16 = 9;
pub(crate) const ALERTS: u16 = 0x12;
pub(crate) const VERSION: u16 = 1;
/// The header of a component.
pub(crate) const HEADER: u32 = 12;
/// The outer container, and that of a frame.
const MOST_NESTED: u64 = 2;
/// Frames of one reply: one for each kind of tool, and some.
const MOST_FRAMES: usize = 64;

/// A reply to BX2.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Bx2 {
    /// What is new since the last BX2: one for each kind of tool, none where nothing is new.
    pub frames: Vec<Bx2Frame>,
    /// What the device says of itself.
    pub alerts: Vec<Alert>,
    /// Components that are not known here, in frames too.
    pub skipped: u32,
}

/// Which tools a frame was taken for: 0 none, 1 active wireless, 2 passive, 3 active, 4 laser, 5 illuminated,
/// 6 background, 7 magnetic.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct FrameKind(pub u8);

/// A frame: all that was seen at one moment.
#[derive(Debug, Clone, PartialEq)]
pub struct Bx2Frame {
    /// For which tools.
    pub kind: FrameKind,
    /// Which of several of its kind.
    pub index: u8,
    /// Of the frame as a whole; if it is not good, no tool of it is.
    pub status: ToolStatus,
    /// The device's number of the frame.
    pub number: u32,
    /// When it was taken, ns of the device's own clock.
    pub device_ns: i64,
    /// Tools.
    pub tools: Vec<Bx2Tool>,
    /// Markers, of a tool or of none.
    pub markers: Vec<Bx2Markers>,
    /// Distances of markers to their places, mm, by handle, as far as they are sent.
    pub errors: Vec<(Handle, Vec<f64>)>,
}

/// A tool of a frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bx2Tool {
    /// Which.
    pub handle: Handle,
    /// Its status.
    pub status: ToolStatus,
    /// Its transform, where the status does not say that it is missing.
    pub transform: Option<Transform>,
}

/// Markers of one tool, or of none ([`Handle::STRAY`]).
#[derive(Debug, Clone, PartialEq)]
pub struct Bx2Markers {
    /// Whose.
    pub handle: Handle,
    /// Each with its status and place.
    pub markers: Vec<Bx2Marker>,
}

/// A single marker.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bx2Marker {
    /// Its status.
    pub status: MarkerStatus,
    /// Which of its tool, from 0; strays are counted.
    pub index: u16,
    /// Where, mm; whatever stands there.
    pub place_mm: [f64; 3],
}

/// What the device says of itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Alert {
    /// 0 a fault, 1 an alert, 2 an event.
    pub kind: u16,
    /// Which.
    pub code: u16,
}

/// The body of a reply to BX2.
///
/// # Errors
/// Where sizes and numbers of items do not agree; what would need more than the body holds; a handle twice.
pub fn parse_bx2(body: &[u8]) -> Result<Bx2, Malformed> {
    let mut reply = Bx2::default();
    let mut reader = Reader::new(body);
    let parsed = root(&mut reader, &mut reply).and_then(|()| reader.done("the last component"));
    match parsed {
        Ok(()) => Ok(reply),
        Err(refusal) => Err(refusal.of("BX2")),
    }
}

/// A component whose content is whole.
pub(crate) struct Component<'a> {
    kind: u16,
    items: u32,
    content: Reader<'a>,
}

fn container(reader: &mut Reader<'_>) -> Result<u16, Refusal> {
    let before = reader.clone();
    let found = reader.u16("a container's version")?;
    if found != VERSION {
        return Err(before.refuse(Fault::GbfVersion { found }));
    }
    let count = reader.u16("number of components")?;
    reader.count(count.into(), HEADER.into(), "components").map(|_| count)
}

fn component<'a>(reader: &mut Reader<'a>) -> Result<Component<'a>, Refusal> {
    let kind = reader.u16("a component")?;
    let before = reader.clone();
    let size = reader.u32("a component")?;
    let _option = reader.u16("a component")?;
    let items = reader.u32("a component")?;
    let content = size.checked_sub(HEADER);
    let content = content.ok_or_else(|| before.refuse(Fault::ComponentSize { found: size }))?;
    let content = reader.part(usize::try_from(content).unwrap_or(usize::MAX), "a component")?;
    Ok(Component { kind, items, content })
}

fn root(reader: &mut Reader<'_>, reply: &mut Bx2) -> Result<(), Refusal> {
    for _ in 0..container(reader)? {
        let mut one = component(reader)?;
        match one.kind {
            FRAME => frames(&mut one, reply)?,
            ALERTS => reply.alerts.extend(items::alerts(&mut one)?),
            _ => reply.skipped = reply.skipped.saturating_add(1),
        }
    }
    Ok(())
}

fn frames(component: &mut Component<'_>, reply: &mut Bx2) -> Result<(), Refusal> {
    let content = &mut component.content;
    let count = content.count(component.items, 20, "frames")?;
    let (found, most) = (reply.frames.len().saturating_add(count), MOST_FRAMES);
    if found > most {
        let (what, found, most) = ("frames", long(found), long(most));
        return Err(content.refuse(Fault::TooMany { what, found, most }));
    }
    for _ in 0..count {
        let frame = frame(content, reply)?;
        reply.frames.push(frame);
    }
    content.done("the last frame")
}

fn frame(reader: &mut Reader<'_>, reply: &mut Bx2) -> Result<Bx2Frame, Refusal> {
    let (kind, index) = (FrameKind(reader.u8("a frame")?), reader.u8("a frame")?);
    let (status, number) = (ToolStatus(reader.u16("a frame")?), reader.u32("a frame")?);
    let seconds = reader.u32("a frame")?;
    let before = reader.clone();
    let device_ns = device_ns(seconds, reader.u32("a frame")?).map_err(|fault| before.refuse(fault))?;
    let mut frame = Bx2Frame {
        kind,
        index,
        status,
        number,
        device_ns,
        tools: Vec::new(),
        markers: Vec::new(),
        errors: Vec::new(),
    };
    for _ in 0..container(reader)? {
        let before = reader.clone();
        let mut one = component(reader)?;
        match one.kind {
            TOOLS => items::tools(&mut one, &mut frame.tools)?,
            MARKERS => items::markers(&mut one, &mut frame.markers)?,
            ERRORS => match items::errors(&mut one, frame.errors.len()) {
                Some(errors) => frame.errors.extend(errors),
                None => reply.skipped = reply.skipped.saturating_add(1),
            },
            ALERTS => reply.alerts.extend(items::alerts(&mut one)?),
            FRAME => {
                let (found, most) = (MOST_NESTED + 1, MOST_NESTED);
                return Err(before.refuse(Fault::Nested { found, most }));
            }
            _ => reply.skipped = reply.skipped.saturating_add(1),
        }
    }
    Ok(frame)
}

impl Alert {
    /// In words.
    pub fn words(self) -> String {
        let kind = match self.kind {
            0 => "fault",
            1 => "alert",
            2 => "event",
            kind => return format!("message {} of the unknown kind {kind}", self.code),
        };
        let known = items::ALERT_WORDS
            .iter()
            .find(|(of, code, _)| (*of, *code) == (self.kind, self.code));
        known.map_or_else(
            || format!("{kind} {}", self.code),
            |(_, _, words)| format!("{kind}: {words}"),
        )
    }
}

impl Bx2 {
    /// All of it, by name.
    pub fn fields(&self) -> Fields {
        let mut fields = Fields::default();
        fields.add("reply", "BX2");
        fields.add("skipped", self.skipped);
        for (number, alert) in self.alerts.iter().enumerate() {
            fields.add(format!("alerts[{number}]"), alert.words());
        }
        for (number, frame) in self.frames.iter().enumerate() {
            frame.put(&mut fields, &format!("frames[{number}]"));
        }
        fields
    }
}
